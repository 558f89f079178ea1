"""Path length over time for several planners.

    python bench/suites/anytime.py --data DIR [--out anytime.json] [--figure time_against_cost.png]

Plans MotionBenchMaker's first problems with several planners and records every path that they find (`solutions` in the
statistics). A planner's curve shows, at each time, the length of its best path so far, divided by the length of the
shortest path that any planner found for that problem, as a mean over the problems. The curve begins when nine problems
in ten have a path.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

import srmp
from srmp._files import write_json
from srmp._table import format_table
from srmp.bench import mbm

SETTINGS: dict[str, dict[str, Any]] = {
    "auto, improving": {"planner_id": "auto"},  # improve_time is set below
    "ARAstar": {"planner_id": "ARAstar", "resolution": 25},
    "MHAstar": {"planner_id": "MHAstar", "resolution": 25},
    "wAstar, weight 50": {"planner_id": "wAstar", "resolution": 25},
    "wAstar, weight 5": {"planner_id": "wAstar", "resolution": 25, "weight": 5},
    "wPASE, 2 threads": {"planner_id": "wPASE", "resolution": 25, "num_threads": 2},
}
TIMES = np.logspace(-4, 1, 151)  # [s]


def solutions_of(
    planner: srmp.PlannerInterface, robot: str, moveit_problem: srmp.MoveItProblem
) -> list[tuple[float, float]]:
    """(time [s], length [rad]) of every path; empty if none was found."""
    try:
        planner.plan(robot, moveit_problem.start, moveit_problem.goals)
    except srmp.PlanningError:
        return []
    return [(each["time_s"], each["cost_rad"]) for each in planner.get_planning_stats()["solutions"]]


def run(data: str, robot: str, geometry: str, problems: str, time_limit: float) -> dict[str, Any]:
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "auto", {}, time_limit)
    rows: list[dict[str, Any]] = []
    with mbm.open_problems(files.directory, robot, (), mbm.parse_numbers(problems)) as chosen:
        for problem in tqdm(chosen, disable=None):
            planner, moveit_problem = runner.set_up(problem)
            row: dict[str, Any] = {"problem": problem.name}
            for name, options in SETTINGS.items():
                extra = {"improve_time": time_limit} if options["planner_id"] == "auto" else {}
                planner.make_planner(robot, {**options, **extra, "time_limit": time_limit, "certify": False})
                row[name] = solutions_of(planner, robot, moveit_problem)
            rows.append(row)
    return {"header": mbm.header("time against cost", robot=robot, geometry=geometry, problems=problems), "rows": rows}


def curve(rows: list[dict[str, Any]], name: str) -> np.ndarray:
    """Mean relative length at each of TIMES; NaN while fewer than nine problems in ten are solved."""
    best = [min((cost for each in SETTINGS for _, cost in row[each]), default=np.nan) for row in rows]
    costs = np.full((len(rows), len(TIMES)), np.nan)
    for i, row in enumerate(rows):
        for time, cost in row[name]:
            costs[i, time <= TIMES] = cost / best[i]
    solved = np.isfinite(costs).sum(axis=0)
    mean = np.nansum(costs, axis=0) / np.maximum(solved, 1)
    return np.where(solved >= 0.9 * len(rows), mean, np.nan)


def table(rows: list[dict[str, Any]]) -> str:
    lines = []
    for name in SETTINGS:
        first = [row[name][0][0] for row in rows if row[name]]
        at = curve(rows, name)
        cells = [f"{len(first)}/{len(rows)}", f"{1e3 * float(np.median(first)):.2f} ms" if first else "–"]
        for time in (0.01, 0.1, 1.0):
            value = at[np.searchsorted(TIMES, time * 0.999)]
            cells.append("–" if np.isnan(value) else f"{value:.3f}")
        lines.append([name, *cells])
    return format_table(["planner", "solved", "first path", "cost at 10 ms", "at 100 ms", "at 1 s"], lines)


def draw(rows: list[dict[str, Any]], path: str) -> None:
    """Draws the fraction of problems with a path (left) and the curves (right)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.8), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    solved, length = figure.subplots(1, 2)
    for name in SETTINGS:
        first = [row[name][0][0] if row[name] else np.inf for row in rows]
        solved.plot(
            1e3 * TIMES, [100.0 * np.mean(np.array(first) <= time) for time in TIMES], label=name, linewidth=1.8
        )
        length.plot(1e3 * TIMES, curve(rows, name), linewidth=1.8)
    solved.set(ylabel="problems with a path [%]", ylim=(0, 102))
    length.set(ylabel="path length / shortest known")
    for axes in (solved, length):
        axes.set(xscale="log", xlabel="time [ms]", xlim=(0.1, 1e3))
        axes.grid(alpha=0.3, which="both")
    solved.legend(frameon=False, loc="lower right")
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="MotionBenchMaker's directory")
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--geometry", default="spheres", choices=["urdf", "spheres"])
    parser.add_argument("--problems", default="1-10", help="numbers in each scenario")
    parser.add_argument("--time-limit", type=float, default=1.0, help="of each plan [s]")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    parser.add_argument("--figure", help="figure of all curves (PNG, SVG)")
    arguments = parser.parse_args()
    result = run(arguments.data, arguments.robot, arguments.geometry, arguments.problems, arguments.time_limit)
    print(table(result["rows"]))
    if arguments.out:
        write_json(arguments.out, result)
    if arguments.figure:
        draw(result["rows"], arguments.figure)


if __name__ == "__main__":
    main()
