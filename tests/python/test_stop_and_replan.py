"""Starts in motion, stop and replan: what is said in docs/stop-and-replan.md, and every bad argument."""

import pickle

import numpy as np
import pytest

import srmp
from srmp import Pose

READY = [0.0, -0.5, 0.0, -1.8, 0.0, 1.2, 0.0]
GOAL = np.add(READY, [1.5, 0.2, 0, 0.4, 0, 0.3, 0])
BEHIND = np.add(READY, [-0.8, 0.3, 0.2, 0, 0.3, 0, 0])
BESIDE = np.add(READY, [1.0, -0.5, 0.4, 0, 0.5, 0.3, 0.2])


@pytest.fixture(params=["toppra", "ruckig"])
def timing(request):
    return request.param


@pytest.fixture
def planner(arm_alone, timing):
    arm_alone.add_box("post", [0.1, 0.1, 0.8], Pose(p=[0.45, 0.35, 0.4]))
    arm_alone.make_planner("arm", {"planner_id": "auto", "timing": timing})
    return arm_alone


def assert_continues(planner, timing, motion, t, next_motion):
    """From where and as fast as the motion is at t, within all limits and proved free."""
    position, velocity, acceleration, _ = motion.state(t)
    assert next_motion.times[0] == 0
    np.testing.assert_array_equal(next_motion.positions[0], position)
    if np.abs(velocity).max() > 1e-9:  # less is at rest
        np.testing.assert_array_equal(next_motion.velocities[0], velocity)
    np.testing.assert_array_equal(next_motion.velocities[-1], 0)
    jerk = timing == "ruckig"
    certificate = planner.verify(
        "arm",
        next_motion,
        start=position,
        jerk=jerk,
        start_velocity=velocity,
        start_acceleration=acceleration if jerk else None,
    )
    assert certificate.holds, certificate.faults
    assert certificate.proved_free
    assert next_motion.certificate.holds


def instants(motion, count, seed):
    return [0.0, *np.random.default_rng(seed).uniform(0, motion.duration, count), motion.duration]


def test_stops_at_random_instants(planner, timing):
    motion = planner.plan("arm", READY, GOAL)
    limits = planner.motion_limits("arm").acceleration
    for t in instants(motion, 50, 1):
        stop = planner.stop(motion, t)
        assert_continues(planner, timing, motion, t, stop)
        velocity = motion.state(t)[1]
        assert (np.abs(velocity) / limits).max() - 1e-6 <= stop.duration <= motion.duration - t + 0.02
        for q in stop.positions[::5]:  # it is on the path
            near = np.abs(motion.positions - q).sum(axis=1).argmin()
            around = np.linspace(*motion.times[[max(near - 1, 0), min(near + 1, len(motion) - 1)]], 50)
            assert min(np.abs(motion.sample(s) - q).max() for s in around) < 1e-2


def test_a_stop_on_a_straight_line_is_as_fast_as_the_limits_allow(arm_alone):
    goal = np.add(READY, [1.0, 0, 0, 0, 0, 0, 0])
    motion = arm_alone.plan("arm", READY, goal)
    limit = arm_alone.motion_limits("arm").acceleration[0]
    for t in np.linspace(0.1, 0.9, 9) * motion.duration:
        speed = motion.state(t)[1][0]
        stop = arm_alone.stop("arm", motion, t)
        np.testing.assert_allclose(stop.duration, speed / limit, rtol=2e-2)
        np.testing.assert_allclose(stop.positions[-1][0] - motion.sample(t)[0], speed**2 / 2 / limit, rtol=3e-2)


def test_new_goals_at_random_instants(planner, timing):
    motion = planner.plan("arm", READY, GOAL)
    for k, t in enumerate(instants(motion, 50, 2)):
        goal = [BEHIND, BESIDE][k % 2]
        found = planner.replan(motion, t, goal)
        assert_continues(planner, timing, motion, t, found)
        np.testing.assert_allclose(found.positions[-1], goal, atol=1e-6)
        stop = planner.stop(motion, t)
        later = planner.plan("arm", stop.positions[-1], goal)
        assert found.duration <= 1.1 * (stop.duration + later.duration)


