"""How plan time grows: with obstacles, triangles, cloud points, joints, arms, and the narrowness of a passage.

    python bench/suites/growth.py [--only boxes,points] [--most 1] [--out growth.json] [--figure growth.png]

Each row is one size: how long the scene took to be made, the first plan in it, and a later plan (the best of
--repeats), all in CPU seconds of one thread, and the memory of the process. The robots are the package's own arm,
chains of joints, and a gantry for the passage, so that nothing else is needed. --most below 1 leaves out the largest
sizes of each series (0.1: those above a tenth of the largest). --figure also writes the same figure as SVG. Aims:
nowhere worse than linear where the physics is local; a cloud of 10^6 points in 300 ms.
"""

from __future__ import annotations

import argparse
import re
import resource
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from certificate_times import add_arm, bumpy_ground, seen_points, timed, write_stl
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm

LIMIT = 60.0  # [s] of a plan
Query = Callable[[], Any]


# --- scenes: each returns the plan that is timed ----------------------------------------------------------------------


def arm_query(planner: srmp.PlannerInterface) -> Query:
    """The package's arm turns by a quarter, over what is there."""
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": LIMIT})
    start = np.array([-0.8, 0.2, 0, 1.2, 0, 0.6, 0])
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, start + 1.6 * np.eye(7)[0])
    return lambda: planner.plan("arm", start, goal)


def boxes(count: int) -> Query:
    """In a room of 6 m, so that few are near; none in the arm's way but one."""
    planner, random = srmp.PlannerInterface(), np.random.default_rng(count)
    add_arm(planner, None, "arm", srmp.Pose())
    planner.add_box("post", [0.08, 0.08, 0.9], srmp.Pose(p=[0.45, 0.05, 0.45]))
    for k in range(count - 1):
        angle, radius = random.uniform(-np.pi, np.pi), 3.0 * np.sqrt(random.uniform(0.12, 1.0))
        place = [radius * np.cos(angle), radius * np.sin(angle), random.uniform(0.0, 1.5)]
        planner.add_box(f"box{k}", random.uniform(0.02, 0.06, 3), srmp.Pose(p=place))
    return arm_query(planner)


def ground(count: int) -> tempfile.TemporaryDirectory[str]:
    directory = tempfile.TemporaryDirectory()
    triangles = bumpy_ground(round(np.sqrt(count / 2)), np.random.default_rng(1)) - [0, 0, 0.1]
    write_stl(Path(directory.name) / "ground.stl", triangles)
    return directory


def triangles(directory: tempfile.TemporaryDirectory[str]) -> Query:
    planner = srmp.PlannerInterface()
    add_arm(planner, None, "arm", srmp.Pose())
    planner.add_mesh("ground", str(Path(directory.name) / "ground.stl"))
    return arm_query(planner)


def cloud(count: int) -> np.ndarray:
    return seen_points(count, np.random.default_rng(2)) - [0, 0, 0.15]


def points(seen: np.ndarray) -> Query:
    planner = srmp.PlannerInterface()
    add_arm(planner, None, "arm", srmp.Pose())
    planner.add_point_cloud("cloud", seen, resolution=0.01)
    return arm_query(planner)


def chain(joints: int) -> str:
    """A URDF: links of 1.2 m together, whose joints turn about z and y in turn."""
    length = 1.2 / joints
    text = '<robot name="chain"><link name="link0"/>'
    for k in range(1, joints + 1):
        axis, offset = ("0 0 1" if k % 2 else "0 1 0"), (0.1 if k == 1 else length)
        text += (
            f'<link name="link{k}"><collision><origin xyz="0 0 {length / 2}"/><geometry>'
            f'<cylinder radius="0.03" length="{0.6 * length}"/></geometry></collision></link>'
            f'<joint name="joint{k}" type="revolute"><parent link="link{k - 1}"/><child link="link{k}"/>'
            f'<origin xyz="0 0 {offset}"/><axis xyz="{axis}"/>'
            '<limit lower="-2.5" upper="2.5" velocity="2" effort="1"/></joint>'
        )
    return text + "</robot>"


