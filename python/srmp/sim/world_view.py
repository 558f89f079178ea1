"""The part of a simulated world that its contacts and the execution of trajectories need.

SimulatedWorld executes trajectories, and executing one needs the world: this protocol, below both, breaks the circle.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Protocol

from srmp import PlannerInterface
from srmp.sim.robots import Robot
from srmp.sim.simulator import Simulator


class WorldView(Protocol):
    """A planner and the simulator whose scene it has read; SimulatedWorld is the only implementation."""

    planner: PlannerInterface
    simulator: Simulator
    robots: dict[str, Robot]

    def refresh(self, sim: Any = None) -> None:
        """Brings the planner's world up to date: SimulatedWorld.refresh."""

    def names_of_keys(self) -> dict[Hashable, list[str]]:
        """Returns the planner's names of each of the simulator's geometries: SimulatedWorld.names_of_keys."""

    def is_of_robot(self, name: str) -> bool:
        """Returns whether this is a link of a robot, or an object that a robot holds: SimulatedWorld.is_of_robot."""
