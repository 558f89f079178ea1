"""Methods of srmp.Trajectory that need no C++: dictionaries, tables, messages and figures."""

from __future__ import annotations

import csv
import functools
import importlib
import io
import itertools
import math
import operator
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._errors import checked
from srmp._files import write_text
from srmp._names import did_you_mean

_REQUIRED = ("joint_names", "positions")
_OPTIONAL = ("times", "velocities", "accelerations", "waypoints")
_PER_JOINT = ("position", "velocity", "acceleration")
_NANOSECONDS = 10**9


# --- dictionaries -----------------------------------------------------------------------------------------------------


def to_dict(trajectory: srmp.Trajectory) -> dict[str, Any]:
    known = [key for key in _OPTIONAL if len(getattr(trajectory, key))]
    arrays = {key: getattr(trajectory, key).tolist() for key in ("positions", *known)}
    return {"joint_names": list(trajectory.joint_names), **arrays}


def from_dict(dictionary: Mapping[str, Any]) -> srmp.Trajectory:
    _require_keys(dictionary, "a trajectory's dictionary", _REQUIRED, _OPTIONAL)
    return srmp.Trajectory(**dictionary)


def _require_keys(value: Any, what: str, required: Sequence[str], optional: Sequence[str]) -> None:
    if not isinstance(value, Mapping):
        raise srmp.InvalidArgument(f"{what} must be a dictionary, but is {value!r}.")
    for key in value:
        if key not in (*required, *optional):
            hint = did_you_mean(str(key), (*required, *optional)) or "."
            raise srmp.InvalidArgument(f"{what} has an unknown key '{key}'{hint}")
    for key in required:
        if key not in value:
            raise srmp.InvalidArgument(f"{what} has no '{key}'.")


# --- NumPy ------------------------------------------------------------------------------------------------------------


def to_numpy(trajectory: srmp.Trajectory) -> np.ndarray:
    dof = len(trajectory.joint_names)
    columns = {
        "time": trajectory.times,
        "position": trajectory.positions,
        "velocity": trajectory.velocities,
        "acceleration": trajectory.accelerations,
        "jerk": trajectory.jerks,
    }
    known = {name: values for name, values in columns.items() if len(values)}
    table = np.empty(
        len(trajectory), dtype=[(name, float, () if values.ndim == 1 else (dof,)) for name, values in known.items()]
    )
    for name, values in known.items():
        table[name] = values
    return table


# --- CSV --------------------------------------------------------------------------------------------------------------


@checked
def to_csv(trajectory: srmp.Trajectory, path: str | os.PathLike[str]) -> None:
    header = ["time"] if len(trajectory.times) else []
    columns = [trajectory.times[:, None]] if len(trajectory.times) else []
    for quantity, values in zip(
        _PER_JOINT, (trajectory.positions, trajectory.velocities, trajectory.accelerations), strict=True
    ):
        if len(values):
            header += [f"{name}_{quantity}" for name in trajectory.joint_names]
            columns.append(values)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(np.hstack(columns).tolist())  # Python's floats are written so that they read back bit for bit
    write_text(path, text.getvalue())


@checked
def from_csv(path: str | os.PathLike[str]) -> srmp.Trajectory:
    header, rows = _read_table(path)
    times, joints = _columns(path, header)
    arrays = {}
    for quantity, plural in zip(_PER_JOINT, ("positions", "velocities", "accelerations"), strict=True):
        if joints[quantity]:
            arrays[plural] = rows[:, [joints[quantity][name] for name in joints["position"]]]
    try:
        return srmp.Trajectory(list(joints["position"]), times=None if times is None else rows[:, times], **arrays)
    except srmp.InvalidArgument as error:
        raise srmp.FileError(f"{path}: {error}") from error


def _read_table(path: str | os.PathLike[str]) -> tuple[list[str], np.ndarray]:
    try:
        with Path(path).open(newline="", encoding="utf-8-sig") as file:
            table = [
                (reader.line_num, cells) for reader in [csv.reader(file, strict=True)] for cells in reader if cells
            ]
    except OSError as error:
        raise srmp.FileError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, csv.Error) as error:
        raise srmp.FileError(f"{path} is not a CSV table: {error}.") from error
    if len(table) < 2:
        raise srmp.FileError(f"{path} must have a header and at least one row.")
    (_, header), *lines = table
    return header, np.array([_numbers(path, header, *line) for line in lines])


def _numbers(path: str | os.PathLike[str], header: list[str], line: int, cells: list[str]) -> list[float]:
    if len(cells) != len(header):
        raise srmp.FileError(f"{path}, line {line}: it has {len(cells)} cells, but the header {len(header)}.")
    try:
        return [float(cell) for cell in cells]
    except ValueError as error:
        raise srmp.FileError(f"{path}, line {line}: {error}.") from error


