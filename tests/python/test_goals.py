"""What plan accepts without ceremony: no make_planner, goals in any form, one robot without its name."""

import numpy as np
import pytest

import srmp

UPRIGHT = np.zeros(7)
TURN = np.array([0.9, 0, 0, 0, 0, 0, 0])
TURNED = {"arm7_joint1": 0.9}


@pytest.fixture
def alone():
    """The package's own arm, with nothing else said."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_path=srmp.data_path("arm7.srdf"), name="arm")
    return planner


@pytest.fixture
def rest(alone):
    return np.array(alone.get_group_states("arm")["ready"])


def same(one, other):
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(one.times, other.times)


def test_plan_without_make_planner_is_auto(alone, rest):
    plain = alone.plan("arm", rest, rest + TURN)
    alone.make_planner("arm", {"planner_id": "auto"})
    same(plain, alone.plan("arm", rest, rest + TURN))
    (one,) = alone.plan_many([srmp.PlanRequest("arm", rest, UPRIGHT)])
    assert one.solved


def test_every_form_of_a_goal_is_the_same_goal(alone, rest):
    turned = rest + TURN
    constraint = srmp.GoalConstraint(srmp.GoalType.JOINTS, turned)
    whole = dict(zip(alone.get_joint_names("arm"), turned.tolist(), strict=True))
    expected = alone.plan("arm", rest, constraint)
    for goal in (turned, turned.tolist(), tuple(turned), TURNED, whole, [constraint], [turned]):
        assert alone.goal("arm", goal if not isinstance(goal, list) or len(goal) > 1 else goal[0], rest) == constraint
        same(alone.plan("arm", rest, goal), expected)
        same(alone.plan(rest, goal), expected)
    pose = alone.compute_fk("arm", turned)
    same(alone.plan(rest, pose), alone.plan("arm", rest, srmp.GoalConstraint(srmp.GoalType.POSE, pose)))
    np.testing.assert_array_equal(alone.plan(rest, "upright").positions[-1], UPRIGHT)


def test_several_goals_of_any_form(alone, rest):
    blocked = rest + TURN / 2
    alone.add_box("wall", size=[0.1, 0.1, 0.4], pose=srmp.Pose(p=alone.compute_fk("arm", blocked).p))
    trajectory = alone.plan("arm", rest, [blocked, "upright", {"arm7_joint1": -0.4}])
    assert alone.get_planning_stats()["goal_index"] in (1, 2)
    assert trajectory.certificate.holds
    assert len(alone.plan("arm", rest, np.array([blocked, UPRIGHT])))


def test_joints_not_named_stay_as_at_the_start(alone, rest):
    assert alone.goal("arm", {"arm7_joint2": 0.3}, UPRIGHT).targets[0].tolist() == [0, 0.3, 0, 0, 0, 0, 0]
    alone.set_qpos("arm", rest)
    assert alone.goal("arm", {"arm7_joint2": 0.3}).targets[0].tolist() == [0, 0.3, *rest[2:]]


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        ("redy", "there is no state 'redy' of all its planned joints in the SRDF, did you mean 'ready'?"),
        ("folded_away", "there is no state 'folded_away'.*; known are 'ready' and 'upright'"),
        ({"arm7_jiont1": 0.1}, "has no joint 'arm7_jiont1', did you mean 'arm7_joint1'?"),
        ({"arm7_palm_joint": 0.1}, "joint 'arm7_palm_joint' of robot 'arm' is fixed"),
        ({"arm7_joint1": float("nan")}, "goal of 'arm': arm7_joint1 is NaN"),
        ({"arm7_joint1": "far"}, "must be numbers by name, and one by link names Poses, but is {'arm7_joint1': 'far'}"),
        ({}, "names no joint"),
        (None, "goal"),
        ("", "there is no state ''"),
        (True, "goal of 'arm' has 1 values"),
        (object(), "a goal must be a GoalConstraint, a Pose, a configuration"),
        ([0.1, 0.2], "goal of 'arm' has 2 values"),
        ([srmp.Pose(), object()], "must be a GoalConstraint"),
    ],
)
def test_wrong_goals_are_refused_with_the_sentence_that_helps(alone, rest, goal, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        alone.plan("arm", rest, goal)
    assert alone.last_request is None


def test_the_name_is_needed_where_there_are_several_robots(alone, rest):
    alone.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"), name="b", end_effector="arm7_hand", base_pose=srmp.Pose(p=[3, 0, 0])
    )
    with pytest.raises(srmp.InvalidArgument, match="for a scene with one robot; here are 'arm' and 'b'"):
        alone.plan(rest, "upright")
    with pytest.raises(srmp.InvalidArgument, match="here is none, call add_articulation first"):
        srmp.PlannerInterface().plan(rest, "upright")


def test_many_robots_and_verify_take_goals_in_any_form(alone, rest):
    alone.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="b",
        base_pose=srmp.Pose(p=[1.5, 0, 0]),
    )
    starts = {"arm": rest, "b": rest}
    goals = {"arm": "upright", "b": {"arm7_joint1": 0.4}}
    motions = alone.plan_multi(starts, goals)
    np.testing.assert_array_equal(motions["arm"].positions[-1], UPRIGHT)
    assert motions["b"].positions[-1][0] == 0.4
    verified = alone.verify_multi(motions, starts=starts, goals=goals)
    assert all(certificate.holds for certificate in verified.values())
    alone.remove_articulation("b")
    alone_again = alone.plan("arm", rest, "upright")
    assert alone.verify("arm", alone_again, start=rest, goals="upright").holds
    assert not alone.verify("arm", alone_again, start=rest, goals="ready").holds


def test_requests_know_no_names():
    assert srmp.PlanRequest("arm", UPRIGHT, srmp.Pose()).goals[0].type == srmp.GoalType.POSE
    with pytest.raises(srmp.InvalidArgument, match=r"give it PlannerInterface.goal\('arm', …\) instead"):
        srmp.PlanRequest("arm", UPRIGHT, "ready")


WORDS = [
    ("allowed_planning_time", "it is 'time_limit' here"),
    ("num_planning_attempts", "each plan is one attempt here"),
    ("max_velocity_scaling_factor", "it is 'velocity_scaling' here"),
    ("max_acceleration_scaling_factor", "it is 'acceleration_scaling' here"),
    ("planner", "it is 'planner_id' here"),
    ("simplify_solutions", "it is 'shortcut' here"),
    ("longest_valid_segment_fraction", "motions are proved free between samples here"),
    ("goal_bias", "planners that sample have nothing to tune here"),
    ("seed", "results are deterministic"),
    ("epsilon", "it is 'weight' here"),
    ("goal_joint_tolerance", "GoalConstraint's position_tolerance and rotation_tolerance"),
    ("num_ik_seeds", "it is 'ik_solutions' here"),
    ("time_step", "it is 'sample_period' here"),
    ("Planning-Time", "it is 'time_limit' here"),
]


@pytest.mark.parametrize(("word", "sentence"), WORDS)
def test_options_of_other_planners_name_ours(alone, word, sentence):
    with pytest.raises(srmp.InvalidArgument, match=f"planner 'auto' has no option '{word}'; .*{sentence}"):
        alone.make_planner("arm", {"planner_id": "auto", word: 5})


@pytest.mark.parametrize("id_", ["RRTConnectkConfigDefault", "PRMstar", "BIT*", "chomp", "LIN", "EST"])
def test_planners_of_other_libraries_name_ours(alone, id_):
    with pytest.raises(srmp.InvalidArgument, match=r"there is no planner .*; .*here"):
        alone.make_planner("arm", {"planner_id": id_})


def test_every_option_that_a_sentence_names_exists():
    """No word of other planners that is an option here is said to be another one."""
    import re

    options = {key for id_ in srmp.available_planners() for key in srmp.planner_options({"planner_id": id_})}
    for option in options:
        assert srmp._srmp._option_of_other_planner(option) == "" or option in ("num_threads",)
    for word, _ in WORDS:
        for name in re.findall(r"'(\w+)' here", srmp._srmp._option_of_other_planner(word)):
            assert name in options
