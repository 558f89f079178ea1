"""How objects of the library show themselves in notebooks: players of motions, tables of everything else."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from srmp import _srmp
from srmp._html_tables import BAD, GOOD, Raw, certificate_table, escaped, table
from srmp._table import format_seconds
from srmp._verify import summary

_PLAYER_HEIGHT = 460  # [px]
_MAX_LINES = 12  # of the small plot of a motion whose robot is not known
_JOINTS = ("#0b7a75", "#d1662b", "#3a6ea5", "#a23b72", "#6b8e23", "#8a5a44", "#5b5ea6", "#b08900", "#444b54")


def html_of(value: Any) -> str:
    """The HTML of an object; only its repr, where something keeps it from being drawn."""
    try:
        return _WRITERS[type(value)](value)
    except _srmp.Error as error:
        return f"<div>{escaped(repr(value))}<br><small>{escaped(error)}</small></div>"


def _planner(planner: Any) -> str:
    from srmp.viewer._drawing import make_drawing

    return _player(make_drawing(planner), repr(planner))


def _trajectory(trajectory: Any) -> str:
    world = _srmp.PlannerInterface()
    robot = trajectory._add_robot_to(world)
    return _motion(trajectory, world if robot else None, {robot: trajectory})


def _multi_trajectory(trajectories: Any) -> str:
    world = _srmp.PlannerInterface()
    known = [trajectory._add_robot_to(world) for trajectory in trajectories.values()]
    return _motion(trajectories, world if known == list(trajectories) else None, dict(trajectories))


def _motion(value: Any, world: Any, trajectories: Mapping[str, Any]) -> str:
    """Without the scene, which a trajectory does not know: robots alone."""
    rows = [
        (robot or "trajectory", f"{one.duration:.3f} s, {one.length:.2f} rad, {len(one)} rows; {_certified(one)}")
        for robot, one in trajectories.items()
    ]
    if world is None:
        return table(rows) + "".join(_lines(one) for one in trajectories.values())
    from srmp.viewer._drawing import make_drawing

    return _player(make_drawing(world, trajectories, clearances=False), repr(value)) + table(rows)


def _certified(trajectory: Any) -> str:
    return f"certificate {summary(trajectory.certificate)}" if trajectory.certificate else "no certificate"


def _player(drawing: Any, title: str) -> str:
    from srmp.viewer._html import page

    text = html.escape(page(drawing, title), quote=True)
    style = f"width: 100%; height: {_PLAYER_HEIGHT}px; border: 1px solid #d0d5da; border-radius: 6px"
    return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{text}"></iframe>'


def _lines(trajectory: Any) -> str:
    """Positions over time as a small drawing."""
    positions = np.asarray(trajectory.positions)[:, :_MAX_LINES]
    times = np.asarray(trajectory.times) if len(trajectory.times) else np.arange(float(len(positions)))
    span, low, high = max(times[-1] - times[0], 1e-9), positions.min(), max(positions.max(), positions.min() + 1e-9)
    picked = np.unique(np.linspace(0, len(times) - 1, 200).astype(int))
    x, y = 600 * (times[picked] - times[0]) / span, 115 - 110 * (positions[picked] - low) / (high - low)
    drawn = "".join(
        f'<polyline fill="none" stroke="{_JOINTS[j % len(_JOINTS)]}" points="'
        + " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, column, strict=True))
        + f'"><title>{escaped(trajectory.joint_names[j])}</title></polyline>'
        for j, column in enumerate(y.T)
    )
    return f'<svg viewBox="0 0 600 120" style="width: 100%; max-width: 600px" role="img">{drawn}</svg>'


def _result(result: Any) -> str:
    statistics = result.statistics
    colour = GOOD if result.solved else BAD
    rows = [
        ("status", Raw(f'<b style="color: {colour}">{escaped(result.status.name)}</b> {escaped(result.reason)}')),
        ("time of the path", format_seconds(statistics["plan_time_s"])),
        ("time in all", format_seconds(statistics["total_time_s"])),
        ("expansions", statistics["expansions"]),
        ("edge checks", statistics["edge_checks"]),
    ]
    if not result.solved:
        return table(rows)
    bound = statistics["bound"]
    cost = f"{statistics['path_cost_rad']:.3f} rad"
    if math.isfinite(bound):
        cost += f", at most {bound:.3g} times the optimum of {statistics['bound_graph']}"
    return table([*rows, ("cost", cost)]) + html_of(result.trajectory)


def _request(request: Any) -> str:
    options = [f"{key} = {value}" for key, value in (request.options or {}).items()]
    return table(
        [
            ("robot", request.robot),
            ("start", _numbers(request.start)),
            *(("goal", _goal(goal)) for goal in request.goals),
            ("planner", ", ".join(options) or "as make_planner says"),
        ]
    )


def _multi_request(request: Any) -> str:
    rows: list[tuple[str, Any]] = []
    for robot, start in request.starts.items():
        goal = _goal(request.goals[robot]) if robot in request.goals else "holds still"
        rows.append((robot, f"from {_numbers(start)} to {goal}"))
    rows += [(robot, f"is committed to {trajectory!r}") for robot, trajectory in request.obstacles.items()]
    return table(rows)


def _goal(goal: Any) -> str:
    targets = "; or ".join(_numbers(target) for target in goal.targets)
    return f"{goal.type.name} {targets}".strip()


def _numbers(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value:.4g}" for value in values) + "]"


_WRITERS: dict[type, Any] = {
    _srmp.PlannerInterface: _planner,
    _srmp.Trajectory: _trajectory,
    _srmp.MultiTrajectory: _multi_trajectory,
    _srmp.PlanResult: _result,
    _srmp.MultiPlanResult: _result,
    _srmp.Certificate: certificate_table,
    _srmp.PlanRequest: _request,
    _srmp.MultiPlanRequest: _multi_request,
}
