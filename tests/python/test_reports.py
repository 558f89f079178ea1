"""What certificates, statistics and distances say is true of what a user does with them."""

import math

import numpy as np
import pytest

import srmp


def joint_goal(q):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


@pytest.fixture
def arm(arm_alone):
    planner = arm_alone
    planner.add_box("post", size=[0.1, 0.1, 0.8], pose=srmp.Pose(p=[0.3, 0, 0.4]))
    planner.make_planner("arm", {"planner_id": "auto"})
    return planner


@pytest.fixture
def ends(arm):
    ready = arm.get_group_states("arm")["ready"]
    turn = np.array([0.9, 0, 0, 0, 0, 0, 0])
    return ready + turn, ready - turn


@pytest.fixture
def plan(arm, ends):
    return arm.plan("arm", ends[0], joint_goal(ends[1]))


def kinds(certificate):
    return {fault.kind for fault in certificate.faults}


# --- jerk


def test_accelerations_that_jump_have_an_unbounded_jerk(arm, ends, plan):
    assert plan.certificate.holds
    assert plan.certificate.jerk.fraction == math.inf
    assert "jerks          unbounded (" in plan.certificate.report()
    strict = arm.verify("arm", plan, jerk=True)
    assert kinds(strict) == {srmp.FaultKind.jerk_limit}
    assert "the acceleration jumps at 0 s" in strict.faults[0].text
    arm.make_planner("arm", {"planner_id": "auto", "timing": "ruckig"})
    smooth = arm.plan("arm", ends[0], joint_goal(ends[1]))
    assert 0.5 < smooth.certificate.jerk.fraction <= 1 + 1e-6
    assert arm.verify("arm", smooth, jerk=True).holds


@pytest.mark.parametrize("scaling", [1.0, 0.3, 0.1, 0.03, 0.01])
def test_slow_motions_with_limited_jerk_stay_jerk_limited(arm, ends, scaling):
    arm.make_planner("arm", {"planner_id": "auto", "timing": "ruckig", "velocity_scaling": scaling})
    smooth = arm.plan("arm", ends[0], joint_goal(ends[1]))
    assert smooth.certificate.jerk.fraction <= 1 + 1e-6
    assert arm.verify("arm", smooth.slice(0.1, 0.5 * smooth.duration), jerk=True, at_rest=False).holds


# --- parts


def test_a_slice_in_motion_can_be_verified(arm, plan):
    part = plan.slice(0.3 * plan.duration, 0.6 * plan.duration)
    assert kinds(arm.verify("arm", part)) == {srmp.FaultKind.not_at_rest}
    certificate = arm.verify("arm", part, at_rest=False)
    assert certificate.holds
    assert certificate.proved_free
    assert srmp.verify(arm, part, at_rest=False).holds


def test_parts_keep_their_certificate(arm, plan):
    for begin, end in ((0.0, 0.5), (0.2, 0.3), (0.4, 1.0)):
        part = plan.slice(begin * plan.duration, end * plan.duration)
        kept, again = part.certificate, arm.verify("arm", part, at_rest=False)
        assert kept.holds
        assert kept.proved_free
        assert kept.velocity == again.velocity
        assert kept.acceleration == again.acceleration
        assert kept.position == again.position
        assert kept.clearance_proved <= kept.clearance <= again.clearance + 1e-5
        assert math.isnan(kept.deviation)
        assert kept.report().count("\n") == again.report().count("\n") - len(again.faults)
    rows = plan[3:10]
    assert rows.certificate.velocity == arm.verify("arm", rows, at_rest=False).velocity


def test_joins_keep_their_certificate(arm, ends, plan):
    cut = 0.37 * plan.duration
    whole = (plan.slice(0, cut) + plan.slice(cut, plan.duration)).certificate
    assert whole.proved_free
    assert whole.velocity.fraction == pytest.approx(plan.certificate.velocity.fraction)
    assert whole.clearance_proved == plan.certificate.clearance_proved
    back = arm.plan("arm", ends[1], joint_goal(ends[0]))
    both, again = plan + back, arm.verify("arm", plan + back)
    assert both.certificate.proved_free
    assert both.certificate.clearance == min(plan.certificate.clearance, back.certificate.clearance)
    assert both.certificate.velocity.fraction == again.velocity.fraction
    assert both.certificate.deviation == pytest.approx(again.deviation)
    arm.set_motion_limits("arm", velocity=0.5)
    slow = arm.plan("arm", ends[1], joint_goal(ends[0]))
    assert (plan + slow).certificate is None  # other limits


