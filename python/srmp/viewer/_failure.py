"""Why a plan failed, for the eye: the configuration that is at fault, what touches there, and the limits it leaves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp.viewer._scene import copied, frame_poses

if TYPE_CHECKING:
    from srmp import Contact, GoalConstraint, PlannerInterface

_MAX_SOLUTIONS = 16  # of inverse kinematics, for a goal pose


@dataclass(frozen=True)
class Touch:
    """Two bodies in contact, or a joint outside its limits."""

    text: str  # "arm/hand – post: 3.2 mm deep"
    point: NDArray[np.float64]  # (3,) [m], world frame
    bodies: tuple[str, ...]  # labels of the bodies at fault: 'robot/link' or an object's name


@dataclass(frozen=True, eq=False)
class Failure:
    """A plan without a trajectory."""

    status: str
    reason: str
    configurations: dict[str, NDArray[np.float64]]  # (dof,), by robot: starts, or goals where these are at fault
    poses: NDArray[np.float64]  # (frames, 7) of these
    touches: list[Touch]


def find_failure(planner: PlannerInterface) -> Failure | None:
    """Why the planner's last plan failed; None where it did not, or where its scene has changed since."""
    request, result = planner.last_request, planner.last_result
    if request is None or result is None or result.solved:
        return None
    if isinstance(request, srmp.PlanRequest):
        starts, goals = {request.robot: request.start}, {request.robot: request.goals}
    else:
        starts, goals = request.starts, {robot: [goal] for robot, goal in request.goals.items()}
    shown = {robot: np.asarray(q) for robot, q in starts.items()}
    if result.status == srmp.Status.goal_invalid:
        shown |= {robot: _at_goal(planner, robot, shown[robot], targets) for robot, targets in goals.items()}
    touches = touches_at(planner, shown) if len(shown) == 1 else touches_together(copied(planner), shown)
    return Failure(result.status.name, result.reason, shown, frame_poses(planner, shown), touches)


def touches_at(planner: PlannerInterface, configurations: Mapping[str, NDArray[np.float64]]) -> list[Touch]:
    """What touches, and which limits are left, with robots at `configurations` among others where they stand."""
    touches: dict[tuple[str, ...], Touch] = {}
    for robot, q in configurations.items():
        for contact in planner.contacts(robot, q):
            touch = _touch(planner, robot, contact)
            touches.setdefault(tuple(sorted(touch.bodies)), touch)
        for joint, text in violations(planner, robot, q).items():
            touch = _limit(planner, robot, q, joint, text)
            touches.setdefault((joint, *touch.bodies), touch)
    return list(touches.values())


def touches_together(world: PlannerInterface, configurations: Mapping[str, NDArray[np.float64]]) -> list[Touch]:
    """touches_at with all of them there at the same time; the robots of this world are moved, and moved back."""
    before = {robot: world.get_qpos(robot) for robot in configurations}
    try:
        for robot, q in configurations.items():
            if not violations(world, robot, q):  # outside its limits it cannot stand while others are checked
                world.set_qpos(robot, q)
        return touches_at(world, configurations)
    finally:
        for robot, q in before.items():
            world.set_qpos(robot, q)


def violations(planner: PlannerInterface, robot: str, q: Iterable[float]) -> dict[str, str]:
    """Sentences on the joints that are outside their limits, by joint name."""
    names, limits = planner.get_joint_names(robot), planner.get_joint_limits(robot)
    return {
        name: f"{name}: {value:.4g} is outside [{lower:.4g}, {upper:.4g}]"
        for name, value, (lower, upper, _) in zip(names, q, limits, strict=True)
        if not lower - 1e-9 <= value <= upper + 1e-9
    }


def _touch(planner: PlannerInterface, robot: str, contact: Contact) -> Touch:
    bodies = (_label(planner, robot, contact.body_a), _label(planner, robot, contact.body_b))
    depth = f"{-1e3 * contact.distance:.1f} mm deep" if contact.distance < 0 else "touching"
    point = (np.asarray(contact.point_a) + np.asarray(contact.point_b)) / 2
    return Touch(f"{contact.body_a} – {contact.body_b}: {depth}", point, bodies)


def _label(planner: PlannerInterface, robot: str, body: str) -> str:
    """Contacts name links of the robot itself without it."""
    return f"{robot}/{body}" if body in planner.get_link_names(robot) and body not in planner.object_names else body


def _limit(planner: PlannerInterface, robot: str, q: NDArray[np.float64], joint: str, text: str) -> Touch:
    """At the first link that the joint moves."""
    moved = np.array(q)
    moved[planner.get_joint_names(robot).index(joint)] += 0.1
    for link in planner.get_link_names(robot):
        here, there = planner.compute_fk(robot, q, link), planner.compute_fk(robot, moved, link)
        if not np.allclose(here.matrix(), there.matrix(), atol=1e-9):
            return Touch(text, np.asarray(here.p), (f"{robot}/{link}",))
    return Touch(text, np.asarray(planner.compute_fk(robot, q).p), ())


def _at_goal(
    planner: PlannerInterface, robot: str, start: NDArray[np.float64], goals: Iterable[GoalConstraint]
) -> NDArray[np.float64]:
    """The configuration at a goal that has the fewest contacts; the start, where inverse kinematics finds none."""
    found: list[NDArray[np.float64]] = []
    for goal in goals:
        for target in goal.targets:
            if goal.type == srmp.GoalType.JOINTS:
                found.append(target)
            elif goal.type == srmp.GoalType.POSE:
                pose = srmp.Pose(target[:3], target[3:])
                found += list(planner.compute_ik(robot, pose, start, max_solutions=_MAX_SOLUTIONS))
    return min(found, key=lambda q: len(planner.contacts(robot, q)), default=start)
