"""A drawing as a picture: solid bodies, painted with matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from srmp.viewer._drawing import CAMERA, Drawing, appearance, bounds, is_floor
from srmp.viewer._motion import Motion
from srmp.viewer._painter import Camera, Solid, paint
from srmp.viewer._scene import Body, Scene, matrix
from srmp.viewer._shapes import Mesh, simplified

_LINE_COLOUR = "#0b7a75"
_FAULT_COLOUR = "#b3402e"
_INSTANTS = 6  # at which the robots of a motion are drawn
_PASSING = 0.2  # opacity of robots between the start and the end
_MAX_TRIANGLES = 4000  # of a body: more take long and cannot be seen
_NEAR = 0.03  # [m] between the places of one body, at least


def draw(drawing: Drawing, title: str = "", instants: int = _INSTANTS) -> Any:
    """A Figure of a scene, its robots at `instants` of their motion, and the paths of their end effectors.

    One robot is dark at first and bright at last; several have a colour each, and are solid where they end. Of a plan
    that failed, what is at fault is red.

    Raises ModuleNotFoundError when matplotlib is not installed.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 7.2), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    axes = figure.add_axes((0.0, 0.0, 1.0, 0.94))
    axes.set_axis_off()
    axes.set_aspect("equal")
    lower, upper = bounds(drawing)
    camera = Camera(lower, upper, **CAMERA)
    margin = 0.07 * float(np.linalg.norm(upper - lower))
    floor = min(float(lower[2]), 0.0)
    reach = np.stack([lower[:2] - margin, upper[:2] + margin])
    scale = Normalize(0.0, drawing.motion.duration if drawing.motion else 1.0)
    colours = colormaps["plasma"]
    paint(axes, camera, _solids(drawing, lambda time: colours(0.85 * scale(time))[:3], instants), floor, reach)
    for path in drawing.paths.values():
        axes.plot(*camera.project(path).T, color=_LINE_COLOUR, linewidth=1.8, linestyle=(0, (4, 1.5)))
    for one in drawing.segments:
        ends = camera.project(one.points.reshape(-1, 3)).reshape(-1, 2, 2)
        axes.add_collection(LineCollection(list(ends), colors=[one.colour], linewidths=0.6))
    for touch in drawing.failure.touches if drawing.failure else ():
        place = camera.project(touch.point)
        axes.plot(*place, "o", color=_FAULT_COLOUR, markersize=6)
        box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.5}
        axes.annotate(touch.text, place, (9, 0), textcoords="offset points", va="center", color=_FAULT_COLOUR, bbox=box)
    axes.autoscale_view()
    if drawing.motion is not None and drawing.motion.duration > 0 and len(drawing.paths) == 1:
        _draw_time_scale(figure, ScalarMappable(scale, _truncated(colours)))
    if drawing.failure and not title:
        title = f"{drawing.failure.status}: {drawing.failure.reason}"
    if title:
        figure.text(0.5, 0.975, title, ha="center", va="top", fontsize=12, wrap=True)
    return figure


def _solids(drawing: Drawing, colour_at: Callable[[float], Any], instants: int) -> list[Solid]:
    scene, motion = drawing.scene, drawing.motion
    several = motion is not None and len(motion.trajectories) > 1
    solids = []
    for body in scene.bodies:
        places = _places(scene, motion, body, instants)
        if not places:
            mesh = scene.placed(body, drawing.poses[0])
            if not is_floor(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)):
                solids.append(Solid(_corners(mesh), *appearance(drawing, body)))
        for k in places:
            assert motion is not None
            last, first = k == len(motion.times) - 1, k == 0
            colour = body.colour if several or body.kind == "held" else colour_at(motion.times[k])
            opacity = 1.0 if last or (first and not several) else _PASSING
            solids.append(Solid(_corners(scene.placed(body, motion.poses[k])), colour, opacity, later=last))
    return solids


def _places(scene: Scene, motion: Motion | None, body: Body, instants: int) -> list[int]:
    """The frames of the motion in which the body is drawn; none, where it never moves."""
    if motion is None or not body.frame:
        return []
    frame, last = scene.frames.index(body.frame), len(motion.times) - 1
    if np.ptp(motion.poses[:, frame], axis=0).max() < 1e-9:
        return []
    chosen = np.unique(np.linspace(0, last, instants).round().astype(int))
    middle = (body.mesh.vertices.min(axis=0) + body.mesh.vertices.max(axis=0)) / 2
    middle = np.append(body.pose[:3, :3] @ middle + body.pose[:3, 3], 1.0)
    middles = {k: (matrix(motion.poses[k, frame]) @ middle)[:3] for k in chosen}
    places = [last]  # and wherever it is not already drawn: a link may turn about its own axis
    for k in [0, *chosen[-2:0:-1]]:
        if all(np.linalg.norm(middles[k] - middles[other]) > _NEAR for other in places):
            places.append(k)
    return places


def _corners(mesh: Mesh) -> np.ndarray:
    mesh = simplified(mesh, _MAX_TRIANGLES)
    return mesh.vertices[mesh.triangles].astype(float)


def _truncated(colours: Any) -> Any:
    """The part of the colour map that the robots use."""
    from matplotlib.colors import ListedColormap

    return ListedColormap(colours(np.linspace(0.0, 0.9, 256)))


def _draw_time_scale(figure: Any, mappable: Any) -> None:
    bar = figure.colorbar(mappable, cax=figure.add_axes((0.90, 0.30, 0.014, 0.36)))
    bar.set_label("time [s]")
    bar.outline.set_visible(False)
