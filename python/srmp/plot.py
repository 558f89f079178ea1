"""Figures drawn with matplotlib from plain numbers: nothing here knows a planner (that is PlannerInterface.plot)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import srmp

_LINE_COLOUR = "#0b7a75"
_LIMIT_COLOUR = "#b3402e"


@dataclass
class Profile:
    """One quantity of all joints over time."""

    name: str
    unit: str
    values: np.ndarray  #: (n, joints)
    limits: np.ndarray | None = None  #: (joints,), of the absolute value


def draw_profiles(joint_names: Sequence[str], times: np.ndarray, profiles: Sequence[Profile], title: str = "") -> Any:
    """A Figure with a row of panels for each joint, one for each profile; limits dashed, with the fraction used.

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
    return figure


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


def write_figure(figure: Any, path: str | Path) -> None:
    """Writes a Figure; raises FileError when it cannot be written, InvalidArgument for a suffix of no figure format."""
    try:
        figure.savefig(path)
    except OSError as error:
        raise srmp.FileError(f"{path} cannot be written: {error.strerror or error}.") from error
    except ValueError as error:  # a format that matplotlib does not know
        raise srmp.InvalidArgument(f"{path}: {error}.") from error


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


def _frame(axes: Any, lower: np.ndarray, upper: np.ndarray, zoom: float = 1.08) -> None:
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    axes.set_box_aspect(np.maximum(upper - lower, 1e-3), zoom=zoom)
    axes.view_init(elev=24, azim=-148)
    axes.set_axis_off()
