"""Trajectories in the other forms that they come in: dictionaries, NumPy's arrays, CSV, and messages of ROS."""

import json
import sys
import types

import numpy as np
import pytest
from support import NAMES, TIMES, refuses

import srmp


def test_dictionaries_are_json_and_read_back(any_trajectory):
    written = json.loads(json.dumps(any_trajectory.to_dict(), allow_nan=False))
    assert srmp.Trajectory.from_dict(written) == any_trajectory
    assert "times" not in srmp.Trajectory(["a"], [[0]]).to_dict()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: {**d, "velocitys": []}, "unknown key 'velocitys', did you mean 'velocities'"),
        (lambda d: {**d, 7: []}, "unknown key '7'"),
        (lambda d: {"positions": d["positions"]}, "has no 'joint_names'"),
        (lambda d: {"joint_names": d["joint_names"]}, "has no 'positions'"),
        (lambda d: {**d, "times": [0]}, "it has 5 rows, but 1 times"),
        (lambda d: [d], "must be a dictionary, but is"),
        (lambda d: None, "must be a dictionary, but is None"),
    ],
)
def test_wrong_dictionaries_are_refused(cubic, change, sentence):
    refuses(lambda: srmp.Trajectory.from_dict(change(cubic.to_dict())), sentence)


def test_numpy_has_a_field_for_all_that_is_known(cubic, jumpy, untimed, tmp_path):
    table = cubic.to_numpy()
    assert table.dtype.names == ("time", "position", "velocity", "acceleration", "jerk")
    assert table.shape == (5,)
    np.testing.assert_array_equal(table["time"], TIMES)
    np.testing.assert_array_equal(table["velocity"], cubic.velocities)
    np.testing.assert_array_equal(table["jerk"], cubic.jerks)
    assert jumpy.to_numpy().dtype.names == ("time", "position", "velocity", "jerk")
    assert untimed.to_numpy().dtype.names == ("position",)
    assert srmp.Trajectory(["a"], [[1], [2]], [0, 1]).to_numpy()["position"].shape == (2, 1)
    np.save(tmp_path / "t.npy", table)
    np.testing.assert_array_equal(np.load(tmp_path / "t.npy"), table)


def test_csv_reads_back_bit_for_bit(any_trajectory, tmp_path):
    file = tmp_path / "t.csv"
    any_trajectory.to_csv(file)
    again = srmp.Trajectory.from_csv(str(file))
    for name in ("joint_names", "positions", "velocities", "accelerations", "times"):
        np.testing.assert_array_equal(getattr(again, name), getattr(any_trajectory, name))
    np.testing.assert_array_equal(again.waypoints, again.positions)


def test_csv_is_a_table_that_others_read(cubic, tmp_path):
    file = tmp_path / "t.csv"
    cubic.to_csv(file)
    lines = file.read_text().splitlines()
    assert lines[0] == "time,a_position,b_position,a_velocity,b_velocity,a_acceleration,b_acceleration"
    assert len(lines) == 6
    np.testing.assert_array_equal(np.loadtxt(file, delimiter=",", skiprows=1)[:, 1:3], cubic.positions)
    awkward = srmp.Trajectory(['left, "arm"', "x_position", "time", " b"], np.full((2, 4), 1 / 3))
    awkward.to_csv(file)
    assert srmp.Trajectory.from_csv(file) == awkward
    file.write_text(
        "\ufeffb_position,time,a_position\r\n\r\n2,0,1\r\n4,1e0,3\r\n", encoding="utf-8"
    )  # of a spreadsheet
    assert srmp.Trajectory.from_csv(file) == srmp.Trajectory(["b", "a"], [[2, 1], [4, 3]], [0, 1])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "must have a header and at least one row"),
        ("time,a_position\n", "must have a header and at least one row"),
        ("time,a_position\n0,1\n1\n", "line 3: it has 1 cells, but the header 2"),
        ("time,a_position\n0,one\n", "line 2: could not convert string to float: 'one'"),
        ("time,a_position\n0,\n", "line 2: could not convert"),
        ("time,a_position\n0,nan\n", "positions, row 0: a is NaN"),
        ("time,a_position\n1,0\n0,0\n", "times must increase, but row 1"),
        ("time,position\n0,1\n", "the column 'position' is neither time nor"),
        ("time,a_pos\n0,1\n", "the column 'a_pos' is neither"),
        ("time,a_position,a_position\n0,1,1\n", "the column 'a_position' is there twice"),
        ("time,time,a_position\n0,0,1\n", "the column 'time' is there twice"),
        ("time\n0\n", "there is no column <joint>_position"),
        ("a_velocity\n0\n", "there is no column <joint>_position"),
        ("time,a_position,b_position,a_velocity\n0,1,1,1\n", "there is no column 'b_velocity'"),
        ("time,a_position,a_velocity,b_velocity\n0,1,1,1\n", "there is no column 'b_position'"),
        ("a_position,a_velocity\n0,1\n", "it has velocities, but no times"),
        ('time,"a_position\n0,1\n', "is not a CSV table"),
    ],
)
def test_wrong_tables_are_refused(tmp_path, text, sentence):
    file = tmp_path / "t.csv"
    file.write_text(text)
    refuses(lambda: srmp.Trajectory.from_csv(file), f"t.csv.*{sentence}", srmp.FileError)


