"""Records: each is a function of the spec and its index, whoever makes it and in whatever order."""

from __future__ import annotations

import importlib
import resource
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._verify import summary
from srmp.datasets.kinds import KINDS
from srmp.datasets.samplers import End, EndSampler
from srmp.datasets.scene import Scene
from srmp.datasets.schema import STATISTICS, certificate_row, to_bytes
from srmp.datasets.spec import SceneSpec, Spec

NO_PROBLEM = "no_problem"
NOT_CERTIFIED = "not_certified"
SKIPPED = "skipped"


def random_numbers(identity: str, index: int) -> np.random.Generator:
    """The random numbers of a record: Philox, keyed by the spec, counted from the index (Salmon et al. 2011)."""
    return np.random.Generator(np.random.Philox(key=int(identity[:32], 16), counter=[0, 0, index, 0]))


class TimeLimitReached(Exception):
    """The plan of a record reached the time limit, so that the clock had a say in how it ended."""


@dataclass(frozen=True)
class MadeShard:
    """A shard as a worker hands it over."""

    number: int
    data: bytes
    """Empty where a record reached the time limit."""
    count: int
    solved: int
    seconds: float
    """Time of the process for it; not part of the data."""
    memory: int
    """The most memory that the process had so far [byte]."""
    timed_out: tuple[int, ...] = ()
    """Records that reached the time limit."""


class Recorder:
    """Makes records with one world of robots, whose objects change from record to record."""

    def __init__(self, spec: Spec, directory: Path) -> None:
        """directory: holds the files of the spec."""
        self._spec, self._identity, self._skip = spec, spec.identity, frozenset(spec.skip)
        functions = str(directory / "functions")
        if functions not in sys.path and (directory / "functions").is_dir():
            sys.path.insert(0, functions)
            importlib.invalidate_caches()
        self._world = srmp.PlannerInterface()
        for robot in spec.robots:
            robot.add_to(self._world, directory)
        self._names = [robot.name for robot in spec.robots]
        self._world.prepare()
        for name in [robot.name for robot in spec.robots]:
            # The last bits of Coal's distances depend on the first query of a process, so it is always this one.
            self._world.is_state_colliding(name, self._world.get_qpos(name))
        self._world.make_planner(self._names, spec.options)
        self._period = float(srmp.planner_options(dict(spec.planner))["sample_period"])
        self._ends = EndSampler(self._world, spec.robots, spec.clearance)
        weights = np.array([scene.weight for scene in spec.scenes])
        self._chances = np.cumsum(weights) / np.sum(weights)

    def shard(self, number: int) -> MadeShard:
        """The shard of this number."""
        began = time.monotonic()
        records, timed_out = [], []
        for index in self._spec.numbers(number):
            try:
                records.append(self.record(index))
            except TimeLimitReached:
                timed_out.append(index)
        data = b"" if timed_out else to_bytes(records, self._identity, number)
        solved = sum(record["status"] == "solved" for record in records)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        return MadeShard(number, data, len(records), solved, time.monotonic() - began, memory, tuple(timed_out))

    def record(self, index: int) -> dict[str, Any]:
        """The record of this index, laid out as schema.SCHEMA. Raises TimeLimitReached."""
        random = random_numbers(self._identity, index)
        spec = self._spec.scenes[int(np.searchsorted(self._chances, random.random(), side="right"))]
        scene, reason = Scene(), ""
        if index in self._skip:
            return self._record(index, spec, scene, SKIPPED, "the spec skips this record", 0, [], {})
        for attempt in range(1, self._spec.tries + 1):
            scene, ends = self._problem(spec, random)
            if not isinstance(ends, str):
                return self._planned(index, spec, scene, *ends, attempt)
            reason = ends
        reason = f"{reason}, in {self._spec.tries} scenes"
        return self._record(index, spec, scene, NO_PROBLEM, reason, self._spec.tries, [], {})

    def _problem(
        self, spec: SceneSpec, random: np.random.Generator
    ) -> tuple[Scene, tuple[dict[str, End], dict[str, End]] | str]:
        """A scene, which is the world's from now on, with starts and goals, or why there are none."""
        scene = KINDS[spec.kind].make(random, **spec.parameters)
        for name in self._world.object_names:
            self._world.remove_object(name)
        for item in scene.objects:
            item.add_to(self._world)
        starts = self._ends.draw(spec.start, scene, random)
        if isinstance(starts, str):
            return scene, f"start: {starts}"
        goals = self._ends.draw(spec.goal, scene, random)
        if isinstance(goals, str):
            return scene, f"goal: {goals}"
        for name, end in starts.items():
            self._world.set_qpos(name, end.configuration)
        return scene, (starts, goals)

    def _planned(
        self, index: int, spec: SceneSpec, scene: Scene, starts: dict[str, End], goals: dict[str, End], attempt: int
    ) -> dict[str, Any]:
        constraints = {name: _goal(end, spec.goal.pose) for name, end in goals.items()}
        configurations = {name: end.configuration for name, end in starts.items()}
        motions: dict[str, srmp.Trajectory] = {}
        proofs: dict[str, srmp.Certificate] = {}
        status, reason = "solved", ""
        try:
            motions = self._plan(configurations, constraints)
        except srmp.PlanningError as error:
            if error.status == srmp.Status.cancelled:
                raise
            status, reason = error.status.name, str(error)
        counts = self._world.get_planning_stats()
        if counts["total_time_s"] >= self._spec.time_limit:
            raise TimeLimitReached
        if motions:
            proofs = self._world.verify_multi(motions, starts=configurations, goals=constraints)
        for name, proof in proofs.items():
            if not (proof.holds and proof.proved_free):
                status, reason = NOT_CERTIFIED, f"the trajectory of '{name}' has no proof: {summary(proof)}"
        if status != "solved":
            motions = {}
        rows = [
            _robot_row(name, starts[name], goals[name], constraints[name], motions.get(name), proofs.get(name))
            for name in self._names
        ]
        return self._record(index, spec, scene, status, reason, attempt, rows, {key: counts[key] for key in STATISTICS})

    def _plan(self, starts: dict[str, np.ndarray], goals: dict[str, srmp.GoalConstraint]) -> dict[str, srmp.Trajectory]:
        """Motions on one clock, all rows one period apart, within the limits that are the robots' own."""
        if len(self._names) == 1:
            name = self._names[0]
            planned = self._world.plan(name, starts[name], goals[name])
            return {name: planned.resample(self._period, self._world.motion_limits(name))}
        together = self._world.plan_multi(starts, goals)
        return even_rows(self._world, together, self._period)

    def _record(
        self,
        index: int,
        spec: SceneSpec,
        scene: Scene,
        status: str,
        reason: str,
        attempts: int,
        robots: list[dict[str, Any]],
        statistics: dict[str, Any],
    ) -> dict[str, Any]:
        return {
            "index": index,
            "seed": self._identity[:32],
            "scene": spec.name,
            "kind": spec.kind,
            "status": status,
            "reason": reason,
            "attempts": attempts,
            "objects": [item.to_dict() for item in scene.objects],
            "robots": robots,
            "statistics": statistics or None,
        }


