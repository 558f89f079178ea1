"""docs/from-other-packages.md: one test for each row of its table."""

import re
from pathlib import Path

import numpy as np
import pytest

import srmp

PAGE = Path(__file__).parents[2] / "docs" / "from-other-packages.md"
URDF, SRDF = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf")
READY = np.array([0, 0, 0, np.pi / 2, 0, np.pi / 2, 0])
ARM = {"end_effector": "arm7_hand", "urdf_path": URDF}


def add(planner, **more):
    planner.add_articulation(name="second", **ARM, **more)


def make(planner, **options):
    planner.make_planner(["arm"], {"planner_id": "wAstar", **options})


def plan_two(planner):
    planner.add_articulation(name="second", **ARM, srdf_path=SRDF, base_pose=srmp.Pose(p=[0, 1.5, 0]))
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, [READY + 0.1])
    return planner.plan_multi(dict.fromkeys(["arm", "second"], READY), dict.fromkeys(["arm", "second"], goal))


def accepted_ids(planner):
    for id_ in ("Astar", "wAstar", "ARAstar", "MHAstar", "wPASE", "xECBS"):
        planner.make_planner(["arm"], {"planner_id": id_})


def pose_goal(planner):
    return planner.plan(READY, srmp.GoalConstraint(srmp.GoalType.POSE, [srmp.Pose(p=[0.1, 0.45, 0.4], q=[0, 1, 0, 0])]))


def place_and_remove(planner):
    planner.set_base_pose("arm", srmp.Pose(p=[0, 0, 0.1]))
    planner.remove_articulation("arm")


def both_heuristics(planner):
    make(planner, heuristic="bfs")
    make(planner, heuristic="joint_euclidean")


def four_options(planner):
    mprim_path = srmp.data_path("primitives/default.yaml")
    make(planner, resolution="5", time_limit="5", weight="10.0")
    make(planner, mprim_path=mprim_path)


# The beginning of a row: what it calls, and what the refusal says ("": it is accepted).
ROWS = {
    "`PlannerInterface()`": (lambda p: srmp.PlannerInterface(), ""),
    "`add_articulation(name=, end": (lambda p: add(p, srdf_path=SRDF), ""),
    '`add_articulation("arm"': (lambda p: p.add_articulation("arm", "arm7_hand", URDF), "give them by name"),
    "`add_articulation(joint_names": (lambda p: add(p, joint_names=["arm7_joint1", "arm7_joint2"]), ""),
    "`add_articulation(link_names": (lambda p: add(p, link_names=[]), "all links of the URDF are read"),
    "`add_articulation(gravity": (lambda p: add(p, gravity=np.zeros(3)), "no dynamics here: leave it out"),
    "`add_articulation(planned": (lambda p: add(p, planned=True), "every robot may be planned"),
    "`add_articulation(gripper": (lambda p: add(p, gripper_joint_names=["x"]), "set_joint_positions"),
    "`set_gripper_qpos": (lambda p: p.set_gripper_qpos("arm", [0.0]), "write set_joint_positions"),
    "`remove_articulation(name)`": (place_and_remove, ""),
    "`add_box": (lambda p: p.add_box("box", np.full(3, 0.1), srmp.Pose(p=[1, 1, 1])), ""),
    "`add_mesh": (lambda p: p.add_mesh("mesh", mesh_path="x.stl"), "it is 'path' here"),
    "`add_point_cloud": (lambda p: p.add_point_cloud("cloud", vertices=np.ones((3, 3))), "it is 'points' here"),
    "`make_planner([name]": (lambda p: make(p, weight="10.0"), ""),
    "`make_planner(articulation": (
        lambda p: p.make_planner(articulation_names=["arm"], planner_context={}),
        "it is 'names' here",
    ),
    "`planner_id`: `Astar": (accepted_ids, ""),
    "`planner_id`: `MGS": (lambda p: make(p, planner_id="MGS"), "'auto' chooses among the planners here"),
    "`heuristic`: `bfs": (both_heuristics, ""),
    "`heuristic`: `joint_euclidean_r": (
        lambda p: make(p, heuristic="joint_euclidean_remove_time"),
        "did you mean 'joint_euclidean'",
    ),
    "`resolution`": (four_options, ""),
    "`allowed_planning_time`": (lambda p: make(p, allowed_planning_time="5"), "it is 'time_limit' here"),
    "`GoalConstraint": (pose_goal, ""),
    "`plan(start": (lambda p: p.plan(READY, srmp.GoalConstraint(srmp.GoalType.JOINTS, [READY + 0.1])), ""),
    "`plan_multi": (plan_two, ""),
    "`save_plan": (lambda p: p.save_plan("plan.txt"), r"write the save\(path\)"),
    "`add_robot": (lambda p: p.add_robot("arm7", name="other", base_pose=srmp.Pose(p=[0, 2, 0])), ""),
}


def table():
    """First and second cell of each row."""
    rows = re.findall(r"^\| (`.*?) \| (\w+) \|", PAGE.read_text(), re.MULTILINE)
    assert len(rows) == len(ROWS)
    return rows


@pytest.fixture
def planner():
    planner = srmp.PlannerInterface()
    planner.add_articulation(name="arm", srdf_path=SRDF, **ARM)
    return planner


@pytest.mark.parametrize(("call", "verdict"), table(), ids=[call for call, _ in table()])
def test_row(planner, call, verdict):
    ((run, says),) = [row for beginning, row in ROWS.items() if call.startswith(beginning)]
    assert verdict in (("renamed", "refused") if says else ("accepted",))
    if not says:
        run(planner)
        return
    with pytest.raises(srmp.Error, match=says):
        run(planner)
    assert planner.robot_names == ["arm"]
    assert planner.object_names == []


def test_renamed_methods_are_not_there(planner):
    assert not hasattr(planner, "save_plan")
    with pytest.raises(AttributeError, match="has no attribute 'sav_plan'"):
        planner.sav_plan()
