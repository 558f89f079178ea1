"""Trajectories: made by hand or by plan, cut, joined, sampled, compared, and drawn."""

import copy
import math
import pickle

import numpy as np
import pytest
from support import NAMES, TIMES, analytic, refuses

import srmp

NAN = math.nan


def certificate(**changes):
    """One as a checker would make it; there is no other way to one than pickling."""
    limits = srmp.MotionLimits([1, 2], [3, 4], [50, 60])
    use = copy_with(srmp.LimitUse, (0.5, "a", 1.0))
    fields = {
        "faults": [],
        "limits": limits,
        "position": use,
        "velocity": use,
        "acceleration": use,
        "jerk": use,
        "collisions_checked": True,
        "checked_from": 0.0,
        "clearance": 0.05,
        "clearance_time": 1.25,
        "body_a": "hand",
        "body_b": "post",
        "clearance_proved": 0.04,
        "sampled": [],
        "deviation": 0.001,
        "deviation_time": 0.5,
        "goal_error": None,
        "bound": math.inf,
        "bound_graph": "lattice",
        "time_s": 0.002,
        "cartesian_deviation": None,
        "constraints": [],
        "clearance_kept": None,
        "link_speeds": [],
        "torque": copy_with(srmp.LimitUse, (0.0, "", 0.0)),
    }
    assert set(changes) <= set(fields)
    return copy_with(srmp.Certificate, tuple({**fields, **changes}.values()))


def copy_with(cls, state):
    value = cls.__new__(cls)
    value.__setstate__(state)
    return value


def with_certificate(trajectory, proof):
    return copy_with(srmp.Trajectory, (*trajectory.__getstate__()[:-1], proof))


# --- making one -------------------------------------------------------------------------------------------------------


def test_a_trajectory_of_ones_own_has_what_it_was_given(cubic):
    position, velocity, acceleration, jerk = analytic(TIMES)
    assert cubic.joint_names == NAMES
    for name, expected in (
        ("positions", position),
        ("velocities", velocity),
        ("accelerations", acceleration),
        ("times", TIMES),
        ("waypoints", position),
    ):
        np.testing.assert_array_equal(getattr(cubic, name), expected)
        with pytest.raises(ValueError, match="read-only"):
            getattr(cubic, name)[0] = 1
    np.testing.assert_allclose(cubic.jerks, jerk, atol=1e-10)
    assert cubic.duration == 2.5
    assert cubic.length == pytest.approx(np.linalg.norm(np.diff(position, axis=0), axis=1).sum())
    assert cubic.certificate is None
    assert len(cubic) == 5
    assert repr(cubic) == "Trajectory(2 joints, 5 rows, 2.5 s)"
    late = srmp.Trajectory(["a"], [[1], [2]], [0, 1.0000000009999894])
    assert repr(late) == "Trajectory(1 joint, 2 rows, 1 s)"


def test_what_is_not_known_has_no_rows(untimed):
    for name in ("velocities", "accelerations", "jerks"):
        assert getattr(untimed, name).shape == (0, 2), name
    assert untimed.times.shape == (0,)
    assert untimed.duration == 0
    assert untimed.length == pytest.approx(2 * math.sqrt(2))
    assert repr(untimed) == "Trajectory(2 joints, 3 rows, no times)"
    assert repr(srmp.Trajectory(["a"], [[1]])) == "Trajectory(1 joint, 1 row, no times)"
    empty = np.zeros((0, 2))
    assert srmp.Trajectory(NAMES, untimed.positions, [], empty, empty, empty) == untimed


def test_arrays_live_as_long_as_they_are_used(cubic):
    positions, times = (
        srmp.Trajectory(NAMES, [[1, 2], [3, 4]], [0, 1]).positions,
        srmp.Trajectory(NAMES, [[1, 2], [3, 4]], [0, 1]).times,
    )
    assert positions.tolist() == [[1, 2], [3, 4]]
    assert times.tolist() == [0, 1]


