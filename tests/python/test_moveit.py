"""MoveIt's files: every field of the messages is a row of docs/moveit.md; requests; the plugin's configuration."""

import re
from pathlib import Path

import numpy as np
import pytest
from moveit_messages import FIELDS, World, at, attached, box, near, one_sentence, orientation, place, position

import srmp

DOCS = Path(__file__).parents[2] / "docs" / "moveit.md"


@pytest.fixture
def world(tmp_path):
    return World(tmp_path)


# --- the tables of the document ---------------------------------------------------------------------------------------


def rows():
    """(section, field, verdict) of each row."""
    section = ""
    for line in DOCS.read_text().splitlines():
        if line.startswith("#"):
            section = line.lstrip("# ")
        if match := re.match(r"\| `([^`]+)` \| ([a-z ]+) \|", line):
            yield section, match[1], match[2]


def test_the_tables_have_every_field_of_the_messages_and_no_other():
    assert {section for section, _, _ in rows()} == set(FIELDS)
    for section, fields in FIELDS.items():
        assert sorted(field for s, field, _ in rows() if s == section) == sorted(fields)
    assert {verdict for _, _, verdict in rows()} == {"honoured", "refused", "no effect"}


# --- as a whole -------------------------------------------------------------------------------------------------------


def test_goals_in_frames_are_reached(world):
    """Plans to a pose that is given in an object's subframe, for a point of an attached object."""
    goal_hand = world.hand(world.ready + 0.3)
    grip = [0, 0, 0.1]
    point = goal_hand @ grip
    world.add(box("crate", 1.5, 1, 0, subframe_names=["lid"], subframe_poses=[at(0, 0, 0.2)]))
    cup = {"is_diff": True, "attached_collision_objects": [attached(touch_links=["arm7_flange", "arm7_palm"])]}
    goal = place(
        position(*(point - [1.5, 1, 0.2]), frame="crate/lid", link="cup"),
        orientation(*goal_hand.q, frame="crate/lid", link="cup", parameterization=1),
    )
    problem = world.apply(goal, start_state=cup, allowed_planning_time=20)
    world.planner.make_planner("arm", problem.options)
    trajectory = world.planner.plan("arm", world.ready, problem.goals)
    reached = world.hand(trajectory.waypoints[-1])
    assert near(reached @ grip, point, 1e-3)


def test_goals_that_leave_axes_free_are_planned(world):
    hand = world.hand(world.ready + 0.3)
    world.planner.make_planner("arm", srmp.Auto(time_limit=20))
    upright = orientation(*hand.q, tolerance=(0.05, 0.05, 7))
    for goal in (place(orientation(*hand.q)), place(position(*hand.p), upright), place(upright)):
        problem = world.apply(goal)
        trajectory = world.planner.plan("arm", world.ready, problem.goals)
        reached = world.hand(trajectory.waypoints[-1])
        across = (hand.inverse() @ reached).matrix()[:2, 2]  # how far its z axis is from the required one
        assert np.abs(across).max() < 0.05
        assert world.planner.verify("arm", trajectory, start=world.ready, goals=problem.goals).holds


def test_a_refused_request_changes_nothing(world):
    moved = {"joint_names": ["base_joint"], "transforms": [{"translation": [1, 0, 0.5]}]}
    state = {"multi_dof_joint_state": moved, "attached_collision_objects": [attached()]}
    world.refused("no_such_frame", place(position(0, 0, 1, frame="no_such_frame")), start_state=state)
    assert near(world.base().p, 0)
    assert world.planner.object_names == []


def test_who_cannot_have_constraints_says_so(world):
    from srmp.datasets.scene_files import read_request

    hand = world.hand()
    moving = {"joint_state": {"name": ["arm7_joint1"], "position": [0.0], "velocity": [0.5]}}
    for request, sentence in (
        ({"path_constraints": place(position(*hand.p, shape=("sphere", [2.0])))}, "has path_constraints"),
        ({"max_cartesian_speed": 0.1}, "has a max_cartesian_speed"),
        ({"start_state": moving}, "begins in motion"),
    ):
        world.apply(**request)
        with pytest.raises(srmp.NotSupported) as caught:
            read_request(world.planner, "arm", world.directory / "request.yaml")
        one_sentence(caught, f"the request {sentence}, which is not supported here")


# --- the plugin's configuration ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "plugin", "kind"),
    [
        ("srmp_planning.yaml", None, None),
        ("srmp_planning_humble.yaml", "planning_plugin", str),
        ("srmp_planning_ros2.yaml", "planning_plugins", list),
    ],
)
def test_pipelines_name_planners_and_no_adapter_that_times(name, plugin, kind):
    """MoveIt 2 reads one text before Jazzy, lists from Jazzy on."""
    yaml = pytest.importorskip("yaml", reason="pip install '.[test]'")
    pipeline = yaml.safe_load((DOCS.parents[1] / "moveit" / "config" / "panda" / name).read_text())
    for options in pipeline["planner_configs"].values():
        srmp.planner_options(options)
    assert set(pipeline["panda_arm"]["planner_configs"]) <= set(pipeline["planner_configs"])
    if plugin:
        adapters = [key for key in pipeline if key.endswith("adapters")]
        assert len(adapters) == (2 if kind is list else 1)
        for key in (plugin, *adapters):
            assert isinstance(pipeline[key], kind)
            assert "Parameterization" not in str(pipeline[key])
