"""Scenes of MuJoCo, SAPIEN, Genesis and PyBullet: read, compared, and trajectories executed (docs/simulators.md)."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from srmp import InvalidArgument, MultiTrajectory, PlannerInterface, Trajectory
from srmp._names import did_you_mean
from srmp.sim.execution import Execution as Execution
from srmp.sim.parity import ParityReport as ParityReport
from srmp.sim.parity import check_parity as check_parity
from srmp.sim.simulator import MissingSimulator as MissingSimulator
from srmp.sim.simulator import Simulator
from srmp.sim.world import SimulatedWorld as SimulatedWorld
from srmp.sim.world import require_planner, world_of

_SIMULATORS = {"mujoco": "MuJoCo", "sapien": "Sapien", "genesis": "Genesis", "pybullet": "PyBullet"}


def read_sim(
    planner: PlannerInterface,
    sim: Any,
    kind: str,
    articulations: Mapping[str, Mapping[str, Any]] | Iterable[Any] | None = None,
    exclude: Sequence[str] = (),
) -> SimulatedWorld:
    """Reads a simulator's scene into the planner: PlannerInterface.read_sim, whose docstring says the rest."""
    require_planner(planner)
    if planner.simulated_world is not None:
        raise InvalidArgument("read_sim was called before; refresh() brings that world up to date, reset() forgets it")
    simulator = open_simulator(sim, kind)
    world = SimulatedWorld(planner, simulator, exclude)
    world.require_excluded()
    world.read(_descriptions(simulator, articulations))
    planner.simulated_world = world
    return world


def execute(
    planner: PlannerInterface,
    trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory],
    robot: str | None = None,
    *,
    real_time: bool = False,
    settle_time: float = 0.5,
    on_step: Callable[[float], bool | None] | None = None,
) -> Execution:
    """Plays the trajectory in the simulator that the planner has read; what SimulatedWorld.execute does."""
    return world_of(planner).execute(trajectory, robot, real_time=real_time, settle_time=settle_time, on_step=on_step)


def open_simulator(sim: Any, kind: str) -> Simulator:
    """The scene as SRMP sees simulators. Raises InvalidArgument for an unknown kind or another's scene."""
    name = str(kind).lower()
    if name not in _SIMULATORS:
        hint = did_you_mean(name, _SIMULATORS, before="; ") or f"; known: {', '.join(_SIMULATORS)}"
        raise InvalidArgument(f"unknown simulator '{kind}'{hint}")
    simulator: Simulator = getattr(importlib.import_module(f"srmp.sim.{name}"), _SIMULATORS[name])(sim)
    return simulator


def _descriptions(simulator: Simulator, articulations: Any) -> dict[str, Mapping[str, Any]]:
    if articulations is None:
        return {articulation.name: {} for articulation in simulator.articulations()}
    if isinstance(articulations, Mapping):
        return {name: {} if description is None else description for name, description in articulations.items()}
    if isinstance(articulations, str):
        articulations = [articulations]
    if not isinstance(articulations, Iterable):
        raise InvalidArgument(
            f"articulations is {articulations!r}; it is to be a list of names, or a dict by robot name"
        )
    names = [simulator.name_of(handle) for handle in articulations]
    return {name: {} for name in names}
