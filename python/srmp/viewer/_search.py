"""What searches did, for the eye: states that were expanded, edges that were tried, conflicts of robots."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, _srmp
from srmp._errors import checked
from srmp._files import write_text
from srmp.viewer._scene import CONTACT
from srmp.viewer._shapes import Segments
from srmp.viewer._tree import conflict_points, drawn_tree, plot_constraints, trees_of

__all__ = ["drawing_of", "plot", "plot_constraints", "searched", "sentence", "to_html"]

if TYPE_CHECKING:
    from srmp import LatticeTrace, PlannerInterface, SearchTrace
    from srmp.viewer._drawing import Drawing

FREE, BLOCKED = (0.30, 0.45, 0.55), (0.90, 0.66, 0.62)
_SHADES = 12  # of expanded states, by their distance to the targets
_CROSS = 0.008  # [m] half the size of the mark of a state
_CONFLICT = 0.03  # and of the mark of a conflict
_MAX_EDGES = 20_000  # that are drawn: the first ones


def searched(planner: PlannerInterface, trace: SearchTrace) -> list[Segments]:
    """Edges that were tried, by whether they are free, and expanded states, bright where they are near the targets.

    All where the end effector is then; of constraint trees, the places of the conflicts. Raises InvalidArgument where
    neither was searched, and UnknownRobot where the planner has not its robot.
    """
    _require_trace(trace)
    lattices = [lattice for lattice in trace.lattices if len(lattice.expanded)]
    conflicts = conflict_points(planner, trace.constraint_nodes)
    if not lattices and not trace.constraint_nodes:
        raise InvalidArgument(
            "this SearchTrace holds no lattice and no constraint tree: RRT-Connect or a roadmap found the path; "
            "make_planner with 'wAstar' searches a lattice, with 'ECBS' a constraint tree"
        )
    edges = {True: np.zeros((0, 2, 3)), False: np.zeros((0, 2, 3))}
    states, distances = [], []
    for lattice in lattices:
        states.append(_tips(planner, lattice, lattice.expanded))
        distances.append(lattice.to_targets)
        tried = _edges(planner, lattice)
        for free in edges:
            edges[free] = np.concatenate([edges[free], tried[(lattice.edges_free > 0.5)[:_MAX_EDGES] == free]])
    drawn = [
        Segments("edges in collision", edges[False], BLOCKED),
        Segments("free edges", edges[True], FREE),
        Segments("conflicts", _crosses(conflicts, _CONFLICT), CONTACT),
    ]
    shaded = _shaded(np.concatenate(states), np.concatenate(distances)) if states else []
    return [one for one in drawn if len(one.points)] + shaded


def sentence(trace: SearchTrace) -> str:
    """What there is to see."""
    parts = []
    if lattices := sum(len(lattice.expanded) > 0 for lattice in trace.lattices):
        states = sum(len(lattice.expanded) for lattice in trace.lattices)
        edges = sum(len(lattice.edges_free) for lattice in trace.lattices)
        blocked = edges - int(sum(lattice.edges_free.sum() for lattice in trace.lattices))
        parts.append(
            f"{states} states expanded in {lattices} lattice{'s' * (lattices > 1)}, bright near the targets; "
            f"{edges} edges tried, {blocked} of them in collision (red)"
        )
    if nodes := trace.constraint_nodes:
        trees = len(trees_of(nodes))
        parts.append(
            f"{len(nodes)} nodes of {trees} constraint tree{'s' * (trees > 1)}, "
            f"{sum(node.conflicts > 0 for node in nodes)} of them with a conflict (red crosses)"
        )
    return "; ".join(parts)


def _tips(planner: PlannerInterface, lattice: LatticeTrace, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) positions of the end effector."""
    return np.array([planner.compute_fk(lattice.robot, q).p for q in rows]).reshape(-1, 3)


def _edges(planner: PlannerInterface, lattice: LatticeTrace) -> NDArray[np.float64]:
    ends = [_tips(planner, lattice, rows[:_MAX_EDGES]) for rows in (lattice.edges_from, lattice.edges_to)]
    return np.stack(ends, axis=1)


def _shaded(states: NDArray[np.float64], distances: NDArray[np.float64]) -> list[Segments]:
    """Crosses at states, in as many colours as there are shades."""
    crosses = _crosses(states, _CROSS).reshape(-1, 3, 2, 3)
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


def _crosses(points: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """(3 n, 2, 3): three segments of half length `size` [m] through each point."""
    arms = size * np.eye(3)
    return np.stack([points[:, None] - arms, points[:, None] + arms], axis=2).reshape(-1, 2, 3)


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
    panels = [*drawing.panels, *((title, drawn_tree(nodes)) for title, nodes in trees_of(trace.constraint_nodes))]
    return replace(drawing, segments=segments, panels=panels, notes=[*drawing.notes, sentence(trace)])


@checked
def plot(trace: SearchTrace, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> Any:
    """SearchTrace.plot."""
    from srmp.plot import write_figure
    from srmp.viewer._picture import draw

    figure = draw(drawing_of(trace, planner), sentence(trace), instants=2)
    if path is not None:
        write_figure(figure, Path(path))
    return figure


@checked
def to_html(trace: SearchTrace, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> str | None:
    """SearchTrace.to_html."""
    from srmp.viewer._html import page

    text = page(drawing_of(trace, planner), "What was searched")
    if path is None:
        return text
    write_text(path, text)
    return None


def _require_trace(trace: object) -> None:
    if not isinstance(trace, _srmp.SearchTrace):
        raise InvalidArgument(f"trace must be a SearchTrace, but is {trace!r}")
