"""Several robots at once: plans the problems of a scenario together and writes one row for each."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._table import format_table
from srmp.bench import mbm
from srmp.bench.repeated import variation
from srmp.bench.runner import Execution, Progress, Steps, run_rows
from srmp.bench.scenarios import find
from srmp.bench.scenes import Problem, Scenario

_STATISTICS = (
    *mbm.STATISTICS,
    *("path_cost_rad", "bound", "tree_nodes", "makespan_s", "flow_time_s"),
    *("independence_detection", "large_neighbourhood_search"),
)


@dataclass(frozen=True)
class Numbered:
    """A problem of a scenario, by its number."""

    scenario: str
    number: int

    @property
    def name(self) -> str:
        """The name in result files, such as "ring/0001"."""
        return f"{self.scenario}/{self.number:04d}"


class Runner:
    """Plans one problem after the other in the scenario's world, which is read once."""

    def __init__(
        self,
        scenario: Scenario,
        planner_id: str,
        options: Mapping[str, str],
        time_limit: float,
        steps: Steps | None = None,
    ) -> None:
        self._scenario = scenario
        self._planner = scenario.world.build()
        self._planner.prepare(steps)
        names = [robot.name for robot in scenario.world.robots]
        self._planner.make_planner(names, {"planner_id": planner_id, "time_limit": time_limit, **options})

    def describe(self) -> dict[str, Any]:
        """The scenario's world in full."""
        return self._scenario.world.to_dict(self._planner)

    def run(self, numbered: Numbered) -> dict[str, Any]:
        """One row of the result file. Raises only for problems that cannot be set up."""
        problem = self._scenario.problem(numbered.number)
        goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, q) for name, q in problem.goals.items()}
        trajectory, reason = None, ""
        try:
            trajectory = self._planner.plan_multi(problem.starts, goals)
            status = "solved"
        except srmp.PlanningError as error:
            status, reason = mbm.status_name(error.status), str(error)
        row: dict[str, Any] = {"problem": numbered.name, "status": status, "reason": reason, **problem.about}
        stats = self._planner.get_planning_stats()
        row.update((key, stats.get(key)) for key in _STATISTICS)  # fewer for a refused request
        row["robots"] = {name: self._robot_row(name, problem, stats, trajectory) for name in problem.starts}
        for cost in ("straight_cost_rad", "ee_cost_m"):
            row[cost] = None if trajectory is None else sum(robot[cost] for robot in row["robots"].values())
        row["certificate"] = _joint_certificate([robot["certificate"] for robot in row["robots"].values()])
        return row

    def _robot_row(self, name: str, problem: Problem, stats: Mapping[str, Any], found: Any | None) -> dict[str, Any]:
        base = next(robot.base for robot in self._scenario.world.robots if robot.name == name)
        row: dict[str, Any] = {
            "joint_names": self._planner.get_joint_names(name),
            "base": list(base),
            "start": problem.starts[name],
            "goal": problem.goals[name],
        }
        if found is None:
            row.update(dict.fromkeys(("path", *mbm.COSTS, "certificate", *mbm.PROFILES)))
            return row
        trajectory = found[name]
        row["path"] = trajectory.waypoints
        row["path_cost_rad"] = stats["robot_cost_rad"][name]
        row["straight_cost_rad"] = mbm.straight_length(self._planner, name, trajectory.waypoints)
        row["ee_cost_m"] = mbm.end_effector_length(self._planner, name, trajectory.waypoints)
        row["certificate"] = _certificate(trajectory)
        row.update((profile, getattr(trajectory, profile)) for profile in mbm.PROFILES)
        return row


def _certificate(trajectory: srmp.Trajectory) -> dict[str, Any] | None:
    """As for one robot, and which pair the clearance is of."""
    certificate = trajectory.certificate
    row = mbm.certificate_row(certificate)
    return row if row is None else {**row, "nearest": [certificate.body_a, certificate.body_b]}


