"""What users hold can be pickled, copied and sent to other processes, and is equal afterwards."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import srmp


def goal(q):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


@pytest.fixture
def values(arm, ready):
    """One of each; in pairs of two that are not equal."""
    there, blocked = ready + 0.1, np.concatenate([[0], ready[1:]])
    requests = [srmp.PlanRequest("arm", ready, goal(q), o) for q, o in ((there, srmp.Auto()), (blocked, None))]
    results = arm.plan_many([*requests, srmp.PlanRequest("arm", ready, goal(ready + 0.05))])
    checker = arm.collision_checker("arm")
    return {
        "pose": (srmp.Pose([1, 2, 3], [0, 0, 1, 1]), srmp.Pose()),
        "goal": (goal([ready, there]), srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose())),
        "trajectory": (results[0].trajectory, results[2].trajectory),
        "statistics": (results[0].statistics, results[1].statistics),
        "status": (srmp.Status.solved, srmp.Status.exhausted),
        "options": (srmp.WAStar(weight=3), srmp.MHAStar(w1=2)),
        "contact": (arm.nearest("arm", ready), arm.nearest("arm", blocked)),
        "certificate": (checker.certify_motion(ready, there), checker.certify_motion(ready, blocked)),
        "request": tuple(requests),
        "result": tuple(results[:2]),
    }


def same(value):
    return value


def again(value):
    return [pickle.loads(pickle.dumps(value)), copy.copy(value), copy.deepcopy(value)]


def test_pickles_and_copies_are_equal_and_others_are_not(values):
    for name, (one, other) in values.items():
        for copied in again(one):
            assert copied == one, name
            assert type(copied) is type(one), name
            assert copied != other, name
            assert copied != "something else", name


def many(ready):
    """A request to plan_multi, its result and the motions in it."""
    world = srmp.PlannerInterface()
    for name, x in (("one", 0), ("other", 3)):
        urdf, srdf = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf")
        world.add_articulation(urdf, srdf, name, "arm7_hand", base_pose=srmp.Pose([x, 0, 0]))
    world.make_planner(["one", "other"], {"planner_id": "xECBS"})
    motions = world.plan_multi({"one": ready, "other": ready}, {"one": goal(ready + 0.1)})
    return [world.last_request, world.last_result, motions, world.motion_limits("one")]


def everything(values, ready):
    certificate = values["trajectory"][0].certificate
    parts = [certificate, certificate.position]
    kept = [value for name, (value, _) in values.items() if name not in ("statistics", "status", "options")]
    return [*kept, *many(ready), *parts]


def test_nothing_equals_none(values, ready):
    for value in everything(values, ready):
        assert value.__eq__(None) is False
        assert value != None  # noqa: E711
        assert value not in [None, 1, "x"]
        unready = type(value).__new__(type(value))
        assert value != unready


def test_broken_states_are_refused(values, ready):
    for value in everything(values, ready):
        kind, state = type(value), value.__getstate__()
        wrong = "this is not the pickled state of a " + kind.__name__
        for broken, why in [
            ((), f"{wrong}: it ends too early"),
            (state[:-1], f"{wrong}: it ends too early"),
            ((*state, 1), f"{wrong}: it has more entries than are known"),
            ((object(),) * len(state), r"^\w"),
        ]:
            with pytest.raises(srmp.InvalidArgument, match=why):
                kind.__new__(kind).__setstate__(broken)


def test_a_copy_lives_on_its_own(values):
    trajectory = copy.deepcopy(values["trajectory"][0])
    expected = values["trajectory"][0].positions.copy()
    values.clear()
    np.testing.assert_array_equal(trajectory.positions, expected)


def test_planning_errors_keep_status_and_statistics(arm, ready):
    with pytest.raises(srmp.PlanningError) as caught:
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose([5, 0, 0])))
    error = caught.value
    assert error.statistics == arm.get_planning_stats()
    for copied in again(error):
        assert type(copied) is srmp.PlanningError
        assert (str(copied), copied.status, copied.statistics) == (str(error), error.status, error.statistics)


@pytest.mark.parametrize("kind", ["InvalidArgument", "UnknownRobot", "FileError", "NotSupported", "Error"])
def test_other_errors_pickle(kind):
    error = getattr(srmp, kind)("what was wrong")
    assert [(type(e), str(e)) for e in again(error)] == [(type(error), "what was wrong")] * 3


def test_values_travel_to_another_process_and_back(values):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        sent = [pair[0] for pair in values.values()]
        assert pool.map(same, sent) == sent


def test_values_have_no_hash(values):
    for name in ("pose", "goal", "trajectory", "contact", "certificate", "request", "result"):
        with pytest.raises(TypeError, match="unhashable"):
            hash(values[name][0])
