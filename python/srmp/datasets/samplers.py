"""Starts and goals of one record: drawn until they are within limits and clear of everything."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import srmp
from srmp.datasets.robot_files import RobotSpec
from srmp.datasets.scene import Region, Scene
from srmp.datasets.spec import Sampler

DRAWS = 20
"""How often an end is drawn for one robot before its scene is given up."""
IK_SEEDS = 8


@dataclass(frozen=True)
class End:
    """A start or a goal of a robot."""

    configuration: np.ndarray
    """(dof,) [rad or m]."""
    pose: srmp.Pose | None = None
    """Of the end effector's link in the world, where the end was drawn as a pose."""


class EndSampler:
    """Draws starts and goals in a world whose objects are those of the record."""

    def __init__(self, world: srmp.PlannerInterface, robots: Sequence[RobotSpec], clearance: float) -> None:
        self._world = world
        self._robots = robots
        self._clearance = clearance
        self._limits = {robot.name: world.get_joint_limits(robot.name) for robot in robots}
        self._home = {robot.name: world.get_qpos(robot.name) for robot in robots}
        self._states = {robot.name: world.get_group_states(robot.name) for robot in robots}

    def draw(self, sampler: Sampler, scene: Scene, random: np.random.Generator) -> dict[str, End] | str:
        """An end for each robot, all collision-free together; or a sentence that says for which none was found.

        Robots are placed one after the other, clear of those that are placed already.
        """
        for robot in self._robots:
            self._world.set_qpos(robot.name, self._home[robot.name])
        ends = {}
        for robot in self._robots:
            end = self._draw_one(robot, sampler, scene, random)
            if end is None:
                return f"no collision-free configuration of '{robot.name}' was found in {DRAWS} draws"
            self._world.set_qpos(robot.name, end.configuration)
            ends[robot.name] = end
        if len(ends) > 1 and not all(self._is_clear(name, end.configuration) for name, end in ends.items()):
            return "the robots were not clear of each other"
        return ends

    def _draw_one(self, robot: RobotSpec, sampler: Sampler, scene: Scene, random: np.random.Generator) -> End | None:
        for _ in range(DRAWS):
            for end in self._candidates(robot, sampler, scene, random):
                if self._is_clear(robot.name, end.configuration):
                    return end
        return None

    def _candidates(self, robot: RobotSpec, sampler: Sampler, scene: Scene, random: np.random.Generator) -> list[End]:
        if sampler.source == "configuration":
            limits = self._limits[robot.name]
            low = np.where(np.isinf(limits[:, 0]), -np.pi, limits[:, 0])
            high = np.where(np.isinf(limits[:, 1]), np.pi, limits[:, 1])
            return [End(low + (high - low) * random.random(len(low)))]
        if sampler.source == "states":
            state = sampler.states[int(random.integers(len(sampler.states)))]
            return [End(np.array(self._states[robot.name][state] if isinstance(state, str) else state))]
        region = _choose(sampler, scene, random)
        pose = _tool_pose(region, random) @ srmp.Pose(p=[0, 0, -robot.tool_length])
        found = self._world.compute_ik(robot.name, pose, self._home[robot.name], max_solutions=2, seeds=IK_SEEDS)
        return [End(np.array(q), pose) for q in found]

    def _is_clear(self, robot: str, q: np.ndarray) -> bool:
        limits = self._limits[robot]
        if np.any(q < limits[:, 0]) or np.any(q > limits[:, 1]):
            return False
        if self._world.is_state_colliding(robot, q):
            return False
        return bool(self._world.collision_checker(robot, mode="coal").clearance([q])[0] >= self._clearance)


def _choose(sampler: Sampler, scene: Scene, random: np.random.Generator) -> Region:
    fitting = [
        region
        for region in scene.regions
        if not sampler.regions or any(fnmatch.fnmatchcase(region.name, pattern) for pattern in sampler.regions)
    ]
    if not fitting:
        names = ", ".join(region.name for region in scene.regions) or "none"
        raise srmp.InvalidArgument(f"no region of the scene is one of {', '.join(sampler.regions)}; it has {names}.")
    return fitting[int(random.integers(len(fitting)))]


def _tool_pose(region: Region, random: np.random.Generator) -> srmp.Pose:
    """Of the end of the tool, its z in the direction in which it points."""
    place = region.pose @ srmp.Pose(p=(random.random(3) - 0.5) * region.size)
    if region.approach == "exact":
        return place
    spin = srmp.Pose.from_rpy([0, 0, 0], [0, 0, float(random.uniform(-np.pi, np.pi))])
    if region.approach == "down":
        return place @ srmp.Pose(q=[1, 0, 0, 0]) @ spin
    if region.approach == "forward":
        return place @ srmp.Pose.from_rpy([0, 0, 0], [0, np.pi / 2, 0]) @ spin
    return place @ srmp.Pose.from_rpy([0, 0, 0], random.uniform(-np.pi, np.pi, 3)) @ spin
