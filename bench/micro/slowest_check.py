"""The slowest single motion check of the benchmarks, by robot and scenario.

    python bench/micro/slowest_check.py --data DIR [--multi-data DIR] --out slowest.json
                                                            builds bench_slowest_check, measures, prints the table
    python bench/micro/slowest_check.py --table slowest.json     prints the table of an earlier run

Each problem is planned by the planners of --planner (several robots: auto alone), saved, and planned again by
bench_slowest_check, which times each motion check that the plan makes. CPU time of one thread; the slowest check of a
problem is repeated, and the best time counts.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from checks import MODELS, build, label, run_or_print

import srmp
from srmp._table import format_table
from srmp.bench import mbm
from srmp.bench.scenarios import find

LIMIT = 10.0  # [s] of one plan
TOGETHER = (("binpick", None), ("shelves", None), ("grid", 8), ("ring", 8))
ALL_STATES = ("panda_two_rod", "panda_four")  # of --multi-data

Saved = tuple[str, str]  # robots and scenario of the problem that is in the file until the next one


def alone(data: Path, problems: str, planners: Sequence[str], file: Path) -> Iterator[Saved]:
    for robot, geometry in MODELS:
        files = mbm.robot_files(str(data), robot, geometry)
        runner = mbm.Runner(files, "auto", {}, LIMIT)
        with mbm.open_problems(files.directory, robot, (), mbm.parse_numbers(problems)) as chosen:
            for problem, planner_id in itertools.product(chosen, planners):
                planner, own = runner.set_up(problem)
                planner.make_planner(robot, {"planner_id": planner_id, "time_limit": LIMIT})
                with contextlib.suppress(srmp.PlanningError):
                    planner.plan(robot, own.start, own.goals)
                planner.save(file)
                yield label(robot, geometry), problem.name.split("/")[0]


def together(data: Path, multi_data: Path | None, problems: str, file: Path) -> Iterator[Saved]:
    scenarios = [(name, robots, data) for name, robots in TOGETHER]
    scenarios += [(f"{multi_data}/{name}.json", None, multi_data) for name in ALL_STATES if multi_data]
    for scenario, robots, own_data in scenarios:
        found = find(scenario, robots, 0, str(own_data))
        planner = found.world.build()
        names = [robot.name for robot in found.world.robots]
        planner.make_planner(names, {"planner_id": "auto", "time_limit": LIMIT})
        for number in sorted(set(mbm.parse_numbers(problems)) & set(found.numbers)):
            problem = found.problem(number)
            goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, q) for name, q in problem.goals.items()}
            with contextlib.suppress(srmp.PlanningError):
                planner.plan_multi(problem.starts, goals)
            planner.save(file)
            yield "several", Path(scenario).stem


def measure(program: Path, file: Path) -> dict[str, Any]:
    done = subprocess.run([program, file], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{program} failed: {done.stderr.strip()}")
    return json.loads(done.stdout)


def run(options: argparse.Namespace) -> dict[str, Any]:
    program = options.program or build("bench_slowest_check")
    rows = []
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "problem.srmp.json"
        saved = alone(options.data, options.problems, options.planners or ["auto"], file)
        both = itertools.chain(saved, together(options.data, options.multi_data, options.problems, file))
        for robot, scenario in both:
            rows.append({"robot": robot, "scenario": scenario, **measure(program, file)})
    return {"header": mbm.header("slowest check", options={"problems": options.problems}), "rows": rows}


def table(result: dict[str, Any]) -> str:
    lines = []
    for robot, rows in itertools.groupby(result["rows"], key=lambda row: row["robot"]):
        own = list(rows)
        slowest = max(own, key=lambda row: row["seconds"])
        count = sum(row["checks"] for row in own)
        lines.append([robot, str(len(own)), f"{count:,}", f"{1e3 * slowest['seconds']:.2f} ms", slowest["scenario"]])
    return format_table(["robots", "plans", "motion checks", "slowest", "in"], lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--multi-data", type=Path, help="directory of panda_two_rod.json and panda_four.json")
    parser.add_argument("--problems", default="1-10", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument("--planner", dest="planners", action="append", help="may be repeated; default: auto")
    parser.add_argument("--program", type=Path, help="bench_slowest_check, if it is built already")
    run_or_print(parser, run, table)


if __name__ == "__main__":
    main()