BAD = [
    ({"joint_names": ["a"]}, r"positions have the shape \(5, 2\), but there are 1 joint names"),
    ({"joint_names": ["a", "a"]}, "joint 'a' is named twice"),
    ({"joint_names": ["a", ""]}, "a joint name is empty"),
    ({"joint_names": []}, "it has no joints"),
    ({"joint_names": [1, 2]}, "joint_names must be text or a list of texts"),
    ({"joint_names": None}, "joint_names must be text or a list of texts"),
    ({"positions": []}, "it has no rows"),
    ({"positions": [1, 2]}, r"positions must have the shape \(n, 2\), not \(2,\)"),
    ({"positions": np.zeros((2, 2, 2))}, r"positions must have the shape \(n, 2\), not \(2, 2, 2\)"),
    ({"positions": "x"}, "positions must be numbers, but is 'x'"),
    ({"positions": [[1, 2], [3]]}, "positions must be numbers"),
    ({"positions": [[1, 2], [3, NAN], [1, 1], [1, 1], [1, 1]]}, "positions, row 1: b is NaN"),
    ({"times": [0, 1]}, "it has 5 rows, but 2 times"),
    ({"times": [[0, 1, 2, 3, 4]]}, "times must be one row of numbers"),
    ({"times": [0, 1, 2, 2, 3]}, "times must increase, but row 3 is at 2 s, after 2 s"),
    ({"times": [0, 1, 2, 1.5, 3]}, "times must increase, but row 3 is at 1.5 s, after 2 s"),
    ({"times": [0, 1, 2, 3, NAN]}, "the time of row 4 is NaN"),
    ({"times": [0, 1e-310, 1, 2, 3]}, "too little for the motion of a between them"),
    ({"times": None}, "it has velocities, but no times"),
    ({"velocities": np.zeros((4, 2))}, r"velocities have the shape \(4, 2\), but positions \(5, 2\)"),
    ({"velocities": np.full((5, 2), math.inf)}, "velocities, row 0: a is infinity"),
    ({"velocities": None}, "it has accelerations, but no velocities"),
    ({"accelerations": np.zeros((5, 3))}, r"accelerations have the shape \(5, 3\), but positions \(5, 2\)"),
    ({"accelerations": np.full((5, 2), NAN)}, "accelerations, row 0: a is NaN"),
    ({"waypoints": np.zeros((3, 3))}, r"waypoints have the shape \(3, 3\), but there are 2 joint names"),
    ({"waypoints": [[0, NAN]]}, "waypoints, row 0: b is NaN"),
]


@pytest.mark.parametrize(("change", "sentence"), BAD)
def test_what_is_no_trajectory_is_refused(change, sentence):
    position, velocity, acceleration, _ = analytic(TIMES)
    good = {
        "joint_names": NAMES,
        "positions": position,
        "times": TIMES,
        "velocities": velocity,
        "accelerations": acceleration,
    }
    refuses(lambda: srmp.Trajectory(**{**good, **change}), sentence)


# --- the motion -------------------------------------------------------------------------------------------------------


def test_states_are_those_of_the_polynomial(cubic):
    t = np.linspace(0.5, 3, 1001)
    for found, expected in zip(cubic.state(t), analytic(t), strict=True):
        assert found.shape == (1001, 2)
        np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_array_equal(cubic.sample(t), cubic.state(t)[0])
    one = cubic.state(1.7)
    assert isinstance(one, tuple)
    for found, expected in zip(one, analytic(1.7), strict=True):
        assert found.shape == (2,)
        np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_array_equal(cubic.sample(1.7), one[0])


def test_sampling_takes_numbers_and_rows_of_numbers(cubic):
    assert cubic.sample(1).shape == cubic.sample(np.float64(1)).shape == cubic.sample(np.array(1.0)).shape == (2,)
    assert cubic.sample([1]).shape == (1, 2)
    assert cubic.sample([]).shape == (0, 2)
    np.testing.assert_array_equal(cubic.sample(TIMES), cubic.positions)
    np.testing.assert_array_equal(cubic.sample([-1, math.inf]), cubic.positions[[0, -1]])


