"""plan_many: many plans at once, each as if it were alone."""

import signal
import threading
import time

import numpy as np
import pytest

import srmp

THREADS = (1, 2, 4)


def goal(q):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


def mirrored(q):
    return np.concatenate([[-q[0]], q[1:]])


@pytest.fixture
def requests(arm, ready):
    there = mirrored(ready)
    return [
        srmp.PlanRequest("arm", ready, goal(there)),
        srmp.PlanRequest("arm", there, goal(ready), srmp.Auto()),
        srmp.PlanRequest("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose([5, 0, 0]))),  # out of reach
        srmp.PlanRequest("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSE, arm.compute_fk("arm", there))),
        srmp.PlanRequest("arm", ready, [goal(there), goal(ready + 0.1)], {"planner_id": "wPASE", "num_threads": 2}),
    ]


def alone(planner, request):
    """The trajectory's bytes, or why there is none."""
    planner.make_planner("arm", request.options or srmp.WAStar(time_limit=10))
    try:
        return planner.plan(request.robot, request.start, request.goals).positions.tobytes()
    except srmp.PlanningError as error:
        return error.status, str(error)


def test_every_result_is_what_plan_alone_finds(arm, requests):
    together = [arm.plan_many(requests, threads) for threads in THREADS]
    for i, request in enumerate(requests):
        expected = alone(arm, request)
        for results in together:
            assert len(results) == len(requests)
            result = results[i]
            found = result.trajectory.positions.tobytes() if result.solved else (result.status, result.reason)
            assert found == expected
            assert result.statistics["expansions"] == arm.get_planning_stats()["expansions"]


def test_a_failed_request_says_why_and_disturbs_nobody(arm, requests):
    results = arm.plan_many(requests)
    assert [result.solved for result in results] == [True, True, False, True, True]
    failed = results[2]
    assert failed.status == srmp.Status.goal_invalid == failed.statistics["status"]
    with pytest.raises(srmp.PlanningError, match="no configuration within the joint limits") as error:
        _ = failed.trajectory
    assert error.value.status == failed.status
    assert error.value.statistics == failed.statistics
    assert str(error.value) == failed.reason
    assert repr(failed) == f"PlanResult(goal_invalid: {failed.reason})"


def test_progress_feeds_a_bar(arm, requests):
    seen = []
    main = threading.get_ident()
    arm.plan_many(requests, 2, progress=lambda done, total: seen.append((done, total, threading.get_ident() == main)))
    assert seen[-1] == (5, 5, True)
    assert seen == sorted(set(seen))


def test_what_progress_raises_stops_all(arm, requests):
    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        arm.plan_many(requests * 20, 2, progress=stop)
    assert all(result.solved for result in arm.plan_many(requests[:2], 2))


def hard(request, time_limit):
    return srmp.PlanRequest(
        request.robot, request.start, request.goals, srmp.AStar(resolution=2, time_limit=time_limit)
    )


def test_ctrl_c_stops_all(arm, requests):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
        began = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            arm.plan_many([hard(requests[0], 60)] * 6, 2)
        assert time.perf_counter() - began < 30
    finally:
        signal.signal(signal.SIGINT, before)


def test_time_limits_are_per_request_and_the_gil_is_released(arm, requests):
    """Three that use up their limit and one that does not; another Python thread goes on meanwhile."""
    ticks, over = [], threading.Event()

    def tick():
        while not over.wait(0.02):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    results = arm.plan_many([hard(requests[0], 0.4)] * 3 + requests[:1], 1)
    over.set()
    thread.join()
    assert [result.status.name for result in results] == ["timed_out"] * 3 + ["solved"]
    assert all(result.statistics["total_time_s"] >= 0.4 for result in results[:3])
    assert len(ticks) > 5


NAN = float("nan")
REFUSED = [
    (lambda p, r: p.plan_many(r, 0), "threads is 0; it must be at least 1"),
    (lambda p, r: p.plan_many(r, -1), "threads is -1"),
    (lambda p, r: srmp.PlanRequest("arm", "left", goal([0] * 7)), "start of 'arm' must be numbers"),
    (lambda p, r: srmp.PlanRequest("arm", [0] * 7, "ready"), "a request knows no joints and states of .arm."),
    (lambda p, r: srmp.PlanRequest("arm", [0] * 7, r[0].goals, {"planner_id": "wAstr"}), "did you mean 'wAstar'"),
    (lambda p, r: p.plan_many([*r, srmp.PlanRequest("amr", r[0].start, r[0].goals)]), "request 5: .*'amr'.*mean 'arm'"),
    (lambda p, r: p.plan_many([r[0], srmp.PlanRequest("arm", [0] * 6, r[0].goals)]), "request 1: start of 'arm'.*7"),
    (lambda p, r: p.plan_many([srmp.PlanRequest("arm", [NAN] * 7, r[0].goals)]), "request 0: .*NaN"),
    (lambda p, r: p.plan_many([srmp.PlanRequest("arm", r[0].start, goal([0] * 8))]), "request 0: goal of 'arm' has 8"),
]


@pytest.mark.parametrize(("call", "sentence"), REFUSED)
def test_wrong_requests_are_refused(arm, requests, call, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        call(arm, requests)


def test_a_request_without_a_planner_is_planned_by_auto(ready):
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_path=srmp.data_path("arm7.srdf"), name="arm")
    own, named = planner.plan_many([srmp.PlanRequest("arm", ready, goal(ready + 0.1), o) for o in (None, srmp.Auto())])
    assert own.solved
    assert (own.trajectory.positions == named.trajectory.positions).all()
    with pytest.raises(srmp.NotSupported, match="request 1: xECBS"):
        planner.plan_many([srmp.PlanRequest("arm", ready, goal(ready + 0.1), o) for o in (srmp.Auto(), srmp.XECBS())])