def test_where_the_way_ahead_is_free_there_is_no_stop(arm_alone):
    ahead = np.add(GOAL, [0.5, 0.1, 0, 0.2, 0.3, 0.2, 0.1])
    motion = arm_alone.plan("arm", READY, GOAL)
    found = arm_alone.replan(motion, 0.5 * motion.duration, ahead)
    speeds = np.abs(found.velocities).max(axis=1)
    assert speeds[:-1].min() > 0.1 * speeds[0] or speeds.argmin() == len(speeds) - 1
    stop = arm_alone.stop(motion, 0.5 * motion.duration)
    assert found.duration < 0.9 * (stop.duration + arm_alone.plan("arm", stop.positions[-1], ahead).duration)


def test_the_old_motion_is_followed_until_the_robot_can_stop_ahead(arm_alone):
    """Joint 6 turns back before its limit while joint 1 goes on so fast that a stop straight ahead takes too long."""
    a = np.add(READY, [0, 0, 0, 0, 0, 0.4, 0])
    b = np.add(a, [1, 0, 0, 0, 0, 0.49, 0])
    corner = [a, b, np.add(a, [2, 0, 0, 0, 0, 0, 0])]
    names, limits = arm_alone.get_joint_names("arm"), arm_alone.motion_limits("arm")
    motion = srmp.time_parameterize(corner, names, limits, blend_deviation=0.2)
    left_later = 0
    for t in np.linspace(0.1, 0.9, 33) * motion.duration:
        position, velocity = motion.state(t)[:2]
        found = arm_alone.replan(motion, t, BEHIND)
        assert_continues(arm_alone, "toppra", motion, t, found)
        try:
            assert found == arm_alone.plan("arm", position, BEHIND, start_velocity=velocity)
        except srmp.PlanningError as error:
            left_later += 1
            assert error.status == srmp.Status.start_invalid
            assert "cannot stop straight ahead of its start velocity: arm7_joint6: " in str(error)
            np.testing.assert_allclose(found.sample(0.01), motion.sample(t + 0.01), atol=1e-9)
    assert 0 < left_later < 10


def test_what_came_into_the_way_is_said(arm_alone):
    motion = arm_alone.plan("arm", READY, GOAL)
    t = 0.5 * motion.duration
    position, velocity = motion.state(t)[:2]
    arm_alone.add_sphere("new", 0.03, arm_alone.compute_fk("arm", position + velocity * 0.15))
    for call in (
        lambda: arm_alone.plan("arm", position, BEHIND, start_velocity=velocity),
        lambda: arm_alone.replan(motion, t, BEHIND),
    ):
        with pytest.raises(srmp.PlanningError, match="new") as error:
            call()
        assert error.value.status == srmp.Status.start_invalid
    with pytest.raises(srmp.PlanningError, match=r"the stop from .* s on is not valid: .*new") as error:
        arm_alone.stop(motion, t)
    assert error.value.status == srmp.Status.exhausted


def test_a_plan_with_a_start_velocity(planner):
    velocity = np.array([0.5, 0.1, 0, 0.2, 0, 0, 0])
    found = planner.plan("arm", READY, GOAL, start_velocity=velocity)
    np.testing.assert_array_equal(found.velocities[0], velocity)
    assert found.certificate.holds
    assert planner.verify("arm", found).faults[0].kind == srmp.FaultKind.not_at_rest
    wrong = planner.verify("arm", found, start_velocity=2 * velocity)
    assert wrong.faults[0].kind == srmp.FaultKind.start
    assert "the velocity is 0.5 at the start; it should be 1" in wrong.faults[0].text
    again = planner.plan("arm", READY, GOAL, start_velocity=velocity)
    assert again == found
    at_rest = planner.plan("arm", READY, GOAL)
    assert planner.plan("arm", READY, GOAL, start_velocity=[0.0] * 7) == at_rest


