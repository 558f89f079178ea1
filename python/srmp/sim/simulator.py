"""The interface that SRMP needs of a simulator; srmp.sim.mujoco, .sapien, .genesis and .pybullet implement it.

Poses are in the world frame unless said otherwise. Joints and links go by the simulator's own names.
"""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from types import ModuleType
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from srmp import Error, NotSupported, Pose
from srmp.sim.shapes import Shape

Positions = Mapping[str, float]  # joint name to [rad or m]


class MissingSimulator(NotSupported, ImportError):
    """The simulator's Python package is not installed."""


def import_simulator(module: str, package: str) -> ModuleType:
    """The module, or MissingSimulator that says what to install."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingSimulator(
            f"this needs the Python package '{package}', which cannot be imported ({error}); pip install {package}"
        ) from error


def diverged(what: str) -> Error:
    """The error for a simulation whose numbers are not finite."""
    return Error(f"the simulation diverged: {what}; a smaller time step or softer controllers may help")


@dataclass(frozen=True)
class Geometry:
    """A collision shape of a body or link."""

    name: str  # among those of its body; "" = the simulator has none
    shape: Shape
    pose: Pose  # in the body's frame
    key: Hashable  # what filters and contacts of this simulator know it by; shapes of a body may share one


@dataclass(frozen=True)
class Body:
    """A rigid body: something in the world, or a link of an articulation."""

    name: str
    pose: Pose
    geometries: tuple[Geometry, ...]


@dataclass(frozen=True)
class Joint:
    """Where a link hangs on its parent: parent pose @ origin is the child's pose with the joint at 0."""

    name: str
    kind: str  # "revolute", "continuous", "prismatic", "fixed"
    parent: str  # link
    child: str  # link
    origin: Pose  # of the child in the parent, at 0
    axis: NDArray[np.float64]  # (3,) unit, in the child's frame
    lower: float = 0.0  # [rad or m]; of no meaning for continuous and fixed ones
    upper: float = 0.0
    velocity: float | None = None  # [rad/s or m/s], > 0; None = the simulator has no such limit


@dataclass(frozen=True)
class Articulation:
    """A tree of links, the root first, parents before children."""

    name: str
    links: tuple[Body, ...]
    joints: tuple[Joint, ...]


class Touch(NamedTuple):
    """Two geometries, by key, that overlap by `depth` [m]."""

    a: Hashable
    b: Hashable
    depth: float


class Probe(ABC):
    """A copy of the world, or the world itself before it is put back, in which joints are set and contacts queried."""

    @abstractmethod
    def put(self, articulation: str, positions: Positions) -> None:
        """Sets these joints; others stay."""

    @abstractmethod
    def link_poses(self, articulation: str) -> dict[str, Pose]:
        """World poses of the links of an articulation, by name."""

    @abstractmethod
    def touching(self) -> list[Touch]:
        """All pairs that overlap and are not filtered."""


class Simulator(ABC):
    """One scene of one simulator."""

    kind: ClassVar[str]
    margin: ClassVar[float]  # [m] by which its contacts may deviate from the shapes that it says it has

    @abstractmethod
    def is_of(self, sim: Any) -> bool:
        """Returns whether this was made of that scene."""

    @abstractmethod
    def articulations(self) -> list[Articulation]:
        """All articulations, robots or not, in their current state."""

    @abstractmethod
    def bodies(self) -> list[Body]:
        """All bodies with collision shapes that belong to no articulation, in their current state."""

    @abstractmethod
    def joint_positions(self, articulation: str) -> dict[str, float]:
        """Positions of all joints but the fixed ones, by name [rad or m]."""

    @abstractmethod
    def link_poses(self, articulation: str) -> dict[str, Pose]:
        """World poses of the links of an articulation, by name."""

    def name_of(self, handle: Any) -> str:
        """The name of an articulation, of which the simulator's users may hold something else (an id, an object)."""
        if isinstance(handle, str):
            return handle
        raise NotSupported(f"bodies and articulations of {self.kind} are named by strings, not by {handle!r}")

    @abstractmethod
    def may_collide(self, a: Hashable, b: Hashable) -> bool:
        """Returns whether contact of the two geometries counts, that is, is not filtered."""

    def filters(self) -> Hashable:
        """The filters of contacts as they are now, in any form; equal while they stay. None: changes are not seen."""
        return None

    def may_differ(self, a: Hashable, b: Hashable, seen_by: str) -> str:
        """Why `seen_by`, "planner" or this kind, may be alone to report that the two touch; "" = not known."""
        return ""

    def self_collision(self, articulation: str) -> bool:
        """Returns whether contact among links of this articulation counts at all."""
        return True

    @abstractmethod
    def probe(self) -> AbstractContextManager[Probe]:
        """A context for what-if queries: on leaving it, the scene is as it was."""

    # --- motion
    @property
    @abstractmethod
    def time_step(self) -> float:
        """Duration of one step [s]."""

    @abstractmethod
    def hold(self, articulation: str) -> None:
        """Begins to control all joints at their current positions; those that no command names stay there."""

    @abstractmethod
    def command(self, articulation: str, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        """Targets at the end of the next step, for the simulator's own controllers."""

    @abstractmethod
    def step(self) -> None:
        """Advances the simulation by one time step."""

    @abstractmethod
    def touching(self) -> list[Touch]:
        """Contacts of the last step."""


def geometries_of(bodies: tuple[Body, ...] | list[Body]) -> Iterator[tuple[Body, Geometry]]:
    """The geometries of all bodies, each with its body."""
    for body in bodies:
        for geometry in body.geometries:
            yield body, geometry
