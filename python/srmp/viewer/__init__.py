"""See robots, scenes and motions: in a browser while you work, as HTML files that play without a server, as pictures.

PlannerInterface.show, to_html and plot call these functions.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from srmp import _srmp
from srmp._errors import checked
from srmp._files import write_text
from srmp.viewer._drawing import make_drawing
from srmp.viewer._html import page

if TYPE_CHECKING:
    import srmp
    from srmp.viewer._server import Viewer as Viewer

    Trajectories = srmp.Trajectory | srmp.MultiTrajectory | Mapping[str, srmp.Trajectory] | None


@checked
def show(
    planner: srmp.PlannerInterface,
    trajectory: Trajectories = None,
    *,
    kinds: Sequence[str] | None = None,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = True,
) -> Viewer:
    """Opens a viewer in the browser: PlannerInterface.show, which explains the arguments."""
    _require_planner(planner)
    from srmp.viewer._server import Viewer

    viewer = Viewer(planner, trajectory, kinds=kinds, host=host, port=port)
    if open_browser:
        import webbrowser

        webbrowser.open(viewer.url)
    return viewer


@checked
def to_html(
    planner: srmp.PlannerInterface,
    path: str | os.PathLike[str] | None = None,
    trajectory: Trajectories = None,
    *,
    title: str = "",
    kinds: Sequence[str] | None = None,
) -> str | None:
    """Writes a page that plays without a server: PlannerInterface.to_html, which explains the arguments."""
    _require_planner(planner)
    _require_text(title)
    text = page(make_drawing(planner, trajectory, kinds=kinds), title or "srmp")
    if path is None:
        return text
    write_text(path, text)
    return None


@checked
def plot(
    planner: srmp.PlannerInterface,
    path: str | os.PathLike[str] | None = None,
    trajectory: Trajectories = None,
    *,
    title: str = "",
    kinds: Sequence[str] | None = None,
) -> Any:
    """Draws a picture: PlannerInterface.plot, which explains the arguments."""
    from srmp.plot import write_figure
    from srmp.viewer._picture import draw

    _require_planner(planner)
    _require_text(title)
    figure = draw(make_drawing(planner, trajectory, kinds=kinds, plots=False), title)
    if path is not None:
        write_figure(figure, Path(path))
    return figure


def _require_planner(planner: object) -> None:
    if not isinstance(planner, _srmp.PlannerInterface):
        raise _srmp.InvalidArgument(f"planner must be a PlannerInterface, but is {planner!r}")


def _require_text(title: object) -> None:
    if not isinstance(title, str):
        raise _srmp.InvalidArgument(f"title must be a string, but is {title!r}")


def __getattr__(name: str) -> Any:
    if name == "Viewer":  # needs viser, which only the viewer extra brings
        from srmp.viewer._server import Viewer

        return Viewer
    raise AttributeError(f"module 'srmp.viewer' has no attribute '{name}'")
