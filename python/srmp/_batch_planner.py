"""BatchPlanner: one request in each of many scenes, all at once, arrays in and arrays out."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import srmp
from srmp._errors import checked


@dataclass(frozen=True)
class Batch:
    """What BatchPlanner.plan returns: n results as arrays of the longest one's size.

    Rows beyond a trajectory repeat its last row, at rest, and have a mask of False; a request without a trajectory has
    its start in all rows, and no row in its mask.
    """

    solved: np.ndarray
    """(n,) bool."""
    positions: np.ndarray
    """(n, rows, dof) [rad or m]."""
    velocities: np.ndarray
    """(n, rows, dof) [rad/s or m/s]."""
    times: np.ndarray
    """(n, rows) [s]."""
    mask: np.ndarray
    """(n, rows) bool: is this row one of the trajectory?"""
    waypoints: np.ndarray
    """(n, waypoints, dof) [rad or m], padded by the last one."""
    waypoint_mask: np.ndarray
    """(n, waypoints) bool."""
    status: list[str]
    """solved, timed_out, exhausted, start_invalid, goal_invalid or cancelled."""
    reasons: list[str]
    """Why there is no trajectory; "" where there is one."""
    trajectories: list[srmp.Trajectory | None]
    """The trajectories themselves, with their certificates."""


class BatchPlanner:
    """Plans in many scenes at once, such as the environments of a simulator that steps many together.

    Each scene is a PlannerInterface of its own, so that all cores plan (the GIL is released); each result is what that
    PlannerInterface alone would return, bit for bit, for any number of threads.
    """

    @checked
    def __init__(
        self,
        scenes: Iterable[srmp.PlannerInterface],
        robot: str | None = None,
        *,
        options: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> None:
        """A planner for scenes that have the same robot.

        scenes: PlannerInterfaces, each its own. robot: the one that is planned for, default the only one. options: of
        the planner, as in make_planner. threads: default one for each core.

        Raises InvalidArgument for no scenes, the same scene twice, robots that differ in their joints, options that are
        wrong, and threads below 1.
        """
        self._scenes = _each("scenes", scenes)
        if not self._scenes:
            raise srmp.InvalidArgument("a BatchPlanner needs at least one scene.")
        for k, scene in enumerate(self._scenes):
            if not isinstance(scene, srmp.PlannerInterface):
                raise srmp.InvalidArgument(f"scenes[{k}] is {scene!r}; it must be a PlannerInterface.")
        if len({id(scene) for scene in self._scenes}) < len(self._scenes):
            raise srmp.InvalidArgument("a scene is there twice; each must be a PlannerInterface of its own.")
        if threads is not None and threads < 1:
            raise srmp.InvalidArgument(f"threads {threads!r}: there must be at least 1.")
        self._robots = [robot or scene.only_robot for scene in self._scenes]
        names = [scene.get_joint_names(name) for scene, name in zip(self._scenes, self._robots, strict=True)]
        for k, own in enumerate(names):
            if own != names[0]:
                raise srmp.InvalidArgument(
                    f"the robot of scenes[{k}] has the joints {', '.join(own)}; "
                    f"that of scenes[0] has {', '.join(names[0])}."
                )
        self._joint_names = names[0]
        srmp.planner_options({"planner_id": "auto", **(options or {})})
        if options is not None:
            for scene, name in zip(self._scenes, self._robots, strict=True):
                scene.make_planner(name, {"planner_id": "auto", **options})
        self._threads = min(threads or os.cpu_count() or 1, len(self._scenes))

    def __len__(self) -> int:
        """The number of scenes."""
        return len(self._scenes)

    @property
    def scenes(self) -> list[srmp.PlannerInterface]:
        """The scenes: to add objects, attach them, call read_sim of an environment, and so on, between plans."""
        return list(self._scenes)

    @property
    def joint_names(self) -> list[str]:
        """The joints of configurations, in their order."""
        return list(self._joint_names)

    @checked
    def update(self, scene: int, poses: Mapping[str, srmp.Pose | ArrayLike]) -> None:
        """Moves objects of a scene; nothing is built anew.

        poses: by object, a Pose or x, y, z [m] and a quaternion x, y, z, w. Raises InvalidArgument for an unknown scene
        or object, or a pose that is none; then nothing was moved.
        """
        if not 0 <= scene < len(self):
            raise srmp.InvalidArgument(f"scene {scene!r}: there are scenes 0 to {len(self) - 1}.")
        world = self._scenes[scene]
        targets = {name: _as_pose(name, pose) for name, pose in poses.items()}
        before = {name: world.get_object_pose(name) for name in targets}
        try:
            for name, pose in targets.items():
                world.set_object_pose(name, pose)
        except srmp.Error:
            for name, pose in before.items():
                with contextlib.suppress(srmp.Error):
                    world.set_object_pose(name, pose)
            raise

    @checked
    def plan(
        self, starts: ArrayLike, goals: ArrayLike | Sequence[Any] | None = None, *, poses: ArrayLike | None = None
    ) -> Batch:
        """Plans one request in each scene.

        starts: (n, dof) [rad or m]. goals: (n, dof) configurations, or a list of n goals in any form that
        PlannerInterface.plan takes. poses: instead of goals, (n, 7) poses of the end effector in the world: x, y, z
        [m], quaternion x, y, z, w. A request without a trajectory does not disturb the others. Ctrl-C stops all plans
        and is raised.

        Raises InvalidArgument for wrong shapes, NaN and goals that are wrong, before anything is planned where it can.
        """
        begin = _numbers("starts", starts)
        if begin.shape != (len(self), len(self._joint_names)):
            raise srmp.InvalidArgument(
                f"starts have the shape {begin.shape}; it must be ({len(self)}, {len(self._joint_names)})."
            )
        if not np.all(np.isfinite(begin)):
            raise srmp.InvalidArgument("starts have a number that is not finite.")
        if (goals is None) == (poses is None):
            raise srmp.InvalidArgument("give either goals or poses.")
        constraints = self._goals(_each("goals", goals) if poses is None else _poses(poses), begin)
        return _batch(begin, self._plan_all(begin, constraints))

    def _plan_all(
        self, starts: np.ndarray, goals: Sequence[srmp.GoalConstraint]
    ) -> list[srmp.Trajectory | srmp.PlanningError]:
        """By threads, which have all ended when it returns or raises."""
        pool = ThreadPoolExecutor(self._threads)
        try:
            return list(pool.map(self._plan_one, range(len(self)), starts, goals))
        except BaseException:  # Ctrl-C reaches this thread alone
            for scene in self._scenes:
                scene._stop_plans(True)
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
            for scene in self._scenes:
                scene._stop_plans(False)

    def _goals(self, given: Sequence[Any], starts: np.ndarray) -> list[srmp.GoalConstraint]:
        if len(given) != len(self):
            raise srmp.InvalidArgument(f"there are {len(given)} goals for {len(self)} scenes.")
        found = []
        for k, (scene, robot, goal) in enumerate(zip(self._scenes, self._robots, given, strict=True)):
            try:
                found.append(scene.goal(robot, goal, starts[k]))
            except srmp.InvalidArgument as error:
                raise srmp.InvalidArgument(f"goals[{k}]: {error}") from error
        return found

    def _plan_one(
        self, scene: int, start: np.ndarray, goal: srmp.GoalConstraint
    ) -> srmp.Trajectory | srmp.PlanningError:
        try:
            return self._scenes[scene].plan(self._robots[scene], start, goal)
        except srmp.PlanningError as error:
            return error
        except srmp.InvalidArgument as error:
            raise srmp.InvalidArgument(f"scene {scene}: {error}") from error


def _numbers(name: str, values: ArrayLike) -> np.ndarray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise srmp.InvalidArgument(f"{name} are not numbers in rows of the same length: {error}.") from error


def _each(name: str, values: Any) -> list[Any]:
    try:
        return list(values)
    except TypeError as error:
        raise srmp.InvalidArgument(f"{name} is {values!r}; it must have one for each scene.") from error


def _poses(poses: Any) -> list[srmp.Pose]:
    return [_as_pose(f"poses[{k}]", pose) for k, pose in enumerate(_each("poses", poses))]


def _as_pose(name: str, pose: srmp.Pose | ArrayLike) -> srmp.Pose:
    if isinstance(pose, srmp.Pose):
        return pose
    numbers = _numbers(f"the numbers of the pose of '{name}'", pose)
    if numbers.shape != (7,):
        raise srmp.InvalidArgument(f"the pose of '{name}' has the shape {numbers.shape}; it must be (7,).")
    return srmp.Pose(numbers[:3], numbers[3:])


def _batch(starts: np.ndarray, results: Sequence[srmp.Trajectory | srmp.PlanningError]) -> Batch:
    trajectories = [result if isinstance(result, srmp.Trajectory) else None for result in results]
    rows = [len(found) if found else 0 for found in trajectories]
    corners = [len(found.waypoints) if found else 0 for found in trajectories]
    n, dof = starts.shape
    positions = np.repeat(starts[:, None], max(rows), axis=1)
    waypoints = np.repeat(starts[:, None], max(corners), axis=1)
    velocities, times = np.zeros((n, max(rows), dof)), np.zeros((n, max(rows)))
    for k, found in enumerate(trajectories):
        if found:
            for table, values in ((positions, found.positions), (waypoints, found.waypoints), (times, found.times)):
                table[k, : len(values)], table[k, len(values) :] = values, values[-1] if len(values) else 0.0
            velocities[k, : len(found.velocities)] = found.velocities
    errors = [result if isinstance(result, srmp.PlanningError) else None for result in results]
    return Batch(
        solved=np.array(rows) > 0,
        positions=positions,
        velocities=velocities,
        times=times,
        mask=np.arange(max(rows)) < np.array(rows)[:, None],
        waypoints=waypoints,
        waypoint_mask=np.arange(max(corners)) < np.array(corners)[:, None],
        status=[error.status.name if error else "solved" for error in errors],
        reasons=[str(error) if error else "" for error in errors],
        trajectories=trajectories,
    )
