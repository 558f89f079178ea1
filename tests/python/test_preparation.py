"""Covers and tables are computed in the background, or by prepare; no result depends on them."""

import contextlib
import os
import signal
import threading
import time

import numpy as np
import pytest

import srmp
from srmp.bench.scenarios import find


def make_planner() -> srmp.PlannerInterface:
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf"), name="arm", end_effector="arm7_hand"
    )
    planner.add_box("shelf", [0.4, 0.8, 0.03], srmp.Pose(p=[0.6, 0.0, 0.45]))
    planner.add_box("post", [0.05, 0.05, 1.0], srmp.Pose(p=[0.35, 0.3, 0.5]))
    return planner


def plans(planner: srmp.PlannerInterface) -> list[bytes]:
    rng = np.random.default_rng(3)
    limits = np.clip(np.asarray(planner.get_joint_limits("arm"), dtype=float), -2.5, 2.5)
    lower, upper = limits[:, 0], limits[:, 1]
    found = []
    for planner_id in ("auto", "wAstar", "RRTConnect"):
        planner.make_planner("arm", {"planner_id": planner_id, "time_limit": 60})
        for _ in range(6):
            start = rng.uniform(lower, upper)
            goal = np.clip(start + rng.uniform(-0.5, 0.5, len(lower)), lower, upper)
            try:
                trajectory = planner.plan("arm", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
                found.append(trajectory.waypoints.tobytes() + trajectory.times.tobytes())
            except srmp.PlanningError as error:
                found.append(str(error).encode())
    return found


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A prepared planner, the directory of its cache, and what prepare reported."""
    directory = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SRMP_CACHE_DIR", str(directory))
        planner = make_planner()
        calls = []
        planner.prepare(lambda done, total: calls.append((done, total)))
    return planner, directory, calls


def test_plans_before_and_after_preparation_are_the_same(prepared, monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    quick = plans(make_planner())
    planner, directory, _ = prepared
    assert plans(planner) == quick
    monkeypatch.setenv("SRMP_CACHE_DIR", str(directory))
    assert plans(make_planner()) == quick  # from the cache


def plans_together(data: str, prepare: bool) -> list[bytes]:
    scenario = find("shelves", 3, 0, data)
    planner = scenario.world.build()
    if prepare:
        planner.prepare()
    found = []
    for number in (1, 6):
        problem = scenario.problem(number)
        planner.make_planner(list(problem.starts), {"planner_id": "auto", "time_limit": 60})
        goals = {robot: srmp.GoalConstraint(srmp.GoalType.JOINTS, q) for robot, q in problem.goals.items()}
        trajectories = planner.plan_multi(problem.starts, goals)
        found += [trajectories[robot].waypoints.tobytes() for robot in goals]
    return found


def test_plans_of_several_robots_do_not_wait_for_covers(mbm_dir, monkeypatch, tmp_path):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    quick = plans_together(str(mbm_dir), prepare=False)
    monkeypatch.setenv("SRMP_CACHE_DIR", str(tmp_path))
    assert plans_together(str(mbm_dir), prepare=True) == quick


def test_prepare_reports_progress(prepared):
    planner, directory, calls = prepared
    assert calls and all(0 <= done <= total for done, total in calls)
    assert any(path.is_file() for path in directory.rglob("*"))
    again = []
    planner.prepare(lambda done, total: again.append((done, total)))
    assert again == []  # nothing is left to do


def test_an_exception_of_progress_ends_prepare(monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")

    def stop(done, total):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        make_planner().prepare(stop)


def test_ctrl_c_ends_prepare(monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.05, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):
            make_planner().prepare()
            time.sleep(0.001)
    timer.join()
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fork beside threads
def test_a_forked_process_does_not_wait_for_its_parents_covers(monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    planner = make_planner()
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 60})  # begins to prepare in the background

    def stop(done, total):
        raise KeyError("enough")

    for _ in range(4):
        child = os.fork()
        if child == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(30)
            with contextlib.suppress(KeyError):
                planner.prepare(stop)
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        time.sleep(0.5)


def test_planners_may_end_while_they_are_prepared(monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    for _ in range(5):
        planner = make_planner()
        planner.make_planner("arm", {"planner_id": "auto"})
        planner.remove_articulation("arm")
    del planner
