"""MoveIt's messages: their fields and the tests of each, an arm that gets them, and short ways to write them."""

import json
from pathlib import Path

import numpy as np
import pytest

import srmp

VIRTUAL_JOINT = '<virtual_joint name="base_joint" type="floating" parent_frame="odom" child_link="arm7_base"/>'

# The fields of the messages, as moveit_msgs defines them, by table of docs/moveit.md.
IN_REQUESTS = {
    "Motion plan requests": """
        workspace_parameters.header workspace_parameters.min_corner workspace_parameters.max_corner
        goal_constraints path_constraints trajectory_constraints reference_trajectories pipeline_id planner_id
        group_name num_planning_attempts allowed_planning_time max_velocity_scaling_factor
        max_acceleration_scaling_factor cartesian_speed_limited_link cartesian_speed_end_effector_link
        max_cartesian_speed""",
    "Start states": """
        start_state.joint_state.header start_state.joint_state.name start_state.joint_state.position
        start_state.joint_state.velocity start_state.joint_state.effort start_state.multi_dof_joint_state.header
        start_state.multi_dof_joint_state.joint_names start_state.multi_dof_joint_state.transforms
        start_state.multi_dof_joint_state.twist start_state.multi_dof_joint_state.wrench
        start_state.attached_collision_objects start_state.is_diff""",
    "Goals": """
        constraints.name constraints.joint_constraints constraints.position_constraints
        constraints.orientation_constraints constraints.visibility_constraints joint_constraints.joint_name
        joint_constraints.position joint_constraints.tolerance_above joint_constraints.tolerance_below
        joint_constraints.weight position_constraints.header position_constraints.link_name
        position_constraints.target_point_offset position_constraints.constraint_region.primitives
        position_constraints.constraint_region.primitive_poses position_constraints.constraint_region.meshes
        position_constraints.constraint_region.mesh_poses position_constraints.weight
        orientation_constraints.header orientation_constraints.orientation orientation_constraints.link_name
        orientation_constraints.absolute_x_axis_tolerance orientation_constraints.absolute_y_axis_tolerance
        orientation_constraints.absolute_z_axis_tolerance orientation_constraints.parameterization
        orientation_constraints.weight""",
}
IN_SCENES = {
    "Planning scenes": """
        name robot_state.joint_state robot_state.multi_dof_joint_state robot_state.attached_collision_objects
        robot_state.is_diff robot_model_name fixed_frame_transforms allowed_collision_matrix.entry_names
        allowed_collision_matrix.entry_values allowed_collision_matrix.default_entry_names
        allowed_collision_matrix.default_entry_values link_padding link_scale object_colors
        world.collision_objects world.octomap is_diff""",
    "Collision objects": """
        header pose id type primitives primitive_poses meshes mesh_poses planes plane_poses subframe_names
        subframe_poses operation""",
    "Attached objects": "link_name object touch_links detach_posture weight",
}
FIELDS = {section: fields.split() for section, fields in (IN_REQUESTS | IN_SCENES).items()}


class World:
    """The package's own arm, and MoveIt's files of scenes and requests for it."""

    def __init__(self, directory, *, srdf=""):
        self.directory = directory
        self.planner = srmp.PlannerInterface()
        text = Path(srmp.data_path("arm7.srdf")).read_text().replace("</robot>", f"{VIRTUAL_JOINT}{srdf}</robot>")
        self.planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_text=text,
            name="arm",
            end_effector="arm7_hand",
        )
        self.joints = self.planner.get_joint_names("arm")
        self.ready = self.planner.get_group_states("arm")["ready"]

    def hand(self, q=None, link="arm7_hand"):
        return self.planner.compute_fk("arm", self.ready if q is None else q, link)

    def base(self):
        return self.hand(link="arm7_base")

    def load(self, **scene):
        path = self.directory / "scene.yaml"
        path.write_text(json.dumps(scene))
        return self.planner.load_moveit_scene(str(path))

    def add(self, *objects, **scene):
        return self.load(world={"collision_objects": list(objects)}, **scene)

    def apply(self, *goals, **request):
        path = self.directory / "request.yaml"
        goals = list(goals) or [joint_goal(self, self.ready)]
        path.write_text(json.dumps({"goal_constraints": goals, **request}))
        return self.planner.apply_moveit_request("arm", srmp.load_moveit_request(str(path)))

    def goal(self, *goals, **request):
        (goal,) = self.apply(*goals, **request).goals
        return goal

    def refused(self, what, *goals, error=srmp.Error, **request):
        with pytest.raises(error) as caught:
            self.apply(*goals, **request)
        one_sentence(caught, what)

    def scene_refused(self, what, error=srmp.Error, **scene):
        before = self.planner.object_names, self.planner.get_qpos("arm").tolist()
        with pytest.raises(error) as caught:
            self.load(**scene)
        one_sentence(caught, what)
        assert before == (self.planner.object_names, self.planner.get_qpos("arm").tolist())


def one_sentence(caught, what):
    text = str(caught.value)
    assert what in text
    assert len(text) < 500
    assert "\n" not in text


def joint_goal(world, q, **more):
    return {
        "joint_constraints": [
            {"joint_name": n, "position": float(x)} | more for n, x in zip(world.joints, q, strict=False)
        ]
    }


def at(*position, xyzw=(0, 0, 0, 1)):
    return {"position": list(position), "orientation": list(xyzw)}


def position(*xyz, frame="", link="arm7_hand", shape=("sphere", [0.01]), region=None, **more):
    kind, sizes = shape
    region = region or {"primitives": [{"type": kind, "dimensions": sizes}], "primitive_poses": [at(*xyz)]}
    return {"header": {"frame_id": frame}, "link_name": link, "constraint_region": region} | more


def orientation(*xyzw, frame="", link="arm7_hand", tolerance=(0.1, 0.1, 0.1), **more):
    names = (f"absolute_{axis}_axis_tolerance" for axis in "xyz")
    message = {"header": {"frame_id": frame}, "link_name": link, "orientation": list(xyzw or (0, 0, 0, 1))}
    return message | dict(zip(names, tolerance, strict=True)) | more


def place(*constraints):
    return {
        "position_constraints": [c for c in constraints if "constraint_region" in c],
        "orientation_constraints": [c for c in constraints if "orientation" in c],
    }


def box(name="box", *xyz, frame="", **more):
    message = {
        "id": name,
        "header": {"frame_id": frame},
        "primitives": [{"type": "box", "dimensions": [0.1, 0.1, 0.1]}],
    }
    return message | {"primitive_poses": [at(*(xyz or (2, 0, 0)))]} | more


def attached(link="arm7_hand", name="cup", **more):
    return {"link_name": link, "object": box(name, 0, 0, 0.1, frame=link)} | more


def near(a, b, tolerance=1e-9):
    return np.allclose(a, b, rtol=0, atol=tolerance)


def target(goal):
    return np.asarray(goal.targets[0])


TRIANGLE = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}
SECTIONS = {name: {} for name in FIELDS}


def row(section, *fields):
    """Registers a test of rows."""

    def register(test):
        for field in fields:
            assert field not in SECTIONS[section]
            SECTIONS[section][field] = test
        return test

    return register


def rows_of(sections):
    """(section, field) of each row of these tables, for test_every_row."""
    return [(section, field) for section in sections for field in FIELDS[section]]
