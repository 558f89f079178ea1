"""Triangles of the shapes that scenes and robots are made of. Metres, in the shape's own frame."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import srmp

_SECTORS = 40  # of round shapes
_MAX_TRIANGLES = 20_000  # of one mesh file; finer ones are simplified, because they are only looked at

_MAX_VOXELS = 10_000  # of a cloud, as it is drawn

Colour = tuple[float, float, float]  # red, green, blue, 0 to 1


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh."""

    vertices: NDArray[np.float32]  # (n, 3)
    triangles: NDArray[np.int32]  # (m, 3)

    def moved(self, pose: NDArray[np.float64]) -> Mesh:
        """The mesh at a pose, a homogeneous (4, 4) matrix, which may scale."""
        vertices = self.vertices @ pose[:3, :3].T + pose[:3, 3]
        turned = np.linalg.det(pose[:3, :3]) < 0  # a mirror turns the triangles inside out
        return make_mesh(vertices, self.triangles[:, ::-1] if turned else self.triangles)


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines of one colour."""

    name: str
    points: NDArray[np.float64]  # (n, 2, 3) [m]
    colour: Colour


def make_mesh(vertices: ArrayLike, triangles: ArrayLike) -> Mesh:
    return Mesh(
        np.ascontiguousarray(np.asarray(vertices, dtype=np.float32).reshape(-1, 3)),
        np.ascontiguousarray(np.asarray(triangles, dtype=np.int32).reshape(-1, 3)),
    )


def joined(meshes: list[Mesh]) -> Mesh:
    """All of them as one mesh."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return make_mesh(
        np.concatenate([np.zeros((0, 3)), *(mesh.vertices for mesh in meshes)]),
        np.concatenate([np.zeros((0, 3)), *(mesh.triangles + k for mesh, k in zip(meshes, first, strict=False))]),
    )


def box(size: ArrayLike) -> Mesh:
    """Full edge lengths (3,), centred."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [corner for a, b, c, d in faces for corner in ((a, b, c), (a, c, d))]
    return make_mesh(corners * np.asarray(size, dtype=float), triangles)


def revolved(profile: ArrayLike, sectors: int = _SECTORS) -> Mesh:
    """The profile, rows (radius, z) from below upwards that begin and end on the axis, turned about z."""
    radii, heights = np.asarray(profile, dtype=float).T
    angles = 2 * np.pi * np.arange(sectors) / sectors
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rings = np.concatenate([radii[:, None, None] * circle, np.tile(heights[:, None, None], (1, sectors, 1))], axis=2)
    here = np.arange(len(radii) * sectors).reshape(len(radii), sectors)
    beside = np.roll(here, -1, axis=1)
    lower = np.stack([here[:-1], beside[:-1], beside[1:]], axis=-1)[radii[:-1] > 0]
    upper = np.stack([here[:-1], beside[1:], here[1:]], axis=-1)[radii[1:] > 0]
    return make_mesh(rings, np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)]))


def sphere(radius: float, sectors: int = _SECTORS) -> Mesh:
    """Centred."""
    return capsule(radius, 0.0, sectors)


def cylinder(radius: float, length: float) -> Mesh:
    """Along z, centred."""
    half = length / 2
    return revolved([(0, -half), (radius, -half), (radius, half), (0, half)])


def cone(radius: float, length: float) -> Mesh:
    """Along z, its base at -length / 2."""
    return revolved([(0, -length / 2), (radius, -length / 2), (0, length / 2)])


def capsule(radius: float, length: float, sectors: int = _SECTORS) -> Mesh:
    """A cylinder of `length` along z with a half sphere on each end, centred."""
    angles = np.linspace(0, np.pi / 2, max(3, sectors // 4 + 1))
    cap = np.stack([radius * np.sin(angles), length / 2 + radius * np.cos(angles)], axis=-1)  # from the top down
    cap[0, 0] = 0.0
    profile = np.concatenate([cap * [1, -1], cap[::-1] if length > 0 else cap[-2::-1]])
    return revolved(profile, sectors)


def spheres(rows: ArrayLike) -> Mesh:
    """Rows x, y, z, radius."""
    unit = sphere(1.0, 12)
    rows = np.asarray(rows, dtype=float).reshape(-1, 4)
    vertices = rows[:, None, :3] + rows[:, None, 3:] * unit.vertices
    triangles = unit.triangles + len(unit.vertices) * np.arange(len(rows))[:, None, None]
    return make_mesh(vertices, triangles)


def voxels(points: ArrayLike, edge: float) -> Mesh:
    """A cube with this edge around each point; of many points, larger cubes that hold several of them."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    while len(points) > _MAX_VOXELS:
        edge *= 2
        points = (np.unique(np.floor(points / edge), axis=0) + 0.5) * edge
    unit = box([edge] * 3)
    triangles = unit.triangles + len(unit.vertices) * np.arange(len(points))[:, None, None]
    return make_mesh(points[:, None] + unit.vertices, triangles)


