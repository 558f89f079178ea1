"""What the package `srmp` of PyPI (0.2.1) calls things, and what to write here instead; docs/from-other-packages.md."""

from __future__ import annotations

from typing import Any, NoReturn

from srmp import _srmp

ARGUMENTS: dict[tuple[str, str], str] = {
    ("add_articulation", "link_names"): "all links of the URDF are read here: leave it out",
    ("add_articulation", "gravity"): "plans have no dynamics here: leave it out",
    ("add_articulation", "planned"): "every robot may be planned here, and stands still while others are: leave it out",
    ("add_articulation", "gripper_joint_names"): "joints that are not planned are set by set_joint_positions here: "
    "leave it out, and give the arm's joints by end_effector, group or joint_names",
    ("make_planner", "articulation_names"): "it is 'names' here",
    ("make_planner", "planner_context"): "it is 'options' here",
    ("add_mesh", "mesh_path"): "it is 'path' here",
    ("add_point_cloud", "vertices"): "it is 'points' here",
}

METHODS: dict[str, str] = {
    "set_gripper_qpos": "set_joint_positions(name, {joint: position})",
    "save_plan": "the save(path) of the trajectory that plan returns, or planner.save(path) for the whole problem",
}


class _NotHere(_srmp.NotSupported, AttributeError):  # type: ignore[misc]
    """Also an AttributeError, for hasattr and getattr with a default."""


def _missing(planner: object, name: str) -> NoReturn:
    """PlannerInterface.__getattr__: called where there is no attribute of that name."""
    if name in METHODS:
        raise _NotHere(f"PlannerInterface has no '{name}'; write {METHODS[name]}")
    raise AttributeError(f"'{type(planner).__name__}' object has no attribute '{name}'", name=name, obj=planner)


def explain_missing_methods(cls: Any) -> None:
    """Calls of METHODS say what to write instead."""
    cls.__getattr__ = _missing
