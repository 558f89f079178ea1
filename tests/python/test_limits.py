"""Limits of the user's: how they are said, that plans keep them, what is refused; paths in time without a planner."""

from types import MappingProxyType

import numpy as np
import pytest

import srmp


def speeds(planner):
    return planner.get_joint_limits("arm")[:, 2]


# --- set_motion_limits ------------------------------------------------------------------------------------------------


def test_the_model_says_the_limits_until_somebody_else_does(arm):
    assert arm.motion_limits("arm") == srmp.MotionLimits(
        speeds(arm), 2 * speeds(arm), 20 * speeds(arm), continuous=[False] * 7
    )
    assert np.array_equal(srmp.default_limits(speeds(arm)).jerk, arm.motion_limits("arm").jerk)


def test_limits_are_a_number_an_array_or_a_dictionary(arm):
    before = arm.motion_limits("arm")
    name = arm.get_joint_names("arm")[2]
    arm.set_motion_limits("arm", velocity=1, acceleration=np.arange(1.0, 8.0), jerk={name: 12})
    after = arm.motion_limits("arm")
    assert after.velocity.tolist() == [1.0] * 7
    assert after.acceleration.tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert after.jerk[2] == 12.0
    assert np.array_equal(np.delete(after.jerk, 2), np.delete(before.jerk, 2))
    arm.set_motion_limits("arm", velocity=np.float32(0.5), acceleration=[3.0] * 7)
    assert arm.motion_limits("arm").velocity.tolist() == [0.5] * 7
    assert arm.motion_limits("arm").jerk.tolist() == after.jerk.tolist()
    arm.set_motion_limits("arm", jerk=MappingProxyType({name: np.float32(8), "arm7_joint7": np.int64(9)}))
    assert arm.motion_limits("arm").jerk[[2, 6]].tolist() == [8, 9]
    arm.set_motion_limits("arm", jerk=np.array(7))
    assert arm.motion_limits("arm").jerk.tolist() == [7] * 7
    arm.set_motion_limits("arm")
    assert arm.motion_limits("arm").acceleration.tolist() == [3.0] * 7


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"velocity": 0}, "the velocity limit is 0; it must be"),
        ({"acceleration": -1.5}, "the acceleration limit is -1.5; it must be"),
        ({"jerk": np.nan}, "the jerk limit is NaN"),
        ({"velocity": np.inf}, "the velocity limit is inf"),
        ({"velocity": [1, 2, 3]}, "velocity limits: got 3, but there are 7 joints"),
        ({"velocity": [[1, 2, 3]]}, "velocity limits must be one row of numbers"),
        (
            {"velocity": "fast"},
            "velocity limits must be a number, one a joint, or a dictionary of joints, but are 'fast'",
        ),
        ({"velocity": True}, "but are True"),
        ({"velocity": object()}, "velocity limits must be numbers, but is <object"),
        ({"velocity": {"arm7_joint1": True}}, "the velocity limit is True; it must be a number"),
        ({"velocity": {"arm7_joint1": [1]}}, "the velocity limit is [1]; it must be a number"),
        ({"velocity": {"arm7_joint11": 1}}, "did you mean 'arm7_joint1'"),
        ({"velocity": {"x": 1}}, "velocity limits name 'x', which is no planned joint"),
        ({"jerk": {"arm7_joint2": "1 m"}}, "arm7_joint2: the jerk limit is '1 m'; it must be a number"),
        ({"jerk": {"arm7_joint2": -2}}, "the jerk limit is -2; it must be"),
    ],
)
def test_limits_that_cannot_be_change_nothing(arm, arguments, text):
    before = arm.motion_limits("arm")
    with pytest.raises(srmp.InvalidArgument) as error:
        arm.set_motion_limits("arm", **arguments)
    assert text in str(error.value)
    assert arm.motion_limits("arm") == before


def test_unknown_robots_are_refused(arm):
    for call in (arm.motion_limits, arm.set_motion_limits):
        with pytest.raises(srmp.InvalidArgument, match="unknown robot 'amr'"):
            call("amr")


