"""Loads every robot of the PyPI package example-robot-data, with and without its SRDF and for every group, and plans.

    python bench/suites/robots.py [--listed | --robots DIR] [--only TEXT] [--limit 60] [--no-plans] [--out robots.json]

Needs example-robot-data (pip install example-robot-data), or --robots with a directory of such files. Writes a JSON
file, and beside it a Markdown table: whether each robot loads, and what is said where it does not; how long the load,
the first plan and a later plan take; how many warnings there are. The first row of each robot begins with an empty
cache. A plan is from the first free configuration of a fixed sequence to the second, by `auto`. Times are by the clock
or, where that is less because the machine is busy, CPU times of the process, with what it prepares in the background.
Each row is a process of its own, which ends after --limit seconds. A group of several chains is planned with the first
end effector that the refusal names.

With --listed there is one row for each robot of that package that planner.add_robot knows by name, with the group of
the list, and the goal is the pose of the end effector at the second configuration.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import warnings
import xml.etree.ElementTree as ET
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import srmp
import srmp.robots
from srmp._files import write_json
from srmp._table import format_seconds
from srmp.bench import mbm
from srmp.bench.scenes import example_robot_data

MAX_TRIES = 300  # configurations, until two are free
TIME_LIMIT = 30.0  # [s] of a plan


@dataclass(frozen=True)
class Case:
    """One row: a robot's files, and what of it is planned."""

    urdf: str
    srdf: str = ""
    group: str = ""
    end_effector: str = ""
    name: str = ""  # of the list of known robots, which says all else

    def label(self, root: Path) -> str:
        name = str(Path(self.urdf).relative_to(root))
        return name + (f" + {Path(self.srdf).name}" if self.srdf else "")


class Stopwatch:
    def __init__(self) -> None:
        self.clock, self.cpu = time.perf_counter(), time.process_time()

    def seconds(self) -> float:
        """By the clock, or CPU time of the process, whichever is less."""
        return min(time.perf_counter() - self.clock, time.process_time() - self.cpu)


# --- what there is ----------------------------------------------------------------------------------------------------


def cases_of(urdf: Path, srdfs: list[Path]) -> list[Case]:
    """Without an SRDF the whole robot, or its longest chain; with one, every group."""
    cases = [Case(str(urdf), end_effector=longest_chain(urdf))]
    for srdf in srdfs:
        groups = [group.get("name", "") for group in ET.parse(srdf).getroot().findall("group")]
        cases += [Case(str(urdf), str(srdf), group) for group in groups] or [
            Case(str(urdf), str(srdf), end_effector=longest_chain(urdf))
        ]
    return cases


def longest_chain(urdf: Path) -> str:
    """The leaf link with the most movable joints above it; "" where there is one leaf only."""
    robot = ET.parse(urdf).getroot()
    above = {joint.find("child").get("link"): joint for joint in robot.findall("joint")}
    parents = {joint.find("parent").get("link") for joint in above.values()}
    leaves = [link.get("name") for link in robot.findall("link") if link.get("name") not in parents]
    if len(leaves) < 2:
        return ""

    def movable(link: str) -> int:
        count = 0
        while link in above:
            count += above[link].get("type") in ("revolute", "continuous", "prismatic")
            link = above[link].find("parent").get("link")
        return count

    return max(leaves, key=movable)


def srdfs_of(urdf: Path, package: Path) -> list[Path]:
    """Those of the package that are of the robot by file name or by the name inside, or all if there is one URDF."""
    only = len(list(package.rglob("*.urdf"))) == 1
    name = ET.parse(urdf).getroot().get("name")

    def fits(srdf: Path) -> bool:
        return only or urdf.stem.startswith(srdf.stem) or ET.parse(srdf).getroot().get("name") == name

    return [srdf for srdf in sorted(package.rglob("*.srdf")) if fits(srdf)]


# --- one row, in a process of its own ---------------------------------------------------------------------------------


def measure(case: Case, package_dir: str, plans: bool) -> None:
    """Prints a JSON object after every step, so that what was done before the limit is known."""
    row: dict[str, Any] = {}

    def report(**values: Any) -> None:
        row.update(values)
        print(json.dumps(row), flush=True)

    planner = srmp.PlannerInterface()
    watch = Stopwatch()
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            if case.name:
                planner.add_robot(case.name, name="robot")
            else:
                planner.add_articulation(
                    urdf_path=case.urdf,
                    srdf_path=case.srdf,
                    name="robot",
                    group=case.group,
                    end_effector=case.end_effector,
                    package_dirs=[package_dir],
                )
    except srmp.Error as error:
        ends = re.search(r"give end_effector, such as '(.*?)'", str(error))
        report(loads=False, says=str(error), **({"end_effector": ends[1]} if ends else {}))
        return
    report(loads=True, load_s=watch.seconds(), dof=len(planner.get_joint_names("robot")))
    report(warnings=[str(warning.message) for warning in caught])
    if not plans:
        return
    ends = free_configurations(planner, 2)
    if len(ends) < 2:
        report(says=f"no two of {MAX_TRIES} configurations are free")
        return
    goal = planner.compute_fk("robot", ends[1]) if case.name else ends[1]
    for key in ("first_plan_s", "later_plan_s"):
        watch = Stopwatch()
        try:
            planner.make_planner("robot", {"planner_id": "auto", "time_limit": TIME_LIMIT})
            planner.plan("robot", ends[0], goal)
            report(**{key: watch.seconds()})
        except srmp.PlanningError as error:
            report(**{key: watch.seconds()}, says=f"{error.status.name}: {error}")


