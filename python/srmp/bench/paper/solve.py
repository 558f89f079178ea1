"""Solves one problem of an experiment with one planner, and checks the path that it returned."""

from __future__ import annotations

import functools
import time
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp.bench import mbm, ompl_wheel
from srmp.bench.paper.contestants import COAL, SRMP, Contestant, by_wheel, ompl_module
from srmp.bench.scenarios import GeneratedScenario
from srmp.bench.scenes import Configurations


@dataclass(frozen=True)
class Task:
    """One row: a problem, and the planner that solves it."""

    experiment: str
    scenario: str
    """Of generated scenarios, or the robot of MotionBenchMaker's problems."""
    contestant: Contestant
    time_limit: float
    number: int = 0
    """Of a problem of a generated scenario: base problem (number - 1) // repetitions."""
    robots: int = 1
    repetitions: int = 1
    problem: mbm.Problem | None = None
    """Of MotionBenchMaker."""

    @property
    def instance(self) -> str:
        """The name of the problem, which several planners solve."""
        return f"{self.experiment}/{self.scenario}/{self.problem.name if self.problem else f'{self.number:04d}'}"

    @property
    def name(self) -> str:
        """The name of the row."""
        return f"{self.instance}/{self.contestant.key}"


@dataclass(frozen=True)
class Query:
    """A scene, and where its robots begin and end."""

    planner: srmp.PlannerInterface
    starts: Configurations
    goals: Configurations

    @property
    def names(self) -> list[str]:
        """Of the robots, sorted."""
        return sorted(self.starts)

    def joined(self, configurations: Configurations) -> list[float]:
        """The configurations of all robots one after the other."""
        return np.concatenate([configurations[name] for name in self.names]).tolist()

    def parted(self, waypoints: np.ndarray) -> dict[str, np.ndarray]:
        """Waypoints of all robots one after the other as those of each; continuous joints without jumps."""
        ends = np.cumsum([len(self.starts[name]) for name in self.names])[:-1]
        return {
            name: _without_jumps(self.planner, name, part)
            for name, part in zip(self.names, np.split(waypoints, ends, axis=1), strict=True)
        }


@dataclass(frozen=True)
class Found:
    """What a planner returned."""

    status: str
    reason: str
    plan_time_s: float
    """Until the path is ready: found, shortcut or simplified."""
    paths: Mapping[str, np.ndarray] | None = None
    """Waypoints of each robot."""
    trajectory: Any = None
    """Of our planners for several robots: their waypoints have no common times."""
    found_by: str | None = None
    bound: float | None = None


class Solver:
    """Makes rows; the last scene and robot stay between them."""

    def __init__(self, data: str | None, seed: int) -> None:
        self._data, self._seed = data, seed
        self._world = functools.lru_cache(maxsize=1)(self._make_world)
        self._runner = functools.lru_cache(maxsize=1)(self._make_runner)

    def run(self, task: Task) -> dict[str, Any]:
        """The row of the task."""
        begin = time.perf_counter()
        query, about = self._query(task)
        own = task.contestant.library == SRMP
        found = _solve(query, task) if own else _solve_by_ompl(query, task, self._seed)
        row = {
            "problem": task.name,
            "experiment": task.experiment,
            "scenario": task.scenario,
            "instance": task.instance,
            "library": task.contestant.library,
            "planner": task.contestant.name,
            **about,
            "status": found.status,
            "reason": found.reason,
            "plan_time_s": found.plan_time_s,
            "found_by": found.found_by,
            "bound": found.bound,
            **dict.fromkeys(("fault", "path_cost_rad", "ee_cost_m")),
        }
        if found.paths is not None:
            row["fault"] = fault_of(query, found)
            row["path_cost_rad"] = sum(
                float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in found.paths.values()
            )
            row["ee_cost_m"] = sum(
                mbm.end_effector_length(query.planner, name, path) for name, path in found.paths.items()
            )
        row["row_time_s"] = time.perf_counter() - begin
        return row

    def _query(self, task: Task) -> tuple[Query, Mapping[str, Any]]:
        if task.problem is None:
            scenario, planner = self._world(task.scenario, task.robots, task.repetitions)
            problem = scenario.problem(task.number)
            return Query(planner, problem.starts, problem.goals), problem.about
        planner, problem = self._runner(task.scenario).set_up(task.problem)
        if len(problem.goals) != 1 or problem.goals[0].type != srmp.GoalType.JOINTS:
            raise srmp.NotSupported(f"{task.instance}: its goal is not one configuration, as OMPL's planners need it.")
        goal = problem.goals[0].targets[0]
        about = {"mbm_scenario": task.problem.scenario}
        return Query(planner, {task.scenario: problem.start}, {task.scenario: goal}), about

    def _make_world(
        self, scenario: str, robots: int, repetitions: int
    ) -> tuple[GeneratedScenario, srmp.PlannerInterface]:
        found = GeneratedScenario(scenario, robots, self._seed, self._data, repetitions)
        planner = found.world.build()
        planner.prepare()
        return found, planner

    def _make_runner(self, robot: str) -> mbm.Runner:
        assert self._data is not None
        return mbm.Runner(mbm.robot_files(self._data, robot, "urdf"), "auto", {}, 1.0)


