"""PyBullet's shapes as those of srmp.sim.shapes, each in a frame of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from srmp import Pose, convex_hull
from srmp.sim import shapes
from srmp.sim.shapes import Shape

HULL_MARGIN = 1e-3  # [m] by which Bullet lets convex hulls collide before they touch
SPHERE, BOX, CYLINDER, MESH, PLANE, CAPSULE = 2, 3, 4, 5, 6, 7  # GEOM_… of pybullet
ENDLESS = np.full(3, np.inf)


def primitive(kind: int, size: tuple[float, ...], pose: Pose) -> tuple[Shape, Pose]:
    """A shape of this GEOM_ type and these dimensions at the pose, and the pose of what it is here."""
    if kind == SPHERE:
        return shapes.Sphere(size[0]), pose
    if kind == BOX:
        return shapes.Box(np.array(size)), pose
    if kind == CYLINDER:
        return shapes.Cylinder(size[1], size[0]), pose
    if kind == CAPSULE:
        return shapes.Capsule(size[1], size[0]), pose
    if kind == PLANE:
        return shapes.Plane(), pose @ turned_to(np.array(size))
    return shapes.Unreadable(f"a shape of PyBullet's type {kind}"), pose


def turned_to(normal: NDArray[np.float64]) -> Pose:
    """A frame whose z axis is the normal."""
    z = normal / np.linalg.norm(normal)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    matrix = np.eye(4)
    matrix[:3, 0] = x / np.linalg.norm(x)
    matrix[:3, 1] = np.cross(z, matrix[:3, 0])
    matrix[:3, 2] = z
    return Pose.from_matrix(matrix)


def hull(points: NDArray[np.float64]) -> shapes.Mesh:
    """Bullet's hulls collide HULL_MARGIN before they touch; this one is as large, or up to 0.26 HULL_MARGIN larger."""
    golden = (1 + 5**0.5) / 2
    around = np.array([[0, s, t * golden] for s in (-1, 1) for t in (-1, 1)])
    around = np.concatenate([np.roll(around, k, axis=1) for k in range(3)])  # an icosahedron
    around *= HULL_MARGIN * 3**0.5 / golden**2  # that holds a sphere of that radius
    corners, _ = convex_hull((points[:, None] + around).reshape(-1, 3))
    return shapes.Mesh(corners, None)


def bounding_reach(found: list[tuple[Shape, Pose]]) -> NDArray[np.float64]:
    """(3,) half the size of the box that holds the boxes of the shapes."""
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    for shape, pose in found:
        below, above = bounds(shape)
        if np.any(np.isinf(above)):
            return ENDLESS
        centre, half = pose @ ((below + above) / 2), np.abs(pose.matrix()[:3, :3]) @ ((above - below) / 2)
        lower, upper = np.minimum(lower, centre - half), np.maximum(upper, centre + half)
    return (upper - lower) / 2 if found else np.zeros(3)


def bounds(shape: Shape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two corners (3,) of the box that holds the shape; infinite where it has no end."""
    match shape:
        case shapes.Box(size):
            half = size / 2
        case shapes.Sphere(radius):
            half = np.full(3, radius)
        case shapes.Cylinder(radius, length):
            half = np.array([radius, radius, length / 2])
        case shapes.Capsule(radius, length):
            half = np.array([radius, radius, length / 2 + radius])
        case shapes.Mesh(vertices, _):
            return vertices.min(axis=0), vertices.max(axis=0)
        case _:
            half = ENDLESS
    return -half, half


def is_surface(shape: Shape) -> bool:
    """Whether the shape has no inside."""
    return isinstance(shape, shapes.Plane) or (isinstance(shape, shapes.Mesh) and shape.triangles is not None)


def inner_point(shape: Shape) -> NDArray[np.float64]:
    """A point in the shape; of a surface, on it."""
    match shape:
        case shapes.Mesh(vertices, None):
            return vertices.mean(axis=0)
        case shapes.Mesh(vertices, triangles):
            return vertices[triangles[len(triangles) // 2]].mean(axis=0)
    return np.zeros(3)
