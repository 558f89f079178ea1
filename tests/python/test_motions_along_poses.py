"""plan_linear and follow: what is said in docs/motions-along-poses.md, and every bad argument."""

import pickle
import time

import numpy as np
import pytest

import srmp
from srmp import Pose

START = [0.0, 0.4, 0.0, -1.6, 0.0, 1.0, 0.0]


def moved(pose, by, turn=0.0):
    rotation = Pose.from_rpy([0, 0, 0], [0, 0, turn])
    return Pose(p=pose.p + by, q=(rotation @ Pose(q=pose.q)).q)


def distance_to_line(points, a, b):
    along = (b - a) / np.linalg.norm(b - a)
    passed = np.clip((points - a) @ along, 0, np.linalg.norm(b - a))
    return np.linalg.norm(a + passed[:, None] * along - points, axis=1)


@pytest.mark.parametrize("method", ["toppra", "ruckig", "none"])
def test_the_hand_moves_straight(arm_alone, method):
    arm_alone.make_planner("arm", {"planner_id": "auto", "timing": method})
    here = arm_alone.compute_fk("arm", START)
    goal = moved(here, [0.0, 0.15, -0.1], 0.3)
    motion = arm_alone.plan_linear("arm", START, goal)
    deviation = motion.certificate.cartesian_deviation
    assert motion.certificate.holds
    assert motion.certificate.proved_free
    assert 0 <= deviation.position <= 1e-3
    assert 0 <= deviation.rotation <= np.radians(0.5)
    times = np.arange(0, motion.duration, 1e-3) if method != "none" else []
    rows = np.array([motion.sample(t) for t in times]) if method != "none" else motion.positions
    points = np.array([arm_alone.compute_fk("arm", q).p for q in rows])
    assert distance_to_line(points, here.p, goal.p).max() <= deviation.position + 1e-9
    end = arm_alone.compute_fk("arm", motion.positions[-1])
    np.testing.assert_allclose(end.p, goal.p, atol=1e-4)
    assert repr(deviation).startswith("CartesianDeviation(")
    assert "poses followed" in motion.certificate.report()


def test_one_robot_needs_no_name_and_one_pose_is_a_line(arm_alone):
    goal = moved(arm_alone.compute_fk("arm", START), [0, 0.1, 0])
    motions = [
        arm_alone.plan_linear(START, goal),
        arm_alone.plan_linear("arm", START, goal),
        arm_alone.follow(START, [goal]),
        arm_alone.follow("arm", START, [goal]),
    ]
    assert all(motion == motions[0] for motion in motions)
    assert arm_alone.last_request is None
    assert arm_alone.last_result is None
    assert arm_alone.get_planning_stats()["status"] == srmp.Status.solved


def test_certificates_of_such_motions_are_kept_in_files(arm_alone, tmp_path):
    goal = moved(arm_alone.compute_fk("arm", START), [0, 0.1, 0])
    motion = arm_alone.plan_linear(START, goal)
    assert motion.certificate.to_dict()["cartesian_deviation"]["position"] <= 1e-3
    plain = arm_alone.plan("arm", START, motion.positions[-1])
    assert plain.certificate.cartesian_deviation is None

    assert pickle.loads(pickle.dumps(motion)).certificate == motion.certificate


def test_an_arc_does_not_stop(arm_alone):
    here = arm_alone.compute_fk("arm", START)
    angles = np.linspace(0, np.pi, 20)[1:]
    arc = [moved(here, [0, 0.05 * np.sin(a), 0.05 * (np.cos(a) - 1)]) for a in angles]
    motion = arm_alone.follow(START, arc, max_deviation=0.002)
    inside = motion.velocities[(motion.times > 0.2) & (motion.times < motion.duration - 0.2)]
    assert np.abs(inside).max(axis=1).min() > 0.01
    points = np.array([arm_alone.compute_fk("arm", motion.sample(t)).p for t in np.arange(0, motion.duration, 1e-3)])
    radii = np.linalg.norm(points - (here.p - [0, 0, 0.05]), axis=1)
    assert np.abs(radii - 0.05).max() <= 0.002 + 0.05 * (1 - np.cos(angles[0] / 2))


@pytest.mark.parametrize("count", [100, 1000, 6000])
def test_close_poses_are_followed_by_few_rows_that_keep_the_limits(arm_alone, count):
    here = arm_alone.compute_fk("arm", START)
    angles = np.linspace(0, 2 * np.pi, count)[1:]
    circle = [moved(here, 0.05 * np.array([np.cos(a) - 1, np.sin(a), 0])) for a in angles]
    motion = arm_alone.follow(START, circle)
    assert motion.certificate.holds
    assert motion.certificate.cartesian_deviation.position <= 1e-3
    assert len(motion) < 3000
    assert (np.abs(motion.accelerations) <= 1.001 * arm_alone.motion_limits("arm").acceleration).all()
    motion.to_joint_trajectory()
    points = np.array([arm_alone.compute_fk("arm", motion.sample(t)).p for t in np.arange(0, motion.duration, 5e-3)])
    center = here.p - [0.05, 0, 0]
    assert np.abs(np.linalg.norm(points - center, axis=1) - 0.05).max() <= 1e-3 + 1e-6


