"""What searches did, for the eye: states that were expanded, edges that were tried, constraint trees."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, _srmp
from srmp._files import write_text
from srmp.viewer._shapes import Segments

if TYPE_CHECKING:
    from srmp import ConstraintNode, LatticeTrace, PlannerInterface, SearchTrace
    from srmp.viewer._drawing import Drawing

FREE, BLOCKED = (0.30, 0.45, 0.55), (0.90, 0.66, 0.62)
_SHADES = 12  # of expanded states, by their distance to the targets
_CROSS = 0.008  # [m] half the size of the mark of a state
_MAX_EDGES = 20_000  # that are drawn: the first ones


def searched(planner: PlannerInterface, trace: SearchTrace) -> list[Segments]:
    """Edges that were tried, by whether they are free, and expanded states, bright where they are near the targets.

    All where the end effector is then. Raises InvalidArgument where no lattice was searched, and UnknownRobot where the
    planner has not its robot.
    """
    _require_trace(trace)
    lattices = [lattice for lattice in trace.lattices if len(lattice.expanded)]
    if not lattices:
        raise InvalidArgument(
            "this SearchTrace holds no lattice: RRT-Connect found the path, or nothing was planned for one robot "
            "alone; make_planner with 'wAstar' searches one"
        )
    edges = {True: np.zeros((0, 2, 3)), False: np.zeros((0, 2, 3))}
    states, distances = [], []
    for lattice in lattices:
        states.append(_tips(planner, lattice, lattice.expanded))
        distances.append(lattice.to_targets)
        tried = _edges(planner, lattice)
        for free in edges:
            edges[free] = np.concatenate([edges[free], tried[(lattice.edges_free > 0.5)[:_MAX_EDGES] == free]])
    drawn = [Segments("edges in collision", edges[False], BLOCKED), Segments("free edges", edges[True], FREE)]
    return [one for one in drawn if len(one.points)] + _shaded(np.concatenate(states), np.concatenate(distances))


def sentence(trace: SearchTrace) -> str:
    """What there is to see."""
    lattices = sum(len(lattice.expanded) > 0 for lattice in trace.lattices)
    states = sum(len(lattice.expanded) for lattice in trace.lattices)
    edges = sum(len(lattice.edges_free) for lattice in trace.lattices)
    blocked = edges - int(sum(lattice.edges_free.sum() for lattice in trace.lattices))
    return (
        f"{states} states expanded in {lattices} lattice{'s' * (lattices > 1)}, bright near the targets; "
        f"{edges} edges tried, {blocked} of them in collision (red)"
    )


def _tips(planner: PlannerInterface, lattice: LatticeTrace, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) positions of the end effector."""
    return np.array([planner.compute_fk(lattice.robot, q).p for q in rows]).reshape(-1, 3)


def _edges(planner: PlannerInterface, lattice: LatticeTrace) -> NDArray[np.float64]:
    ends = [_tips(planner, lattice, rows[:_MAX_EDGES]) for rows in (lattice.edges_from, lattice.edges_to)]
    return np.stack(ends, axis=1)


def _shaded(states: NDArray[np.float64], distances: NDArray[np.float64]) -> list[Segments]:
    """Crosses at states, in as many colours as there are shades."""
    arms = _CROSS * np.eye(3)
    crosses = np.stack([states[:, None] - arms, states[:, None] + arms], axis=2)  # (n, 3, 2, 3)
    largest = max(float(distances.max()), 1e-9)
    shades = np.minimum((_SHADES * distances / largest).astype(int), _SHADES - 1)
    return [
        Segments(
            f"expanded, {largest * shade / _SHADES:.2f} to {largest * (shade + 1) / _SHADES:.2f} rad to go",
            crosses[shades == shade].reshape(-1, 2, 3),
            _heat(1 - shade / (_SHADES - 1)),
        )
        for shade in np.unique(shades)
    ]


def _heat(value: float) -> tuple[float, float, float]:
    """From dark violet (0, far from the targets) over orange to yellow (1, near them)."""
    stops = np.array([[0.20, 0.05, 0.45], [0.75, 0.20, 0.50], [0.98, 0.55, 0.25], [0.98, 0.90, 0.20]])
    place = value * (len(stops) - 1)
    k = min(int(place), len(stops) - 2)
    red, green, blue = stops[k] + (place - k) * (stops[k + 1] - stops[k])
    return float(red), float(green), float(blue)


