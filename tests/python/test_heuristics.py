"""Heuristics of the user's own, in Python."""

import gc
import threading
import weakref

import numpy as np
import pytest

import srmp


def distance(configurations, goals):
    """What joint_euclidean says where no joint goes all the way round."""
    return np.linalg.norm(configurations[:, None] - goals[None], axis=2).min(axis=1)


def goal_from(ready, turn=-1.8):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, np.add(ready, [turn, 0, 0, 0, 0, 0, 0]))


PLANNERS = [
    srmp.Auto(heuristic="mine"),
    srmp.WAStar(heuristic="mine"),
    srmp.ARAStar(heuristic="mine", final_weight=40),
    srmp.MHAStar(inadmissible_heuristics=["mine", "bfs(0.1)"]),
    srmp.WPASE(heuristic="mine", num_threads=2),
]


@pytest.mark.parametrize("options", PLANNERS, ids=lambda options: options.planner_id)
def test_every_planner_takes_it_in_batches(arm, ready, options):
    shapes = []

    def mine(configurations, goals):
        shapes.append((configurations.shape, goals.shape, configurations.dtype))
        return distance(configurations, goals)

    arm.add_heuristic("mine", mine)
    assert arm.heuristic_names == ["mine"]
    arm.make_planner("arm", options)
    path = arm.plan("arm", ready, goal_from(ready)).waypoints
    assert all(q == (q[0], 7) and g == (1, 7) and t == np.float64 for q, g, t in shapes)
    assert max(q[0] for q, _, _ in shapes) > 3
    assert np.array_equal(path, arm.plan("arm", ready, goal_from(ready)).waypoints)


def test_bounds_hold_only_on_the_user_s_word(arm, ready):
    arm.add_heuristic("guess", distance)
    arm.add_heuristic("law", distance, consistent=True)
    bounds = {}
    for name in arm.heuristic_names:
        arm.make_planner("arm", srmp.WAStar(heuristic=name))
        arm.plan("arm", ready, goal_from(ready))
        bounds[name] = arm.get_planning_stats()["bound"]
    assert bounds["guess"] == np.inf
    assert bounds["law"] <= 50


WRONG = [
    (lambda q, g: -np.ones(len(q)), r"heuristic 'bad' is -1 at \[.*\]; it must be finite and at least 0"),
    (lambda q, g: np.full(len(q), np.nan), "heuristic 'bad' is NaN at"),
    (lambda q, g: np.zeros(len(q) + 2), "heuristic 'bad' returned 3 values for 1 configurations"),
    (lambda q, g: np.zeros((len(q), 1)), "values of heuristic 'bad' must be one row of numbers"),
    (lambda q, g: "far", "values of heuristic 'bad' must be numbers"),
]


@pytest.mark.parametrize(("function", "sentence"), WRONG)
def test_wrong_values_are_refused(arm, ready, function, sentence):
    arm.add_heuristic("bad", function)
    arm.make_planner("arm", srmp.WAStar(heuristic="bad"))
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        arm.plan("arm", ready, goal_from(ready))


def test_wrong_names_are_refused(arm):
    arm.add_heuristic("mine", distance)
    for name, sentence in [
        ("mine", "there is a heuristic 'mine' already"),
        ("bfs", "there is a heuristic 'bfs' already"),
        ("", "must not be empty"),
        ("a b", "spaces, commas or brackets"),
    ]:
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            arm.add_heuristic(name, distance)
    with pytest.raises(TypeError):
        arm.add_heuristic("number", 7)
    with pytest.raises(srmp.InvalidArgument, match=r"heuristic 'bfs\(0\)': between the brackets"):
        arm.make_planner("arm", srmp.WAStar(heuristic="bfs(0)"))
    arm.remove_heuristic("mine")
    with pytest.raises(srmp.InvalidArgument, match="no heuristic 'mine'"):
        arm.remove_heuristic("mine")
    with pytest.raises(srmp.InvalidArgument, match="'inadmissible_heuristics' is 'mine'"):
        arm.make_planner("arm", srmp.MHAStar(inadmissible_heuristics=["mine"]))
    assert arm.heuristic_names == []


def test_what_it_raises_ends_the_plan(arm, ready):
    def broken(configurations, goals):
        raise ZeroDivisionError("no such thing")

    arm.add_heuristic("broken", broken)
    arm.make_planner("arm", srmp.WAStar(heuristic="broken"))
    with pytest.raises(ZeroDivisionError, match="no such thing"):
        arm.plan("arm", ready, goal_from(ready))
    with pytest.raises(ZeroDivisionError, match="no such thing"):
        arm.plan_many([srmp.PlanRequest("arm", ready, goal_from(ready))] * 3, threads=2)
    arm.make_planner("arm", srmp.WAStar())
    arm.plan("arm", ready, goal_from(ready))


def test_it_must_not_use_its_own_planner(arm, ready):
    arm.add_heuristic("loop", lambda q, g: [arm.compute_fk("arm", x).p[2] for x in q])
    arm.make_planner("arm", srmp.WAStar(heuristic="loop"))
    with pytest.raises(srmp.Error, match="is planning"):
        arm.plan("arm", ready, goal_from(ready))


def test_many_plans_share_it(arm, ready):
    threads = set()

    def mine(configurations, goals):
        threads.add(threading.get_ident())
        return distance(configurations, goals)

    arm.add_heuristic("mine", mine)
    requests = [
        srmp.PlanRequest("arm", ready, goal_from(ready, turn), options)
        for turn in (-1.8, -0.5)
        for options in (srmp.WAStar(heuristic="mine"), srmp.MHAStar(inadmissible_heuristics=["mine"]))
    ]
    alone = [r.trajectory.waypoints for r in arm.plan_many(requests, threads=1)]
    assert threads == {threading.get_ident()}
    threads.clear()
    for n in (2, 4):
        others = [r.trajectory.waypoints for r in arm.plan_many(requests, threads=n)]
        assert all(np.array_equal(a, b) for a, b in zip(alone, others, strict=True))
    assert threading.get_ident() not in threads


def test_planner_and_function_go_together(arm):
    class Mine:
        def __init__(self, planner):
            self.planner = planner

        def __call__(self, configurations, goals):
            return distance(configurations, goals)

    planner = srmp.PlannerInterface()
    mine = Mine(planner)
    planner.add_heuristic("mine", mine)
    gone = weakref.ref(mine)
    del mine
    gc.collect()
    assert gone() is not None
    del planner
    gc.collect()
    assert gone() is None

    arm.add_heuristic("mine", distance)
    arm.reset()
    assert arm.heuristic_names == []
