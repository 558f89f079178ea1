"""MoveIt's planar bases that are planned, and what holds for the sources of the plugin without ROS."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

import srmp

SOURCES = Path(__file__).parents[2] / "moveit" / "src"
CHECKS = SOURCES.parent / "test"
VIRTUAL_JOINT = '<virtual_joint name="base_joint" type="planar" parent_frame="odom" child_link="arm7_base"/>'


def test_a_planned_planar_base_starts_where_the_multi_dof_state_says(tmp_path):
    planner = srmp.PlannerInterface()
    srdf = Path(srmp.data_path("arm7.srdf")).read_text().replace("</robot>", f"{VIRTUAL_JOINT}</robot>")
    robot = {"name": "arm", "end_effector": "arm7_hand", "planar_bounds": [[-3, -3], [3, 3]]}
    planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_text=srdf, **robot)
    ready = planner.get_group_states("arm")["ready"]
    planner.set_qpos("arm", ready)
    driven = [1.5, -2, 0.8, *ready[3:]]
    names = planner.get_joint_names("arm")
    constraints = [{"joint_name": name, "position": q} for name, q in zip(names, driven, strict=True)]

    def apply(goal=None, **change):
        state = {"header": {"frame_id": "odom"}, "joint_names": ["base_joint"]}
        state |= {"transforms": [{"translation": [1, -2, 0], "rotation": [0, 0, np.sin(0.4), np.cos(0.4)]}]} | change
        request = {"goal_constraints": [goal or {"joint_constraints": constraints}]}
        path = tmp_path / "request.yaml"
        path.write_text(json.dumps(request | {"start_state": {"multi_dof_joint_state": state}}))
        return planner.apply_moveit_request("arm", srmp.load_moveit_request(str(path)))

    problem = apply()
    assert np.allclose(problem.start, [1, -2, 0.8, *ready[3:]], atol=1e-9)
    assert problem.ignored_joints == []
    motion = planner.plan("arm", problem.start, problem.goals)
    assert np.allclose(motion.positions[-1], driven)
    for transform in ({"translation": [0, 0, 0.1]}, {"rotation": [np.sin(0.1), 0, 0, np.cos(0.1)]}):
        with pytest.raises(srmp.Error, match="leaves the plane"):
            apply(transforms=[transform])
    with pytest.raises(srmp.Error, match="only the planning frame"):
        apply(header={"frame_id": "arm7_hand"})


def test_the_plugin_needs_no_symbol_of_the_library():
    """It opens the library in a scope of its own (library.hpp), so it must not be linked: errors of the library are
    caught there, and not made, as their constructor is in the library."""
    for path in sorted(SOURCES.glob("*.?pp")):
        if path.name != "session_library.cpp":
            assert not re.search(r"throw srmp::|srmp::\w*(Error|InvalidArgument|NotSupported)\(", path.read_text()), (
                path
            )


def test_only_two_headers_name_messages_and_responses_of_one_moveit():
    """The plugin and its checks are the same sources for MoveIt 1 and MoveIt 2."""
    one_version = re.compile(r"\bros::|\w+_msgs::|[.>](trajectory|error_code|description|planning_time)_\b")
    for path in sorted([*SOURCES.glob("*.?pp"), *CHECKS.glob("*.?pp")]):
        if path.name not in ("ros_version.hpp", "pipeline.hpp"):
            assert not one_version.search(path.read_text()), path


def test_both_versions_of_moveit_are_checked_with_the_same_configurations():
    one = yaml.safe_load((CHECKS / "pipelines.yaml").read_text())["srmp"]
    two = yaml.safe_load((CHECKS / "pipelines_humble.yaml").read_text())["/**"]["ros__parameters"]
    assert two["srmp"] == one
    assert two["srmp_adapters"]["planner_configs"] == one["planner_configs"]


def test_parameters_of_ros_2_keep_their_digits():
    """rclcpp's value_to_string writes six digits after the point, and lists in brackets: as_text writes both."""
    source = (SOURCES / "ros_version.hpp").read_text()
    assert source.count("value_to_string()") == 2  # in as_text, for truth values and texts, and its comment
