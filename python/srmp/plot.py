"""Figures of motions, drawn with matplotlib from plain numbers: nothing here knows a planner."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d import Axes3D

_LINE_COLOUR = "#0b7a75"
_LIMIT_COLOUR = "#b3402e"
_CUBE_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_CUBE_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_OBJECT_COLOUR = "#c2955d"
_EDGE_COLOUR = "#6b4f35"
_FLOOR_COLOUR = "#e9e6e1"


@dataclass
class SceneDrawing:
    """Solids in the world frame; poses are homogeneous (4, 4) matrices of their centres, sizes in metres."""

    boxes: list[tuple[ArrayLike, ArrayLike]] = field(default_factory=list)  #: (edge lengths (3,), pose)
    cylinders: list[tuple[float, float, ArrayLike]] = field(default_factory=list)  #: (radius, length along z, pose)
    spheres: list[tuple[float, ArrayLike]] = field(default_factory=list)  #: (radius, centre (3,))


@dataclass
class MotionDrawing:
    """A robot at m instants: polylines through its link origins."""

    link_origins: Sequence[ArrayLike]  #: m times (links, 3) [m], base first
    times: ArrayLike  #: (m,) [s]
    end_effector_path: ArrayLike  #: (n, 3) [m], as fine as it shall look


@dataclass
class Profile:
    """One quantity of all joints over time."""

    name: str
    unit: str
    values: np.ndarray  #: (n, joints)
    limits: np.ndarray | None = None  #: (joints,), of the absolute value


def draw_profiles(
    path: Path, joint_names: Sequence[str], times: np.ndarray, profiles: Sequence[Profile], title: str = ""
) -> None:
    """Writes a figure with a row of panels for each joint, one for each profile; limits dashed, with the fraction used.

    Raises ModuleNotFoundError when matplotlib is not installed.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    joints = len(joint_names)
    figure = Figure(figsize=(3.4 * len(profiles), 1.0 + 1.35 * joints), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    grid: Any = figure.subplots(joints, len(profiles), sharex=True, squeeze=False)
    for j, name in enumerate(joint_names):
        for axes, profile in zip(grid[j], profiles, strict=True):
            _draw_profile(axes, times, profile, j)
        grid[j][0].set_ylabel(name, rotation=0, ha="right", va="center", labelpad=10, fontsize=10)
    for top, bottom, profile in zip(grid[0], grid[-1], profiles, strict=True):
        top.set_title(f"{profile.name} [{profile.unit}]", fontsize=10)
        bottom.set_xlabel("time [s]", fontsize=9)
    if title:
        figure.suptitle(title, fontsize=12)
    figure.align_ylabels(grid[:, 0])
    figure.tight_layout(h_pad=0.4, w_pad=0.8)
    figure.savefig(path)


def _draw_profile(axes: Any, times: np.ndarray, profile: Profile, joint: int) -> None:
    values = profile.values[:, joint]
    axes.plot(times, values, color=_LINE_COLOUR, linewidth=1.3, zorder=3)
    axes.grid(color="#e3e3e3", linewidth=0.6)
    axes.tick_params(labelsize=8, length=2)
    axes.margins(x=0.02, y=0.12)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if np.ptp(values) < 1e-9 and profile.limits is None:  # a line, not the noise of its last digits
        axes.set_ylim(values[0] - 0.1, values[0] + 0.1)
    if profile.limits is not None:
        limit = profile.limits[joint]
        for bound in (-limit, limit):
            axes.axhline(bound, color=_LIMIT_COLOUR, linewidth=1.0, linestyle=(0, (4, 3)), zorder=2)
        fraction = np.abs(values).max() / limit
        broken = fraction > 1 + 1e-6
        axes.text(
            *(0.99, 0.97, f"{100 * fraction:.{1 if broken else 0}f} % of {limit:g}"),
            transform=axes.transAxes,
            ha="right",
            va="top",
            fontsize=7,
            color=_LIMIT_COLOUR if broken else "#555555",
            fontweight="bold" if broken else "normal",
        )
        axes.margins(y=0.22)


def draw_motion(
    path: str | Path, scene: SceneDrawing, motion: MotionDrawing | Sequence[MotionDrawing], title: str = ""
) -> None:
    """Writes a figure of the scene and the motions, early robots dark, late ones bright; the suffix says the format.

    Several motions have one clock.

    Raises ModuleNotFoundError when matplotlib is not installed.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 8), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    axes: Any = figure.add_axes((-0.02, -0.03, 0.96, 0.98), projection="3d", computed_zorder=False)
    motions = [motion] if isinstance(motion, MotionDrawing) else list(motion)
    lower, upper = _bounds(scene, motions)
    every_time = np.concatenate([np.asarray(one.times, dtype=float) for one in motions])
    scale = Normalize(every_time.min(), max(every_time.max(), every_time.min() + 1e-9))
    colours = colormaps["plasma"]

    _draw_floor(axes, lower, upper)
    for size, pose in scene.boxes:
        _draw_box(axes, np.asarray(size, dtype=float), np.asarray(pose, dtype=float))
    for radius, length, pose in scene.cylinders:
        _draw_cylinder(axes, radius, length, np.asarray(pose, dtype=float))
    for radius, centre in scene.spheres:
        _draw_sphere(axes, radius, np.asarray(centre, dtype=float))
    for one in motions:
        times = np.asarray(one.times, dtype=float)
        for k, (origins, time) in enumerate(zip(one.link_origins, times, strict=True)):
            last = k in (0, len(times) - 1)
            _draw_robot(axes, np.asarray(origins, dtype=float), colours(0.9 * scale(time)), 1.0 if last else 0.45)
        traced = np.asarray(one.end_effector_path, dtype=float)
        axes.plot(*traced.T, color="#0b7a75", linewidth=1.8, linestyle=(0, (4, 1.5)), zorder=30)

    _frame(axes, lower, upper)
    _draw_time_scale(figure, ScalarMappable(scale, _truncated(colours)))
    if title:
        figure.text(0.5, 0.955, title, ha="center", va="top", fontsize=12)
    figure.savefig(path)


def draw_spheres(path: str | Path, panels: Sequence[tuple[str, Sequence[ArrayLike]]]) -> None:
    """Writes a figure with a panel for each (title, groups of spheres): rows x, y, z, radius; one colour a group.

    Raises ModuleNotFoundError when matplotlib is not installed.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = Figure(figsize=(7 * len(panels), 8), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)  # no window, no global state
    every = np.vstack([np.asarray(group, dtype=float).reshape(-1, 4) for _, groups in panels for group in groups])
    lower, upper = (every[:, :3] - every[:, 3:]).min(axis=0), (every[:, :3] + every[:, 3:]).max(axis=0)
    colours = colormaps["tab20"]
    for k, (title, groups) in enumerate(panels):
        axes: Any = figure.add_subplot(1, len(panels), k + 1, projection="3d")
        faces, shades = [], []
        for index, group in enumerate(groups):
            spheres = np.asarray(group, dtype=float).reshape(-1, 4)
            unit = _sphere_faces(16 if len(every) < 1500 else 8)
            faces.append((spheres[:, None, None, :3] + spheres[:, None, None, 3:] * unit).reshape(-1, 4, 3))
            shades.append(np.repeat([colours(index % 20)], len(faces[-1]), axis=0))
        axes.add_collection3d(
            Poly3DCollection(np.vstack(faces), facecolors=np.vstack(shades), shade=True, linewidths=0)
        )
        _frame(axes, lower, upper, zoom=0.95)
        axes.set_title(title, fontsize=12)
    figure.tight_layout()
    figure.savefig(path)


def _sphere_faces(sectors: int) -> np.ndarray:
    """Quadrangles (n, 4, 3) of a unit sphere."""
    around, up = np.linspace(0, 2 * np.pi, sectors + 1), np.linspace(0, np.pi, sectors // 2 + 1)
    u, v = np.meshgrid(around, up, indexing="ij")
    points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    corners = [points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def _truncated(colours: Any) -> Any:
    """The part of the colour map that the robots use."""
    from matplotlib.colors import ListedColormap

    return ListedColormap(colours(np.linspace(0.0, 0.9, 256)))


def _bounds(scene: SceneDrawing, motions: Sequence[MotionDrawing]) -> tuple[np.ndarray, np.ndarray]:
    points = [np.zeros((1, 3))]
    for motion in motions:
        points.append(np.asarray(motion.end_effector_path, dtype=float).reshape(-1, 3))
        points += [np.asarray(origins, dtype=float) for origins in motion.link_origins]
    for size, pose in scene.boxes:
        points.append(_transform(np.asarray(pose, dtype=float), _CUBE_CORNERS * np.asarray(size, dtype=float)))
    for radius, length, pose in scene.cylinders:
        points.append(_transform(np.asarray(pose, dtype=float), 2 * _CUBE_CORNERS * [radius, radius, length / 2]))
    for radius, centre in scene.spheres:
        points.append(np.asarray(centre, dtype=float) + 2 * radius * _CUBE_CORNERS)
    every = np.vstack(points)
    return every.min(axis=0), every.max(axis=0)


def _transform(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ pose[:3, :3].T + pose[:3, 3]


def _draw_floor(axes: Axes3D, lower: np.ndarray, upper: np.ndarray) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    (x0, y0, z), (x1, y1, _) = lower - 0.02, upper + 0.02
    z = lower[2] - 1e-3
    floor = Poly3DCollection([[(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]], facecolor=_FLOOR_COLOUR, zorder=0)
    axes.add_collection3d(floor)


def _draw_box(axes: Axes3D, size: np.ndarray, pose: np.ndarray) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = _transform(pose, _CUBE_CORNERS * size)
    faces = Poly3DCollection(
        [corners[list(face)] for face in _CUBE_FACES],
        facecolors=_OBJECT_COLOUR,
        edgecolors=_EDGE_COLOUR,
        linewidths=0.6,
        alpha=0.16,
        shade=True,
        zorder=5,
    )
    axes.add_collection3d(faces)


def _draw_cylinder(axes: Any, radius: float, length: float, pose: np.ndarray) -> None:
    angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, 33), [-length / 2, length / 2])
    side = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    points = _transform(pose, side.reshape(-1, 3)).reshape(side.shape)
    axes.plot_surface(*np.moveaxis(points, -1, 0), color=_OBJECT_COLOUR, alpha=0.35, linewidth=0, zorder=5)
    for rim in points:
        axes.plot(*rim.T, color=_EDGE_COLOUR, linewidth=0.6, zorder=6)


def _draw_sphere(axes: Any, radius: float, centre: np.ndarray) -> None:
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
    x, y, z = np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)
    axes.plot_surface(
        centre[0] + radius * x,
        centre[1] + radius * y,
        centre[2] + radius * z,
        color=_OBJECT_COLOUR,
        alpha=0.35,
        zorder=5,
    )


def _draw_robot(axes: Any, origins: np.ndarray, colour: Any, alpha: float) -> None:
    axes.plot(
        *origins.T, color=colour, alpha=alpha, linewidth=6, solid_capstyle="round", solid_joinstyle="round", zorder=20
    )
    axes.plot(*origins.T, color="white", alpha=alpha, linewidth=0, marker="o", markersize=2.5, zorder=21)


def _frame(axes: Any, lower: np.ndarray, upper: np.ndarray, zoom: float = 1.08) -> None:
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    axes.set_box_aspect(np.maximum(upper - lower, 1e-3), zoom=zoom)
    axes.view_init(elev=24, azim=-148)
    axes.set_axis_off()


def _draw_time_scale(figure: Any, mappable: Any) -> None:
    bar = figure.colorbar(mappable, cax=figure.add_axes((0.915, 0.27, 0.014, 0.42)))
    bar.set_label("time [s]")
    bar.outline.set_visible(False)
