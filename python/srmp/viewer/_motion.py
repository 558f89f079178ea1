"""Motions of all robots of a scene on one clock, as poses of their links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp._names import did_you_mean
from srmp._verify import robot_of
from srmp.viewer._scene import frame_poses

if TYPE_CHECKING:
    from srmp import MultiTrajectory, PlannerInterface, Trajectory

RATE = 30.0  # [1/s] frames
_MAX_FRAMES = 3000  # of one motion: a long one is shown with fewer frames a second
_PATH_SPEED = 1.0  # [rad/s or m/s] at which a path without times is shown


@dataclass(frozen=True, eq=False)
class Motion:
    """What moves, sampled for the eye."""

    times: NDArray[np.float64]  # (n,) [s], from 0
    poses: NDArray[np.float64]  # (n, frames, 7), in the order of Scene.frames
    configurations: dict[str, NDArray[np.float64]]  # (n, dof), by robot that moves
    trajectories: dict[str, Trajectory]  # by robot; timed

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])


def trajectories_of(
    planner: PlannerInterface, trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory] | None
) -> dict[str, Trajectory]:
    """The trajectories by robot name, joints in the robots' order; None: those of the planner's last result, if any.

    Raises InvalidArgument for an unknown robot, and joints that are not those of the robot.
    """
    if trajectory is None:
        result = planner.last_result
        if result is None or not result.solved:
            return {}
        trajectory = result.trajectory
    if isinstance(trajectory, srmp.Trajectory):
        trajectory = {robot_of(planner, trajectory): trajectory}
    if not isinstance(trajectory, Mapping):
        raise srmp.InvalidArgument(
            f"trajectory must be a Trajectory, a MultiTrajectory or Trajectories by robot name, but is {trajectory!r}"
        )
    return {robot: _in_order(planner, robot, one) for robot, one in trajectory.items()}


def _in_order(planner: PlannerInterface, robot: str, trajectory: Trajectory) -> Trajectory:
    """With times, and with the joints in the order of the robot."""
    if robot not in planner.robot_names:
        raise srmp.UnknownRobot(f"there is no robot '{robot}'{did_you_mean(robot, planner.robot_names)}")
    if not isinstance(trajectory, srmp.Trajectory):
        raise srmp.InvalidArgument(f"the trajectory of '{robot}' must be a Trajectory, but is {trajectory!r}")
    names = planner.get_joint_names(robot)
    if sorted(names) != sorted(trajectory.joint_names):
        raise srmp.InvalidArgument(
            f"the trajectory of '{robot}' moves {', '.join(trajectory.joint_names)}, but the robot's joints are "
            f"{', '.join(names)}"
        )
    columns = [trajectory.joint_names.index(name) for name in names]
    if columns == list(range(len(names))) and len(trajectory.times):
        return trajectory
    velocities = trajectory.velocities[:, columns] if len(trajectory.velocities) else None
    positions = trajectory.positions[:, columns]
    times = trajectory.times if len(trajectory.times) else _times_along(positions)
    return srmp.Trajectory(names, positions, times, velocities)


def _times_along(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1) / _PATH_SPEED
    return np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-6))])


def sample_motion(planner: PlannerInterface, trajectories: Mapping[str, Trajectory], rate: float = RATE) -> Motion:
    """The motion in frames, `rate` a second, of robots that all begin at time 0 and rest where they end."""
    duration = max((float(one.times[-1]) for one in trajectories.values()), default=0.0)
    times = np.linspace(0.0, duration, min(_MAX_FRAMES, max(2, round(duration * rate) + 1)))
    configurations = {robot: np.asarray(one.sample(times)) for robot, one in trajectories.items()}
    poses = np.array(
        [frame_poses(planner, {robot: rows[k] for robot, rows in configurations.items()}) for k in range(len(times))]
    )
    return Motion(times, poses, configurations, dict(trajectories))