def _columns(path: str | os.PathLike[str], header: list[str]) -> tuple[int | None, dict[str, dict[str, int]]]:
    """The column of the times, and for each quantity the joints and their columns."""
    times = None
    joints: dict[str, dict[str, int]] = {quantity: {} for quantity in _PER_JOINT}
    for column, name in enumerate(header):
        joint, _, quantity = name.rpartition("_")
        if header.index(name) != column:
            raise srmp.FileError(f"{path}: the column '{name}' is there twice.")
        if name == "time":
            times = column
        elif joint and quantity in _PER_JOINT:
            joints[quantity][joint] = column
        else:
            raise srmp.FileError(
                f"{path}: the column '{name}' is neither time nor <joint>_position, <joint>_velocity or "
                "<joint>_acceleration."
            )
    for quantity in _PER_JOINT:
        if joints[quantity] or quantity == "position":
            _require_same_joints(path, quantity, joints)
    return times, joints


def _require_same_joints(path: str | os.PathLike[str], quantity: str, joints: dict[str, dict[str, int]]) -> None:
    if not joints["position"]:
        raise srmp.FileError(f"{path}: there is no column <joint>_position.")
    for name in joints["position"]:
        if name not in joints[quantity]:
            raise srmp.FileError(f"{path}: there is no column '{name}_{quantity}'.")
    for name in joints[quantity]:
        if name not in joints["position"]:
            raise srmp.FileError(f"{path}: there is no column '{name}_position'.")


# --- trajectory_msgs/JointTrajectory ----------------------------------------------------------------------------------


def to_joint_trajectory(trajectory: srmp.Trajectory, accelerations: bool) -> dict[str, Any]:
    if not len(trajectory.times):
        raise srmp.InvalidArgument("a JointTrajectory needs times, but this trajectory is a path without them.")
    arrays = (trajectory.positions, trajectory.velocities, trajectory.accelerations if accelerations else ())
    stamps = [_nanoseconds(time) - _nanoseconds(trajectory.times[0]) for time in trajectory.times]
    for i, (a, b) in enumerate(itertools.pairwise(stamps)):
        if a >= b:
            raise srmp.InvalidArgument(
                f"rows {i} and {i + 1} are in the same nanosecond, and a JointTrajectory counts in nanoseconds."
            )
    points = []
    for i, stamp in enumerate(stamps):
        position, velocity, acceleration = (rows[i].tolist() if len(rows) else [] for rows in arrays)
        points.append(
            {
                "positions": position,
                "velocities": velocity,
                "accelerations": acceleration,
                "effort": [],
                "time_from_start": dict(zip(("sec", "nanosec"), divmod(stamp, _NANOSECONDS), strict=True)),
            }
        )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(trajectory.joint_names),
        "points": points,
    }


_ROS_MESSAGES = {"JointTrajectory": "trajectory_msgs", "RobotTrajectory": "moveit_msgs"}


@checked
def to_ros(trajectory: srmp.Trajectory, message: str, accelerations: bool) -> Any:
    if message not in _ROS_MESSAGES:
        hint = did_you_mean(message, _ROS_MESSAGES) or "; known are 'JointTrajectory' and 'RobotTrajectory'."
        raise srmp.InvalidArgument(f"message: there is no trajectory message '{message}'{hint}")
    content = to_joint_trajectory(trajectory, accelerations)
    if message == "RobotTrajectory":
        content = {"joint_trajectory": content}
    try:
        filled = getattr(importlib.import_module(f"{_ROS_MESSAGES[message]}.msg"), message)()
        points = importlib.import_module("trajectory_msgs.msg")
    except ImportError:
        return content
    target = filled if message == "JointTrajectory" else filled.joint_trajectory
    target.joint_names = content.get("joint_trajectory", content)["joint_names"]
    target.points = [
        _ros_point(points.JointTrajectoryPoint(), point) for point in content.get("joint_trajectory", content)["points"]
    ]
    return filled


def _ros_point(point: Any, content: Mapping[str, Any]) -> Any:
    """Filled; a duration has the fields sec and nanosec in ROS 2, and secs and nsecs in ROS 1."""
    for name in ("positions", "velocities", "accelerations"):
        setattr(point, name, content[name])
    for value, names in zip(content["time_from_start"].values(), (("sec", "secs"), ("nanosec", "nsecs")), strict=True):
        setattr(point.time_from_start, next(name for name in names if hasattr(point.time_from_start, name)), value)
    return point


def _nanoseconds(time: float) -> int:
    """To the nearest one; whole seconds are split off first, so that none of the digits is lost."""
    seconds = math.floor(time)
    return seconds * _NANOSECONDS + round((time - seconds) * _NANOSECONDS)