def test_plans_keep_the_limits(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, ready - [1.8, 0, 0, 0, 0, 0, 0])
    fast = arm.plan("arm", ready, goal)
    arm.set_motion_limits("arm", velocity=0.3, acceleration={arm.get_joint_names("arm")[0]: 0.2})
    assert arm.last_result is None  # that was another request
    slow = arm.plan("arm", ready, goal)
    assert slow.duration > 2 * fast.duration
    assert slow.certificate.limits == arm.motion_limits("arm")
    assert 0.9 < slow.certificate.velocity.fraction <= 1 + 1e-6
    times = np.linspace(0, slow.duration, 2000)
    _, velocity, acceleration, _ = slow.state(times)
    assert np.abs(velocity).max() <= 0.3 * (1 + 1e-6)
    assert np.abs(acceleration[:, 0]).max() <= 0.2 * (1 + 1e-6)


# --- time_parameterize ------------------------------------------------------------------------------------------------

CORNER = [[0, 0], [1, 0], [1, 1]]
LIMITS = srmp.MotionLimits([1, 1], [2, 2], [20, 20])


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_path_in_time(method):
    motion = srmp.time_parameterize(CORNER, ["a", "b"], LIMITS, method=method, sample_period=0.01)
    assert motion.joint_names == ["a", "b"]
    assert motion.positions[0].tolist() == [0, 0]
    assert motion.positions[-1].tolist() == [1, 1]
    assert np.array_equal(motion.waypoints, CORNER)
    _, velocity, acceleration, _ = motion.state(np.linspace(0, motion.duration, 3000))
    assert np.abs(velocity).max() <= 1 + 1e-6
    assert np.abs(acceleration).max() <= 2 + 1e-5
    assert 2.5 < motion.duration < 3.5
    assert np.abs(motion.times - 0.5).min() < 5e-4


def test_corners_shrink_where_the_chord_is_not_free():
    queried = []

    def is_free(a, b):
        queried.append((a, b))
        return False

    arguments = {"blend_deviation": 0.1, "reach": [1, 1]}
    rounded = srmp.time_parameterize(CORNER, ["a", "b"], LIMITS, **arguments)
    stopping = srmp.time_parameterize(CORNER, ["a", "b"], LIMITS, is_free=is_free, **arguments)
    assert queried
    assert queried[0][0].shape == (2,)
    assert rounded.duration < stopping.duration
    assert np.abs(stopping.positions - [1, 0]).max(axis=1).min() < 1e-6  # it goes through the corner
    assert np.abs(rounded.positions - [1, 0]).max(axis=1).min() > 1e-3


def test_motions_that_begin_and_end_moving():
    line = [[0, 0], [1, 0]]
    motion = srmp.time_parameterize(line, ["a", "b"], LIMITS, start_velocity=[0.5, 0], end_velocity=[0.25, 0])
    assert motion.velocities[0].tolist() == [0.5, 0]
    assert motion.velocities[-1].tolist() == [0.25, 0]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"waypoints": []}, "waypoint"),
        ({"waypoints": [[0, np.nan]]}, "waypoint 0: b is NaN"),
        ({"waypoints": [[0, 0, 0]]}, "waypoints must have the shape (n, 2)"),
        ({"limits": srmp.MotionLimits([1], [1], [1])}, "velocity limits: got 1, but there are 2 joints"),
        ({"method": "topra"}, "method is 'topra'; it must be one of 'toppra' and 'ruckig', did you mean 'toppra'?"),
        ({"sample_period": 0}, "sample"),
        ({"blend_deviation": -1}, "blend"),
        ({"reach": [1]}, "reach"),
        ({"start_velocity": [2, 0]}, "start"),
        ({"end_velocity": [0, 0.5, 0]}, "end"),
    ],
)
def test_invalid_arguments_are_refused(arguments, text):
    arguments_ = {"waypoints": CORNER, "joint_names": ["a", "b"], "limits": LIMITS, **arguments}
    with pytest.raises(srmp.InvalidArgument) as error:
        srmp.time_parameterize(**arguments_)
    assert text in str(error.value)