def test_requests_with_a_start_velocity(planner, tmp_path):
    velocity = [0.5, 0.1, 0, 0.2, 0, 0, 0]
    request = srmp.PlanRequest("arm", READY, GOAL, start_velocity=velocity)
    np.testing.assert_array_equal(request.start_velocity, velocity)
    assert len(request.start_acceleration) == 0
    copy = pickle.loads(pickle.dumps(request))
    assert copy == request
    found = planner.plan("arm", READY, GOAL, start_velocity=velocity)
    assert planner.plan_many([request, copy])[1].trajectory == found
    planner.plan("arm", READY, GOAL, start_velocity=velocity)
    planner.save(tmp_path / "problem.json")
    loaded = srmp.PlannerInterface.load(tmp_path / "problem.json")
    np.testing.assert_array_equal(loaded.last_request.start_velocity, velocity)
    assert loaded.last_result.trajectory == found


def test_path_constraints_hold_from_the_instant_on(arm_alone):
    motion = arm_alone.plan("arm", READY, GOAL)
    t = 0.4 * motion.duration
    here = arm_alone.compute_fk("arm", motion.sample(t)).p
    inside = srmp.PathConstraint.box([2.0, 2.0, 2.0], Pose(p=here))
    found = arm_alone.replan(motion, t, BESIDE, constraints=[inside])
    assert found.certificate.constraints[0].deviation <= 1


def test_bad_arguments(planner, timing):
    motion = planner.plan("arm", READY, GOAL)
    path = srmp.Trajectory(motion.joint_names, motion.positions)
    other = srmp.Trajectory([f"x{i}" for i in range(7)], motion.positions, motion.times, motion.velocities)
    calls = [lambda *a: planner.stop(*a), lambda *a: planner.replan(*a, BEHIND)]
    for call in calls:
        for t in (-0.1, motion.duration + 0.1, np.nan, np.inf):
            with pytest.raises(srmp.InvalidArgument, match=r"t is .* s; the motion lasts from 0 to"):
                call(motion, t)
        with pytest.raises(srmp.InvalidArgument, match="has no times"):
            call(path, 0.0)
        with pytest.raises(srmp.InvalidArgument, match="the trajectory has the joints 'x0'"):
            call(other, 0.0)
        with pytest.raises(srmp.InvalidArgument, match="did you mean 'arm'"):
            call("arn", motion, 0.1)
    for values, sentence in (
        ([1.0], "has 1 values"),
        ([np.nan] * 7, "nan|finite"),
        ([100.0] + [0.0] * 6, "the start velocity is 100; its limit is"),
        ("fast", "numbers"),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            planner.plan("arm", READY, GOAL, start_velocity=values)
    for values, sentence in (([1.0], "has 1 values"), ([np.inf] * 7, "inf|finite")):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            planner.plan("arm", READY, GOAL, start_velocity=[0.1] * 7, start_acceleration=values)
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            planner.verify("arm", motion, start_velocity=values)
    if timing == "ruckig":
        with pytest.raises(srmp.InvalidArgument, match="does not have the direction of start_velocity"):
            planner.plan("arm", READY, GOAL, start_velocity=[0.1] * 7, start_acceleration=[1.0] + [0.0] * 6)
    planner.make_planner("arm", {"planner_id": "auto", "timing": "none"})
    for call in (
        lambda: planner.stop(motion, 0.1),
        lambda: planner.replan(motion, 0.1, BEHIND),
        lambda: planner.plan("arm", READY, GOAL, start_velocity=[0.1] * 7),
    ):
        with pytest.raises(srmp.InvalidArgument, match="timing is 'none'"):
            call()


def test_a_slice_that_ends_in_motion_is_too_short(planner):
    motion = planner.plan("arm", READY, GOAL)
    part = motion.slice(0, 0.55 * motion.duration)
    with pytest.raises(srmp.InvalidArgument, match="ends before the robot can stop"):
        planner.stop(part, 0.54 * motion.duration)
