"""The collision shapes of simulators, and how each becomes one that the planner has. Metres, in a shape's own frame."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, NotSupported, PlannerInterface, Pose, convex_hull

PLANE_REACH = 20.0  # [m] half the edge of the box that stands for a plane, and its depth
LAYER_DEPTH = 0.04  # [m] between the sheets that fill a height field: no link is thinner
ELLIPSOID_TOLERANCE = 1e-3  # the polyhedron around an ellipsoid reaches out by less than this fraction of its semi-axes


@dataclass(frozen=True)
class Box:
    """A box, centred."""

    size: NDArray[np.float64]  # (3,) full edge lengths


@dataclass(frozen=True)
class Sphere:
    """A sphere, centred."""

    radius: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, centred."""

    radius: float
    length: float  # along z


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with a half sphere on each end, centred."""

    radius: float
    length: float  # along z, without the half spheres


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid along the axes, centred."""

    semi_axes: NDArray[np.float64]  # (3,)


@dataclass(frozen=True)
class Plane:
    """The half space z <= 0."""


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh as a surface, or a convex hull."""

    vertices: NDArray[np.float64]  # (n, 3)
    triangles: NDArray[np.int64] | None  # (m, 3); None: the convex hull of the vertices, as a solid


@dataclass(frozen=True)
class HeightField:
    """Solid from `bottom` up to the surface z = heights[row, column], rows along y, columns along x, centred."""

    heights: NDArray[np.float64]  # (rows, columns)
    spacing: tuple[float, float]  # along x and y
    bottom: float
    rising: bool = True  # cells are cut from (row, column) to (row + 1, column + 1), else along the other diagonal


@dataclass(frozen=True)
class Unreadable:
    """Something that SRMP has no shape for."""

    what: str  # "a geom of type sdf"


Shape = Box | Sphere | Cylinder | Capsule | Ellipsoid | Plane | Mesh | HeightField | Unreadable


def same_shape(a: Shape, b: Shape) -> bool:
    """Whether the two shapes are equal, number by number."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    return all(
        np.array_equal(getattr(a, field.name), getattr(b, field.name))  # type: ignore[arg-type]
        for field in dataclasses.fields(a)
    )


def add_object(planner: PlannerInterface, name: str, shape: Shape, pose: Pose) -> None:
    """Adds the shape to the planner's world, as docs/simulators.md says for each."""
    match shape:
        case Box(size):
            planner.add_box(name, size=size, pose=pose)
        case Sphere(radius):
            planner.add_sphere(name, radius=radius, pose=pose)
        case Cylinder(radius, length):
            planner.add_cylinder(name, radius=radius, length=length, pose=pose)
        case Capsule(radius, length):
            planner.add_capsule(name, radius=radius, length=length, pose=pose)
        case Plane():
            planner.add_box(name, size=[2 * PLANE_REACH] * 2 + [PLANE_REACH], pose=placed_pose(shape, pose))
        case _:
            mesh = as_mesh(shape)
            convex = mesh.triangles is None
            triangles = {} if convex else {"triangles": mesh.triangles}
            planner.add_mesh(name, vertices=mesh.vertices, convex=convex, pose=pose, **triangles)


def object_pose(shape: Shape, pose: Pose, centre: NDArray[np.float64]) -> Pose:
    """The pose at which add_object is to put it: of an endless plane, the part below `centre`."""
    if not isinstance(shape, Plane):
        return pose
    below = pose.inverse() @ np.asarray(centre)
    return pose @ Pose(p=[below[0], below[1], 0.0])


def placed_pose(shape: Shape, pose: Pose) -> Pose:
    """The pose of the planner's object that add_object made for `pose`."""
    return pose @ Pose(p=[0, 0, -PLANE_REACH / 2]) if isinstance(shape, Plane) else pose


def require_readable(shape: Shape) -> None:
    """Raises NotSupported for an Unreadable shape."""
    if isinstance(shape, Unreadable):
        raise NotSupported(f"{shape.what} cannot be read")


def as_mesh(shape: Shape) -> Mesh:
    """Ellipsoids and height fields as meshes; meshes as they are."""
    match shape:
        case Mesh():
            return shape
        case Ellipsoid(semi_axes):
            return Mesh(_directions() * np.asarray(semi_axes), None)
        case HeightField():
            return _layers(shape)
    require_readable(shape)
    raise InvalidArgument(f"a {type(shape).__name__} has no mesh")


def hull(shape: Mesh) -> Mesh:
    """The mesh, with triangles of its own where it is the hull of its vertices."""
    if shape.triangles is not None:
        return shape
    vertices, triangles = convex_hull(shape.vertices)
    return Mesh(vertices, np.asarray(triangles))


def _directions() -> NDArray[np.float64]:
    """Corners of a polyhedron that holds the unit sphere: an icosahedron with faces split four times, scaled."""
    golden = (1 + 5**0.5) / 2
    corners = np.array(
        [[s * 1.0, t * golden, 0.0] for s in (-1, 1) for t in (-1, 1)]
        + [[0.0, s * 1.0, t * golden] for s in (-1, 1) for t in (-1, 1)]
        + [[t * golden, 0.0, s * 1.0] for s in (-1, 1) for t in (-1, 1)]
    )
    points, faces = (np.asarray(part) for part in convex_hull(corners / np.linalg.norm(corners[0])))
    for _ in range(4):
        a, b, c = (points[faces[:, k]] for k in range(3))
        ab, bc, ca = ((u + v) / np.linalg.norm(u + v, axis=1, keepdims=True) for u, v in ((a, b), (b, c), (c, a)))
        triangles = np.concatenate(
            [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        ).reshape(-1, 3)
        points, indices = np.unique(triangles.round(12), axis=0, return_inverse=True)
        faces = indices.reshape(-1, 3)
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    distances = np.abs(np.sum(normals * a, axis=1)) / np.linalg.norm(normals, axis=1)
    return points / distances.min()


def _layers(field: HeightField) -> Mesh:
    """The surface, copies of it further down every LAYER_DEPTH, the bottom, and the four sides."""
    heights = np.asarray(field.heights, dtype=float)
    rows, columns = heights.shape
    if rows < 2 or columns < 2:
        raise InvalidArgument(f"a height field has {rows} x {columns} heights; it needs at least 2 x 2")
    dx, dy = field.spacing
    x, y = np.meshgrid((np.arange(columns) - (columns - 1) / 2) * dx, (np.arange(rows) - (rows - 1) / 2) * dy)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]  # b, d: next column; c, d: next row
    cells = [(a, b, d), (a, d, c)] if field.rising else [(a, b, c), (b, d, c)]
    sheet = np.concatenate([np.stack([corner.ravel() for corner in cell], axis=1) for cell in cells])
    depths = np.append(np.arange(0.0, heights.max() - field.bottom, LAYER_DEPTH), np.inf)
    levels = [np.maximum(heights - depth, field.bottom) for depth in depths]
    vertices = np.concatenate([np.stack([x.ravel(), y.ravel(), level.ravel()], axis=1) for level in levels])
    sheets = [sheet + k * number.size for k in range(len(levels))]
    rim = np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])
    following, below = np.roll(rim, -1), (len(levels) - 1) * number.size
    sides = [
        np.stack([rim, following, rim + below], axis=1),
        np.stack([following, following + below, rim + below], axis=1),
    ]
    return Mesh(vertices, np.concatenate(sheets + sides))
