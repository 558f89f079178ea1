"""stop and replan at random instants of motions in MotionBenchMaker's problems: continuous, within limits, certified.

    python bench/suites/stop_and_replan.py --data DIR [--robot panda] [--instants 100] [--timing toppra] [--out F.json]

Each instant is one of a motion from the start to the goal of a problem; the new goal is the start of the motion, or a
random configuration up to 0.3 rad from its end. Position and velocity of what is found are compared with those
of the motion, bit for bit, and it is verified again by `verify`, which plans nothing.

The exit code is 1 when a motion is not continuous, exceeds a limit, or is not proved free.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm


def rows_of(data: str, robot: str, instants: int, seed: int, timing: str) -> Iterator[dict[str, Any]]:
    files = mbm.robot_files(data, robot, "urdf")
    runner = mbm.Runner(files, "auto", {"timing": timing}, 10.0)
    rng = np.random.default_rng([seed, instants])
    with mbm.open_problems(files.directory, robot) as problems:
        for number in range(instants):
            problem = problems[number * len(problems) // instants]
            planner, request = runner.set_up(problem)
            try:
                motion = planner.plan(robot, request.start, request.goals)
            except srmp.PlanningError:
                continue
            t = rng.uniform(0, motion.duration)
            goal = request.start if number % 2 else motion.positions[-1] + rng.uniform(-0.3, 0.3, len(request.start))
            yield {"problem": problem.name, "t": t, **row_of(planner, robot, motion, t, goal, timing)}


def row_of(
    planner: srmp.PlannerInterface, robot: str, motion: srmp.Trajectory, t: float, goal: np.ndarray, timing: str
) -> dict[str, Any]:
    row: dict[str, Any] = {"duration_s": motion.duration, "speed": float(np.abs(motion.state(t)[1]).max())}
    for name, plan in (
        ("stop", lambda: planner.stop(robot, motion, t)),
        ("replan", lambda: planner.replan(robot, motion, t, goal)),
    ):
        begin = time.perf_counter()
        try:
            found = plan()
        except srmp.PlanningError as error:
            row[name] = {"status": mbm.status_name(error.status), "reason": str(error)}
            continue
        wall = time.perf_counter() - begin
        row[name] = {
            "status": "solved",
            "wall_s": wall,
            "duration_s": found.duration,
            "valid": is_valid(planner, robot, motion, t, found, timing == "ruckig"),
        }
    return row


def is_valid(
    planner: srmp.PlannerInterface, robot: str, motion: srmp.Trajectory, t: float, found: srmp.Trajectory, jerk: bool
) -> bool:
    position, velocity, acceleration, _ = motion.state(t)
    certificate = planner.verify(
        robot,
        found,
        start=position,
        jerk=jerk,
        start_velocity=velocity,
        start_acceleration=acceleration if jerk else None,
    )
    same = np.array_equal(found.positions[0], position) and np.allclose(
        found.velocities[0], velocity, rtol=0, atol=1e-9
    )
    return bool(same and certificate.holds and certificate.proved_free and found.certificate.holds)


def run(data: str, robot: str, instants: int, seed: int, timing: str) -> dict[str, Any]:
    options = {"robot": robot, "instants": instants, "seed": seed, "timing": timing}
    rows = list(rows_of(data, robot, instants, seed, timing))
    return {"header": mbm.header("stop_and_replan", options=options), "rows": rows}


def is_wrong(row: dict[str, Any]) -> bool:
    return any(row[name]["status"] == "solved" and not row[name]["valid"] for name in ("stop", "replan"))


def table(result: dict[str, Any]) -> str:
    lines = []
    for name in ("stop", "replan"):
        of = [row[name] for row in result["rows"]]
        solved = [row for row in of if row["status"] == "solved"]
        walls, durations = ([row[key] for row in solved] for key in ("wall_s", "duration_s"))
        invalid_goals = sum(row["status"] == "goal_invalid" for row in of)
        lines.append(
            [
                name,
                f"{len(solved)}/{len(of) - invalid_goals}",
                str(invalid_goals),
                *(format_seconds(float(np.percentile(walls, p))) for p in (50, 95)),
                format_seconds(float(np.median(durations))),
                str(sum(not row["valid"] for row in solved)),
            ]
        )
    return format_table(["", "solved", "goals invalid", "call median", "p95", "motion median", "wrong"], lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda", choices=sorted(mbm.GROUPS), help="default: panda")
    parser.add_argument("--instants", type=int, default=100, help="default: 100")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--timing", default="toppra", choices=("toppra", "ruckig"), help="default: toppra")
    return int(any(map(is_wrong, run_and_report(parser, run, table)["rows"])))


if __name__ == "__main__":
    sys.exit(main())