# --- even rows


@pytest.mark.parametrize("dt", [0.002, 0.01, 0.05, 0.2])
def test_even_rows_keep_the_limits(arm, plan, dt):
    limits = arm.motion_limits("arm")
    even = plan.resample(dt, limits)
    np.testing.assert_allclose(np.diff(even.times), dt, rtol=1e-9)
    assert even.times[0] == plan.times[0]
    np.testing.assert_array_equal(even.positions[[0, -1]], plan.positions[[0, -1]])
    assert even.certificate.holds
    assert not kinds(arm.verify("arm", even)) - {srmp.FaultKind.collision}
    assert plan.duration <= even.duration * (1 + 1e-9) <= 1.5 * plan.duration + 2 * dt
    with pytest.raises(srmp.InvalidArgument, match="velocity limits"):
        plan.resample(dt, srmp.MotionLimits([1], [1], [1]))


def test_resampling_says_where_it_exceeds_limits(arm, plan):
    for dt in (0.005, 0.05, 0.3):
        said, again = plan.resample(dt).certificate, arm.verify("arm", plan.resample(dt))
        assert not said.proved_free
        limits = {srmp.FaultKind.velocity_limit, srmp.FaultKind.acceleration_limit}
        assert kinds(said) & limits == kinds(again) & limits
        assert said.acceleration == again.acceleration
    assert srmp.FaultKind.acceleration_limit in kinds(plan.resample(0.05).certificate)


# --- the base


@pytest.mark.parametrize("gap", [1e-3, 3e-5, 0.0, -5e-6])
def test_the_fixed_base_counts_in_distances_unless_it_stands_on_something(arm_alone, gap):
    planner = arm_alone
    ready = planner.get_group_states("arm")["ready"]
    alone = planner.distance_to_collision("arm", ready)
    planner.add_box("floor", size=[3, 3, 0.1], pose=srmp.Pose(p=[0, 0, -0.05 - gap]))
    checker = planner.collision_checker("arm")
    pair, distance = planner.nearest("arm", ready), planner.distance_to_collision("arm", ready)
    assert not planner.is_state_colliding("arm", ready)
    assert distance == pair.distance
    assert checker.clearance([ready])[0] == checker.nearest(ready).distance > 0.001  # of what moves
    if gap > 1e-5:
        assert distance == pytest.approx(gap, abs=2e-6)
        assert (pair.body_a, pair.body_b) == ("arm7_base", "floor")
    else:
        assert distance > 0.001
        assert distance <= alone


# --- files and counts


def test_verify_says_what_the_constructor_refuses(arm, plan, tmp_path):
    path = tmp_path / "motion.json"
    plan.save(path)
    text = path.read_text()
    assert '"waypoints"' in text

    def reported(change):
        import json

        content = json.loads(text)
        change(content)
        path.write_text(json.dumps(content))
        try:
            return {fault.kind for fault in arm.verify("arm", srmp.Trajectory.load(path)).faults}
        except srmp.FileError:
            return {"refused"}

    assert reported(lambda c: None) == set()
    nan = lambda c: c["waypoints"][0].__setitem__(0, "nan")  # noqa: E731
    assert reported(nan) in ({srmp.FaultKind.not_finite}, {"refused"})
    assert reported(lambda c: c.update(velocities=[])) in ({srmp.FaultKind.shape}, {"refused"})
    assert reported(lambda c: c["joint_names"].__setitem__(1, c["joint_names"][0])) in (
        {srmp.FaultKind.joint_names},
        {"refused"},
    )


def test_samples_are_no_expansions(arm, ends):
    arm.make_planner("arm", {"planner_id": "RRTConnect"})
    arm.plan("arm", ends[0], joint_goal(ends[1]))
    stats = arm.get_planning_stats()
    assert stats["expansions"] == 0
    assert stats["samples"] > 0
    arm.make_planner("arm", {"planner_id": "wAstar"})
    arm.plan("arm", ends[0], joint_goal(ends[1]))
    stats = arm.get_planning_stats()
    assert stats["expansions"] > 0
    assert stats["samples"] == 0
