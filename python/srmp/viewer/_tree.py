"""Constraint trees of conflict-based searches, for the eye: as a figure, as SVG, and where the robots collide."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, _srmp
from srmp._errors import checked
from srmp.viewer._failure import touches_together
from srmp.viewer._scene import copied

if TYPE_CHECKING:
    from srmp import ConstraintNode, PlannerInterface, SearchTrace

_CONFLICT, _SOLVED, _LINE = "#b3402e", "#0b7a75", "#4d7389"
_MAX_NODES = 400  # of a tree, that are drawn as SVG, and whose conflicts are drawn
_STEP, _HEIGHT, _RADIUS = 14, 26, 4  # of the SVG


def conflict_points(planner: PlannerInterface, nodes: Sequence[ConstraintNode]) -> NDArray[np.float64]:
    """(n, 3) [m] where the two robots of each node's first conflict touch, or else midway between their end effectors.

    Of the first nodes only. Raises UnknownRobot where the planner has not its robots.
    """
    with_conflict = [node for node in nodes if node.conflicts][:_MAX_NODES]
    world = copied(planner) if with_conflict else planner
    points: dict[bytes, NDArray[np.float64]] = {}  # many nodes have the same conflict
    for node in with_conflict:
        key = b"".join(name.encode() + q.tobytes() for name, q in node.configurations.items())
        if key not in points:
            touches = touches_together(world, node.configurations)
            here = [touch.point for touch in touches if len({label.split("/")[0] for label in touch.bodies}) > 1]
            ends = [world.compute_fk(name, q).p for name, q in node.configurations.items()]
            points[key] = np.mean(here or ends, axis=0)
    return np.array(list(points.values())).reshape(-1, 3)


@checked
def plot_constraints(trace: SearchTrace, path: str | os.PathLike[str] | None = None) -> Any:
    """SearchTrace.plot_constraints: a panel for each tree, its root above; a node says who collide first, and when."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from srmp.plot import write_figure

    if not isinstance(trace, _srmp.SearchTrace):
        raise InvalidArgument(f"trace must be a SearchTrace, but is {trace!r}")
    trees = trees_of(trace.constraint_nodes)
    if not trees:
        raise InvalidArgument(
            "this SearchTrace holds no constraint tree: the robots were planned otherwise; make_planner with 'ECBS' "
            "searches one"
        )
    figure = Figure(figsize=(10, 5.5 * len(trees)), dpi=120, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    for (title, nodes), axes in zip(trees, figure.subplots(len(trees), 1, squeeze=False)[:, 0], strict=True):
        axes.set_title(title, fontsize=10)
        _draw_tree(axes, nodes)
    figure.tight_layout()
    if path is not None:
        write_figure(figure, Path(path))
    return figure


def trees_of(nodes: Iterable[ConstraintNode]) -> list[tuple[str, list[ConstraintNode]]]:
    """Each tree with its title."""
    by_tree: dict[int, list[ConstraintNode]] = {}
    for node in nodes:
        by_tree.setdefault(node.tree, []).append(node)
    return [
        (f"constraint tree: {len(tree)} nodes opened, {sum(n.conflicts == 0 for n in tree)} without conflict", tree)
        for tree in by_tree.values()
    ]


def said(node: ConstraintNode) -> str:
    """Who collide first at a node, and when."""
    return f"{' – '.join(node.robots)}, {node.time_s:.2f} s" if node.conflicts else "no conflict"


def drawn_tree(nodes: list[ConstraintNode], chosen: ConstraintNode | None = None) -> str:
    """The tree as SVG, with a ring around the node that is chosen; of large trees the nodes that were opened first."""
    first = nodes[:_MAX_NODES]
    places = {n: (_STEP * (x + 1), _HEIGHT * y + _STEP) for n, (x, y) in node_places(first).items()}
    width, height = (max(place[k] for place in places.values()) + _STEP for k in (0, 1))
    lines, circles = [], []
    for node in first:
        x, y = places[node.number]
        if node.number and node.parent in places:
            above = places[node.parent]
            lines.append(f'<path d="M{above[0]:.1f} {above[1]}L{x:.1f} {y}" stroke="{_LINE}"/>')
        ring = ' stroke="black" stroke-width="2"' if chosen is not None and node.number == chosen.number else ""
        circles.append(
            f'<circle cx="{x:.1f}" cy="{y}" r="{_RADIUS}" fill="{_CONFLICT if node.conflicts else _SOLVED}"{ring}>'
            f"<title>{html.escape(f'node {node.number}, cost {node.cost:.3f}: {said(node)}')}</title></circle>"
        )
    style = f"display: block; width: 100%; max-width: {max(width, 120):.0f}px"
    return (
        f'<svg viewBox="0 0 {width:.0f} {height}" style="{style}" role="img">{"".join(lines)}{"".join(circles)}</svg>'
        + (f"<div>the first {_MAX_NODES} of {len(nodes)} nodes</div>" if len(nodes) > _MAX_NODES else "")
    )


def node_places(nodes: list[ConstraintNode]) -> dict[int, tuple[float, int]]:
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
    places = node_places(nodes)
    for node in nodes:
        x, y = places[node.number]
        if node.number and node.parent in places:
            above = places[node.parent]
            axes.plot([above[0], x], [-above[1], -y], color=_LINE, linewidth=1.0, zorder=1)
        axes.plot(x, -y, "o", color=_CONFLICT if node.conflicts else _SOLVED, markersize=6, zorder=2)
        if len(nodes) <= 40:
            text = said(node).replace(", ", "\n")
            axes.annotate(text, (x, -y), (5, 3), textcoords="offset points", fontsize=7)
    axes.margins(0.12)
    axes.set_axis_off()
