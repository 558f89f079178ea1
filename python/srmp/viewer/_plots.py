"""What changes along a motion: how much of its limits it uses, and how near it comes to anything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srmp.viewer._motion import Motion

if TYPE_CHECKING:
    from srmp import PlannerInterface

_COLOURS = ("#0b7a75", "#d1662b", "#3a6ea5", "#a23b72", "#6b8e23", "#8a5a44", "#5b5ea6", "#b08900", "#444b54")
_SAMPLES = 120  # clearances of a motion: each is a query of distances


@dataclass(frozen=True, eq=False)
class Series:
    """One line of a plot."""

    name: str
    values: NDArray[np.float64]  # (n,), NaN or infinity: no value
    colour: str


@dataclass(frozen=True, eq=False)
class Plot:
    """Lines over one time."""

    title: str
    times: NDArray[np.float64]  # (n,) [s]
    series: list[Series]
    limit: float | None = None  # drawn dashed


def plots_of(planner: PlannerInterface, motion: Motion, clearances: bool = True) -> list[Plot]:
    """Positions, used fractions of the limits, and clearances, of all robots that move."""
    if motion.duration <= 0:
        return []
    plots = [_limits(planner, motion, quantity) for quantity in ("velocity", "acceleration", "jerk")]
    plots += [_positions(motion)] if len(motion.trajectories) == 1 else []
    plots += [_clearances(planner, motion)] if clearances else []
    return [plot for plot in plots if plot.series]


def _limits(planner: PlannerInterface, motion: Motion, quantity: str) -> Plot:
    """Each joint where one robot moves, the largest of all joints where several do."""
    times = np.linspace(0, motion.duration, 400)
    series = []
    for robot, trajectory in motion.trajectories.items():
        if not len(trajectory.velocities):
            continue
        _, *derivatives = trajectory.state(times)
        own = trajectory.certificate.limits if trajectory.certificate else planner.motion_limits(robot)
        limits = getattr(own, quantity)
        used = np.abs(derivatives[("velocity", "acceleration", "jerk").index(quantity)]) / limits
        used[times > trajectory.times[-1] + 1e-9] = 0.0
        if len(motion.trajectories) == 1:
            series += list(zip(trajectory.joint_names, used.T, strict=True))
        else:
            series.append((robot, used.max(axis=1)))
    return Plot(f"{quantity}, fraction of the limit", times, _coloured(series), 1.0)


def _positions(motion: Motion) -> Plot:
    """Of each joint [rad or m]."""
    (trajectory,) = motion.trajectories.values()
    times = np.linspace(0, motion.duration, 400)
    columns = np.asarray(trajectory.sample(times)).T
    return Plot("position [rad, m]", times, _coloured(list(zip(trajectory.joint_names, columns, strict=True))))


def _clearances(planner: PlannerInterface, motion: Motion) -> Plot:
    """Of each robot, among the others as they move [mm]."""
    times = np.linspace(0, motion.duration, _SAMPLES)
    rows = {robot: np.asarray(one.sample(times)) for robot, one in motion.trajectories.items()}
    series = []
    for robot, q in rows.items():
        others = {other: (times, row) for other, row in rows.items() if other != robot}
        checker = planner.timed_collision_checker(robot, others, mode="coal")
        values = 1e3 * np.asarray(checker.clearance(q, times))
        if np.isfinite(values).any():
            series.append((robot, values))
    return Plot("clearance [mm]", times, _coloured(series))


def _coloured(lines: list[tuple[str, NDArray[np.float64]]]) -> list[Series]:
    return [Series(name, values, _COLOURS[k % len(_COLOURS)]) for k, (name, values) in enumerate(lines)]
