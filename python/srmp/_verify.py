"""Verification of any trajectory in a scene, which may be a file."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from srmp import _srmp
from srmp._errors import checked

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    import srmp


@checked
def verify(
    scene: srmp.PlannerInterface | str | os.PathLike[str],
    trajectory: srmp.Trajectory,
    robot: str | None = None,
    *,
    start: ArrayLike | None = None,
    goals: srmp.GoalConstraint | Sequence[srmp.GoalConstraint] | None = None,
    limits: srmp.MotionLimits | None = None,
    jerk: bool = False,
    max_deviation: float | None = None,
    gap_tolerance: float = 0.5,
    at_rest: bool = True,
    package_dirs: Sequence[str] = (),
) -> srmp.Certificate:
    """A Certificate of any trajectory, whoever planned it: PlannerInterface.verify, which explains the arguments.

    scene: a PlannerInterface, or the path of a scene or problem file (package_dirs: where meshes of its robots are
    looked for). robot: default the one whose joint names are those of the trajectory, in any order, else the only one.
    The request of a problem file, if it is for this robot, says start and goals where they are not given. Other robots
    stand still; PlannerInterface.verify_multi is for those that move together.

    Raises InvalidArgument as PlannerInterface.verify, and where it is not clear which robot is meant; FileError as
    PlannerInterface.load.
    """
    if isinstance(scene, _srmp.PlannerInterface):
        world, request = scene, None
    else:
        world = _srmp.PlannerInterface.load(scene, package_dirs=list(package_dirs))
        request = world.last_request
    name = robot if robot is not None else robot_of(world, trajectory)
    if isinstance(request, _srmp.PlanRequest) and request.robot == name:
        start = request.start if start is None else start
        goals = request.goals if goals is None else goals
    return world.verify(
        name,
        trajectory,
        start=start,
        goals=goals,
        limits=limits,
        jerk=jerk,
        max_deviation=max_deviation,
        gap_tolerance=gap_tolerance,
        at_rest=at_rest,
    )


def load_with_result(
    path: str | os.PathLike[str], package_dirs: Sequence[str], *, solved: bool = False
) -> srmp.PlannerInterface:
    """A problem file with a request and its result; with `solved`, a trajectory. Raises FileError if it has none."""
    world = _srmp.PlannerInterface.load(path, package_dirs=list(package_dirs))
    if world.last_request is None or world.last_result is None:
        raise _srmp.FileError(f"{path}: it holds no request with its result; save after plan, before any change")
    if solved and not world.last_result.solved:
        raise _srmp.FileError(f"{path}: it holds no trajectory: the plan ended with {world.last_result.status.name}")
    return world


def is_multi(path: str | os.PathLike[str]) -> bool:
    """Returns whether this is a problem file whose request is one to plan_multi; False for any other file."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        return content["format"] == "srmp problem" and "starts" in content["request"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return False  # the reader of the file says what is wrong


def has_scene(path: str | os.PathLike[str]) -> bool:
    """Returns whether this is a problem or scene file, whole or damaged."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))["format"] in ("srmp problem", "srmp scene")
    except (ValueError, KeyError, TypeError, RecursionError):
        return False


def verify_multi(
    world: srmp.PlannerInterface, *, jerk: bool, max_deviation: float | None, at_rest: bool
) -> dict[str, srmp.Certificate]:
    """Verifies the last result against its request, by code that plans nothing."""
    request, result = world.last_request, world.last_result
    assert isinstance(request, _srmp.MultiPlanRequest)
    assert isinstance(result, _srmp.MultiPlanResult)
    return world.verify_multi(
        result.trajectory,
        starts=request.starts,
        goals=request.goals,
        obstacles=request.obstacles,
        constraints=request.constraints,
        jerk=jerk,
        max_deviation=max_deviation,
        at_rest=at_rest,
    )


def robot_of(world: srmp.PlannerInterface, trajectory: srmp.Trajectory) -> str:
    """The robot whose joints these are, in any order, else the only one; raises InvalidArgument."""
    names = world.robot_names
    joints = sorted(trajectory.joint_names)
    fitting = [name for name in names if sorted(world.get_joint_names(name)) == joints]
    for choice in (fitting, names):
        if len(choice) == 1:
            return choice[0]
    if not names:
        raise _srmp.InvalidArgument("the scene has no robot that the trajectory could be of.")
    those = ", ".join(f"'{name}'" for name in (fitting or names))
    have = "all have" if fitting else "do not have"
    raise _srmp.InvalidArgument(f"name the robot that the trajectory is of: {those} {have} its joints.")


def summary(certificate: srmp.Certificate) -> str:
    """One line: "holds, proved free, clearance 2.3 mm", or the kinds of its faults."""
    if not certificate.holds:
        kinds = list(dict.fromkeys(fault.kind.name for fault in certificate.faults))
        count = len(certificate.faults)
        return f"{count} fault{'s' if count > 1 else ''}: {', '.join(kinds)}"
    if not certificate.collisions_checked:
        return "holds, collisions not checked"
    parts = len(certificate.sampled)
    free = (
        "proved free"
        if certificate.proved_free
        else f"free, but {parts} part{'s' if parts > 1 else ''} at samples only"
    )
    return f"holds, {free}, {_clearance(certificate)}"


def _clearance(certificate: srmp.Certificate) -> str:
    if math.isinf(certificate.clearance):
        return "nothing to collide with"
    return f"clearance {certificate.clearance * 1e3:.3g} mm"