@pytest.mark.parametrize(("wiggle", "count"), [(2e-4, 50), (1e-4, 300), (2.4e-4, 200)])
def test_poses_that_wiggle_by_less_than_the_tolerance_are_followed_in_order(arm_alone, wiggle, count):
    here = arm_alone.compute_fk("arm", START)
    still = [moved(here, wiggle * np.array([np.sin(i), np.cos(i), 0])) for i in range(count)]
    for poses in ([*still, moved(here, [0, 0, 0.05])], [moved(here, [0, 0, 0.05]), *still, moved(here, [0, 0, 0.03])]):
        motion = arm_alone.follow(START, poses)
        assert motion.certificate.holds
        assert motion.certificate.cartesian_deviation.position <= 1e-3


def test_poses_where_the_robot_is_already(arm_alone):
    here = arm_alone.compute_fk("arm", START)
    there = moved(here, [0, 0, 0.03])
    for poses in ([here], [here, here], [there, there, here, here]):
        motion = arm_alone.follow(START, poses)
        assert motion.certificate.holds
        np.testing.assert_allclose(arm_alone.compute_fk("arm", motion.positions[-1]).p, here.p, atol=1e-4)


def test_what_cannot_be_followed_says_why(arm_alone):
    here = arm_alone.compute_fk("arm", START)
    with pytest.raises(srmp.PlanningError, match="no configuration within the joint limits") as caught:
        arm_alone.plan_linear(START, moved(here, [0, 2.0, 0]))
    assert caught.value.status == srmp.Status.exhausted
    arm_alone.add_box("wall", size=[1, 0.02, 1], pose=moved(here, [0, 0.25, 0]))
    with pytest.raises(srmp.PlanningError, match=r"'arm7_hand' c.* of 0.4 m along its path.*'wall'"):
        arm_alone.plan_linear(START, moved(here, [0, 0.4, 0]))
    arm_alone.add_sphere("ball", radius=0.1, pose=Pose(p=here.p))
    with pytest.raises(srmp.PlanningError, match="start is invalid") as caught:
        arm_alone.plan_linear(START, moved(here, [0, 0.1, 0]))
    assert caught.value.status == srmp.Status.start_invalid


def test_time_limits_and_ctrl_c_hold_here_too(arm_alone):
    arm_alone.make_planner("arm", {"planner_id": "auto", "time_limit": 1e-4})
    here = arm_alone.compute_fk("arm", START)
    with pytest.raises(srmp.PlanningError, match="time limit") as caught:
        arm_alone.plan_linear(START, moved(here, [0, 0.2, 0]))
    assert caught.value.status == srmp.Status.timed_out


def test_the_proof_of_a_tiny_tolerance_ends_with_the_time_limit(arm_alone):
    arm_alone.make_planner("arm", {"planner_id": "auto", "time_limit": 0.2})
    here = arm_alone.compute_fk("arm", START)
    began = time.process_time()
    with pytest.raises(srmp.PlanningError, match=r"time limit|leaves the path by more than half of max_deviation"):
        arm_alone.plan_linear(START, moved(here, [0, 0.2, 0]), max_deviation=1e-10, max_rotation=1e-10)
    assert time.process_time() - began < 5  # it took minutes


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"name": "arn"}, "did you mean 'arm'"),
        ({"start": START[:3]}, "3"),
        ({"start": [np.nan] * 7}, "NaN|nan|finite"),
        ({"poses": []}, "no poses to follow"),
        ({"link": "arm7_hnd"}, "did you mean 'arm7_hand'"),
        ({"link": "arm7_base"}, "no planned joint moves it"),
        ({"max_deviation": 0.0}, "max_deviation is 0; it must be above 0"),
        ({"max_deviation": 1.0}, "at most 0.1 m"),
        ({"max_deviation": np.nan}, "max_deviation is NaN"),
        ({"max_rotation": -1.0}, "max_rotation is -1"),
        ({"max_rotation": 1.0}, "at most 0.5 rad"),
        ({"poses": [1, 2, 3]}, "poses"),
        ({"poses": "somewhere"}, "poses"),
        ({"poses": [Pose(), Pose(p=[0, 0, 1e6])]}, "pose 1 to follow: .* at most 1000 m are allowed"),
        ({"poses": [Pose(p=[0, 0, 900]), Pose()] * 2}, "the path along the poses is .* m long; at most 1000 m"),
    ],
)
def test_wrong_arguments_are_refused(arm_alone, arguments, words):
    goal = moved(arm_alone.compute_fk("arm", START), [0, 0.1, 0])
    with pytest.raises(srmp.Error, match=words):
        arm_alone.follow(**{"name": "arm", "start": START, "poses": [goal], **arguments})