def test_without_velocities_the_motion_is_straight():
    straight = srmp.Trajectory(NAMES, [[0, 0], [3, 4], [3, 5]], [0, 1, 3])
    np.testing.assert_allclose(straight.sample([0.5, 2]), [[1.5, 2], [3, 4.5]])
    np.testing.assert_allclose(straight.state(2)[1], [0, 0.5])
    assert straight.resample(0.5).velocities.shape == (0, 2)
    np.testing.assert_array_equal(straight.resample(1e9).times, [0, 3])  # both ends, however long the period


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda t: t.sample(NAN), "the time to sample is NaN"),
        (lambda t: t.sample([1, NAN]), "the time to sample is NaN"),
        (lambda t: t.state(NAN), "the time to sample is NaN"),
        (lambda t: t.sample([[1]]), "t must be a number or one row of numbers, but has 2 dimensions"),
        (lambda t: t.sample("x"), "t must be numbers, but is 'x'"),
        (lambda t: t.resample(0), "dt is 0; it must be a finite number above 0"),
        (lambda t: t.resample(NAN), "dt is NaN"),
        (lambda t: t.resample(1e-9), "more than ten million rows"),
        (lambda t: t.slice(2, 1), "a slice from 2 s to 1 s holds nothing of a motion from 0.5 s to 3 s"),
        (lambda t: t.slice(4, 5), "holds nothing"),
        (lambda t: t.slice(NAN, 1), "the begin of the slice is NaN"),
        (lambda t: t[::2], r"trajectory\[::2\] would leave out rows"),
        (lambda t: t[::-1], r"trajectory\[::-1\]"),
        (lambda t: t[3:3], "rows 3 to 3 hold nothing"),
        (lambda t: t[9:], "hold nothing"),
        (lambda t: t[1], r"trajectory\[first:last\]; positions\[i\] is one row"),
        (lambda t: list(t), r"trajectory\[first:last\]"),
        (lambda t: t + t, "another position than this one ends with: a jumps by"),
        (lambda t: t + srmp.Trajectory(["a", "c"], t.positions, TIMES), "the next one moves 'a' and 'c', this one"),
        (lambda t: t + srmp.Trajectory(NAMES, t.positions[-1:], [0]), "one of the two has velocities"),
        (lambda t: t + srmp.Trajectory(NAMES, t.positions[-1:], [0], [[0, 0]]), "another velocity"),
        (lambda t: t + srmp.Trajectory(NAMES, t.positions), "it has no times"),
    ],
)
def test_invalid_arguments_are_refused(cubic, call, sentence):
    refuses(lambda: call(cubic), sentence)


def test_a_path_without_times_cannot_say_when(untimed):
    for call in (
        lambda: untimed.sample(0),
        lambda: untimed.state(0),
        lambda: untimed.resample(1),
        lambda: untimed.slice(0, 1),
        lambda: untimed + untimed,
        untimed.to_joint_trajectory,
    ):
        refuses(call, "times")


def test_only_trajectories_are_added(cubic):
    with pytest.raises(TypeError):
        cubic + 1


def same_motion(a, b, first, last):
    """Away from rows, where accelerations and jerks may jump."""
    t = np.linspace(first, last, 1003)
    t = t[np.abs(t[:, None] - np.append(a.times, b.times)).min(axis=1) > 1e-6]
    for one, other in zip(a.state(t), b.state(t), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7)


def test_parts_are_the_same_motion(cubic, jumpy):
    for t in (cubic, jumpy):
        first, last = t.times[0] + 0.1, t.times[-1] - 0.2
        part = t.slice(first, last)
        np.testing.assert_allclose(part.times[[0, -1]], [first, last], rtol=1e-15)
        same_motion(t, part, first, last)
        np.testing.assert_array_equal(part.waypoints, part.positions)
        rows = t[1:-1]
        for name in ("positions", "velocities", "accelerations", "times"):
            np.testing.assert_array_equal(getattr(rows, name), getattr(t, name)[1:-1])
        same_motion(t, rows, rows.times[0], rows.times[-1])
        assert t[:] == t[-9:9] == t.slice(-math.inf, math.inf) == t
        assert len(t[2:3]) == 1