def free_configurations(planner: srmp.PlannerInterface, count: int) -> list[np.ndarray]:
    """The first of a fixed sequence: where the robot stands, then random ones, near it before far from it."""
    random = np.random.default_rng(0)
    rest = planner.get_qpos("robot")
    lower, upper = np.clip(planner.get_joint_limits("robot")[:, :2].T, -np.pi, np.pi)
    found = []
    for k in range(MAX_TRIES):
        spread = min(1.0, 3 * k / MAX_TRIES + (0.3 if k else 0.0))
        q = np.clip(rest + spread * (random.uniform(lower, upper) - rest), lower, upper) if k else rest
        if not planner.is_state_colliding("robot", q):
            found.append(q)
            if len(found) == count:
                break
    return found


def run(case: Case, package_dir: Path, cache: str, limit: float, plans: bool) -> dict[str, Any]:
    command = [sys.executable, __file__, "--row", json.dumps(asdict(case)), "--robots", str(package_dir)]
    command += [] if plans else ["--no-plans"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "SRMP_CACHE_DIR": cache}
    )
    try:
        printed, errors = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        process.kill()
        printed, errors = process.communicate()
        errors = f"ended after {limit:g} s"
    lines = printed.splitlines()
    row = json.loads(lines[-1]) if lines else {"loads": None}
    return row if process.returncode == 0 else {**row, "says": errors.strip().splitlines()[-1] if errors else "crashed"}


# --- the table --------------------------------------------------------------------------------------------------------


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""

    def seconds(value: float | None) -> str:
        return "–" if value is None else format_seconds(value)

    lines = [
        "| robot | planned | dof | loads | load | first plan | later plan | warnings | what is said |",
        "|---" * 9 + "|",
    ]
    for row in rows:
        loads = {True: "yes", False: "no", None: "?"}[row["loads"]]
        times = " | ".join(seconds(row.get(key)) for key in ("load_s", "first_plan_s", "later_plan_s"))
        said = row.get("says", "").replace("|", "\\|")
        lines.append(
            f"| {row['robot']} | {row['planned']} | {row.get('dof', '–')} | {loads} | {times} | "
            f"{len(row.get('warnings', []))} | {said} |"
        )
    return "\n".join(lines) + "\n"


def run_listed(root: Path, options: argparse.Namespace) -> None:
    """One row for each robot that has a name, each with an empty cache."""
    rows: list[dict[str, Any]] = []
    for name, robot in srmp.robots.available().items():
        if robot.package != "example-robot-data" or options.only not in name:
            continue
        with tempfile.TemporaryDirectory() as cache:
            row = run(
                Case(str(robot.urdf_path), name=name), root.parents[1], cache, options.limit, not options.no_plans
            )
        rows.append({"robot": name, "planned": robot.title, **row})
        print(table(rows[-1:]).splitlines()[-1], flush=True)
        write_json(options.out, {"header": mbm.header("robots", limit_s=options.limit), "rows": rows})
        Path(options.out).with_suffix(".md").write_text(table(rows))
    print(f"{sum(row['loads'] is True for row in rows)} of {len(rows)} robots load; wrote {options.out}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--listed", action="store_true", help="the robots of the package that have names")
    parser.add_argument("--robots", help="directory with the robots; default: that of example-robot-data")
    parser.add_argument("--only", default="", help="rows whose label holds this text")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for each row")
    parser.add_argument("--no-plans", action="store_true", help="load only")
    parser.add_argument("--out", default="robots.json")
    parser.add_argument("--row", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.row:
        measure(Case(**json.loads(options.row)), options.robots, not options.no_plans)
        return
    found = Path(options.robots) if options.robots else example_robot_data()
    if found is None:
        raise SystemExit("say where the robots are (--robots), or pip install example-robot-data")
    root = found.resolve()
    if options.listed:
        run_listed(root, options)
        return
    rows = []
    for urdf in sorted(root.rglob("*.urdf")):
        package = root / urdf.relative_to(root).parts[0]
        with tempfile.TemporaryDirectory() as cache:
            for case in cases_of(urdf, srdfs_of(urdf, package)):
                label, planned = case.label(root), case.group or f"chain to {case.end_effector or 'its end'}"
                if options.only not in f"{label} {planned}":
                    continue
                row = run(case, root.parents[1], cache, options.limit, not options.no_plans)
                if end := row.pop("end_effector", ""):  # a group of several chains
                    planned += f", end effector {end}"
                    case = replace(case, end_effector=end)
                    row = run(case, root.parents[1], cache, options.limit, not options.no_plans)
                rows.append({"robot": label, "planned": planned, **row})
                print(table(rows[-1:]).splitlines()[-1], flush=True)
                write_json(options.out, {"header": mbm.header("robots", limit_s=options.limit), "rows": rows})
                Path(options.out).with_suffix(".md").write_text(table(rows))
    print(f"{sum(row['loads'] is True for row in rows)} of {len(rows)} rows load; wrote {options.out}")


if __name__ == "__main__":
    main()
