"""Pictures of solid bodies with matplotlib: triangles shaded, sorted by depth, and painted from back to front."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LIGHT = np.array([-0.50, -0.35, 0.79])  # towards the light
_FLOOR = "#eceae6"
_SHADOW = "#d5d2cc"
_PIECES = 45  # no painted triangle is longer than this part of the picture: neighbours are then sorted well


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles of one colour."""

    corners: NDArray[np.float64]  # (n, 3, 3) [m], world frame
    colour: tuple[float, float, float]
    opacity: float = 1.0
    later: bool = False  #: painted over others at the same place


class Camera:
    """A perspective view of the box from `lower` to `upper`."""

    def __init__(
        self, lower: NDArray[np.float64], upper: NDArray[np.float64], yaw: float, pitch: float, distance: float = 1.9
    ) -> None:
        self.size = float(np.linalg.norm(upper - lower))
        back = np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)])
        right = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        self.eye = (lower + upper) / 2 + distance * self.size * back
        self._axes = np.stack([right, np.cross(back, right), -back])

    def depth(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of points (…, 3), along the view [m]."""
        return (points - self.eye) @ self._axes[2]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (…, 3) to the picture (…, 2)."""
        seen = (points - self.eye) @ self._axes.T
        return seen[..., :2] / np.maximum(seen[..., 2:], 1e-3 * self.size)


def paint(axes: Any, camera: Camera, solids: list[Solid], floor: float, reach: NDArray[np.float64]) -> None:
    """Solids on a floor at the height `floor`, a rectangle of corners `reach` (2, 2), with their shadows on it."""
    from matplotlib.collections import PolyCollection

    (x0, y0), (x1, y1) = reach
    plate = np.array([[x0, y0, floor], [x1, y0, floor], [x1, y1, floor], [x0, y1, floor]])
    axes.add_collection(PolyCollection([camera.project(plate)], facecolors=_FLOOR))
    pieces = [(_cut(solid.corners, camera.size / _PIECES), solid) for solid in solids if len(solid.corners)]
    if not pieces:
        return
    opaque = [_cut(solid.corners, camera.size / 12) for _, solid in pieces if solid.opacity >= 1]
    if opaque:
        shadows = _shadows(np.concatenate(opaque), floor, reach)
        _add(axes, PolyCollection(camera.project(shadows), facecolors=_SHADOW, edgecolors=_SHADOW, lw=0.3))
    corners, counts = np.concatenate([part for part, _ in pieces]), [len(part) for part, _ in pieces]
    colours = np.concatenate([_shaded(part, solid, camera) for part, solid in pieces])
    nearer = np.repeat([camera.size / _PIECES / 2 if solid.later else 0.0 for _, solid in pieces], counts)
    keep = colours[:, 3] > 0
    corners, colours, nearer = corners[keep], colours[keep], nearer[keep]
    order = np.argsort(nearer - camera.depth(corners.mean(axis=1)), kind="stable")
    corners, colours = corners[order], colours[order]
    seams = np.where(colours[:, 3:] >= 1, colours, 0.0)  # thin edges close the seams; they would show on what is clear
    _add(axes, PolyCollection(camera.project(corners), facecolors=colours, edgecolors=seams, lw=0.3))


def _add(axes: Any, triangles: Any) -> None:
    """As pixels, also in SVG and PDF: there are too many for other programs."""
    triangles.set_rasterized(True)
    axes.add_collection(triangles)


def _shaded(corners: NDArray[np.float64], solid: Solid, camera: Camera) -> NDArray[np.float64]:
    """Colours (n, 4) of triangles; what one looks through has no back sides."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    to_eye = camera.eye - corners.mean(axis=1)
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    facing = np.einsum("ij,ij->i", normals, to_eye)
    normals *= np.where(facing < 0, -1.0, 1.0)[:, None]
    light = 0.52 + 0.13 * normals[:, 2] + 0.38 * np.clip(normals @ _LIGHT, 0, 1) + 0.08 * np.abs(facing)
    colours = np.empty((len(corners), 4))
    colours[:, :3] = np.clip(light[:, None] * np.asarray(solid.colour), 0, 1)
    colours[:, 3] = np.where((solid.opacity >= 1) | (facing > 0), solid.opacity, 0.0)
    return colours


def _shadows(corners: NDArray[np.float64], floor: float, reach: NDArray[np.float64]) -> NDArray[np.float64]:
    """The triangles (n, 3, 3) as the light throws them on the floor, as far as it goes."""
    heights = np.maximum(corners[..., 2:] - floor, 0.0)
    thrown = corners - heights * _LIGHT / _LIGHT[2]
    thrown[..., 2] = floor
    inside = ((thrown[..., :2] >= reach[0]) & (thrown[..., :2] <= reach[1])).all(axis=(1, 2))
    return thrown[inside & (corners[..., 2].max(axis=1) >= floor)]


def _cut(corners: NDArray[np.float64], longest: float) -> NDArray[np.float64]:
    """Triangles halved at their longest edges until no edge is longer than this."""
    done = []
    while len(corners):
        lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        long = lengths.max(axis=1) > longest
        done.append(corners[~long])
        corners, edge = corners[long], lengths[long].argmax(axis=1)
        if not len(corners):
            break
        turned = np.take_along_axis(corners, ((edge[:, None] + np.arange(3)) % 3)[..., None], axis=1)
        a, b, c = turned[:, 0], turned[:, 1], turned[:, 2]
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done) if done else corners