def test_parts_join_to_the_whole(cubic, jumpy):
    for t in (cubic, jumpy):
        cut = t.times[0] + 0.3 * t.duration
        whole = t.slice(0, cut) + t.slice(cut, 9)
        assert whole.duration == pytest.approx(t.duration)
        same_motion(t, whole, t.times[0], t.times[-1])
        by_rows = t[:3] + t[2:]
        np.testing.assert_array_equal(by_rows.positions, t.positions)
        np.testing.assert_allclose(by_rows.times, t.times, rtol=1e-15)
        assert t[:3].followed_by(t[2:]) == by_rows


def test_resampling_has_a_row_at_every_multiple_and_at_the_end(cubic):
    t = cubic.resample(0.4)
    np.testing.assert_allclose(t.times, [0.5, 0.9, 1.3, 1.7, 2.1, 2.5, 2.9, 3.0])
    np.testing.assert_array_equal(t.positions, cubic.sample(t.times))
    np.testing.assert_array_equal(t.waypoints, cubic.waypoints)


# --- as a value -------------------------------------------------------------------------------------------------------


def test_copies_are_equal_and_others_are_not(any_trajectory):
    for again in (pickle.loads(pickle.dumps(any_trajectory)), copy.copy(any_trajectory), copy.deepcopy(any_trajectory)):
        assert again == any_trajectory
    assert any_trajectory != any_trajectory[1:]
    assert any_trajectory != "something else"


def test_every_array_counts_for_equality(cubic):
    parts = ("joint_names", "positions", "times", "velocities", "accelerations", "waypoints")
    for name in parts:
        arrays = {part: getattr(cubic, part) for part in parts}
        arrays[name] = ["b", "a"] if name == "joint_names" else arrays[name] + 1
        assert srmp.Trajectory(**arrays) != cubic, name


def test_certificates_are_kept_pickled_and_dropped_with_what_they_are_about(cubic):
    proof = certificate()
    t = with_certificate(cubic, proof)
    for same in (t, pickle.loads(pickle.dumps(t)), copy.deepcopy(t), t[:], t.slice(0, 9)):
        assert same.certificate == proof
    for part in (t[1:], t.slice(1, 2), t[:2] + t[1:]):
        assert part.certificate.proved_free
        assert part.certificate.clearance_proved == proof.clearance_proved
    assert not t.resample(0.1).certificate.proved_free
    assert srmp.Trajectory.from_dict(t.to_dict()).certificate is None
    assert t == cubic  # the same motion


def test_certificates_read_as_their_claims():
    proof = certificate()
    assert proof.holds
    assert proof.proved_free
    assert (proof.clearance, proof.body_a, proof.body_b, proof.bound) == (0.05, "hand", "post", math.inf)
    assert math.isnan(proof.goal_error)
    assert (proof.velocity.fraction, proof.velocity.joint, proof.velocity.time) == (0.5, "a", 1.0)
    np.testing.assert_array_equal(proof.limits.acceleration, [3, 4])
    assert "clearance      50 mm, hand and post at 1.25 s" in proof.report()
    assert repr(proof) == "Certificate(holds, proved free)"
    for name in dir(proof):
        if not name.startswith("_"):
            with pytest.raises(AttributeError):
                setattr(proof, name, None)


def test_certificates_name_faults_and_what_is_only_sampled():
    fault = copy_with(srmp.Fault, (srmp.FaultKind.collision, "hand and post touch", None))
    sampled = copy_with(srmp.SampledInterval, (1.0, 2.0, "hand", "post"))
    proof = certificate(faults=[fault], sampled=[sampled])
    assert not proof.holds
    assert not proof.proved_free
    assert proof.faults == [fault]
    assert proof.faults[0].kind is srmp.FaultKind.collision
    assert math.isnan(proof.faults[0].time)
    assert (proof.sampled[0].from_time, proof.sampled[0].to_time, proof.sampled[0].body_b) == (1.0, 2.0, "post")
    assert "FAULT collision: hand and post touch" in proof.report()
    assert repr(proof) == "Certificate(1 fault: hand and post touch)"
    assert repr(fault) == "Fault(collision: hand and post touch)"
    assert repr(sampled) == "SampledInterval(1 s to 2 s, hand and post)"
    assert repr(certificate(sampled=[sampled])) == "Certificate(holds, free; 1 parts at samples)"
    assert repr(certificate(collisions_checked=False)) == "Certificate(holds, collisions not checked)"
    assert repr(proof.velocity) == "LimitUse(0.5, a)"
    assert len(srmp.FaultKind) == 17