def drawing_of(trace: SearchTrace, planner: PlannerInterface) -> Drawing:
    """The planner's scene, and its last motion or failure, with what was searched."""
    from srmp.viewer._drawing import make_drawing

    if not isinstance(planner, _srmp.PlannerInterface):
        raise InvalidArgument(f"planner must be a PlannerInterface, but is {planner!r}")
    segments = searched(planner, trace)
    drawing = make_drawing(planner)
    return replace(drawing, segments=segments, notes=[*drawing.notes, sentence(trace)])


def plot(trace: SearchTrace, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> Any:
    """SearchTrace.plot."""
    from srmp.plot import write_figure
    from srmp.viewer._picture import draw

    figure = draw(drawing_of(trace, planner), sentence(trace), instants=2)
    if path is not None:
        write_figure(figure, Path(path))
    return figure


def to_html(trace: SearchTrace, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> str | None:
    """SearchTrace.to_html."""
    from srmp.viewer._html import page

    text = page(drawing_of(trace, planner), "What was searched")
    if path is None:
        return text
    write_text(path, text)
    return None


# --- constraint trees -------------------------------------------------------------------------------------------------


def plot_constraints(trace: SearchTrace, path: str | os.PathLike[str] | None = None) -> Any:
    """SearchTrace.plot_constraints: a panel for each tree, its root above; a node says who collide first, and when."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from srmp.plot import write_figure

    _require_trace(trace)
    trees = [nodes for nodes in _trees(trace.constraint_nodes) if nodes]
    if not trees:
        raise InvalidArgument(
            "this SearchTrace holds no constraint tree: the robots were planned otherwise; make_planner with 'ECBS' "
            "searches one"
        )
    figure = Figure(figsize=(10, 5.5 * len(trees)), dpi=120, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    for nodes, axes in zip(trees, figure.subplots(len(trees), 1, squeeze=False)[:, 0], strict=True):
        _draw_tree(axes, nodes)
    figure.tight_layout()
    if path is not None:
        write_figure(figure, Path(path))
    return figure


def _trees(nodes: Iterable[ConstraintNode]) -> list[list[ConstraintNode]]:
    by_tree: dict[int, list[ConstraintNode]] = {}
    for node in nodes:
        by_tree.setdefault(node.tree, []).append(node)
    return list(by_tree.values())


def _places(nodes: list[ConstraintNode]) -> dict[int, tuple[float, int]]:
    """(across, depth) of each node by its number: leaves beside each other, parents above the middle of theirs."""
    children: dict[int, list[int]] = {node.number: [] for node in nodes}
    for node in nodes:
        if node.number and node.parent in children:
            children[node.parent].append(node.number)
    depth: dict[int, int] = {}
    for node in nodes:  # a parent was opened before its children
        depth[node.number] = depth.get(node.parent, -1) + 1 if node.number else 0
    across: dict[int, float] = {}
    leaves = 0
    for node in sorted(nodes, key=lambda node: -node.number):
        own = [across[child] for child in children[node.number]]
        across[node.number] = float(np.mean(own)) if own else float(leaves)
        leaves += not own
    return {number: (across[number], depth[number]) for number in across}


def _draw_tree(axes: Any, nodes: list[ConstraintNode]) -> None:
    places = _places(nodes)
    for node in nodes:
        x, y = places[node.number]
        if node.number and node.parent in places:
            above = places[node.parent]
            axes.plot([above[0], x], [-above[1], -y], color=FREE, linewidth=1.0, zorder=1)
        axes.plot(x, -y, "o", color="#b3402e" if node.conflicts else "#0b7a75", markersize=6, zorder=2)
        if len(nodes) <= 40:
            said = f"{' – '.join(node.robots)}\n{node.time_s:.2f} s" if node.conflicts else "no conflict"
            axes.annotate(said, (x, -y), (5, 3), textcoords="offset points", fontsize=7)
    solved = sum(node.conflicts == 0 for node in nodes)
    axes.set_title(f"constraint tree: {len(nodes)} nodes opened, {solved} without conflict", fontsize=10)
    axes.margins(0.12)
    axes.set_axis_off()


def _require_trace(trace: object) -> None:
    if not isinstance(trace, _srmp.SearchTrace):
        raise InvalidArgument(f"trace must be a SearchTrace, but is {trace!r}")