def even_rows(
    planner: srmp.PlannerInterface, together: srmp.MultiTrajectory, period: float
) -> dict[str, srmp.Trajectory]:
    """The robots' motions with rows a period [s] apart: as much slower, all of them, as their limits demand."""
    joined = together.merged()
    limits = [planner.motion_limits(name) for name in together]
    all_limits = srmp.MotionLimits(
        *(np.concatenate([getattr(own, key) for own in limits]) for key in ("velocity", "acceleration", "jerk")),
        [flag for own in limits for flag in (own.continuous or [False] * len(own.velocity))],
    )
    even = joined.resample(period, all_limits)
    motions, first = {}, 0
    for name in together:
        names = together[name].joint_names
        own = slice(first, first + len(names))
        motions[name] = srmp.Trajectory(
            names, even.positions[:, own], even.times, even.velocities[:, own], waypoints=even.waypoints[:, own]
        )
        first += len(names)
    return motions


def _goal(end: End, as_pose: bool) -> srmp.GoalConstraint:
    if as_pose and end.pose is not None:
        return srmp.GoalConstraint(srmp.GoalType.POSE, end.pose)
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, end.configuration)


def _robot_row(
    name: str,
    start: End,
    goal: End,
    constraint: srmp.GoalConstraint,
    trajectory: srmp.Trajectory | None,
    certificate: srmp.Certificate | None,
) -> dict[str, Any]:
    row: dict[str, Any] = {
        "name": name,
        "start": start.configuration,
        "goal_type": constraint.type.name,
        "goal": constraint.targets[0],
        "goal_pose": list(goal.pose) if goal.pose else None,
        "times": None,
        "positions": None,
        "velocities": None,
        "waypoints": None,
        "certificate": None,
    }
    if trajectory is not None:
        for key in ("times", "positions", "velocities", "waypoints"):
            row[key] = np.ravel(getattr(trajectory, key))
        row["certificate"] = certificate_row(certificate)
    return row
