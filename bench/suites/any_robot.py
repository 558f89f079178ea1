"""Plans arms that planner.add_robot knows by name among random boxes: robots that no other benchmark names.

    python bench/suites/any_robot.py [--robots ur10 so100 …] [--worlds 3] [--problems 10] [--baseline PYTHON]
                                     [--out any_robot.json]

Needs example-robot-data (pip install example-robot-data). Each world has boxes around where the end effector can be, of
random sizes, none of which touches the robot at rest; each problem is from one random free configuration to another.
Times are of `auto` with the robot's better covers (planner.prepare()), the best of --repeats: until the path is ready,
then its timing and its certificate. Problems that are not solved have no time; those that `auto` proves to have no
path within --limit are counted. With --baseline each robot is planned in turns by the srmp of another Python
environment, and the last column is the median ratio of the whole call.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import warnings
from typing import Any

import numpy as np
from report import result_of, run_and_report

import srmp
from srmp._table import format_seconds, format_table

ARMS = (
    *("panda", "ur3_gripper", "ur5", "ur10", "kinova", "xarm6", "xarm7", "z1", "so100", "so101", "baxter", "pr2"),
    *("tiago", "tiago_pro", "talos_left_arm", "anymal_kinova", "b1_z1"),
)
PARTS = {"path": "plan_time_s", "timing": "timing_time_s", "certificate": "verification_time_s", "call": "total_time_s"}
SAMPLES = 200  # configurations that show where the end effector can be
MAX_TRIES = 4000  # configurations of which enough are free, or the world has fewer problems


def random_world(robot: str, boxes: int, random: np.random.Generator) -> srmp.PlannerInterface:
    planner = srmp.PlannerInterface()
    planner.add_robot(robot, name="robot")
    limits = joint_ranges(planner)
    reached = np.array([planner.compute_fk("robot", random.uniform(*limits)).p for _ in range(SAMPLES)])
    middle = np.median(reached, axis=0)
    radius = float(np.percentile(np.linalg.norm(reached - middle, axis=1), 90))
    rest, added = planner.get_qpos("robot"), 0
    for k in range(10 * boxes):
        size, place = random.uniform(0.05, 0.3, 3) * radius, middle + random.uniform(-1, 1, 3) * radius
        planner.add_box(f"box {k}", size, srmp.Pose(p=place))
        if planner.is_state_colliding("robot", rest):
            planner.remove_object(f"box {k}")
            continue
        added += 1
        if added == boxes:
            break
    return planner


def joint_ranges(planner: srmp.PlannerInterface) -> np.ndarray:
    return np.clip(planner.get_joint_limits("robot")[:, :2].T, -np.pi, np.pi)


def free_configurations(planner: srmp.PlannerInterface, count: int, random: np.random.Generator) -> list[np.ndarray]:
    limits, found = joint_ranges(planner), []
    for _ in range(MAX_TRIES):
        q = random.uniform(*limits)
        if not planner.is_state_colliding("robot", q):
            found.append(q)
            if len(found) == count:
                break
    return found


def best_times(planner: srmp.PlannerInterface, start: np.ndarray, goal: np.ndarray, repeats: int) -> dict[str, Any]:
    times = []
    for _ in range(repeats):
        try:
            planner.plan("robot", start, goal)
        except srmp.PlanningError as error:
            return {"status": error.status.name, "reason": str(error)}
        statistics = planner.get_planning_stats()
        times.append([statistics[key] for key in PARTS.values()])
    return {"status": "solved", **dict(zip(PARTS.values(), np.min(times, axis=0).tolist(), strict=True))}


def plan_robot(robot: str, worlds: int, problems: int, boxes: int, repeats: int, limit: float) -> list[dict[str, Any]]:
    random, rows = np.random.default_rng(0), []
    for world in range(worlds):
        planner = random_world(robot, boxes, random)
        free = free_configurations(planner, 2 * problems, random)
        planner.prepare()
        planner.make_planner("robot", {"planner_id": "auto", "time_limit": limit})
        for i, (start, goal) in enumerate(zip(free[::2], free[1::2], strict=False)):
            row = best_times(planner, start, goal, repeats)
            rows.append({"robot": robot, "dof": len(start), "world": world, "problem": i, **row})
    return rows


def run(robots: list[str], baseline: str | None, **options: Any) -> dict[str, Any]:
    rows = []
    for robot in robots:
        for python, is_baseline in ((sys.executable, False), (baseline, True)):
            if not python:
                continue
            command = [python, __file__, "--one", robot, *(f"--{key}={value}" for key, value in options.items())]
            found = result_of(f"'{robot}' by {python}", command)
            rows += [{**row, "baseline": is_baseline} for row in found]
        print(table({"rows": [row for row in rows if row["robot"] == robot]}).splitlines()[-1], flush=True)
    return {"options": options, "rows": rows}


def median_ratio(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> str:
    pairs = [(a, b) for a, b in zip(ours, theirs, strict=False) if a["status"] == b["status"] == "solved"]
    return f"{np.median([a['total_time_s'] / b['total_time_s'] for a, b in pairs]):.2f}" if pairs else "–"


def percentile(rows: list[dict[str, Any]], key: str, percent: int) -> str:
    return format_seconds(float(np.percentile([row[key] for row in rows], percent))) if rows else "–"


def table(result: dict[str, Any]) -> str:
    lines = []
    for robot in dict.fromkeys(row["robot"] for row in result["rows"]):
        ours, theirs = (
            [row for row in result["rows"] if row["robot"] == robot and row["baseline"] is is_baseline]
            for is_baseline in (False, True)
        )
        solved = [row for row in ours if row["status"] == "solved"]
        times = [percentile(solved, key, 50) for key in PARTS.values()] + [percentile(solved, PARTS["path"], 95)]
        dof = str(ours[0]["dof"]) if ours else "–"
        counts = [f"{len(solved)}/{len(ours)}", str(sum(row["status"] == "exhausted" for row in ours))]
        lines.append([robot, dof, *counts, *times, median_ratio(ours, theirs)])
    return format_table(["robot", "dof", "solved", "no path", *PARTS, "path, 95 %", "ratio"], lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--robots", nargs="+", default=list(ARMS), help="names (default: %(default)s)")
    parser.add_argument("--worlds", type=int, default=3)
    parser.add_argument("--problems", type=int, default=10, help="of each world")
    parser.add_argument("--boxes", type=int, default=15, help="of each world")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=2.0, help="time limit of a plan [s]")
    if "--one" in sys.argv:
        parser.add_argument("--one")
        options = vars(parser.parse_args())
        options["robot"] = options.pop("one")
        del options["robots"]
        warnings.simplefilter("ignore")
        print(json.dumps(plan_robot(**options)))
        return
    parser.add_argument("--baseline", help="the Python of another environment with srmp, measured in turns")
    run_and_report(parser, run, table)


if __name__ == "__main__":
    main()