def test_what_is_free_raises_is_raised():
    def is_free(a, b):
        raise KeyError("no map of this place")

    with pytest.raises(KeyError, match="no map"):
        srmp.time_parameterize(CORNER, ["a", "b"], LIMITS, is_free=is_free)


def test_default_limits():
    limits = srmp.default_limits([1, 0, np.inf, 1e7])
    assert limits.velocity.tolist() == [1, 1, 1, 1]
    assert limits.acceleration.tolist() == [2] * 4
    assert limits.jerk.tolist() == [20] * 4
    with pytest.raises(srmp.InvalidArgument, match="velocity limit of joint 1 is -1"):
        srmp.default_limits([1, -1])


# --- joint_limits.yaml ------------------------------------------------------------------------------------------------

MOVEIT = """
default_velocity_scaling_factor: 0.5
joint_limits:
  arm7_joint1: {has_velocity_limits: true, max_velocity: 1, has_acceleration_limits: true, max_acceleration: 1.5}
  arm7_joint3: {has_velocity_limits: false, max_velocity: 0, has_jerk_limits: true, max_jerk: 5}
  left_finger: {has_velocity_limits: true, max_velocity: 0.1}
"""


@pytest.fixture
def limits_file(tmp_path):
    path = tmp_path / "joint_limits.yaml"
    path.write_text(MOVEIT)
    return path


def test_moveits_file_takes_the_place_of_what_was_set(arm, limits_file):
    arm.set_motion_limits("arm", velocity=0.1, jerk=1)
    for _ in range(2):  # a second time changes nothing
        assert arm.load_joint_limits("arm", limits_file) == ["left_finger"]
        limits = arm.motion_limits("arm")
        assert limits.velocity.tolist() == [0.5, *(0.5 * speeds(arm)[1:])]
        assert limits.acceleration.tolist() == [1.5, *(2 * speeds(arm)[1:])]
        assert limits.jerk[2] == 5
        assert limits.jerk[0] == 20 * speeds(arm)[0]


def test_a_file_that_is_refused_changes_nothing(arm, limits_file):
    before = arm.motion_limits("arm")
    limits_file.write_text(MOVEIT.replace("max_velocity: 1,", "max_velocity: -1,"))
    with pytest.raises(
        srmp.FileError, match=r"joint_limits.yaml:4: arm7_joint1: max_velocity is -1; it must be above 0"
    ):
        arm.load_joint_limits("arm", limits_file)
    limits_file.write_text(MOVEIT + "  arm7_joint2: {has_position_limits: true, max_position: 1}\n")
    with pytest.raises(srmp.NotSupported, match="narrower position limits belong in the URDF"):
        arm.load_joint_limits("arm", limits_file)
    with pytest.raises(srmp.FileError, match="there is no such file"):
        arm.load_joint_limits("arm", "nowhere.yaml")
    with pytest.raises(srmp.InvalidArgument, match="unknown robot 'amr'"):
        arm.load_joint_limits("amr", limits_file)
    assert arm.motion_limits("arm") == before


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_problem_file_keeps_limits_that_were_set(arm, ready, tmp_path):
    arm.set_motion_limits("arm", velocity=0.7, jerk={"arm7_joint1": 1 / 3})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.1)
    trajectory = arm.plan("arm", ready, goal)
    arm.save(tmp_path / "p.json")
    loaded = srmp.PlannerInterface.load(tmp_path / "p.json")
    assert loaded.motion_limits("arm") == arm.motion_limits("arm")
    assert loaded.plan("arm", ready, goal) == trajectory


def test_robots_that_go_take_their_limits_with_them(arm):
    arm.set_motion_limits("arm", velocity=0.7)
    arm.remove_articulation("arm")
    arm.add_articulation(srmp.data_path("arm7.urdf"), name="arm", end_effector="arm7_hand")
    assert arm.motion_limits("arm").velocity.tolist() == speeds(arm).tolist()
    arm.set_motion_limits("arm", velocity=0.7)
    arm.reset()
    arm.add_articulation(srmp.data_path("arm7.urdf"), name="arm", end_effector="arm7_hand")
    assert arm.motion_limits("arm").velocity.tolist() == speeds(arm).tolist()
