"""Measures whether similar problems have similar solutions.

    python bench/suites/consistency.py --data DIR [--out consistency.json]

For MotionBenchMaker's first problems of each scenario, the goal is moved ten times by up to 2 degrees in one joint, to
a configuration that is free and within limits; the moves are the same on every run. Reported are the plans that failed,
the coefficient of variation (standard deviation / mean) of the end effector's path length over a problem's ten goals,
and the change of that length (the mean relative difference to the path to the problem's own goal), both as means over
problems.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._files import write_json
from srmp._table import format_table
from srmp.bench import mbm
from srmp.bench.repeated import coefficient_of_variation
from srmp.cli import parse_key_values

LARGEST_MOVE = np.radians(2.0)
GOALS = 10
PLANNERS = ("auto", "wAstar")


def moved_goals(planner: srmp.PlannerInterface, robot: str, goal: np.ndarray, seed: list[int]) -> list[np.ndarray]:
    """GOALS free configurations, each of which differs from `goal` in one joint."""
    random = np.random.default_rng(seed)
    limits = planner.get_joint_limits(robot)
    goals: list[np.ndarray] = []
    for _ in range(100 * GOALS):
        if len(goals) == GOALS:
            return goals
        q = goal.copy()
        q[random.integers(len(q))] += random.uniform(-LARGEST_MOVE, LARGEST_MOVE)
        if (limits[:, 0] <= q).all() and (q <= limits[:, 1]).all() and not planner.is_state_colliding(robot, q):
            goals.append(q)
    raise RuntimeError("too few configurations near a goal are free")


def row_of(
    planner: srmp.PlannerInterface,
    robot: str,
    problem: mbm.Problem,
    start: np.ndarray,
    goals: list[np.ndarray],
    threads: int,
) -> dict[str, Any]:
    """Lengths of the paths to the problem's own goal (the first) and to the moved goals; None without a path."""
    requests = [srmp.PlanRequest(robot, start, srmp.GoalConstraint(srmp.GoalType.JOINTS, q)) for q in goals]
    results = planner.plan_many(requests, threads)
    own, *moved = [
        mbm.end_effector_length(planner, robot, result.trajectory.waypoints) if result.solved else None
        for result in results
    ]
    solved = [length for length in moved if length is not None]
    return {
        "problem": problem.name,
        "ee_length_m": own,
        "ee_lengths_m": moved,
        "failed": [f"{result.status.name}: {result.reason}" for result in results[1:] if not result.solved],
        "variation": coefficient_of_variation(solved) if len(solved) > 1 else None,
        "change": float(np.mean(np.abs(np.array(solved) / own - 1))) if own and solved else None,
    }


def run(
    data: str,
    robot: str,
    geometry: str,
    problems: str,
    planners: list[str],
    time_limit: float,
    threads: int,
    options: dict[str, str],
) -> dict[str, Any]:
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "auto", {}, time_limit)
    rows: dict[str, list[dict[str, Any]]] = {planner_id: [] for planner_id in planners}
    with mbm.open_problems(files.directory, robot, (), mbm.parse_numbers(problems)) as chosen:
        for at, problem in enumerate(chosen):
            planner, moveit_problem = runner.set_up(problem)
            own = moveit_problem.goals[0].targets[0]
            goals = [own, *moved_goals(planner, robot, own, [at, problem.number])]
            for planner_id in planners:
                planner.make_planner(robot, {"planner_id": planner_id, "time_limit": time_limit, **options})
                rows[planner_id].append(row_of(planner, robot, problem, moveit_problem.start, goals, threads))
    settings = {"robot": robot, "geometry": geometry, "problems": problems, "time_limit": time_limit, **options}
    header = mbm.header("consistency", options=settings)
    return {"header": header, "planners": {name: {**summary(r), "rows": r} for name, r in rows.items()}}


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    variations = [row["variation"] for row in rows if row["variation"] is not None]
    changes = [row["change"] for row in rows if row["change"] is not None]
    return {
        "plans": GOALS * len(rows),
        "failed": sum(len(row["failed"]) for row in rows),
        "mean_variation": float(np.mean(variations)),
        "median_variation": float(np.median(variations)),
        "largest_variation": float(np.max(variations)),
        "mean_change": float(np.mean(changes)),
    }


def table(result: dict[str, Any]) -> str:
    lines = []
    for name, found in result["planners"].items():
        fractions = [found[f"{which}_variation"] for which in ("mean", "median", "largest")] + [found["mean_change"]]
        lines.append(
            [name, f"{found['failed']}/{found['plans']}", *(f"{100 * fraction:.1f} %" for fraction in fractions)]
        )
    return format_table(["planner", "failed", "variation (mean)", "median", "largest", "change (mean)"], lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--geometry", choices=["urdf", "spheres"], default="urdf")
    parser.add_argument("--problems", default="1-5", help="numbers in each scenario")
    parser.add_argument("--planner", dest="planners", action="append", help="may be repeated; default: auto and wAstar")
    parser.add_argument("--time-limit", type=float, default=10.0)
    parser.add_argument("--option", dest="options", action="append", default=[], help="KEY=VALUE; may be repeated")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    options = vars(parser.parse_args())
    out = options.pop("out")
    options["planners"] = options["planners"] or list(PLANNERS)
    options["options"] = parse_key_values(options["options"])
    result = run(**options)
    print(table(result))
    if out:
        write_json(out, result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