def from_joint_trajectory(message: Mapping[str, Any]) -> srmp.Trajectory:
    _require_keys(message, "a JointTrajectory", ("joint_names", "points"), ("header",))
    points = message["points"]
    if not isinstance(points, Sequence) or isinstance(points, str) or not points:
        raise srmp.InvalidArgument("points of a JointTrajectory must be a list of at least one point.")
    for i, point in enumerate(points):
        what = f"point {i} of a JointTrajectory"
        _require_keys(point, what, ("positions", "time_from_start"), ("velocities", "accelerations", "effort"))
        _require_keys(point["time_from_start"], f"time_from_start of {what}", ("sec", "nanosec"), ())
        if _length(point, "effort", what):
            raise srmp.InvalidArgument(f"{what} has efforts, which a Trajectory cannot hold; leave them out.")
    arrays = {key: _stacked(points, key) for key in ("positions", "velocities", "accelerations")}
    stamps = [point["time_from_start"] for point in points]
    try:
        whole = [(operator.index(stamp["sec"]), operator.index(stamp["nanosec"])) for stamp in stamps]
    except TypeError as error:
        raise srmp.InvalidArgument(f"time_from_start of a JointTrajectory must be whole numbers: {error}.") from error
    times = [(seconds * _NANOSECONDS + nanoseconds) / _NANOSECONDS for seconds, nanoseconds in whole]
    return srmp.Trajectory(message["joint_names"], times=times, **arrays)


def _stacked(points: Sequence[Mapping[str, Any]], key: str) -> list[Any] | None:
    lengths = [_length(point, key, f"point {i} of a JointTrajectory") for i, point in enumerate(points)]
    if not any(lengths):
        return None
    for i, length in enumerate(lengths):
        if length != lengths[0]:
            raise srmp.InvalidArgument(
                f"point {i} of a JointTrajectory has {length} {key}, but point 0 has {lengths[0]}."
            )
    return [point[key] for point in points]


def _length(point: Mapping[str, Any], key: str, what: str) -> int:
    try:
        return len(point.get(key, ()))
    except TypeError as error:
        raise srmp.InvalidArgument(f"{key} of {what} must be a list, but is {point[key]!r}.") from error


# --- a figure ---------------------------------------------------------------------------------------------------------


@checked
def plot(
    trajectory: srmp.Trajectory, path: str | os.PathLike[str] | None, limits: srmp.MotionLimits | None, title: str
) -> Any:
    if limits is None and trajectory.certificate is not None:
        limits = trajectory.certificate.limits
    names = trajectory.joint_names
    if limits is not None and len(limits.velocity) != len(names):
        raise srmp.InvalidArgument(
            f"limits are for {len(limits.velocity)} joints, but the trajectory moves {len(names)}."
        )
    return _draw({"": trajectory}, {"": limits}, path, title)


@functools.partial(checked, name="plot")
def plot_many(trajectories: srmp.MultiTrajectory, path: str | os.PathLike[str] | None, title: str) -> Any:
    certificates = {robot: one.certificate for robot, one in trajectories.items()}
    limits = {robot: certificate and certificate.limits for robot, certificate in certificates.items()}
    if not limits:
        raise srmp.InvalidArgument("there is no robot whose motion could be drawn.")
    return _draw(dict(trajectories.items()), limits, path, title)


def _draw(
    trajectories: Mapping[str, srmp.Trajectory],
    limits: Mapping[str, srmp.MotionLimits | None],
    path: str | os.PathLike[str] | None,
    title: str,
) -> Any:
    """By robot name; "" names one alone. A robot whose own motion is over rests where it ended."""
    from srmp.plot import Profile, draw_profiles, write_figure

    if any(not len(one.times) for one in trajectories.values()):
        raise srmp.InvalidArgument("a path without times has no profiles to draw.")
    rows = np.unique(np.concatenate([one.times for one in trajectories.values()]))
    times = _drawn_times(rows)
    states = [_state(one, times) for one in trajectories.values()]
    names = [f"{robot}/{joint}" if robot else joint for robot, one in trajectories.items() for joint in one.joint_names]

    def profile(name: str, unit: str, order: int) -> Profile:
        values = np.hstack([state[order] for state in states])
        known = all(own is not None for own in limits.values()) and order > 0
        bounds = np.concatenate([getattr(own, name) for own in limits.values()]) if known else None
        return Profile(name, unit, values, bounds)

    profiles = [
        profile("position", "rad, m", 0),
        profile("velocity", "rad/s, m/s", 1),
        profile("acceleration", "rad/s², m/s²", 2),
        profile("jerk", "rad/s³, m/s³", 3),
    ]
    figure = draw_profiles(names, times, profiles, title)
    if path is not None:
        write_figure(figure, Path(path))
    return figure


def _state(trajectory: srmp.Trajectory, times: np.ndarray) -> list[np.ndarray]:
    """Position, velocity, acceleration and jerk; at rest once the motion is over."""
    position, *derivatives = trajectory.state(np.minimum(times, trajectory.times[-1]))
    over = times > trajectory.times[-1]
    return [position, *(np.where(over[:, None], 0.0, values) for values in derivatives)]


def _drawn_times(rows: np.ndarray) -> np.ndarray:
    """Each row, times between them, and a moment before the next: accelerations and jerks may jump there."""
    inside = max(1, math.ceil(2000 / len(rows)))
    fractions = np.append(np.arange(inside) / inside, 1 - 1e-6)
    return np.append((rows[:-1, None] + np.diff(rows)[:, None] * fractions).ravel(), rows[-1])