def test_certificates_and_their_parts_are_values():
    fault = copy_with(srmp.Fault, (srmp.FaultKind.not_at_rest, "it moves at its end", 3.0))
    sampled = copy_with(srmp.SampledInterval, (1.0, 2.0, "hand", "post"))
    proof = certificate(faults=[fault], sampled=[sampled])
    for value, other in (
        (proof, certificate()),
        (fault, copy_with(srmp.Fault, (srmp.FaultKind.goal, "it moves at its end", 3.0))),
        (sampled, copy_with(srmp.SampledInterval, (1.0, 2.5, "hand", "post"))),
        (proof.limits, srmp.MotionLimits([1, 2], [3, 4], [50, 61])),
        (proof.velocity, copy_with(srmp.LimitUse, (0.5, "b", 1.0))),
        (srmp.FaultKind.not_at_rest, srmp.FaultKind.goal),
    ):
        for again in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
            assert again == value
            assert again != other
    for name, value in (("time_s", 1.0), ("goal_error", 0.1), ("body_b", "table"), ("bound", 2.0)):
        assert certificate(**{name: value}) != certificate(), name
    with pytest.raises(TypeError, match="unhashable"):
        hash(proof)


def test_limits_of_motions():
    limits = srmp.MotionLimits([1, 2], [3, 4], [5, 6], [True, False])
    assert (limits.velocity.tolist(), limits.jerk.tolist(), limits.continuous) == ([1, 2], [5, 6], [True, False])
    assert repr(limits) == "MotionLimits(2 joints)"
    refuses(lambda: srmp.MotionLimits([1, 2], [3], [5, 6]), "acceleration limits: got 1, but there are 2 joints")
    refuses(lambda: srmp.MotionLimits([1, 0], [3, 4], [5, 6]), "joint 1: the velocity limit is 0")
    refuses(lambda: srmp.MotionLimits([1, 2], [3, 4], [5, NAN]), "joint 1: the jerk limit is NaN")
    refuses(lambda: srmp.MotionLimits([1, 2], [3, 4], [5, 6], [True]), "continuous: got 1 flags, but there are 2")
    refuses(lambda: srmp.MotionLimits("fast", [3, 4], [5, 6]), "velocity limits must be numbers")


# --- the end effector -------------------------------------------------------------------------------------------------


@pytest.fixture
def planned(arm, ready):
    arm.set_base_pose("arm", srmp.Pose([0.01, 0, 0]))
    return arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.1))


def test_a_plan_knows_where_its_end_effector_goes(arm, planned):
    tip = planned.end_effector_path()
    np.testing.assert_allclose(tip, [arm.compute_fk("arm", q).p for q in planned.positions], atol=1e-12)
    elbow = planned.end_effector_path(link="arm7_elbow")
    np.testing.assert_allclose(elbow, [arm.compute_fk("arm", q, "arm7_elbow").p for q in planned.positions], atol=1e-12)
    t = np.linspace(planned.times[0], planned.times[-1], 20000)
    fine = np.array([arm.compute_fk("arm", q).p for q in planned.sample(t)])
    assert planned.end_effector_length() == pytest.approx(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum(), rel=1e-4)
    assert 0 < planned.end_effector_length(link="arm7_elbow") < planned.end_effector_length()
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, planned.positions[-1])
    [result] = arm.plan_many([srmp.PlanRequest("arm", planned.positions[0], goal)])
    for t in (result.trajectory, planned[:], planned[:3] + planned[2:]):
        np.testing.assert_allclose(t.end_effector_path(), tip, atol=1e-12)
    np.testing.assert_array_equal(planned[3:5].end_effector_path(), tip[3:5])


