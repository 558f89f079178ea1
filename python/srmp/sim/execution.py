"""Trajectories, played by a simulator's own controllers."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from srmp import Error, InvalidArgument, MultiTrajectory, Trajectory
from srmp.sim.contacts import ContactNames, Pair
from srmp.sim.robots import Robot, require_known
from srmp.sim.simulator import diverged
from srmp.sim.world_view import WorldView

START_TOLERANCE = 0.05  # [rad or m]: a robot that is farther from where its trajectory starts would jump


@dataclass(frozen=True)
class TouchEvent:
    """Two bodies that touched while a trajectory was executed."""

    body_a: str  # an object of the planner, or a link as "robot/link"
    body_b: str
    time: float  # [s] when first
    depth: float  # [m] the deepest
    allowed: bool  # the planner was told to ignore it, or it was so at the start

    def __str__(self) -> str:
        return f"{self.body_a} and {self.body_b} touch at {self.time:.3f} s, up to {1000 * self.depth:.3g} mm deep"


@dataclass(frozen=True)
class Execution:
    """Measurements at the end of every step. By robot: (n, dof), in the order of the trajectory's joints."""

    times: NDArray[np.float64]  # (n,) [s] since the start
    positions: dict[str, NDArray[np.float64]]  # [rad or m]
    targets: dict[str, NDArray[np.float64]]
    contacts: list[TouchEvent]  # of robots and what they hold, with anything

    @property
    def largest_error(self) -> float:
        """The largest tracking error of any joint at any step [rad or m]."""
        return max(float(np.abs(self.positions[name] - target).max()) for name, target in self.targets.items())

    @property
    def final_error(self) -> float:
        """The largest tracking error of any joint at the end [rad or m]."""
        return max(float(np.abs(self.positions[name][-1] - target[-1]).max()) for name, target in self.targets.items())

    @property
    def unexpected_contacts(self) -> list[TouchEvent]:
        """The contacts that are not allowed."""
        return [contact for contact in self.contacts if not contact.allowed]


def by_robot(
    world: WorldView, trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory], robot: str | None
) -> dict[str, Trajectory]:
    """The trajectories by robot; the robot of a single one is found by its joints."""
    if not isinstance(trajectory, Trajectory | MultiTrajectory | Mapping):
        raise InvalidArgument(
            f"a {type(trajectory).__name__} cannot be executed; give a Trajectory, a MultiTrajectory, or a dict of "
            "trajectories by robot"
        )
    if not isinstance(trajectory, Trajectory):
        if robot is not None:
            raise InvalidArgument(
                f"robot='{robot}' is for a single trajectory; these are of {', '.join(trajectory.keys())}"
            )
        trajectories = dict(trajectory.items())
        if not trajectories:
            raise InvalidArgument("there is no trajectory to execute")
    else:
        trajectories = {_only_owner(world, trajectory) if robot is None else robot: trajectory}
    for name, each in trajectories.items():
        known = require_known("robot", name, world.robots)
        if not isinstance(each, Trajectory):
            raise InvalidArgument(f"the trajectory of robot '{name}' is a {type(each).__name__}, not a Trajectory")
        for joint in each.joint_names:
            require_known(f"joint of robot '{name}'", joint, known.joints)
    return trajectories


def _only_owner(world: WorldView, trajectory: Trajectory) -> str:
    owners = [name for name, robot in world.robots.items() if set(trajectory.joint_names) <= set(robot.joints)]
    if len(owners) != 1:
        raise InvalidArgument(
            f"{'several robots have' if owners else 'no robot has'} the joints {', '.join(trajectory.joint_names)}; "
            f"say which one is meant: robot=… (there are {', '.join(world.robots) or 'none'})"
        )
    return owners[0]