def joints(count: int) -> Query:
    """The chain bends from one side to the other, around a post."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=chain(count), name="chain", end_effector=f"link{count}")
    planner.add_box("post", [0.06, 0.06, 1.5], srmp.Pose(p=[0.5, 0, 0.75]))
    planner.make_planner("chain", {"planner_id": "auto", "time_limit": LIMIT})
    bent = np.where(np.arange(count) % 2, 2.0 / count, 0.0)
    start, end = bent.copy(), bent.copy()
    start[0], end[0] = -0.9, 0.9
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, end)
    return lambda: planner.plan("chain", start, goal)


def arms(count: int) -> Query:
    """In a grid, 1 m apart; each turns by 0.8 rad."""
    planner = srmp.PlannerInterface()
    columns = int(np.ceil(np.sqrt(count)))
    names = [f"arm{k}" for k in range(count)]
    for k, name in enumerate(names):
        row, column = divmod(k, columns)
        add_arm(planner, None, name, srmp.Pose(p=[float(column), float(row), 0]))
    planner.make_planner(names, {"planner_id": "auto", "time_limit": LIMIT})
    start = np.array([-0.4, 0.5, 0, 1.2, 0, 0.6, 0])
    goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, start + 0.8 * np.eye(7)[0]) for name in names}
    return lambda: planner.plan_multi(dict.fromkeys(names, start), goals)


GANTRY = (
    '<robot name="gantry"><link name="base"/><link name="x"/><link name="y"/><link name="tool"><collision><geometry>'
)
GANTRY += '<box size="0.1 0.1 0.1"/></geometry></collision></link>' + "".join(
    f'<joint name="joint_{child}" type="prismatic"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
    '<limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>'
    for parent, child, axis in (("base", "x", "1 0 0"), ("x", "y", "0 1 0"), ("y", "tool", "0 0 1"))
)
GANTRY += "</robot>"


def passage(clearance_mm: float) -> Query:
    """A box of 0.1 m passes a slot in a wall that leaves so much on each side."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=GANTRY, name="gantry", end_effector="tool")
    half = 0.05 + 1e-3 * clearance_mm
    for side in (-1, 1):
        place = [0, 0.07 + side * (half + 0.5), 0]
        planner.add_box(f"wall{side}", [0.2, 1.0, 2.0], srmp.Pose(p=place))
    planner.make_planner("gantry", {"planner_id": "auto", "time_limit": LIMIT})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, [0.4, -0.2, 0.1])
    return lambda: planner.plan("gantry", [-0.4, -0.2, -0.1], goal)


class Series(NamedTuple):
    label: str
    make: Callable[[Any], Query]
    sizes: Sequence[float]  # of the passage: clearances [mm]
    material: Callable[[Any], Any] = lambda size: size  # what make() is given; not timed


SERIES = {
    "boxes": Series("boxes", boxes, (10, 30, 100, 300, 1000, 3000, 10_000)),
    "triangles": Series("triangles", triangles, (1000, 10_000, 100_000, 1_000_000), ground),
    "points": Series("points of a cloud", points, (1000, 10_000, 100_000, 1_000_000), cloud),
    "joints": Series("joints", joints, (6, 7, 10, 14, 21)),
    "arms": Series("arms", arms, (2, 4, 8, 16, 32, 64, 128)),
    "passage": Series("1 / clearance [1/m]", passage, (100, 30, 10, 3, 1)),
}


# --- measurements -----------------------------------------------------------------------------------------------------


