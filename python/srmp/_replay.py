"""Plans a saved request again, and compares the result with the saved one bit for bit."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from srmp import _srmp

if TYPE_CHECKING:
    import srmp

# Times, and the work of a plan, may differ.
COMPARED_STATISTICS = ("path_cost_rad", "bound", "bound_graph", "goal_index")


def plan_again(world: srmp.PlannerInterface, request: srmp.PlanRequest | srmp.MultiPlanRequest) -> None:
    """Plans the request; raises what plan or plan_multi raises."""
    if isinstance(request, _srmp.MultiPlanRequest):
        world.plan_multi(request.starts, request.goals, request.obstacles, request.constraints)
    else:
        in_motion = len(request.start_velocity) > 0
        world.plan(
            request.robot,
            request.start,
            request.goals,
            constraints=request.constraints,
            start_velocity=request.start_velocity if in_motion else None,
            start_acceleration=request.start_acceleration if len(request.start_acceleration) > 0 else None,
        )


def first_difference(
    before: srmp.PlanResult | srmp.MultiPlanResult, now: srmp.PlanResult | srmp.MultiPlanResult
) -> str | None:
    """The first difference of two results of one request, as a sentence; None when they are equal."""
    if before.status != now.status:
        return f"the status was {before.status.name} and is {now.status.name}{f' ({now.reason})' if now.reason else ''}"
    if not before.solved:
        return None
    if isinstance(before, _srmp.PlanResult):
        difference = _first_difference(before.trajectory, now.trajectory)
        return difference or _first_difference_of_statistics(before.statistics, now.statistics)
    for robot, trajectory in before.trajectory.items():
        if difference := _first_difference(trajectory, now.trajectory[robot]):
            return f"robot '{robot}': {difference}"
    return _first_difference_of_statistics(before.statistics, now.statistics)


def _first_difference(before: srmp.Trajectory, now: srmp.Trajectory) -> str | None:
    if before.joint_names != now.joint_names:
        return f"the joints were {before.joint_names} and are {now.joint_names}"
    for name in ("waypoints", "times", "positions", "velocities", "accelerations"):
        a, b = getattr(before, name), getattr(now, name)
        if len(a) != len(b):
            return f"{name} had {len(a)} rows and has {len(b)}"
        places = np.argwhere(np.ascontiguousarray(a).view(np.uint64) != np.ascontiguousarray(b).view(np.uint64))
        if len(places):
            place = tuple(places[0])
            column = f", column {place[1]} ({before.joint_names[place[1]]})" if len(place) > 1 else ""
            return f"{name}, row {place[0]}{column}: was {float(a[place])!r} and is {float(b[place])!r}"
    if (before.certificate is None) != (now.certificate is None):
        return "there was no certificate and there is one" if now.certificate else "there is no certificate any more"
    if before.certificate is None or now.certificate is None:
        return None
    was = before.certificate.to_dict()
    return _first_difference_of_entries(
        "certificate", was, now.certificate.to_dict(), [k for k in was if k != "time_s"]
    )


def _first_difference_of_statistics(before: Mapping[str, Any], now: Mapping[str, Any]) -> str | None:
    return _first_difference_of_entries("statistics", before, now, [k for k in COMPARED_STATISTICS if k in before])


def _first_difference_of_entries(
    what: str, before: Mapping[str, Any], now: Mapping[str, Any], names: Iterable[str]
) -> str | None:
    for name in names:
        was, is_now = (json.dumps(each.get(name), default=str) for each in (before, now))
        if was != is_now:
            return f"{what}, {name}: was {was} and is {is_now}"
    return None