def play(
    world: WorldView,
    trajectories: Mapping[str, Trajectory],
    real_time: bool,
    settle_time: float,
    on_step: Callable[[float], bool | None] | None,
) -> Execution:
    """The loop behind SimulatedWorld.execute."""
    world.refresh()  # what it refuses is refused before anything moves
    simulator = world.simulator
    step = simulator.time_step
    duration = max(trajectory.duration for trajectory in trajectories.values()) + settle_time
    times = step * np.arange(1, max(1, math.ceil(duration / step - 1e-9)) + 1)
    players = [_Player(world, world.robots[name], trajectory, times) for name, trajectory in trajectories.items()]
    for player in players:
        player.require_start()
    contacts = _Contacts(world)
    for player in players:
        simulator.hold(player.robot.articulation)
    start = time.perf_counter()
    done = 0
    try:
        for k, now in enumerate(times):
            for player in players:
                player.command(k)
            simulator.step()
            for player in players:
                player.measure(k)
            contacts.note(float(now))
            done = k + 1
            if real_time:
                time.sleep(max(0.0, start + now - time.perf_counter()))
            if on_step is not None and on_step(float(now)) is False:
                break
    except BaseException:  # on_step's too: the planner knows where the robots stopped
        with contextlib.suppress(Error):
            world.refresh()
        raise
    world.refresh()
    return Execution(
        times=times[:done],
        positions={player.robot.name: player.measured[:done] for player in players},
        targets={player.robot.name: player.positions[:done] for player in players},
        contacts=contacts.events(),
    )


class _Player:
    """One robot's trajectory, sampled at the simulator's steps."""

    def __init__(self, world: WorldView, robot: Robot, trajectory: Trajectory, times: NDArray[np.float64]) -> None:
        self.world = world
        self.robot = robot
        self.trajectory = trajectory
        self.names = [robot.joints[joint] for joint in trajectory.joint_names]
        self.positions, self.velocities, self.accelerations, _ = trajectory.state(times)
        after = times >= trajectory.duration  # at rest, though the trajectory's last moment may brake
        self.velocities[after] = self.accelerations[after] = 0.0
        self.measured = np.zeros_like(self.positions)

    def require_start(self) -> None:
        now = self.world.simulator.joint_positions(self.robot.articulation)
        first = self.trajectory.sample(0.0)
        for ours, theirs, target in zip(self.trajectory.joint_names, self.names, first, strict=True):
            if abs(now[theirs] - target) > START_TOLERANCE:
                raise InvalidArgument(
                    f"joint '{ours}' of robot '{self.robot.name}' is at {now[theirs]:.4g}, and the trajectory starts "
                    f"at {target:.4g}; plan from where the robot is (get_qpos after refresh)"
                )

    def command(self, k: int) -> None:
        rows = (self.positions[k], self.velocities[k], self.accelerations[k])
        position, velocity, acceleration = (dict(zip(self.names, row.tolist(), strict=True)) for row in rows)
        self.world.simulator.command(self.robot.articulation, position, velocity, acceleration)

    def measure(self, k: int) -> None:
        now = self.world.simulator.joint_positions(self.robot.articulation)
        self.measured[k] = [now[name] for name in self.names]
        if not np.isfinite(self.measured[k]).all():
            raise diverged(f"robot '{self.robot.name}' has joints that are not finite numbers")


class _Contacts:
    """Records contacts, by the planner's names."""

    def __init__(self, world: WorldView) -> None:
        self.simulator = world.simulator
        self.names = ContactNames(world)
        self.first: dict[Pair, tuple[float, float]] = {}
        with self.simulator.probe() as probe:
            self.at_start = set(self.names.of_robots(probe.touching()))

    def note(self, now: float) -> None:
        for pair, depth in self.names.of_robots(self.simulator.touching()).items():
            since, deepest = self.first.get(pair, (now, 0.0))
            self.first[pair] = (since, max(deepest, depth))

    def events(self) -> list[TouchEvent]:
        return [
            TouchEvent(a, b, since, depth, (a, b) in self.at_start or self.names.told_to_ignore((a, b)))
            for (a, b), (since, depth) in sorted(self.first.items(), key=lambda item: item[1][0])
        ]