def make_solver(data: str | Path | None, seed: int) -> Solver:
    """A Solver, as workers need it."""
    return Solver(None if data is None else str(data), seed)


# --- planners ---------------------------------------------------------------------------------------------------------


def _solve(query: Query, task: Task) -> Found:
    planner, names = query.planner, query.names
    planner.make_planner(names, {"planner_id": task.contestant.id, "time_limit": task.time_limit})
    goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, q) for name, q in query.goals.items()}
    trajectory, status, reason = None, "solved", ""
    try:
        if len(names) == 1:
            trajectory = planner.plan(names[0], query.starts[names[0]], goals[names[0]])
        else:
            trajectory = planner.plan_multi(query.starts, goals)
    except srmp.PlanningError as error:
        status, reason = mbm.status_name(error.status), str(error)
    stats = planner.get_planning_stats()
    if trajectory is None:
        return Found(status, reason, stats["plan_time_s"])
    paths = {name: (trajectory if len(names) == 1 else trajectory[name]).waypoints for name in names}
    together = trajectory if len(names) > 1 else None
    return Found(status, reason, stats["plan_time_s"], paths, together, stats["found_by"], stats["bound"])


def _solve_by_wheel(query: Query, task: Task) -> Found:
    name = query.names[0]
    ends = query.starts[name], query.goals[name]
    result = ompl_wheel.plan(query.planner, name, *ends, task.contestant.id, task.time_limit)
    paths = query.parted(result["waypoints"]) if result["status"] == "solved" else None
    return Found(result["status"], "", result["plan_time_s"], paths)


def _solve_by_ompl(query: Query, task: Task, seed: int) -> Found:
    if by_wheel(task.contestant):
        return _solve_by_wheel(query, task)
    module = ompl_module()
    assert module is not None
    result = module.plan(
        query.planner,
        query.names,
        query.joined(query.starts),
        query.joined(query.goals),
        task.contestant.id,
        task.time_limit,
        1 + zlib.crc32(f"{seed}/{task.instance}".encode()) % 2**31,
        "coal" if task.contestant.library == COAL else "srmp",
    )
    paths = query.parted(np.array(result["waypoints"])) if result["status"] == "solved" else None
    return Found(result["status"], "", result["plan_time_s"], paths)


def _without_jumps(planner: srmp.PlannerInterface, robot: str, path: np.ndarray) -> np.ndarray:
    path = path.copy()
    continuous = np.isinf(planner.get_joint_limits(robot)).all(axis=1)
    path[:, continuous] = np.unwrap(path[:, continuous], axis=0)
    return path


# --- checks -----------------------------------------------------------------------------------------------------------

_TOLERANCE = 1e-6  # [rad or m], of starts, goals and limits


def fault_of(query: Query, found: Found) -> str | None:
    """What is wrong with a path, by code that plans nothing; None where nothing is.

    Start, goal and limits are compared. A path is proved free between its waypoints by Coal's distances; the motions of
    several robots that our planners return are verified on their own clock, PlannerInterface.verify_multi.
    """
    assert found.paths is not None
    for name, path in found.paths.items():
        ends = mbm.difference(query.planner, name, path[[0, -1]], np.array([query.starts[name], query.goals[name]]))
        if (np.abs(ends) > _TOLERANCE).any():
            return f"{name}: the path does not lead from the start to the goal"
        limits = query.planner.get_joint_limits(name)
        if (path < limits[:, 0] - _TOLERANCE).any() or (path > limits[:, 1] + _TOLERANCE).any():
            return f"{name}: the path leaves the joint limits"
    if found.trajectory is not None:
        certificates = query.planner.verify_multi(found.trajectory, starts=query.starts)
        faults = [f"{name}: {fault.text}" for name, c in certificates.items() for fault in c.faults]
        faults += [f"{name}: not proved free" for name, c in certificates.items() if not c.proved_free]
        return faults[0] if faults else None
    return _collision(query, found.paths)


def _collision(query: Query, paths: Mapping[str, np.ndarray]) -> str | None:
    """Of robots that move straight from row to row at the same times."""
    for name, path in paths.items():
        certify = _certifier(query.planner, name, paths)
        for k in range(len(path) - 1):
            certificate = certify(path, k)
            if not certificate.proved:
                pair = f"{certificate.body_a} and {certificate.body_b}"
                touch = certificate.interval[0] == certificate.interval[1]
                return f"{name}, segment {k + 1} of {len(path) - 1}: {pair} " + (
                    "collide" if touch else "could not be proved apart"
                )
    return None


def _certifier(
    planner: srmp.PlannerInterface, name: str, paths: Mapping[str, np.ndarray]
) -> Callable[[np.ndarray, int], srmp.MotionCertificate]:
    """Certifies the segment of this number of the robot's path, among the others on theirs."""
    if len(paths) == 1:
        alone = planner.collision_checker(name, mode="coal")
        return lambda path, k: alone.certify_motion(path[k], path[k + 1])
    others = {other: (np.arange(len(path), dtype=float), path) for other, path in paths.items() if other != name}
    among = planner.timed_collision_checker(name, others, mode="coal")
    return lambda path, k: among.certify_motion(path[k], path[k + 1], float(k), float(k + 1))