def test_other_trajectories_ask_a_planner(arm, planned):
    again = pickle.loads(pickle.dumps(planned))
    refuses(again.end_effector_path, "does not know its robot .* name a planner and a robot")
    refuses(again.end_effector_length, "does not know its robot")
    np.testing.assert_array_equal(again.end_effector_path(arm), planned.end_effector_path())
    assert again.end_effector_length(arm, "arm") == planned.end_effector_length()
    backwards = srmp.Trajectory(planned.joint_names[::-1], planned.positions[:, ::-1])
    np.testing.assert_array_equal(backwards.end_effector_path(arm), planned.end_effector_path())
    arm.set_base_pose("arm", srmp.Pose([0, 0, 1]))
    moved = again.end_effector_path(arm) - planned.end_effector_path()
    np.testing.assert_allclose(moved, np.tile([-0.01, 0, 1], (len(again), 1)), atol=1e-12)


def test_wrong_robots_links_and_planners_are_refused(arm, planned):
    refuses(lambda: planned.end_effector_path(arm, "amr"), "'amr'.*did you mean 'arm'")
    refuses(lambda: planned.end_effector_path(arm, link="arm7_hnad"), "arm7_hnad.*did you mean 'arm7_hand'")
    refuses(lambda: planned.end_effector_length(arm, link="arm7_hnad"), "did you mean 'arm7_hand'")
    refuses(lambda: planned.end_effector_path("arm"), "planner must be a PlannerInterface, but is 'arm'")
    refuses(
        lambda: planned.end_effector_path(srmp.PlannerInterface()), "robot must be named where there is not exactly"
    )
    refuses(lambda: planned.end_effector_path(robot="arm"), "a robot is named, but no planner to find it in")
    arm.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_path=srmp.data_path("arm7.srdf"), name="other")
    refuses(lambda: planned.end_effector_path(arm), "there are 'arm' and 'other'")
    short = srmp.Trajectory(planned.joint_names[:6], planned.positions[:, :6])
    refuses(lambda: short.end_effector_path(arm, "arm"), "does not say where 'arm7_joint7' of robot")
    wrong = srmp.Trajectory([*planned.joint_names[:6], "arm7_jiont7"], planned.positions)
    refuses(lambda: wrong.end_effector_path(arm, "arm"), "'arm7_jiont7', which is no planned joint.*did you mean")


# --- figures ----------------------------------------------------------------------------------------------------------


def test_plots_are_figures(cubic, jumpy, planned, tmp_path):
    pytest.importorskip("matplotlib")
    cubic.plot(tmp_path / "plain.png")
    jumpy.plot(str(tmp_path / "limits.png"), limits=srmp.MotionLimits([1, 2], [30, 40], [500, 600]), title="a title")
    with_certificate(cubic, certificate()).plot(tmp_path / "certificate.svg")
    planned.plot(tmp_path / "planned.png")
    srmp.Trajectory(["a"], [[1]], [0], [[0]]).plot(tmp_path / "one.png")
    for name in ("plain.png", "limits.png", "planned.png", "one.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert "% of 60" in (tmp_path / "certificate.svg").read_text()  # the certificate's limits are drawn


def test_what_cannot_be_drawn_is_refused(cubic, untimed, tmp_path):
    pytest.importorskip("matplotlib")
    refuses(lambda: untimed.plot(tmp_path / "p.png"), "a path without times has no profiles to draw")
    refuses(lambda: cubic.plot(tmp_path / "p.png", limits=5), "limits must be a MotionLimits or None, but is 5")
    one = srmp.MotionLimits([1], [1], [1])
    refuses(lambda: cubic.plot(tmp_path / "p.png", limits=one), "limits are for 1 joints, but the trajectory moves 2")
    refuses(lambda: cubic.plot(tmp_path / "p.xyz"), "p.xyz.*xyz")
    refuses(lambda: cubic.plot(tmp_path / "no" / "p.png"), "p.png cannot be written: No such", srmp.FileError)