def row_of(series: str, size: float, repeats: int) -> dict[str, Any]:
    material = SERIES[series].material(size)
    begin = time.process_time()
    query = SERIES[series].make(material)
    made = time.process_time()
    row: dict[str, Any] = {"series": series, "size": size, "make_s": made - begin, "status": "solved"}
    try:
        query()
        row["first_s"] = time.process_time() - made
        _, row["plan_s"] = timed(query, repeats)
    except srmp.PlanningError as error:
        row.update(status=error.status.name, first_s=time.process_time() - made, plan_s=None)
    row["memory_bytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024  # the most so far
    return row


def sizes_of(series: str, most: float) -> list[float]:
    sizes = SERIES[series].sizes
    hardness = [1 / size if series == "passage" else size for size in sizes]
    return [size for size, hard in zip(sizes, hardness, strict=True) if hard <= most * max(hardness)]


def run(only: str, most: float, repeats: int, figure: Path | None) -> dict[str, Any]:
    """One row for each size of the chosen series."""
    chosen = only.split(",") if only else list(SERIES)
    if unknown := [name for name in chosen if name not in SERIES]:
        raise srmp.InvalidArgument(f"only '{unknown[0]}': there are {', '.join(SERIES)}.")
    rows = [row_of(name, size, repeats) for name in chosen for size in sizes_of(name, most)]
    if figure:
        for path in {figure, figure.with_suffix(".svg")}:
            draw(rows, path)
    options = {"only": chosen, "most": most, "repeats": repeats}
    return {"header": mbm.header("growth", options=options), "rows": rows, "exponents": exponents(rows)}


def exponents(rows: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    """Of each series: p of the fit time ~ size^p through the later plans, None of fewer than two; 1 is linear."""
    found: dict[str, float | None] = {}
    for name in dict.fromkeys(row["series"] for row in rows):
        solved = [row for row in rows if row["series"] == name and row["plan_s"]]
        x = np.log([abscissa(row) for row in solved])
        y = np.log([row["plan_s"] for row in solved])
        found[name] = float(np.polyfit(x, y, 1)[0]) if len(solved) > 1 else None
    return found


def abscissa(row: dict[str, Any]) -> float:
    return 1e3 / row["size"] if row["series"] == "passage" else row["size"]


def table(result: dict[str, Any]) -> str:
    lines = []
    for row in result["rows"]:
        times = [row["make_s"], row["first_s"], row["plan_s"]]
        cells = ["–" if value is None else format_seconds(value) for value in times]
        size = f"{row['size']:g}" + (" mm" if row["series"] == "passage" else "")
        lines.append([row["series"], size, row["status"], *cells, f"{row['memory_bytes'] / 1e6:.0f} MB"])
    fits = ", ".join(f"{name} {value:.2f}" for name, value in result["exponents"].items() if value is not None)
    head = ["series", "size", "status", "scene", "first plan", "later plan", "memory"]
    return format_table(head, lines) + (f"\nexponents (1 is linear): {fits}" if fits else "")


def draw(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """A panel for each series: scene, first plan and later plan over size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    names = list(dict.fromkeys(row["series"] for row in rows))
    columns = min(3, len(names))
    figure = Figure(figsize=(3.4 * columns, 3.0 * -(-len(names) // columns)), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    for k, name in enumerate(names):
        axes = figure.add_subplot(-(-len(names) // columns), columns, k + 1)
        own = [row for row in rows if row["series"] == name]
        x = [abscissa(row) for row in own]
        for key, label, style in (
            ("make_s", "scene", ":"),
            ("first_s", "first plan", "--"),
            ("plan_s", "later plan", "-"),
        ):
            y = [np.nan if row[key] is None else 1e3 * row[key] for row in own]
            axes.plot(x, y, style, marker="o", markersize=3, label=label)
        axes.set(
            xscale="log", yscale="log", xlabel=SERIES[name].label, ylabel="CPU time [ms]" if k % columns == 0 else ""
        )
        if max(x) < 10 * min(x):  # hardly a decade: the sizes themselves
            axes.set_xticks(x, [f"{value:g}" for value in x])
            axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(alpha=0.3, which="both")
        if k == 0:
            axes.legend(frameon=False)
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--only", default="", help=f"comma-separated: {', '.join(SERIES)}; default: all")
    parser.add_argument("--most", type=float, default=1.0, help="fraction of the largest size (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--figure", type=Path, help="figure (PNG; the same as SVG beside it)")
    run_and_report(parser, run, table)


if __name__ == "__main__":
    main()
