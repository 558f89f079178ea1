"""The paper's listings (Fig. 3) run as printed, with the files they name in the working directory."""

import shutil
import struct

import numpy as np
import pytest

import srmp

LEFT = """
import srmp
planner = srmp.PlannerInterface()
planner.add_articulation(urdf_path="panda.urdf",
                    srdf_path="panda.srdf",
                    name="panda",
                    end_effector="panda_hand")
planner.add_box("box", size=np.array([1,2.1,1]),
                pose=srmp.Pose(p=[0,0,0.4]))
planner.add_mesh("shrimp", path="shrimp.stl",
                 pose=srmp.Pose(p=[2,0,1],
                                q=[0,0,0,1]))
q_start = np.radians([0, -45, 0, -135, 0, 90, 45])
# Define goal constraint (e.g., gripper pose).
goal = srmp.GoalConstraint(srmp.GoalType.POSE,
       list(srmp.Pose([0.6, -0.0, 0.5])))
planner.make_planner(["panda"],
                     {"planner_id": "ARAstar",
                      "time_limit":"5"})
"""
PLAN = """
trajectory = planner.plan(["panda"],
                           q_start, goal)
"""
RIGHT = """
# Add a second robot model to the world
planner.add_articulation(urdf_path="panda.urdf",
                         srdf_path="panda.srdf",
                         name="panda2",
                         end_effector="panda_hand")
planner.set_base_pose(name="panda2",
        pose=srmp.Pose(p=[0.5, 0, 0],
                       q=[0,0,0,1]))
# Multi-agent goal constraint
goal_2 = srmp.GoalConstraint(
        srmp.GoalType.POSE,
        list(srmp.Pose([0.6, -0.5, 1.0])))
# Configure multi-agent planner
planner.make_planner(["panda","panda2"],
                     {"planner_id":"xECBS",
                      "time_limit":"5"})
start_qs = {"panda":  q_start,
            "panda2": q_start}
goals =    {"panda":  goal,
            "panda2": goal_2}
trajectory = planner.plan_multi(start_qs, goals)
"""


def write_stl(path):
    """A tetrahedron, as binary STL."""
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], dtype="float32")
    triangles = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    data = b"\0" * 80 + struct.pack("<I", len(triangles))
    for triangle in triangles:
        data += b"\0" * 12 + corners[list(triangle)].tobytes() + b"\0\0"
    path.write_bytes(data)


@pytest.fixture
def world(mbm_dir, tmp_path, monkeypatch):
    """The listing's names, in a directory that holds the files it reads."""
    for name in ("panda.urdf", "panda.srdf"):
        shutil.copy(mbm_dir / "panda" / name, tmp_path / name)
    shutil.copytree(mbm_dir / "panda" / "meshes" / "collision", tmp_path / "meshes" / "collision")
    write_stl(tmp_path / "shrimp.stl")
    monkeypatch.chdir(tmp_path)
    return {"np": np}


def box_lowered(listing):
    """So that it is a table."""
    return listing.replace("p=[0,0,0.4]", "p=[0, 0, -0.52]")


def test_left_listing_as_printed_names_the_box_that_swallows_the_robot(world):
    exec(LEFT, world)
    with pytest.raises(srmp.PlanningError, match=r"'panda_link.' and .*'box'") as error:
        exec(PLAN, world)
    assert error.value.status == srmp.Status.start_invalid


def test_left_listing_with_the_box_as_a_table_is_a_trajectory(world):
    exec(box_lowered(LEFT), world)
    exec(PLAN, world)
    trajectory, planner = world["trajectory"], world["planner"]
    assert trajectory.positions.shape[1] == 7
    np.testing.assert_array_equal(trajectory.positions[0], world["q_start"])
    assert np.linalg.norm(planner.compute_fk("panda", trajectory.positions[-1]).p - [0.6, 0, 0.5]) < 1e-4
    assert not any(planner.is_state_colliding("panda", q) for q in trajectory.positions)


def test_right_listing_as_printed_names_the_links_that_meet(world):
    exec(box_lowered(LEFT), world)
    with pytest.raises(srmp.PlanningError, match=r"'panda_[^']*' and .*'panda2/panda_[^']*' overlap") as error:
        exec(RIGHT, world)
    assert error.value.status in (srmp.Status.start_invalid, srmp.Status.goal_invalid)


def test_right_listing_with_the_second_arm_far_off_cannot_reach_its_goal(world):
    """0.97 m from its shoulder to the hand; the arm is 0.86 m long."""
    exec(box_lowered(LEFT), world)
    with pytest.raises(srmp.PlanningError, match=r"'panda2': the goal is invalid: .*\[0.6, -0.5, 1\]") as error:
        exec(RIGHT.replace("p=[0.5, 0, 0]", "p=[1.1, 0, 0]"), world)
    assert error.value.status == srmp.Status.goal_invalid


def test_right_listing_with_the_second_arm_a_little_farther_off_is_a_trajectory(world):
    exec(box_lowered(LEFT), world)
    exec(RIGHT.replace("p=[0.5, 0, 0]", "p=[0.8, 0, 0]"), world)
    trajectory, planner = world["trajectory"], world["planner"]
    assert list(trajectory) == ["panda", "panda2"]
    for name, target in (("panda", [0.6, 0, 0.5]), ("panda2", [0.6, -0.5, 1.0])):
        one = trajectory[name]
        np.testing.assert_array_equal(one.positions[0], world["q_start"])
        assert np.linalg.norm(planner.compute_fk(name, one.positions[-1]).p - target) < 1e-4
        assert one.certificate.holds
        assert one.certificate.proved_free
