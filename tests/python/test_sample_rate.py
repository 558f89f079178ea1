"""The option sample_rate: rows at even times, within all limits and proved, and what it is refused with."""

import numpy as np
import pytest

import srmp
from srmp import Pose

READY = [0.0, -0.5, 0.0, -1.8, 0.0, 1.2, 0.0]
GOAL = np.add(READY, [1.5, 0.2, 0, 0.4, 0, 0.3, 0])


def make(planner, timing="toppra", rate=500, **options):
    planner.make_planner("arm", {"planner_id": "auto", "timing": timing, "sample_rate": rate} | options)


def assert_even(motion, rate):
    np.testing.assert_allclose(motion.times, np.arange(len(motion)) / rate, rtol=0, atol=1e-12)


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
@pytest.mark.parametrize("rate", [50, 250.5, 500, 1000])
def test_rows_are_even_and_keep_the_limits(arm_alone, timing, rate):
    arm_alone.add_box("post", [0.1, 0.1, 0.8], Pose(p=[0.45, 0.35, 0.4]))
    make(arm_alone, timing, 0)
    before = arm_alone.plan("arm", READY, GOAL)
    make(arm_alone, timing, rate)
    motion = arm_alone.plan("arm", READY, GOAL)
    assert_even(motion, rate)
    assert motion.certificate.holds
    assert motion.certificate.proved_free
    assert arm_alone.verify("arm", motion, start=READY, goals=GOAL, jerk=timing == "ruckig").holds
    np.testing.assert_array_equal(motion.positions[[0, -1]], before.positions[[0, -1]])
    np.testing.assert_array_equal(motion.velocities[[0, -1]], 0)
    assert before.duration < motion.duration < 1.001 * before.duration + 3 / rate
    # Accelerations of polynomials that follow one another are the same: no jump, with TOPP-RA neither.
    times = motion.times[1:-1]
    limits = arm_alone.motion_limits("arm")
    jumps = motion.state(times + 1e-9)[2] - motion.state(times - 1e-9)[2]
    assert (np.abs(jumps) <= 1e-4 * limits.acceleration).all()
    assert np.isfinite(motion.certificate.jerk.fraction)


def test_controllers_that_read_rows_alone_see_the_limits(arm_alone):
    make(arm_alone, "ruckig", 500)
    motion, limits = arm_alone.plan("arm", READY, GOAL), arm_alone.motion_limits("arm")
    rate = np.diff(motion.positions, axis=0) * 500
    assert (np.abs(rate) <= limits.velocity * (1 + 1e-6)).all()
    assert (np.abs(np.diff(rate, axis=0)) * 500 <= limits.acceleration * (1 + 1e-6)).all()
    assert (np.abs(np.diff(rate, 2, axis=0)) * 500**2 <= limits.jerk * (1 + 1e-6)).all()


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
def test_motions_along_poses_and_sequences(arm_alone, timing):
    make(arm_alone, timing)
    here = arm_alone.compute_fk("arm", READY)
    line = arm_alone.plan_linear("arm", READY, Pose(p=np.add(here.p, [0, 0.2, 0]), q=here.q))
    assert_even(line, 500)
    assert line.certificate.holds
    assert line.certificate.cartesian_deviation.position <= 1e-3
    steps = [srmp.Segment.move(GOAL), srmp.Segment.wait(0.1234), srmp.Segment.move(READY)]
    result = arm_alone.plan_sequence("arm", READY, steps)
    assert_even(result.trajectory, 500)
    wait = result.parts[1]
    assert wait.end - wait.begin == pytest.approx(0.124)


def test_robots_together(arm_alone):
    arm_alone.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"), srdf_path=srmp.data_path("arm7.srdf"), name="other",
        end_effector="arm7_hand", base_pose=Pose(p=[0.0, 0.6, 0.0]),
    )  # fmt: skip
    options = {"planner_id": "auto", "sample_rate": 250}
    arm_alone.make_planner(["arm", "other"], options)
    goal = np.add(READY, [0, 0.2, 0, 0.2, 0, 0, 0.5])
    starts, goals = {"arm": READY, "other": READY}, {"arm": goal, "other": goal}
    motions = arm_alone.plan_multi(starts, goals)
    for motion in motions.values():
        assert_even(motion, 250)
        assert motion.certificate.proved_free
    arm_alone.make_planner("arm", options)
    with pytest.raises(srmp.NotSupported, match="'sample_rate' is 250 Hz, but a motion that waits for moving"):
        arm_alone.plan_multi({"arm": READY}, {"arm": goal}, {"other": motions["other"]})


def test_a_robot_that_is_there_already(arm_alone):
    make(arm_alone)
    assert arm_alone.plan("arm", READY, READY).times.tolist() == [0]


def test_what_it_is_refused_with(arm_alone):
    motion = arm_alone.plan("arm", READY, GOAL)
    make(arm_alone)
    t = motion.duration / 2
    for call in (
        lambda: arm_alone.stop(motion, t),
        lambda: arm_alone.replan(motion, t, READY),
        lambda: arm_alone.plan("arm", motion.sample(t), READY, start_velocity=motion.state(t)[1]),
    ):
        with pytest.raises(srmp.NotSupported, match=r"'sample_rate' is 500 Hz, but .* has no even rows"):
            call()


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"sample_rate": -1}, "sample_rate"),
        ({"sample_rate": np.nan}, "sample_rate"),
        ({"sample_rate": np.inf}, "sample_rate"),
        ({"sample_rate": "fast"}, "sample_rate"),
        ({"sample_rate": 500, "sample_period": 0.01}, "'sample_period' and 'sample_rate' are both given"),
        ({"sample_rate": 500, "timing": "none"}, "a path without times has no 'sample_rate'"),
    ],
)
def test_bad_options_are_refused(arm_alone, options, text):
    with pytest.raises(srmp.InvalidArgument, match=text):
        arm_alone.make_planner("arm", {"planner_id": "auto"} | options)


def test_too_many_rows_are_refused(arm_alone):
    make(arm_alone, rate=1e6)
    with pytest.raises(srmp.InvalidArgument, match="more than 200000 rows"):
        arm_alone.plan("arm", READY, GOAL)
