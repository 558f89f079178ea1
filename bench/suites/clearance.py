"""What clearance costs on MotionBenchMaker: clearance, length, duration and time with and without it.

    python bench/suites/clearance.py --data DIR [--robots panda,ur5] [--problems 1-10] [--clearance 0.005] [--out FILE]

Plans each problem with no clearance, with `preferred_clearance` and with `clearance`, in turns and several times, each
time in a scene that is set up anew, so that the checkers are made anew too. The CPU time of the calling thread counts,
the least of all repeats. The clearance of a motion is that of 200 instants, by Coal alone; the ends are left out of
`below`, which is the part of the duration that a motion is closer than the clearance to something though neither of its
ends is.

The exit code is 1 when a motion with `clearance` has no certificate that says that it keeps it, or when an instant
between the times that the certificate names does not.
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

INSTANTS = 200
TOLERANCE = 3e-6  # [m] of Coal's distances


def settings(clearance: float) -> dict[str, dict[str, float]]:
    return {
        "none": {},
        "preferred": {"preferred_clearance": clearance},
        "required": {"clearance": clearance},
    }


def clearances(planner: srmp.PlannerInterface, robot: str, motion: srmp.Trajectory) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(motion.times[0], motion.times[-1], INSTANTS)
    return times, np.array([planner.distance_to_collision(robot, motion.sample(t)) for t in times])


def row_of(
    planner: srmp.PlannerInterface, robot: str, motion: srmp.Trajectory, clearance: float, setting: str
) -> dict[str, Any]:
    times, found = clearances(planner, robot, motion)
    close_ends = min(found[0], found[-1]) < clearance
    row = {
        "status": "solved",
        "length_rad": float(np.linalg.norm(np.diff(motion.waypoints, axis=0), axis=1).sum()),
        "duration_s": motion.duration,
        "clearance_m": float(found.min()),
        "below": float((found < clearance).mean()),
        "close_ends": bool(close_ends),
        "proved_free": motion.certificate.proved_free,
        "wrong": not motion.certificate.holds,
    }
    if setting == "required":
        kept = motion.certificate.clearance_kept
        within = (times >= kept.from_time) & (times <= kept.to_time)
        apart = found[within] >= clearance - TOLERANCE
        row["wrong"] |= kept.violation != 0 or not (apart.all() or bool(kept.close_links))
    return row


def rows_of(
    data: str, robot: str, problems: str, clearance: float, repeats: int, time_limit: float
) -> Iterator[dict[str, Any]]:
    files = mbm.robot_files(data, robot, "urdf")
    runner = mbm.Runner(files, "auto", {}, time_limit)
    with mbm.open_problems(files.directory, robot, (), mbm.parse_numbers(problems)) as found:
        for problem in found:
            rows: dict[str, dict[str, Any]] = {}
            for _, (name, options) in [(k, item) for k in range(repeats) for item in settings(clearance).items()]:
                planner, request = runner.set_up(problem)
                planner.make_planner([robot], {"time_limit": time_limit, **options})
                begin = time.thread_time()
                try:
                    motion = planner.plan(robot, request.start, request.goals)
                except srmp.PlanningError as error:
                    rows[name] = {"status": mbm.status_name(error.status), "reason": str(error)}
                    continue
                seconds = time.thread_time() - begin
                if name not in rows:
                    rows[name] = {**row_of(planner, robot, motion, clearance, name), "cpu_s": seconds}
                rows[name]["cpu_s"] = min(seconds, rows[name]["cpu_s"])
            yield from ({"robot": robot, "problem": problem.name, "setting": name, **row} for name, row in rows.items())


def run(data: str, robots: str, problems: str, clearance: float, repeats: int, time_limit: float) -> dict[str, Any]:
    rows = [
        row for robot in robots.split(",") for row in rows_of(data, robot, problems, clearance, repeats, time_limit)
    ]
    options = {"robots": robots, "problems": problems, "clearance": clearance, "repeats": repeats}
    return {"header": mbm.header("clearance", options=options), "rows": rows}


def percent(ratio: float) -> str:
    return f"{100 * (ratio - 1):+.1f} %"


def cells(robot: str, setting: str, rows: dict[tuple[str, str], dict[str, Any]]) -> list[str]:
    """Of a setting; what is compared with no clearance is so over the problems that both solve."""
    names = [problem for problem, which in rows if which == setting]
    solved = [name for name in names if rows[name, setting]["status"] == "solved"]
    both = [name for name in solved if rows[name, "none"]["status"] == "solved"]

    def total(key: str, which: str) -> float:
        return float(sum(rows[name, which][key] for name in both))

    motions = [rows[name, setting] for name in solved]
    far = [motion["below"] for motion in motions if not motion["close_ends"]]
    median = float(np.median([motion["cpu_s"] for motion in motions]))
    return [
        robot,
        setting,
        f"{len(solved)}/{len(names)}",
        f"{1e3 * np.median([motion['clearance_m'] for motion in motions]):.2f} mm",
        f"{1e3 * np.percentile([motion['clearance_m'] for motion in motions], 10):.2f} mm",
        f"{100 * np.mean(far):.2f} %" if far else "-",
        percent(total("length_rad", setting) / total("length_rad", "none")),
        percent(total("duration_s", setting) / total("duration_s", "none")),
        format_seconds(median),
        percent(float(np.median([rows[n, setting]["cpu_s"] / rows[n, "none"]["cpu_s"] for n in both]))),
        percent(total("cpu_s", setting) / total("cpu_s", "none")),
        str(sum(motion["wrong"] for motion in motions)),
    ]


def table(result: dict[str, Any]) -> str:
    clearance = result["header"]["options"]["clearance"]
    lines = []
    for robot in result["header"]["options"]["robots"].split(","):
        rows = {(row["problem"], row["setting"]): row for row in result["rows"] if row["robot"] == robot}
        lines += [cells(robot, setting, rows) for setting in settings(clearance)]
    titles = ["robot", "clearance", "solved", "median", "p10", "below", "length", "duration", "CPU median", "ratio"]
    return format_table([*titles, "of sums", "wrong"], lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robots", default="panda,ur5", help="with commas between them; default: panda,ur5")
    parser.add_argument("--problems", default="1-10", help="numbers of the problems of each scenario; default: 1-10")
    parser.add_argument("--clearance", type=float, default=0.005, help="[m]; default: 0.005")
    parser.add_argument("--repeats", type=int, default=3, help="plans of each problem and setting; default: 3")
    parser.add_argument("--time-limit", type=float, default=5.0, help="[s] of a plan; default: 5")
    result = run_and_report(parser, run, table)
    return int(any(row.get("wrong") for row in result["rows"]))


if __name__ == "__main__":
    sys.exit(main())