def test_files_that_cannot_be_read_or_written_are_named(cubic, tmp_path):
    refuses(lambda: srmp.Trajectory.from_csv(tmp_path / "no.csv"), "no.csv cannot be read: No such", srmp.FileError)
    refuses(
        lambda: cubic.to_csv(tmp_path / "no" / "t.csv"), "t.csv: the file cannot be written: No such", srmp.FileError
    )
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x01")
    refuses(lambda: srmp.Trajectory.from_csv(tmp_path / "binary.csv"), "binary.csv is not a CSV table", srmp.FileError)


def test_joint_trajectories_are_laid_out_as_in_ros(cubic):
    message = json.loads(json.dumps(cubic.to_joint_trajectory(accelerations=True)))
    assert list(message) == ["header", "joint_names", "points"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert message["joint_names"] == NAMES
    assert message["points"][2] == {
        "positions": cubic.positions[2].tolist(),
        "velocities": cubic.velocities[2].tolist(),
        "accelerations": cubic.accelerations[2].tolist(),
        "effort": [],
        "time_from_start": {"sec": 1, "nanosec": 0},
    }
    assert message["points"][4]["time_from_start"] == {"sec": 2, "nanosec": 500_000_000}
    # By default controllers do not follow quintics.
    points = cubic.to_joint_trajectory()["points"]
    assert [point["accelerations"] for point in points] == [[]] * 5


class RosTime:
    """A duration of ROS 2, or of ROS 1."""

    def __init__(self, *names):
        for name in names:
            setattr(self, name, 0)


def stand_in_for_ros(monkeypatch, *time_names):
    """Modules with the messages that a ROS installation has."""

    class JointTrajectoryPoint:
        def __init__(self):
            self.positions, self.velocities, self.accelerations, self.effort = [], [], [], []
            self.time_from_start = RosTime(*time_names)

    class JointTrajectory:
        def __init__(self):
            self.joint_names, self.points = [], []

    class RobotTrajectory:
        def __init__(self):
            self.joint_trajectory = JointTrajectory()

    for package, messages in {
        "trajectory_msgs": (JointTrajectory, JointTrajectoryPoint),
        "moveit_msgs": (RobotTrajectory,),
    }.items():
        module = types.ModuleType(f"{package}.msg")
        for message in messages:
            setattr(module, message.__name__, message)
        monkeypatch.setitem(sys.modules, package, types.ModuleType(package))
        monkeypatch.setitem(sys.modules, f"{package}.msg", module)


@pytest.mark.parametrize("time_names", [("sec", "nanosec"), ("secs", "nsecs")])
def test_ros_messages_are_filled(cubic, monkeypatch, time_names):
    stand_in_for_ros(monkeypatch, *time_names)
    message = cubic.to_ros()
    assert type(message).__name__ == "JointTrajectory"
    assert message.joint_names == NAMES
    assert message.points[2].positions == cubic.positions[2].tolist()
    assert message.points[2].velocities == cubic.velocities[2].tolist()
    assert message.points[2].accelerations == []
    assert [getattr(message.points[4].time_from_start, name) for name in time_names] == [2, 500_000_000]
    robot = cubic.to_ros("RobotTrajectory", accelerations=True)
    assert type(robot).__name__ == "RobotTrajectory"
    assert robot.joint_trajectory.points[2].accelerations == cubic.accelerations[2].tolist()


def test_without_ros_there_is_a_dictionary(cubic, monkeypatch):
    for package in ("trajectory_msgs", "moveit_msgs"):
        monkeypatch.setitem(sys.modules, f"{package}.msg", None)  # an import of it fails
    assert cubic.to_ros() == cubic.to_joint_trajectory()
    assert cubic.to_ros("RobotTrajectory") == {"joint_trajectory": cubic.to_joint_trajectory()}
    refuses(lambda: cubic.to_ros("RobotTrajectroy"), "did you mean 'RobotTrajectory'?")


def test_joint_trajectories_read_back(any_trajectory):
    if not len(any_trajectory.times):
        return
    again = srmp.Trajectory.from_joint_trajectory(any_trajectory.to_joint_trajectory(accelerations=True))
    for name in ("joint_names", "positions", "velocities", "accelerations"):
        np.testing.assert_array_equal(getattr(again, name), getattr(any_trajectory, name))
    np.testing.assert_allclose(again.times, any_trajectory.times - any_trajectory.times[0], atol=1e-9)


def test_joint_trajectories_round_to_nanoseconds():
    def stamps(*times):
        message = srmp.Trajectory(["a"], np.zeros((len(times), 1)), times).to_joint_trajectory()
        return [(p["time_from_start"]["sec"], p["time_from_start"]["nanosec"]) for p in message["points"]]

    assert stamps(0, 0.9999999999, 2.1) == [(0, 0), (1, 0), (2, 100_000_000)]
    assert stamps(-1.5, 0) == [(0, 0), (1, 500_000_000)]
    refuses(lambda: stamps(0, 1, 1 + 1e-10), "rows 1 and 2 are in the same nanosecond")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda m: None, "a JointTrajectory must be a dictionary, but is None"),
        (lambda m: {"points": m["points"]}, "has no 'joint_names'"),
        (lambda m: {**m, "point": []}, "unknown key 'point', did you mean 'points'"),
        (lambda m: {**m, "points": []}, "a list of at least one point"),
        (lambda m: {**m, "points": 5}, "a list of at least one point"),
        (lambda m: {**m, "points": [5]}, "point 0 of a JointTrajectory must be a dictionary"),
        (lambda m: point(m, effort=[1, 2]), "point 1 of a JointTrajectory has efforts"),
        (lambda m: point(m, effort=1), "effort of point 1 of a JointTrajectory must be a list, but is 1"),
        (lambda m: point(m, velocities=[]), "point 1 of a JointTrajectory has 0 velocities, but point 0 has 2"),
        (lambda m: point(m, positions=[1]), "point 1 of a JointTrajectory has 1 positions, but point 0 has 2"),
        (lambda m: point(m, positions=None), "positions of point 1 of a JointTrajectory must be a list, but is None"),
        (lambda m: point(m, velocity=[]), "unknown key 'velocity', did you mean 'velocities'"),
        (lambda m: point(m, time_from_start=1.0), "time_from_start of point 1 .* must be a dictionary, but is 1.0"),
        (lambda m: point(m, time_from_start={"sec": 1}), "time_from_start of point 1 .* has no 'nanosec'"),
        (lambda m: point(m, time_from_start={"sec": 1.5, "nanosec": 0}), "must be whole numbers"),
        (lambda m: point(m, time_from_start={"sec": 0, "nanosec": 0}), "times must increase, but row 1"),
    ],
)
def test_wrong_joint_trajectories_are_refused(cubic, change, sentence):
    refuses(lambda: srmp.Trajectory.from_joint_trajectory(change(cubic.to_joint_trajectory())), sentence)


def point(message, **change):
    points = list(message["points"])
    points[1] = {**points[1], **change}
    return {**message, "points": points}


def test_joint_trajectories_may_leave_out_what_they_do_not_know():
    points = [{"positions": [k], "time_from_start": {"sec": k, "nanosec": 0}} for k in range(3)]
    found = srmp.Trajectory.from_joint_trajectory({"joint_names": ["a"], "points": points})
    assert found == srmp.Trajectory(["a"], [[0], [1], [2]], [0, 1, 2])
