"""Checks that a time limit which is not reached does not change the result.

    python bench/suites/any_limit.py --data DIR [--cases 40] [--repeats 2] [--out any_limit.json]

Each case is planned with a generous limit, which says how long it takes, and then with limits from 1.2 to 50 times
as long, and all of that again beside a process that keeps another core busy. Plans that end before their limit must
have one hash: waypoints, samples and times of all trajectories, or the status. Plans that reach their limit (on a busy
machine those of the shortest limits do) are counted and not compared. The cases are of several robots (generated
scenarios, half of them around motions that other robots are committed to) with each planner, and of one robot with each
planner and with improve_rounds. The exit code is 1 when any case has two different hashes.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import itertools
import multiprocessing
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import overshoot
from report import run_and_report

import srmp
from srmp._table import format_table
from srmp.bench import mbm
from srmp.bench.scenarios import find

GENEROUS = 60.0  # [s]; cases that take longer are left out
FACTORS = (1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 25.0, 50.0)
SCENARIOS = (("binpick", 4), ("shelves", 3), ("ring", 4), ("grid", 8))
PLANNERS: tuple[dict[str, Any], ...] = (
    {"planner_id": "xECBS"},
    {"planner_id": "auto"},
    {"planner_id": "xECBS"},
    {"planner_id": "Prioritised"},
    {"planner_id": "ECBS"},
    {"planner_id": "auto", "num_threads": 2},
)
ONE_ROBOT: tuple[dict[str, Any], ...] = (
    {"planner_id": "auto"},
    {"planner_id": "auto", "improve_rounds": 3},
    {"planner_id": "RRTConnect"},
    {"planner_id": "wAstar", "weight": 10.0},
    {"planner_id": "MHAstar"},
    {"planner_id": "ARAstar", "final_weight": 5.0},
    {"planner_id": "wPASE", "num_threads": 2},
)

Outcome = tuple[str, float]
"""Hash of the trajectories, or the status; total_time_s."""


@dataclass(frozen=True)
class Case:
    """`plan` plans it with a time limit [s]."""

    name: str
    plan: Callable[[float], Outcome]


def outcome(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> Outcome:
    """Of a plan by `planner`, which has just been made."""
    try:
        found = plan()
        trajectories = [found] if isinstance(found, srmp.Trajectory) else [found[name] for name in sorted(found)]
        arrays = [array for t in trajectories for array in (t.waypoints, t.positions, t.times)]
        digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()[:16]
    except srmp.PlanningError as error:
        digest = error.status.name
    return digest, planner.get_planning_stats()["total_time_s"]


@dataclass
class Compared:
    """The different results of a case, and the limits that each was given for."""

    need_s: float
    limits_of: dict[str, list[float]]
    reached: int

    @property
    def same(self) -> bool:
        return len(self.limits_of) == 1


def compare(case: Case, factors: Sequence[float], repeats: int, generous: float = GENEROUS) -> Compared | None:
    """None: even the generous limit was reached."""
    digest, need = case.plan(generous)
    if need >= generous:
        return None
    compared = Compared(need, {digest: [generous]}, 0)
    for factor, _ in itertools.product(factors, range(repeats)):
        limit = factor * need
        digest, total = case.plan(limit)
        if total < limit:
            compared.limits_of.setdefault(digest, []).append(limit)
        else:
            compared.reached += 1
    return compared


# --- cases


def described(options: Mapping[str, Any]) -> str:
    return ", ".join(str(value) for value in options.values())


def joints(q: np.ndarray) -> srmp.GoalConstraint:
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


def several(
    name: str,
    planner: srmp.PlannerInterface,
    starts: Mapping[str, np.ndarray],
    goals: Mapping[str, np.ndarray],
    options: Mapping[str, Any],
    obstacles: Mapping[str, srmp.Trajectory] | None = None,
) -> Case:
    """A case of several robots."""
    constraints = {robot: joints(q) for robot, q in goals.items()}

    def plan(limit: float) -> Outcome:
        planner.make_planner(list(starts), {**options, "time_limit": limit})
        return outcome(planner, lambda: planner.plan_multi(dict(starts), constraints, obstacles=dict(obstacles or {})))

    return Case(f"{name} {described(options)}{', obstacles' if obstacles else ''}", plan)


def around_others(name: str, planner: srmp.PlannerInterface, problem: Any, options: Mapping[str, Any]) -> Case | None:
    """The first half of the robots is planned around the motions of the others, which are found first."""
    robots = list(problem.starts)
    half = len(robots) // 2
    planned, others = robots[:half], robots[half:]
    planner.make_planner(others, {"planner_id": "xECBS", "time_limit": GENEROUS})
    for robot in planned:
        planner.set_qpos(robot, problem.starts[robot])
    goals = {robot: joints(problem.goals[robot]) for robot in others}
    with contextlib.suppress(srmp.PlanningError):
        committed = planner.plan_multi({robot: problem.starts[robot] for robot in others}, goals)
        starts = {robot: problem.starts[robot] for robot in planned}
        ends = {robot: problem.goals[robot] for robot in planned}
        return several(name, planner, starts, ends, options, {robot: committed[robot] for robot in others})
    return None


def generated(data: str) -> Iterator[Case | None]:
    """Problems of the scenarios in turn, each with the next planner, together and around others."""
    worlds = [find(scenario, robots, 0, data) for scenario, robots in SCENARIOS]
    planners = [world.world.build() for world in worlds]
    for k in itertools.count():
        scenario, planner = worlds[k % len(worlds)], planners[k % len(worlds)]
        number = 1 + 5 * (k // len(worlds))
        problem, options = scenario.problem(number), PLANNERS[k % len(PLANNERS)]
        name = f"{scenario.name}/{number:04d}"
        yield several(name, planner, problem.starts, problem.goals, options)
        yield around_others(name, planner, problem, options)


def committed() -> Iterator[Case]:
    """Two arms across a table, one of which is committed."""
    planner = overshoot.two_arms()
    names = planner.get_joint_names("right")
    for number, (times, angles, start, end) in enumerate(overshoot.AMONG_COMMITTED, 1):
        rows = np.array([overshoot.turned(angle) for angle in angles])
        motion = srmp.Trajectory(names, rows, times, np.zeros(rows.shape))
        starts, goals = {"left": overshoot.turned(start)}, {"left": overshoot.turned(end)}
        yield several(f"committed {number}", planner, starts, goals, {"planner_id": "xECBS"}, {"right": motion})


def single(planner: srmp.PlannerInterface, robot: str, name: str, problem: Any, options: Mapping[str, Any]) -> Case:
    """A case of one robot."""

    def plan(limit: float) -> Outcome:
        planner.make_planner(robot, {**options, "time_limit": limit})
        return outcome(planner, lambda: planner.plan(robot, problem.start, problem.goals))

    return Case(f"{name} {described(options)}", plan)


def of_one_robot(data: str, robot: str) -> Iterator[Case]:
    files = mbm.robot_files(data, robot, "urdf")
    runner = mbm.Runner(files, "auto", {}, GENEROUS)
    with mbm.open_problems(files.directory, robot, overshoot.SCENARIOS, mbm.parse_numbers("1-2")) as chosen:
        for problem in chosen:
            planner, moveit_problem = runner.set_up(problem)
            for options in ONE_ROBOT:
                yield single(planner, robot, problem.name, moveit_problem, options)


# --- the run


def spin() -> None:
    while True:
        pass


@contextlib.contextmanager
def busy_neighbour(busy: bool) -> Iterator[None]:
    """A process that keeps a core busy."""
    process = multiprocessing.get_context("spawn").Process(target=spin, daemon=True)
    if busy:
        process.start()
    try:
        yield
    finally:
        if busy:
            process.terminate()
            process.join()


def run(data: str, robot: str, cases: int, repeats: int) -> dict[str, Any]:
    several_robots = itertools.chain(committed(), generated(data))
    rows, left_out = [], 0

    def measure(case: Case) -> bool:
        found = []
        for busy in (False, True):
            with busy_neighbour(busy):
                found.append(compare(case, FACTORS, repeats))
        known = [compared for compared in found if compared is not None]
        if not known:
            return False
        limits_of: dict[str, list[float]] = {}
        for compared in known:
            for digest, limits in compared.limits_of.items():
                limits_of.setdefault(digest, []).extend(limits)
        rows.append(
            {
                "case": case.name,
                "need_s": known[0].need_s,
                "limits_s": limits_of,
                "reached": sum(compared.reached for compared in known),
            }
        )
        print_row(rows[-1])
        return True

    while len(rows) < cases:
        case = next(several_robots)
        left_out += case is None or not measure(case)
    for case in of_one_robot(data, robot):
        left_out += not measure(case)
    options = {"robot": robot, "cases": cases, "repeats": repeats, "factors": FACTORS}
    return {"header": mbm.header("any limit", options=options), "left_out": left_out, "rows": rows}


def print_row(row: Mapping[str, Any]) -> None:
    hashes = Counter({digest: len(limits) for digest, limits in row["limits_s"].items()})
    print(f"{row['case']}: {row['need_s']:.3f} s, {dict(hashes)}, limit reached {row['reached']} times", flush=True)


def table(result: Mapping[str, Any]) -> str:
    rows = result["rows"]
    different = [row for row in rows if len(row["limits_s"]) > 1]
    plans = sum(len(limits) for row in rows for limits in row["limits_s"].values())
    return format_table(
        ["cases", "plans before their limit", "at it", "cases with several answers", "left out"],
        [
            [
                str(len(rows)),
                str(plans),
                str(sum(row["reached"] for row in rows)),
                str(len(different)),
                str(result["left_out"]),
            ]
        ],
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda", help="of the cases of one robot")
    parser.add_argument("--cases", type=int, default=40, help="of several robots")
    parser.add_argument("--repeats", type=int, default=2, help="of each limit")
    result = run_and_report(parser, run, table)
    return int(any(len(row["limits_s"]) > 1 for row in result["rows"]))


if __name__ == "__main__":
    sys.exit(main())