def of_object(shape: Mapping[str, Any]) -> Mesh:
    """The shape of an object in a scene file."""
    match shape["kind"]:
        case "box":
            return box(shape["size"])
        case "sphere":
            return sphere(shape["radius"])
        case "cylinder":
            return cylinder(shape["radius"], shape["length"])
        case "capsule":
            return capsule(shape["radius"], shape["length"])
        case "cone":
            return cone(shape["radius"], shape["length"])
        case "point cloud":
            return voxels(shape["points"], shape["resolution"])
        case "mesh" if shape["convex"]:
            return make_mesh(*srmp.convex_hull(np.asarray(shape["vertices"], dtype=float).reshape(-1, 3)))
        case "mesh":
            return make_mesh(shape["vertices"], shape["triangles"])
    raise srmp.NotSupported(f"an object of the kind '{shape['kind']}' cannot be drawn")


def simplified(mesh: Mesh, max_triangles: int = _MAX_TRIANGLES) -> Mesh:
    """The mesh with at most about this many triangles: near vertices are merged (Rossignac, Borrel 1993)."""
    cells = 256
    while len(mesh.triangles) > max_triangles:
        lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        places = np.floor((mesh.vertices - lower) / max((upper - lower).max(), 1e-9) * cells).astype(np.int64)
        _, index, counts = np.unique(places, axis=0, return_inverse=True, return_counts=True)
        index = index.reshape(-1)
        sums = np.stack([np.bincount(index, mesh.vertices[:, k]) for k in range(3)], axis=-1)
        triangles = index[mesh.triangles]
        a, b, c = triangles.T
        mesh = make_mesh(sums / counts[:, None], triangles[(a != b) & (b != c) & (c != a)])
        cells //= 2
    return mesh


class MeshesUnreadable(srmp.NotSupported):
    """The package that reads mesh files is not installed."""


@functools.lru_cache(maxsize=512)
def load_mesh_file(path: str) -> tuple[tuple[Mesh, Colour | None], ...]:
    """The parts of a mesh file, each with the colour of its material where it has one.

    Raises MeshesUnreadable where trimesh is not installed, and FileError for a file that it cannot read.
    """
    try:
        import trimesh
    except ImportError as error:
        raise MeshesUnreadable("mesh files are read by trimesh: pip install '.[viewer]' in the checkout") from error
    try:
        scene = trimesh.load(path, force="scene", skip_materials=Path(path).suffix.lower() == ".stl")
        parts = scene.dump(concatenate=False)
    except ImportError as error:
        raise MeshesUnreadable(f"{path}: {error}; pip install '.[viewer]' in the checkout") from error
    except Exception as error:  # trimesh raises whatever its readers raise
        raise srmp.FileError(f"{path}: {error}") from error
    found = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if not found:
        raise srmp.FileError(f"{path}: it holds no triangles")
    limit = max(500, _MAX_TRIANGLES // len(found))
    return tuple((simplified(make_mesh(part.vertices, part.faces), limit), _colour_of(part)) for part in found)


def _colour_of(part: Any) -> Colour | None:
    """The colour of a part's material; None where nothing says one."""
    if not part.visual.defined:
        return None
    try:
        material = getattr(part.visual, "material", None)
        rgba = np.asarray(part.visual.main_color if material is None else material.main_color, dtype=float) / 255
    except (AttributeError, TypeError, ValueError):
        return None
    return (float(rgba[0]), float(rgba[1]), float(rgba[2])) if rgba.shape == (4,) else None
