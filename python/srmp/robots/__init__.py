"""Robots by name, from packages that users install: `planner.add_robot("panda")`, `srmp robots`; docs/robots.md."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from srmp import InvalidArgument, NotSupported, PlannerInterface
from srmp._authors_words import ARGUMENTS, missing_in_module
from srmp._errors import checked
from srmp._names import did_you_mean
from srmp.robots._list import Robot, read_list
from srmp.robots.srdf import AllowedCollisions, sample_allowed_collisions

__all__ = [
    "AllowedCollisions",
    "Robot",
    "add_robot",
    "available",
    "find",
    "register",
    "sample_allowed_collisions",
]

VARIABLE = "SRMP_ROBOTS"  # directories with TOML files of the user's own
_LISTS = Path(__file__).parent / "lists"
_ARGUMENTS = (
    *("name", "end_effector", "group", "joint_names", "fixed_joints", "base_pose", "package_dirs"),
    *("planar_bounds", "floating_bounds", "strict"),
)
_BOUNDS = {"planar_bounds", "floating_bounds"}
_registered: dict[str, Robot] = {}


def __getattr__(name: str) -> Any:
    missing_in_module(name, __name__)


@checked
def register(path: str | os.PathLike[str]) -> list[Robot]:
    """Adds the robots of a TOML file, or of all TOML files of a directory, to the list of known robots.

    They count more than robots of the same names that were there before. Returns them. Raises FileError, with the
    place, for a file that is missing or broken or has an unknown key; then none is added.
    """
    robots = read_list(path)
    _registered.update((robot.name, robot) for robot in robots)
    return robots


def available() -> dict[str, Robot]:
    """All known robots by name, sorted: those of this package, of the directories in SRMP_ROBOTS, and registered ones.

    SRMP_ROBOTS names directories, separated as in PATH. Raises FileError for a broken file in them.
    """
    robots = read_list(_LISTS)
    for directory in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        robots += read_list(directory)
    known = {robot.name: robot for robot in robots} | _registered
    return dict(sorted(known.items()))


def find(name: str) -> Robot:
    """The known robot of that name. Raises InvalidArgument, with the nearest name, when there is none."""
    known = available()
    if not isinstance(name, str) or name not in known:
        nearest = did_you_mean(name, known)
        raise InvalidArgument(
            f"no robot {name!r} is known{nearest}{'' if nearest else ';'} `srmp robots` lists all, and "
            "add_articulation adds a robot from its URDF"
        )
    return known[name]


def add_robot(planner: PlannerInterface, robot: str, **arguments: Any) -> Robot:
    """PlannerInterface.add_robot: adds a known robot to the planner and returns what is known of it."""
    for key in arguments:
        if key not in _ARGUMENTS:
            theirs = ARGUMENTS.get(("add_robot", key))
            hint = f"; {theirs}" if theirs else did_you_mean(key, _ARGUMENTS)
            raise InvalidArgument(
                f"add_robot has no argument '{key}'{hint or '; it takes robot, ' + ', '.join(_ARGUMENTS)}"
            )
    known = find(robot)
    if known.refused and not any(
        f"give {bounds}" in known.refused and arguments.get(bounds) is not None for bounds in _BOUNDS
    ):
        raise NotSupported(f"robot '{robot}' cannot be planned: {known.refused}")
    name = arguments.pop("name", robot)
    planner.add_articulation(name=name, **known.arguments(**arguments))
    try:
        if "fixed_joints" not in arguments:
            planned = set(planner.get_joint_names(name))
            fixed = {joint: position for joint, position in known.fixed_joints.items() if joint not in planned}
            planner.set_joint_positions(name, fixed)
        for one, other in known.allowed_collisions:
            planner.set_allowed_collision(f"{name}/{one}", f"{name}/{other}")
        _set_limits(planner, name, known.limits)
    except BaseException:
        planner.remove_articulation(name)
        raise
    return known


def _set_limits(planner: PlannerInterface, name: str, limits: Mapping[str, Mapping[str, float]]) -> None:
    """Those of the list for the joints that are planned; another group may not have them all."""
    planned = set(planner.get_joint_names(name))
    unknown = [joint for joint in limits if joint not in planner.get_all_joint_limits(name)]
    if unknown:
        raise InvalidArgument(
            f"the list of robots has limits of '{unknown[0]}', which is not a movable joint of '{name}'"
            + did_you_mean(unknown[0], planner.get_all_joint_limits(name))
        )
    kinds = {kind for values in limits.values() for kind in values}
    chosen: dict[str, Any] = {
        kind: {joint: values[kind] for joint, values in limits.items() if joint in planned and kind in values}
        for kind in sorted(kinds)
    }
    if any(chosen.values()):
        planner.set_motion_limits(name, **{kind: values for kind, values in chosen.items() if values})
