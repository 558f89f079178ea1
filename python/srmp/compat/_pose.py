"""Poses with MPLib's interface, and the screw motion between two."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import srmp

Array = NDArray[np.float64]


class Pose:
    """Position p (3,) [m] and quaternion q = [w, x, y, z] (normalised).

    Pose(), Pose(p, q), or of anything that is a pose: an object with p and q = [w, x, y, z] (sapien.Pose), an
    srmp.Pose, seven numbers x, y, z, qw, qx, qy, qz, or a (4, 4) matrix.
    """

    def __init__(self, p: Any = None, q: ArrayLike | None = None) -> None:
        if q is None and p is not None and np.shape(p) != (3,):
            self._pose = to_pose(p)
        else:
            self._pose = _from_wxyz([0, 0, 0] if p is None else p, [1, 0, 0, 0] if q is None else q)

    @property
    def p(self) -> Array:
        """Position x, y, z, (3,) [m]."""
        return np.array(self._pose.p)

    @p.setter
    def p(self, p: ArrayLike) -> None:
        self._pose = _from_wxyz(p, self.q)

    @property
    def q(self) -> Array:
        """Quaternion w, x, y, z, (4,)."""
        return np.roll(self._pose.q, 1)

    @q.setter
    def q(self, q: ArrayLike) -> None:
        self._pose = _from_wxyz(self.p, q)

    def inv(self) -> Pose:
        """The inverse transform."""
        return Pose(self._pose.inverse())

    def to_transformation_matrix(self) -> Array:
        """Homogeneous (4, 4)."""
        return self._pose.matrix()

    def distance(self, other: Any) -> float:
        """norm(p - other.p) + the smaller of norm(q - other.q) and norm(q + other.q), as in MPLib."""
        there = Pose(other)
        rotation = min(np.linalg.norm(self.q - there.q), np.linalg.norm(self.q + there.q))
        return float(np.linalg.norm(self.p - there.p) + rotation)

    def __mul__(self, other: Any) -> Any:
        """Pose * Pose, or Pose * point (3,)."""
        if hasattr(other, "q"):
            return Pose(self._pose @ to_pose(other))
        return self._pose @ np.asarray(other)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pose) and self._pose == other._pose

    __hash__ = None  # type: ignore[assignment]  # p and q may be set

    def __repr__(self) -> str:
        return f"Pose({self.p.tolist()}, {self.q.tolist()})"


def _from_wxyz(p: Any, q: Any) -> srmp.Pose:
    return srmp.Pose.from_wxyz(np.ravel(p), np.ravel(q))  # ravel: ManiSkill's are batches of one


def to_pose(value: Any) -> srmp.Pose:
    """Whatever MPLib, SAPIEN and ManiSkill call a pose."""
    if isinstance(value, srmp.Pose):  # its q is [x, y, z, w]: which must not be read
        return value
    if isinstance(value, Pose):
        return value._pose
    if hasattr(value, "p") and hasattr(value, "q"):
        return _from_wxyz(value.p, value.q)
    with contextlib.suppress(TypeError, ValueError):
        numbers = np.asarray(value, dtype=float)
        if numbers.shape == (7,):
            return _from_wxyz(numbers[:3], numbers[3:])
        if numbers.shape == (4, 4):
            return srmp.Pose.from_matrix(numbers)
    raise srmp.InvalidArgument(
        "a pose must be an object with p and q = [w, x, y, z], the seven numbers x, y, z, qw, qx, qy, qz, or a (4, 4) "
        f"matrix, but is {value!r}"
    )


def screw(start: srmp.Pose, goal: srmp.Pose) -> Callable[[float], srmp.Pose]:
    """The pose after a fraction, 0..1, of the screw motion from start to goal (Chasles): a rotation, of pi at most,
    about an axis, and a slide along it."""
    motion = goal @ start.inverse()
    q = motion.q if motion.q[3] >= 0 else -motion.q
    sine = float(np.linalg.norm(q[:3]))
    angle = 2 * math.atan2(sine, q[3])
    if angle < 1e-9:
        return lambda fraction: srmp.Pose(start.p + fraction * motion.p, start.q)
    axis = q[:3] / sine
    slide = (axis @ motion.p) * axis
    across = motion.p - slide
    centre = (across + np.cross(axis, across) / math.tan(angle / 2)) / 2  # a point of the axis

    def pose_at(fraction: float) -> srmp.Pose:
        rotation = np.append(math.sin(fraction * angle / 2) * axis, math.cos(fraction * angle / 2))
        about_origin = srmp.Pose([0, 0, 0], rotation)
        return srmp.Pose(centre - about_origin @ centre + fraction * slide, rotation) @ start

    return pose_at
