"""plan_multi: requests and options that are refused, and what is said of goals that cannot be reached."""

import pickle

import pytest
from multi_arms import GOALS, STARTS, two
from support import READY, joints, turned

import srmp
from srmp import GoalConstraint, GoalType

NAN = float("nan")
REFUSED = [
    ({"left": READY}, {"left": GOALS["left"], "right": GOALS["right"]}, "'right' has a goal but no start"),
    (STARTS, {"lft": GOALS["left"]}, "'lft', did you mean 'left'"),
    ({"lft": READY, "right": READY}, {}, "'lft', did you mean 'left'"),
    ({"left": READY[:6], "right": READY}, GOALS, "start of 'left' has 6 values.*7 planned"),
    ({"left": [NAN] * 7, "right": READY}, GOALS, "start of 'left': arm7_joint1 is NaN"),
    ({"left": "up", "right": READY}, GOALS, "start of 'left' must be numbers, but is 'up'"),
    (STARTS, {"left": joints(READY[:6])}, "goal of 'left' has 6 values"),
    ({"lfet": READY}, {"left": GOALS["left"]}, "'lfet', did you mean 'left'"),
    (
        STARTS,
        {"left": GoalConstraint.hold(), "right": GoalConstraint.hold()},
        "nothing to plan: every robot",
    ),
    (STARTS, {}, "every robot with a start holds; one moves when it has a goal to reach"),
    (None, GOALS, "starts must be a dictionary by robot name, but are None"),
    ([READY], GOALS, "starts must be a dictionary by robot name, but are "),
    ({1: READY}, GOALS, "starts must be by robot name, which is a string, but one is by 1"),
    ({"left": None, "right": READY}, GOALS, "start of 'left' must be numbers, but is None"),
    ({"left": READY * 1j, "right": READY}, GOALS, "start of 'left' must be real numbers, but is array"),
    (STARTS, None, "goals must be a dictionary by robot name, but are None"),
    (STARTS, {"left": None}, "the goal of 'left' must be a GoalConstraint"),
    (STARTS, {"left": [READY, READY]}, "the goal of 'left' must be one; a GoalConstraint can have several"),
    ({}, {}, "at least one robot"),
]


@pytest.mark.parametrize(("starts", "goals", "sentence"), REFUSED)
def test_invalid_requests_are_refused(starts, goals, sentence):
    planner = two()
    with pytest.raises(srmp.InvalidArgument, match=sentence) as error:
        planner.plan_multi(starts, goals)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("obstacles", "sentence"),
    [
        ([1], r"obstacles must be a dictionary by robot name, but are \[1\]"),
        ({"right": None}, "obstacles must be Trajectory objects by robot name, but that of 'right' is None"),
    ],
)
def test_wrong_obstacles_are_no_type_errors(obstacles, sentence):
    planner = two()
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.plan_multi(STARTS, GOALS, obstacles=obstacles)
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.verify_multi({}, obstacles=obstacles)
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        srmp.MultiPlanRequest(STARTS, GOALS, obstacles)


FAR = turned(9)
INVALID = [
    ({"left": FAR, "right": READY}, GOALS, "start_invalid", "'left': the start.*arm7_joint1: 9 rad is above.*2.9 rad"),
    (STARTS, {"left": joints(FAR)}, "goal_invalid", "'left'.*arm7_joint1: 9 rad is above.*2.9 rad"),
    ({"left": READY, "right": READY}, GOALS, "start_invalid", "'left' and 'right'.*'arm7_.*'right/arm7_.*overlap by"),
    (
        STARTS,
        {"left": joints(READY), "right": joints(READY)},
        "goal_invalid",
        "'left' and 'right'.*'arm7_.*'right/arm7_.*overlap by",
    ),
    ({"left": turned(0.6), "right": READY}, {"left": joints(READY)}, "goal_invalid", "'left'.*'right/arm7_.*overlap"),
    (STARTS, {"left": GoalConstraint(GoalType.POSITION, [5, 0, 0])}, "goal_invalid", "'left'.*no configuration within"),
]


@pytest.mark.parametrize(("starts", "goals", "status", "sentence"), INVALID)
def test_what_cannot_be_says_why(starts, goals, status, sentence):
    planner = two()
    with pytest.raises(srmp.PlanningError, match=sentence) as error:
        planner.plan_multi(starts, goals)
    assert error.value.status == getattr(srmp.Status, status)
    assert "\n" not in str(error.value)
    assert planner.plan_multi(STARTS, GOALS)["left"].certificate.holds  # nothing is left of it


def test_planners_are_for_one_robot_or_for_many():
    planner = two()
    with pytest.raises(srmp.InvalidArgument, match=r"'wAstar' plans for one robot, but 2 were named; use 'xECBS'"):
        planner.make_planner(["left", "right"], {"planner_id": "wAstar"})
    planner.make_planner(["left"], srmp.WAStar())
    with pytest.raises(srmp.InvalidArgument, match="a goal of type 'hold' is for plan_multi"):
        planner.plan("left", READY, GoalConstraint.hold())


def test_hold_and_any_have_no_targets():
    for goal, kind in ((GoalConstraint.hold(), "hold"), (GoalConstraint.any(), "any")):
        assert len(goal.targets) == 0
        assert pickle.loads(pickle.dumps(goal)) == goal
        assert repr(goal).startswith(f"GoalConstraint({kind}")
        with pytest.raises(srmp.InvalidArgument, match=f"a goal of type '{kind}' has no target"):
            GoalConstraint(goal.type, [0.0] * 7)
    assert GoalConstraint.hold() != GoalConstraint.any()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            {"heuristic_lfet": "bfs"},
            "for robot 'lfet' alone, which is none of the robots.*did you mean 'left'",
        ),
        ({"heuristic_left": "bsf"}, "'heuristic_left' is 'bsf', did you mean 'bfs'"),
        ({"heuristic_left": 3}, "'heuristic_left' is 3; it must be a word"),
        ({"resolution_left": 3}, "no option 'resolution_left', did you mean 'resolution'"),
    ],
)
def test_wrong_options_of_single_robots(options, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        two().make_planner(["left", "right"], {"planner_id": "xECBS", **options})
