"""A time limit that is not reached changes nothing: the clock stops plans and never steers them.

Plans that end before their limit are compared, so the tests hold on machines of any speed. The full test (40 cases,
beside a process that keeps a core busy) is `python bench/suites/any_limit.py --data DIR`.
"""

from math import pi

import numpy as np
import pytest

import srmp

FACTORS = (1.2, 3, 50)  # of the time that a case needs


@pytest.fixture(scope="module")
def any_limit(suite):
    return suite("any_limit")


@pytest.fixture(scope="module")
def arms():
    """Three of the package's arms around a table."""
    planner = srmp.PlannerInterface()
    for name, x, y, yaw in (("left", 0, 0, 0), ("right", 0.6, 0, pi), ("third", 0.3, -0.7, pi / 2)):
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_path=srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=srmp.Pose.from_rpy([x, y, 0], [0, 0, yaw]),
        )
    planner.add_box("table", size=[3, 3, 0.1], pose=srmp.Pose(p=[0.3, 0, -0.051]))
    return planner


def turned(angle):
    """The hand in front of the arm, which is turned about its base."""
    return np.array([angle, 0, 0, pi / 2, 0, pi / 2, 0])


def assert_one_answer(any_limit, case):
    compared = any_limit.compare(case, FACTORS, repeats=1)
    assert compared is not None
    assert compared.same, f"{case.name}: {compared.limits_of}"


SEVERAL = [
    {"planner_id": "xECBS"},
    {"planner_id": "auto"},
    {"planner_id": "auto", "improve_rounds": 1},
    {"planner_id": "auto", "num_threads": 2},
    {"planner_id": "ECBS"},
    {"planner_id": "Prioritised"},
]


@pytest.mark.parametrize("options", SEVERAL, ids=str)
def test_several_arms(any_limit, arms, options):
    starts = {"left": turned(-0.9), "right": turned(-0.9)}
    goals = {"left": turned(0.9), "right": turned(0.9)}
    assert_one_answer(any_limit, any_limit.several("cross", arms, starts, goals, options))


@pytest.mark.parametrize("number", range(3))
def test_around_a_committed_motion(any_limit, suite, arms, number):
    times, angles, start, end = suite("overshoot").AMONG_COMMITTED[number]
    rows = np.array([turned(angle) for angle in angles])
    motion = srmp.Trajectory(arms.get_joint_names("right"), rows, times, np.zeros(rows.shape))
    case = any_limit.several(
        "committed", arms, {"left": turned(start)}, {"left": turned(end)}, {"planner_id": "xECBS"}, {"right": motion}
    )
    assert_one_answer(any_limit, case)


ONE = [
    {"planner_id": "auto"},
    {"planner_id": "auto", "improve_rounds": 3},
    {"planner_id": "RRTConnect"},
    {"planner_id": "wAstar"},
    {"planner_id": "MHAstar"},
    {"planner_id": "ARAstar", "final_weight": 10.0},
    {"planner_id": "wPASE", "num_threads": 2},
]


@pytest.mark.parametrize("options", ONE, ids=str)
def test_one_arm(any_limit, arm, ready, options):
    problem = srmp.PlanRequest(
        "arm", ready, [srmp.GoalConstraint(srmp.GoalType.JOINTS, ready - [1.8, 0, 0, 0, 0, 0, 0])]
    )
    assert_one_answer(any_limit, any_limit.single(arm, "arm", "turn", problem, options))


def test_a_plan_has_no_more_rows_than_can_be_verified_in_time(arms):
    arms.make_planner("left", {"planner_id": "auto", "time_limit": 20, "sample_period": 1e-6})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, turned(0.9))
    with pytest.raises(srmp.InvalidArgument, match="sample period of 1e-06 s would give more than 200000 rows"):
        arms.plan("left", turned(-0.9), goal)