def _joint_certificate(certificates: Sequence[Mapping[str, Any] | None]) -> dict[str, Any] | None:
    """Of all robots together; None where a robot has none."""
    known = [certificate for certificate in certificates if certificate is not None]
    if len(known) < len(certificates):
        return None
    closest = min(known, key=lambda certificate: certificate["clearance"])
    return {
        "holds": all(certificate["holds"] for certificate in known),
        "proved_free": all(certificate["proved_free"] for certificate in known),
        **{key: closest[key] for key in ("clearance", "nearest")},
    }


def run(
    scenario: str,
    robots: int | None = None,
    *,
    problems: str = "",
    planner_id: str = "auto",
    options: Mapping[str, str] | None = None,
    time_limit: float = 20.0,
    seed: int = 0,
    data: str | Path | None = None,
    geometry: str = "urdf",
    execution: Execution | None = None,
    progress: Progress[Numbered] | None = None,
    steps: Steps | None = None,
) -> dict[str, Any]:
    """Runs the chosen problems of a scenario (a file, or a name that `find` knows): {"header": …, "rows": […]}.

    runner.run_rows says how. Ctrl-C ends it early: header["complete"] is then False, and the rows are those that were
    finished.
    """
    execution = execution or Execution()
    found = find(scenario, robots, seed, data, geometry)
    settings = (planner_id, options or {}, time_limit)
    chosen = _choose(found, problems)
    runner = Runner(found, *settings, steps)
    described = {
        "scenario": scenario,
        "robots": len(found.world.robots),
        "problems": problems or f"{found.numbers[0]}-{found.numbers[-1]}",
        "planner": planner_id,
        "planner_options": dict(options or {}),
        "time_limit": time_limit,
        "seed": seed,
        "data": data,
        "geometry": geometry,
    }
    rows, complete = run_rows(
        chosen,
        functools.partial(_make_runner, (scenario, robots, seed, data, geometry), settings),
        request=mbm.journal_request("several robots", described),
        solver=runner,
        execution=execution,
        progress=progress,
    )
    header = mbm.run_header("several robots", complete, described, execution, scenario=runner.describe())
    return {"header": header, "rows": rows}


def _make_runner(scenario: tuple[Any, ...], settings: tuple[Any, ...]) -> Runner:
    return Runner(find(*scenario), *settings)


def _choose(scenario: Scenario, problems: str) -> list[Numbered]:
    numbers = sorted(mbm.parse_numbers(problems)) if problems else list(scenario.numbers)
    if 0 in numbers:
        raise srmp.InvalidArgument(f"problems '{problems}': they are numbered from 1.")
    if not scenario.endless:
        numbers = [number for number in numbers if number in scenario.numbers]
    if not numbers:
        raise srmp.InvalidArgument(f"problems '{problems}': '{scenario.name}' has 1 to {scenario.numbers[-1]}.")
    return [Numbered(scenario.name, number) for number in numbers]


# --- statistics -------------------------------------------------------------------------------------------------------


def format_statistics(rows: Sequence[Mapping[str, Any]]) -> str:
    """The table that `srmp bench multi` prints: that of `srmp bench mbm`, then columns of several robots."""
    entry, *_ = mbm.statistics(rows)
    solved = [row for row in rows if row["status"] == "solved"]
    clearances = [row["certificate"]["clearance"] for row in solved if row["certificate"]]
    nodes = f"{np.median([row['tree_nodes'] for row in solved]):.0f}" if solved else "–"
    makespan = f"{np.mean([row['makespan_s'] for row in solved]):.2f} s" if solved else "–"
    clearance = f"{1e3 * min(clearances):.2g} mm" if clearances else "–"
    header = [*mbm.COLUMNS, "nodes", "makespan", "clearance"]
    table = format_table(header, [[*mbm.cells(entry), nodes, makespan, clearance]])
    coefficient = variation(rows)
    if math.isnan(coefficient):
        return table
    return (
        f"{table}\nrepetitions: the summed end-effector length varies by {coefficient:.1%} (standard deviation by mean)"
    )
