"""What the package `srmp` of PyPI (0.2.1) calls things, and what to write here instead; docs/from-other-packages.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

from srmp import _srmp

_ALL_PLANNED = "every robot may be planned here, and stands still while others are: leave it out"
_NO_COLOURS = "the viewer chooses the colours here: leave it out"
_NO_GRID = "there is no grid of the workspace here; heuristics that need one make it, with the option 'bfs_resolution'"
_ONE_CHECKER = "collisions have one exact checker here, which chooses its SIMD kernels itself: leave it out"
_NO_DOWNLOADS = "nothing is downloaded here: robots come from packages that pip installs, such as example-robot-data"
_BY_FILE = "it is a line of a TOML file here, whose path is the argument; docs/robots.md shows one"
_ADDED = {
    "link_names": "all links of the URDF are read here: leave it out",
    "gravity": "plans have no dynamics here: leave it out",
    "planned": _ALL_PLANNED,
    "gripper_joint_names": "joints that are not planned are set by set_joint_positions here: leave it out, and give "
    "the arm's joints by end_effector, group or joint_names",
}
_OF_ROBOTS = {
    "articulation_name": "it is 'name' here",
    "robot_name": "it is 'name' here",
    "qpos": "it is 'q' here",
    "link_name": "it is 'link' here",
    "local": "it is in world axes here; rotate it by the transpose of compute_fk(name, q, link).matrix()[:3, :3]",
    "move_group_only": "the planned joints have a column each here: leave it out",
}
_ROBOT_CALLS = (
    "compute_fk",
    "compute_ik",
    "compute_jacobian",
    "is_state_colliding",
    "distance_to_collision",
    "set_qpos",
    "get_qpos",
    "get_link_names",
)

ARGUMENTS: dict[tuple[str, str], str] = {
    ("PlannerInterface", "grid_config"): _NO_GRID,
    **{("add_articulation", argument): instead for argument, instead in _ADDED.items()},
    **{("add_robot", argument): instead for argument, instead in _ADDED.items()},
    ("add_articulation", "end_effectors"): "give 'group' or 'joint_names'; goals of several links are {link: Pose}",
    ("add_robot", "srdf_path"): "the list of robots says which SRDF; add_articulation takes another",
    ("make_planner", "articulation_names"): "it is 'names' here",
    ("make_planner", "planner_context"): "it is 'options' here",
    ("plan", "goal_constraint"): "it is 'goal' here",
    ("plan_multi", "start_states"): "it is 'starts' here",
    ("plan_multi", "goal_constraints"): "it is 'goals' here",
    **{("GoalConstraint", argument): "it is 'targets' here" for argument in ("joints", "poses", "positions")},
    **{(f"add_{shape}", "color"): _NO_COLOURS for shape in ("box", "sphere", "cylinder", "mesh")},
    ("add_mesh", "mesh_path"): "it is 'path' here",
    ("add_point_cloud", "vertices"): "it is 'points' here",
    ("add_point_cloud", "colors"): _NO_COLOURS,
    ("attach_object", "object_name"): "it is 'name' here",
    ("attach_object", "robot_name"): "it is 'robot' here",
    ("attach_object", "link_id"): "it is 'link' here, the name of a link",
    ("attach_object", "is_link_name"): "links have names, not numbers, here: leave it out",
    ("attach_object", "pose"): "it is 'pose_in_link' here",
    ("detach_object", "also_remove"): "call remove_object(name) then",
    ("set_allowed_collision", "name1"): "it is 'a' here",
    ("set_allowed_collision", "name2"): "it is 'b' here",
    **{(call, argument): instead for call in _ROBOT_CALLS for argument, instead in _OF_ROBOTS.items()},
    ("compute_ik", "ee_pose"): "it is 'target' here",
    ("compute_ik", "init_state_val"): "it is 'reference' here",
    ("read_sim", "sim_type"): "it is 'kind' here",
    ("load_scene", "clear"): "it replaces the whole scene here: leave it out",
    ("reset", "reset_robots"): "it removes robots and objects here; remove_object removes one object",
    **{
        ("register", argument): _BY_FILE
        for argument in (
            *("name", "urdf_path", "srdf_path", "end_effector", "description", "default_qpos", "joint_names"),
            "gripper_joint_names",
        )
    },
}

_PLANNER: dict[str, str] = {
    "start_visualizer": "planner.show(), or planner.to_html(path) for a page that needs no server",
    **dict.fromkeys(
        ("attach_visualizer", "detach_visualizer", "get_visualizer"),
        "viewer = planner.show(), which follows the planner by itself until viewer.close()",
    ),
    "save_plan": "the save(path) of the trajectory that plan returns, or planner.save(path) for the whole problem",
    "set_gripper_qpos": "set_joint_positions(name, {joint: position})",
    "get_gripper_joint_names": "the 'gripper' of what add_robot returns, or of srmp.robots.find(name)",
    "get_articulation_names": "robot_names",
    "has_articulation": "name in planner.robot_names",
    "get_object_names": "object_names",
    "has_object": "name in planner.object_names",
    "is_object_attached": "what the program knows: attach_object attaches, and only detach_object detaches",
    "get_move_group_joint_names": "get_joint_names(name)",
    "get_move_group_joint_limits": "get_joint_limits(name), with the velocity limits in a third column",
    "get_move_group_qpos_dim": "len(planner.get_joint_names(name))",
    "get_move_group_joint_types": "get_joint_limits(name): continuous joints have -inf and inf there",
    "get_active_joint_names": "get_all_joint_limits(name), whose keys are all movable joints",
    "get_link_index": "get_link_names(name).index(link); links go by their names here",
    "get_link_pose": "compute_fk(name, planner.get_qpos(name), link)",
    "get_jacobian": "compute_jacobian(name, planner.get_qpos(name), link)",
    "get_manipulability": "numpy.sqrt(numpy.linalg.det(j @ j.T)) with j = planner.compute_jacobian(name, q, link)",
    "compute_joint_velocities": "numpy.linalg.pinv(planner.compute_jacobian(name, q, link)) @ twist",
    "collision_aware_ik": "compute_ik(name, pose, reference), nearest first, and is_state_colliding(name, q) of each",
    **dict.fromkeys(
        ("distance_to_self_collision", "distance_to_robot_collision"),
        "distance_to_collision(name, q), which is to anything; nearest(name, q) names the pair",
    ),
    "is_robot_colliding_with_objects": "contacts(name, q), which names the bodies of each pair",
    "set_qpos_all": "set_qpos(name, q) for each robot",
    "update_object_pose": "set_object_pose(name, pose)",
    "detach_all_objects": "detach_object(name) for each",
    "update_attached_bodies_pose": "nothing: what is attached moves with its link",
    "set_object_color": "nothing: the viewer chooses the colours",
    **dict.fromkeys(("is_articulation_planned", "set_articulation_planned"), f"nothing: {_ALL_PLANNED}"),
    **dict.fromkeys(("get_grid", "get_grid_config", "set_grid"), f"nothing: {_NO_GRID}"),
    "plan_screw": "plan_linear(name, start, pose), for a straight motion; "
    "srmp.compat.mplib.Planner.plan_screw plans other screws",
    "get_mgs_roots": "nothing: there is no planner MGS here, and srmp.SearchTrace records what others search",
    "is_vamp_state_valid": "not planner.is_state_colliding(name, q)",
    **dict.fromkeys(
        (
            "get_active_validity_backend",
            "get_available_validity_backends",
            "get_vamp_supported_robots",
            "is_robot_vamp_supported",
        ),
        f"nothing: {_ONE_CHECKER}",
    ),
}
_POSE: dict[str, str] = {
    "inv": "inverse()",
    "get_p": "p",
    "get_q": "q, which is x, y, z, w here",
    "set_p": "Pose(p, q): poses do not change",
    "set_q": "Pose(p, q), with q = x, y, z, w: poses do not change",
    "to_transformation_matrix": "matrix()",
    "distance": "numpy.linalg.norm(a.p - b.p), and the angle of a.inverse() * b",
}
_POSE_ORDER = "Pose(p=…, q=…): poses do not change, and q is x, y, z, w here"
_GOAL: dict[str, str] = dict.fromkeys(("joints", "poses", "positions"), "targets")
_GOAL_TYPES: dict[str, str] = {
    f"MULTI_GOAL_{kind}": f"GoalType.{kind} with several targets, any of which will do"
    for kind in ("JOINTS", "POSE", "POSITION")
}
_MODULE: dict[str, str] = {
    "save_plan": "trajectory.save(path)",
    "load_plan": "srmp.Trajectory.load(path) or srmp.MultiTrajectory.load(path)",
    "save_scene": "planner.save_scene(path)",
    "load_scene": "planner.load_scene(path)",
    "GridConfig": f"nothing: {_NO_GRID}",
    "OccupancyGrid": f"nothing: {_NO_GRID}",
    "ViserPlannerInterface": "planner.show()",
}
_ROBOTS: dict[str, str] = {
    "list_available": "available()",
    "get": "find(name)",
    "info": "find(name)",
    "unregister": "nothing: a robot that is registered again replaces the one of its name",
    "RobotNotFoundError": "srmp.InvalidArgument",
    **dict.fromkeys(
        ("download", "download_all", "get_cache_dir", "set_cache_dir", "DownloadError"), f"nothing: {_NO_DOWNLOADS}"
    ),
}


class _NotHere(_srmp.NotSupported, AttributeError):  # type: ignore[misc]
    """Also an AttributeError, for hasattr and getattr with a default."""


class Missing:
    """A member of an enumeration that says what to write instead.

    No AttributeError: after one, the enumeration would raise its own, without the sentence.
    """

    def __init__(self, sentence: str) -> None:
        self._sentence = sentence

    def __get__(self, instance: object, owner: type) -> NoReturn:
        raise _srmp.NotSupported(self._sentence)


def _sentence(owner: str, name: str, instead: str) -> str:
    nothing, colon, why = instead.partition("nothing: ")
    return f"{owner} has no '{name}'" + (f": {why}" if colon and not nothing else f"; write {instead}")


def _explain(cls: Any, instead: Mapping[str, str]) -> None:
    """cls.__getattr__ is called where an instance has no attribute of a name."""

    def missing(self: object, name: str) -> NoReturn:
        if name in instead:
            raise _NotHere(_sentence(cls.__name__, name, instead[name]))
        raise AttributeError(f"'{cls.__name__}' object has no attribute '{name}'", name=name, obj=self)

    cls.__getattr__ = missing


def _explain_assignment(cls: Any, name: str, instead: str) -> None:
    """An assignment to a property that cannot change says what to write instead."""
    prop = vars(cls)[name]

    def refuse(self: object, value: object) -> NoReturn:
        raise _NotHere(f"'{name}' of a {cls.__name__} cannot be assigned; write {instead}")

    setattr(cls, name, property(prop.fget, refuse, None, prop.__doc__))


def explain_missing_names() -> None:
    """What the other package has says what to write instead, of classes of this one."""
    _explain(_srmp.PlannerInterface, _PLANNER)
    _explain(_srmp.Pose, _POSE)
    for name in ("p", "q"):
        _explain_assignment(_srmp.Pose, name, _POSE_ORDER)
    _explain(_srmp.GoalConstraint, _GOAL)
    for name, instead in _GOAL_TYPES.items():
        setattr(_srmp.GoalType, name, Missing(_sentence("GoalType", name, instead)))


def missing_in_module(name: str, module: str = "srmp") -> NoReturn:
    """A module's __getattr__: AttributeError, with what to write instead where the other package has the name."""
    instead = {"srmp": _MODULE, "srmp.robots": _ROBOTS}[module]
    if name in instead:
        raise _NotHere(_sentence(module, name, instead[name]))
    raise AttributeError(f"module '{module}' has no attribute '{name}'")
