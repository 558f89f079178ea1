"""Scenes as generators make them and as records hold them: objects, and regions where tools start and end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import srmp
from srmp._names import did_you_mean

SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "cone": 2, "mesh": 0, "convex": 0}
"""Types of objects, and how many numbers their size has."""
APPROACHES = ("down", "forward", "any", "exact")


@dataclass(frozen=True)
class SceneObject:
    """An object: its type, size [m], pose in the world, and for meshes vertices [m] and triangles in its own frame.

    size: of a box its edge lengths; of a sphere its radius; of cylinder, capsule and cone radius and length along z; of
    a mesh (its surface) and of a convex hull nothing.
    """

    name: str
    type: str
    size: tuple[float, ...]
    pose: tuple[float, ...]
    """x, y, z [m], quaternion x, y, z, w."""
    vertices: tuple[float, ...] = ()
    """x, y, z of one after the other."""
    triangles: tuple[int, ...] = ()
    """Three vertex numbers of one after the other."""

    def add_to(self, planner: srmp.PlannerInterface) -> None:
        """Adds the object to the planner's world."""
        pose = pose_of(self.pose)
        if self.type in ("mesh", "convex"):
            vertices, triangles = np.reshape(self.vertices, (-1, 3)), np.reshape(self.triangles, (-1, 3))
            planner.add_mesh(self.name, pose=pose, convex=self.type == "convex", vertices=vertices, triangles=triangles)
        elif self.type == "box":
            planner.add_box(self.name, self.size, pose)
        else:
            getattr(planner, f"add_{self.type}")(self.name, *self.size, pose)

    def to_dict(self) -> dict[str, Any]:
        """As records and specs hold it."""
        return {
            "name": self.name,
            "type": self.type,
            "size": list(self.size),
            "pose": list(self.pose),
            "vertices": list(self.vertices),
            "triangles": list(self.triangles),
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> SceneObject:
        """The object of a dictionary that to_dict made."""
        arrays = {key: tuple(values[key]) for key in ("size", "pose", "vertices", "triangles")}
        return cls(values["name"], values["type"], **arrays)


@dataclass(frozen=True)
class Region:
    """A box, in its own frame, in which tools are placed; how they point.

    approach: "down" and "forward" point the tool along -z and +x of the region's frame, turned freely about that
    direction; "any" in any direction; "exact" takes the region's own orientation.
    """

    name: str
    pose: srmp.Pose
    size: tuple[float, float, float]
    """Edge lengths [m], each at least 0."""
    approach: str = "down"


@dataclass
class Scene:
    """What a scene generator returns: objects, and regions for starts and goals. Lengths in metres, world frame."""

    objects: list[SceneObject] = field(default_factory=list)
    regions: list[Region] = field(default_factory=list)

    def box(self, name: str, size: Sequence[float], pose: srmp.Pose | Sequence[float]) -> None:
        """Adds a box with edge lengths `size` (3,); `pose` is that of its centre, or the centre alone."""
        self._add(name, "box", size, pose)

    def sphere(self, name: str, radius: float, pose: srmp.Pose | Sequence[float]) -> None:
        """Adds a sphere."""
        self._add(name, "sphere", [radius], pose)

    def cylinder(self, name: str, radius: float, length: float, pose: srmp.Pose | Sequence[float]) -> None:
        """Adds a cylinder along z."""
        self._add(name, "cylinder", [radius, length], pose)

    def capsule(self, name: str, radius: float, length: float, pose: srmp.Pose | Sequence[float]) -> None:
        """Adds a capsule along z; `length` is that between its half spheres."""
        self._add(name, "capsule", [radius, length], pose)

    def cone(self, name: str, radius: float, length: float, pose: srmp.Pose | Sequence[float]) -> None:
        """Adds a cone along z, its apex above."""
        self._add(name, "cone", [radius, length], pose)

    def mesh(
        self, name: str, vertices: Any, triangles: Any, pose: srmp.Pose | Sequence[float], *, convex: bool = False
    ) -> None:
        """Adds the surface of vertices (n, 3) and triangles (m, 3) of vertex numbers; convex: a solid convex hull.

        The triangles of a convex hull are found here, those that are given are not used.
        """
        if convex:
            vertices, triangles = srmp.convex_hull(vertices)
        corners = np.asarray(vertices, dtype=float).reshape(-1, 3)
        faces = np.asarray(triangles, dtype=int).reshape(-1, 3)
        self._add(name, "convex" if convex else "mesh", [], pose, corners, faces)

    def region(
        self, name: str, size: Sequence[float], pose: srmp.Pose | Sequence[float], approach: str = "down"
    ) -> None:
        """Adds a region of edge lengths `size` (3,) about the centre `pose`. Raises InvalidArgument."""
        if approach not in APPROACHES:
            hint = did_you_mean(approach, APPROACHES) or f"; known: {', '.join(APPROACHES)}."
            raise srmp.InvalidArgument(f"the approach of region '{name}' is '{approach}'{hint}")
        lengths = _numbers(size, 3, f"the size of region '{name}'")
        if min(lengths) < 0:
            raise srmp.InvalidArgument(f"the size of region '{name}' is {list(lengths)}: no length may be below 0.")
        self.regions.append(Region(name, _as_pose(pose), lengths, approach))

    def _add(
        self,
        name: str,
        kind: str,
        size: Sequence[float],
        pose: srmp.Pose | Sequence[float],
        vertices: np.ndarray | None = None,
        triangles: np.ndarray | None = None,
    ) -> None:
        lengths = _numbers(size, SIZES[kind], f"the size of {kind} '{name}'")
        corners = () if vertices is None else tuple(vertices.ravel().tolist())
        faces = () if triangles is None else tuple(triangles.ravel().tolist())
        self.objects.append(SceneObject(name, kind, lengths, tuple(_as_pose(pose)), corners, faces))


def pose_of(numbers: Sequence[float]) -> srmp.Pose:
    """The pose of x, y, z [m] and a quaternion x, y, z, w."""
    return srmp.Pose(numbers[:3], numbers[3:])


def _as_pose(pose: srmp.Pose | Sequence[float]) -> srmp.Pose:
    return pose if isinstance(pose, srmp.Pose) else srmp.Pose(p=pose)


def _numbers(values: Sequence[float], count: int, what: str) -> tuple[float, ...]:
    numbers = tuple(float(value) for value in values)
    if len(numbers) != count or not np.all(np.isfinite(numbers)):
        raise srmp.InvalidArgument(f"{what} is {list(values)}: it must be {count} finite numbers.")
    return numbers
