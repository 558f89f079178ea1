"""MoveIt's files: every row of the tables in docs/moveit.md has a test here, and every field of the messages a row."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import srmp
from srmp import GoalType, Pose

DOCS = Path(__file__).parents[2] / "docs" / "moveit.md"
VIRTUAL_JOINT = '<virtual_joint name="base_joint" type="floating" parent_frame="odom" child_link="arm7_base"/>'

# --- the tables of the document ---------------------------------------------------------------------------------------

# The fields of the messages, as moveit_msgs defines them.
MESSAGES = {
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
FIELDS = {section: fields.split() for section, fields in MESSAGES.items()}


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


# --- worlds, requests and scenes --------------------------------------------------------------------------------------


class World:
    def __init__(self, directory, *, end_effector="arm7_hand", srdf=""):
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


@pytest.fixture
def world(tmp_path):
    return World(tmp_path)


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


def requests(*fields):
    return row("Motion plan requests", *fields)


def starts(*fields):
    return row("Start states", *(f"start_state.{field}" for field in fields))


def goals(*fields):
    return row("Goals", *fields)


def scenes(*fields):
    return row("Planning scenes", *fields)


def objects(*fields):
    return row("Collision objects", *fields)


def attachments(*fields):
    return row("Attached objects", *fields)


# --- requests ---------------------------------------------------------------------------------------------------------


@requests("group_name")
def group_name(world):
    assert world.apply(group_name="arm").goals
    world.refused("no group 'arn', did you mean 'arm'?", group_name="arn")
    other = World(world.directory, srdf='<group name="wrist"><joint name="arm7_joint7"/></group>')
    other.refused("the request is for group 'wrist', and joint 'arm7_joint1'", group_name="wrist")


@requests("planner_id")
def planner_id(world):
    assert world.apply(planner_id="wAstar").options == {"planner_id": "wAstar"}
    assert world.apply(planner_id="BKPIECEkConfigDefault").options == {}


@requests("pipeline_id", "num_planning_attempts")
def without_effect(world):
    assert world.apply(pipeline_id="ompl", num_planning_attempts=4).options == {}
    world.refused("num_planning_attempts is 1.5", num_planning_attempts=1.5)
    world.refused("did you mean 'num_planning_attempts'?", num_planing_attempts=1)


@requests("allowed_planning_time")
def allowed_planning_time(world):
    assert world.apply(allowed_planning_time=2.5).options == {"time_limit": 2.5}
    assert world.apply(allowed_planning_time=0).options == {}


@requests("max_velocity_scaling_factor", "max_acceleration_scaling_factor")
def scaling(world):
    for name in ("velocity", "acceleration"):
        field = f"max_{name}_scaling_factor"
        assert world.apply(**{field: 0.5}).options == {f"{name}_scaling": 0.5}
        assert world.apply(**{field: 0}).options == {}
        world.refused(f"{field} is 1.5", **{field: 1.5})
    world.planner.make_planner("arm", world.apply(max_velocity_scaling_factor=0.1).options)
    goal = joint_goal(world, world.ready + 0.3)
    problem = world.apply(goal, max_velocity_scaling_factor=0.1)
    slow = world.planner.plan("arm", world.ready, problem.goals)
    limits = world.planner.motion_limits("arm").velocity
    assert (np.abs(slow.velocities) <= 0.1 * limits + 1e-6).all()


@requests("max_cartesian_speed", "cartesian_speed_limited_link", "cartesian_speed_end_effector_link")
def max_cartesian_speed(world):
    assert world.apply(max_cartesian_speed=0).link_speeds == []
    assert world.apply(cartesian_speed_limited_link="arm7_hand").link_speeds == []
    assert world.apply(max_cartesian_speed=0.1).link_speeds == [srmp.LinkSpeedLimit("", speed=0.1)]
    for field in ("cartesian_speed_limited_link", "cartesian_speed_end_effector_link"):
        problem = world.apply(joint_goal(world, world.ready + 0.3), max_cartesian_speed=0.1, **{field: "arm7_forearm"})
        assert problem.link_speeds == [srmp.LinkSpeedLimit("arm7_forearm", speed=0.1)]
        world.refused("did you mean 'arm7_hand'", max_cartesian_speed=0.1, **{field: "arm7_hnad"})
    world.planner.set_motion_limits("arm", link_speeds=problem.link_speeds)
    motion = world.planner.plan("arm", problem.start, problem.goals)
    assert motion.certificate.link_speeds[0].speed <= 0.1
    world.planner.set_motion_limits("arm", link_speeds={})
    world.refused("max_cartesian_speed is Infinity; only finite", max_cartesian_speed=float("inf"))


@requests("workspace_parameters.header", "workspace_parameters.min_corner", "workspace_parameters.max_corner")
def workspace(world):
    corners = {"min_corner": [-1, -1, -1], "max_corner": [1, 1, 1]}
    assert world.apply(workspace_parameters=corners | {"header": {"frame_id": "arm7_base"}}).goals
    world.refused("no_such_frame", workspace_parameters=corners | {"header": {"frame_id": "no_such_frame"}})
    world.refused("min_corner", workspace_parameters=corners | {"min_corner": [2, 0, 0]})


@requests("path_constraints")
def constraints_of_the_path(world):
    hand = world.hand()
    turned = world.ready + 0.8 * np.eye(7)[0]
    upright = orientation(*hand.q, tolerance=(0.1, 0.1, 7))
    low = position(*hand.p, shape=("box", [2, 2, 0.1]))
    world.planner.set_qpos("arm", world.ready)
    problem = world.apply(joint_goal(world, turned), path_constraints=place(upright, low))
    assert [constraint.type for constraint in problem.constraints] == ["box", "cone"]
    motion = world.planner.plan("arm", problem.start, problem.goals, constraints=problem.constraints)
    for q in motion.positions:
        here = world.hand(q)
        assert abs(here.p[2] - hand.p[2]) <= 0.05
        assert np.arccos(np.clip(here.matrix()[:3, 2] @ hand.matrix()[:3, 2], -1, 1)) <= 0.1
    assert world.apply(path_constraints=place()).constraints == []
    ball = position(0.1, 0.2, 0.3, shape=("sphere", [0.4]), frame="arm7_base", link="arm7_elbow")
    (kept,) = world.apply(path_constraints=place(ball)).constraints
    assert (kept.type, kept.link) == ("distance", "arm7_elbow")
    world.refused("is for 'arm7_hnad'", path_constraints=place(orientation(link="arm7_hnad")))
    world.refused("'moon'", path_constraints=place(orientation(frame="moon")))
    world.refused("joint_constraints in path_constraints", path_constraints=joint_goal(world, world.ready))
    world.refused("is a cylinder", path_constraints=place(position(0, 0, 0, shape=("cylinder", [1, 1]))))
    several = {"primitives": [{"type": "sphere", "dimensions": [1]}] * 2, "primitive_poses": [{}, {}]}
    world.refused("several primitives", path_constraints=place(position(region=several)))
    world.refused("visibility_constraints", path_constraints={"visibility_constraints": [{}]})


@requests("trajectory_constraints", "reference_trajectories")
def references(world):
    empty = {"name": "", "joint_constraints": []}
    assert world.apply(
        path_constraints=empty, trajectory_constraints={"constraints": []}, reference_trajectories=[]
    ).goals
    world.refused("trajectory_constraints", trajectory_constraints={"constraints": [place(orientation())]})
    world.refused("reference_trajectories", reference_trajectories=[{"header": {}}])


@requests("goal_constraints")
def goal_constraints(world):
    problem = world.apply(joint_goal(world, world.ready), place(position(0.4, 0, 0.4)))
    assert [goal.type for goal in problem.goals] == [GoalType.JOINTS, GoalType.POSITION]
    world.refused("no goal_constraints", goal_constraints=[])


# --- start states -----------------------------------------------------------------------------------------------------


@starts("joint_state.header", "joint_state.name", "joint_state.position", "joint_state.effort")
def joint_state(world):
    world.planner.set_qpos("arm", world.ready)
    names, header = ["arm7_joint2", "torso_joint"], {"frame_id": "world", "stamp": {"sec": 1}}
    state = {"header": header, "name": names, "position": [0.2, 1], "effort": [3, 4]}
    problem = world.apply(start_state={"joint_state": state})
    assert near(problem.start, [*world.ready[:1], 0.2, *world.ready[2:]])
    assert problem.ignored_joints == ["torso_joint"]
    assert near(world.planner.get_qpos("arm"), world.ready)
    world.refused("did you mean 'arm7_joint2'?", start_state={"joint_state": state | {"name": ["arm7_jiont2", "x"]}})


@starts("joint_state.velocity")
def velocity(world):
    state = {"name": ["arm7_joint1"], "position": [0.2]}
    assert world.apply(start_state={"joint_state": state | {"velocity": [0.003]}}).start_velocity is None
    problem = world.apply(start_state={"joint_state": state | {"velocity": [0.3]}})
    assert problem.start_velocity.tolist() == [0.3, 0, 0, 0, 0, 0, 0]
    motion = world.planner.plan("arm", problem.start, problem.goals, start_velocity=problem.start_velocity)
    assert motion.velocities[0].tolist() == problem.start_velocity.tolist()
    world.refused("names 1 joints, but has 2 velocities", start_state={"joint_state": state | {"velocity": [1, 1]}})


@starts(*(f"multi_dof_joint_state.{f}" for f in ("header", "joint_names", "transforms", "twist", "wrench")))
def multi_dof_joint_state(world):
    moved = {"translation": [1, 0, 0.5], "rotation": [0, 0, 1, 0]}
    state = {"header": {"frame_id": "odom"}, "joint_names": ["base_joint"], "transforms": [moved], "wrench": [{}]}
    world.apply(start_state={"multi_dof_joint_state": state})
    base = world.base()
    assert near(base.p, [1, 0, 0.5])
    assert near(base.q, [0, 0, 1, 0])
    assert world.apply(start_state={"multi_dof_joint_state": {"header": {"frame_id": "of_no_joint"}}}).goals
    at_origin = {"joint_names": ["wheels"], "transforms": [{}]}
    assert world.apply(start_state={"multi_dof_joint_state": at_origin}).ignored_joints == ["wheels"]
    for change in (
        {"header": {"frame_id": "arm7_shoulder"}},
        {"joint_names": ["wheels"]},
        {"twist": [{"linear": [1, 0, 0]}]},
        {"transforms": []},
    ):
        world.refused("", start_state={"multi_dof_joint_state": state | change})


@starts("attached_collision_objects")
def attached_at_the_start(world):
    q = world.ready + 0.2
    cup = attached() | {"object": box("cup", *world.hand(q).p)}
    state = {"joint_state": {"name": world.joints, "position": q.tolist()}, "attached_collision_objects": [cup]}
    world.apply(start_state=state)
    world.planner.set_qpos("arm", q)
    assert near(world.planner.get_object_pose("cup").p, world.hand(q).p)
    detach = [{"object": {"id": "cup", "operation": 1}}]
    world.refused("detach it in the scene", start_state={"is_diff": True, "attached_collision_objects": detach})


@starts("is_diff")
def start_is_diff(world):
    world.load(robot_state={"attached_collision_objects": [attached()]})
    state = {"joint_state": {"name": ["arm7_joint1"], "position": [0.2]}}
    world.refused("the robot holds 'cup'", start_state=state)
    assert world.apply(start_state=state | {"is_diff": True}).goals
    assert world.apply(start_state=state | {"attached_collision_objects": [attached()]}).goals
    assert world.apply(start_state={}).goals


# --- goals ------------------------------------------------------------------------------------------------------------


@goals("constraints.name")
def constraint_name(world):
    world.refused("goal 1 ('up'): ", {"name": "up"} | place(position(0, 0, 1, frame="no_such_frame")))


@goals("constraints.joint_constraints", "joint_constraints.joint_name", "joint_constraints.position")
def joint_constraints(world):
    goal = world.goal(joint_goal(world, world.ready))
    assert goal.type == GoalType.JOINTS
    assert near(target(goal), world.ready)
    world.refused("'arm7_joint7' is left free", joint_goal(world, world.ready[:6]))
    world.refused("position_constraints are not supported", joint_goal(world, world.ready) | place(position(0, 0, 1)))
    world.refused("orientation_constraints are not supported", joint_goal(world, world.ready) | place(orientation()))
    wrong = [{"joint_name": "arm7_jiont1", "position": 0}]
    world.refused("did you mean 'arm7_joint1'?", {"joint_constraints": wrong})


@goals("joint_constraints.tolerance_above", "joint_constraints.tolerance_below", "joint_constraints.weight")
def joint_tolerances(world):
    upper = world.planner.get_joint_limits("arm")[:, 1]
    beyond = upper + 0.05
    goal = world.goal(joint_goal(world, beyond, tolerance_below=0.1, weight=0))
    assert near(target(goal), upper)
    goal = world.goal(joint_goal(world, beyond, tolerance_above=0.1, tolerance_below=0.01))
    world.planner.make_planner("arm", srmp.Auto())
    with pytest.raises(srmp.PlanningError, match="above the upper limit") as caught:
        world.planner.plan("arm", world.ready, goal)
    assert caught.value.status == srmp.Status.goal_invalid
    world.refused("tolerance_above is -1", joint_goal(world, beyond, tolerance_above=-1))


@goals("constraints.position_constraints", "position_constraints.header", "position_constraints.weight")
def position_constraints(world):
    goal = world.goal(place(position(0.4, 0, 0.4, weight=0.5)))
    assert goal.type == GoalType.POSITION
    assert near(target(goal), [0.4, 0, 0.4])
    world.refused("several position_constraints", place(position(0, 0, 1), position(0, 0, 1)))
    world.add(box("crate", 1, 0, 0, subframe_names=["lid"], subframe_poses=[at(0, 0, 0.2)]))
    world.planner.add_box("table", size=[1, 1, 0.1], pose=Pose(p=[0, 0, -2]))
    for frame, origin in {
        "": (0, 0, 0),
        "world": (0, 0, 0),
        "odom": (0, 0, 0),
        "/arm7_base": (0, 0, 0),
        "arm/arm7_base": (0, 0, 0),
        "crate": (1, 0, 0),
        "crate/lid": (1, 0, 0.2),
        "table": (0, 0, -2),
    }.items():
        assert near(target(world.goal(place(position(0.4, 0, 0.4, frame=frame)))), np.add(origin, (0.4, 0, 0.4)))
    world.refused("unknown frame 'no_such_frame'", place(position(0.4, 0, 0.4, frame="no_such_frame")))
    world.refused("did you mean 'crate/lid'?", place(position(0.4, 0, 0.4, frame="crate/lit")))
    world.refused("which the planned joints move", place(position(0, 0, 0.1, frame="arm7_hand")))


@goals("position_constraints.link_name", "position_constraints.target_point_offset")
def constrained_point(world):
    required = world.hand()
    required = Pose(p=np.add(required.p, [0, 0, 0.05]), q=required.q)  # of the point, with this orientation
    turned = orientation(*required.q)
    world.apply(start_state={"attached_collision_objects": [attached()]})
    offset = {"target_point_offset": {"x": 0.02, "y": 0, "z": 0.1}}
    for constraint, in_hand in (
        (position(*required.p, **offset), [0.02, 0, 0.1]),
        (position(*required.p, link="cup"), [0, 0, 0.1]),
        (position(*required.p, link="cup", **offset), [0.02, 0, 0.2]),
    ):
        goal = world.goal(place(constraint, turned))
        hand = Pose(p=target(goal)[:3], q=target(goal)[3:])
        assert near(hand @ in_hand, required.p)
    world.refused("without an orientation constraint", place(position(*required.p, **offset)))
    world.refused("not rigidly joined", place(position(*required.p, link="arm7_elbow"), turned))
    world.refused("did you mean 'arm7_hand'?", place(position(*required.p, link="arm7_hnad")))


@goals("position_constraints.constraint_region.primitives", "position_constraints.constraint_region.primitive_poses")
def regions(world):
    goal = world.goal(place(position(0.4, 0, 0.4, shape=("sphere", [0.03]))))
    assert near(goal.position_tolerance, 0.03 / np.sqrt(3))
    goal = world.goal(place(position(0.4, 0, 0.4, shape=("box", [0.02, 0.04, 0.06]))))
    assert near(goal.position_tolerance, [0.01, 0.02, 0.03])
    goal = world.goal(place(position(0.4, 0, 0.4, shape=("cylinder", [0.06, 0.02]))))
    assert near(goal.position_tolerance, [0.02 / np.sqrt(2), 0.02 / np.sqrt(2), 0.03])
    sphere = {"type": "sphere", "dimensions": [0.01]}
    either = {"primitives": [sphere, sphere], "primitive_poses": [at(0.4, 0, 0.4), at(0.5, 0, 0.4)]}
    problem = world.apply(place(position(region=either)))
    assert near([target(goal) for goal in problem.goals], [[0.4, 0, 0.4], [0.5, 0, 0.4]])
    world.refused("cone", place(position(0.4, 0, 0.4, shape=("cone", [0.1, 0.1]))))
    world.refused("2 shapes, but 1", place(position(region=either | {"primitive_poses": [at(0, 0, 0)]})))


@goals("position_constraints.constraint_region.meshes", "position_constraints.constraint_region.mesh_poses")
def mesh_regions(world):
    region = {"meshes": [TRIANGLE], "mesh_poses": [at(0, 0, 0)]}
    world.refused("has meshes", place(position(region=region)))
    world.refused("has mesh_poses", place(position(region=region | {"meshes": []})))


@goals("constraints.orientation_constraints", "orientation_constraints.orientation", "orientation_constraints.weight")
def orientation_constraints(world):
    goal = world.goal(place(orientation(1, 0, 0, 0, weight=2)))
    assert goal.type == GoalType.POSE
    assert near(target(goal)[3:], [1, 0, 0, 0])
    assert np.isinf(goal.position_tolerance).all()
    world.refused("several orientation_constraints", place(orientation(), orientation()))
    world.refused("has the length 2", place(orientation(0, 0, 0, 2)))


@goals("orientation_constraints.header", "orientation_constraints.link_name")
def constrained_orientation(world):
    turned = Pose(q=[0, 0, 1, 0])  # half a turn about z
    world.planner.add_box("table", size=[1, 1, 0.1], pose=Pose(p=[0, 0, -2], q=turned.q))
    goal = world.goal(place(orientation(1, 0, 0, 0, frame="table")))
    assert near(np.abs(target(goal)[3:]), [0, 1, 0, 0])
    world.refused("unknown frame 'no_such_frame'", place(orientation(frame="no_such_frame")))
    world.refused("not rigidly joined", place(position(0.4, 0, 0.4), orientation(link="arm7_upper_arm")))
    world.refused("did you mean 'arm7_hand'?", place(position(0.4, 0, 0.4), orientation(link="arm7_hamd")))


@goals(
    *(f"orientation_constraints.absolute_{axis}_axis_tolerance" for axis in "xyz"),
    "orientation_constraints.parameterization",
)
def rotation_tolerances(world):
    for parameterization in (0, 1):
        goal = world.goal(place(orientation(tolerance=(0.01, 0.02, 0.03), parameterization=parameterization)))
        assert near(goal.rotation_tolerance, [0.01, 0.02, 0.03], 1e-3)
        assert (np.asarray(goal.rotation_tolerance) <= [0.01, 0.02, 0.03]).all()
        free = world.goal(place(orientation(tolerance=(0.1, 0.1, 3.15), parameterization=parameterization)))
        assert np.isinf(free.rotation_tolerance).tolist() == [False, False, True]
        least = world.goal(place(orientation(tolerance=(0, 0, 0), parameterization=parameterization)))
        assert near(least.rotation_tolerance, 1e-4, 1e-6)
        anything = orientation(tolerance=(7, 7, 7), parameterization=parameterization)
        assert world.goal(place(position(0.4, 0, 0.4), anything)).type == GoalType.POSITION
        world.refused("nothing is asked for", place(anything))
    world.refused("tolerance is -0.1", place(orientation(tolerance=(-0.1, 0, 0))))
    world.refused("parameterization is 2", place(orientation(parameterization=2)))


@goals("constraints.visibility_constraints")
def visibility_constraints(world):
    world.refused("visibility_constraints", joint_goal(world, world.ready) | {"visibility_constraints": [{}]})


# --- scenes -----------------------------------------------------------------------------------------------------------


@scenes("name", "robot_model_name", "object_colors")
def labels(world):
    world.load(name="kitchen", robot_model_name="arm", object_colors=[{"id": "x", "color": {"r": 1}}])
    assert world.planner.object_names == []
    other = srmp.PlannerInterface()
    for name in ("left", "right"):
        other.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), name=name, end_effector="arm7_hand")
    world.planner = other
    state = {"joint_state": {"name": ["arm7_joint1"], "position": [0.3]}}
    world.load(robot_model_name="right", robot_state=state)
    assert other.get_qpos("right")[0] == 0.3
    assert other.get_qpos("left")[0] == 0
    with pytest.raises(srmp.InvalidArgument, match="in the robots 'left' and 'right'"):
        world.load(robot_model_name="middle", robot_state=state)
    with pytest.raises(srmp.InvalidArgument, match="write 'left/arm7_hand'"):
        world.add(box("box", 0, 0, 1, frame="arm7_hand"))
    world.add(box("box", 0, 0, 1, frame="left/arm7_hand"))


@scenes("robot_state.joint_state")
def scene_joints(world):
    upper = world.planner.get_joint_limits("arm")[1, 1]
    state = {
        "name": ["arm7_joint1", "arm7_joint2", "wheel"],
        "position": [0.3, float(upper) + 1, 2],
        "velocity": [1, 1, 1],
    }
    notes = world.load(robot_state={"joint_state": state})
    assert world.planner.get_qpos("arm")[0] == 0.3
    assert len(notes) == 2
    assert "'arm7_joint2'" in notes[0]
    assert "'wheel'" in notes[1]


@scenes("robot_state.multi_dof_joint_state")
def scene_base(world):
    state = {"joint_names": ["base_joint"], "transforms": [{"translation": [0, 0, 1]}]}
    world.add(box("box", 0, 0, 1, frame="arm7_base"), robot_state={"multi_dof_joint_state": state})
    assert near(world.base().p, [0, 0, 1])
    assert near(world.planner.get_object_pose("box").p, [0, 0, 2])


@scenes("robot_state.attached_collision_objects", "robot_state.is_diff", "is_diff")
def diffs(world):
    world.planner.add_box("table", size=[1, 1, 0.1], pose=Pose(p=[0, 0, -2]))
    world.add(box("old"), robot_state={"attached_collision_objects": [attached()], "is_diff": True})
    world.add(box("new"), is_diff=True)
    assert world.planner.object_names == ["cup", "new", "old", "table"]
    world.add(box("full"), is_diff=False)
    assert world.planner.object_names == ["full", "table"]
    world.scene_refused("'table'", world={"collision_objects": [box("table")]})


@scenes("fixed_frame_transforms")
def fixed_frames(world):
    lifted = {"translation": [0, 0, 2]}
    moveit = {"header": {"frame_id": "shelf"}, "child_frame_id": "odom", "transform": lifted}
    tf = {"header": {"frame_id": "shelf"}, "child_frame_id": "board", "transform": lifted}
    world.add(
        box("low", 0, 0, 1, frame="shelf"), box("high", 0, 0, 1, frame="board"), fixed_frame_transforms=[moveit, tf]
    )
    assert near(world.planner.get_object_pose("low").p, [0, 0, 3])
    assert near(world.planner.get_object_pose("high").p, [0, 0, 5])
    world.scene_refused("both unknown", fixed_frame_transforms=[tf])
    clash = {"header": {"frame_id": "odom"}, "child_frame_id": "arm7_base", "transform": lifted}
    world.scene_refused("stand differently", fixed_frame_transforms=[clash])
    world.scene_refused("unknown frame 'shelv'", world={"collision_objects": [box(frame="shelv")]})


@scenes("allowed_collision_matrix.entry_names", "allowed_collision_matrix.entry_values")
def matrix(world):
    names = ["box", "arm7_hand", "arm7_elbow", "arm7_upper_arm"]

    def load(hand, unknown="arm7_hand", **more):
        entries = np.zeros((4, 4), bool)
        entries[0, 1] = entries[1, 0] = hand
        matrix = {"entry_names": [names[0], unknown, *names[2:]], "entry_values": entries.tolist()}
        return world.add(box(), allowed_collision_matrix=matrix, **more)

    allowed = world.planner.allowed_collision
    notes = load(True)
    assert allowed("box", "arm7_hand")
    assert not allowed("box", "arm7_elbow")
    assert any("'arm/arm7_elbow'" in note for note in notes)  # neighbours, which the robot's own rules allow
    assert allowed("arm7_upper_arm", "arm7_elbow")
    load(False, is_diff=True)
    assert not allowed("box", "arm7_hand")
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'arm7_hand'"):
        load(True, unknown="arm7_hnad")
    load(False, unknown="torso")


@scenes("allowed_collision_matrix.default_entry_names", "allowed_collision_matrix.default_entry_values")
def defaults(world):
    allowed = world.planner.allowed_collision
    matrix = {"default_entry_names": ["box", "arm7_hand", "arm7_elbow"], "default_entry_values": [True, True, False]}
    world.add(box(), box("other", 3, 0, 0), allowed_collision_matrix=matrix)
    assert allowed("box", "arm7_shoulder")
    assert allowed("box", "other")
    assert allowed("box", "arm7_hand")
    assert allowed("other", "arm7_hand")
    assert not allowed("box", "arm7_elbow")
    assert not allowed("other", "arm7_shoulder")


@scenes("link_padding", "link_scale")
def padding(world):
    links = world.planner.get_link_names("arm")
    world.planner.add_sphere("ball", radius=0.1, pose=Pose(p=[0, 0, 3]))
    before = world.planner.distance_to_collision("arm", world.ready)
    world.load(link_padding=[{"link_name": link, "padding": 0.02} for link in links])
    assert near(world.planner.distance_to_collision("arm", world.ready), before - 0.02, 1e-6) or before < 0.1
    world.scene_refused("only one padding", link_padding=[{"link_name": "arm7_hand", "padding": 0.02}])
    world.scene_refused("did you mean 'arm7_hand'?", link_padding=[{"link_name": "arm7_hnad", "padding": 0.02}])
    world.scene_refused("must be 0 or above", link_padding=[{"link_name": "arm7_hand", "padding": -1}])
    world.load(link_scale=[{"link_name": "arm7_hand", "scale": 1}])
    world.scene_refused("scale of link 'arm7_hand'", link_scale=[{"link_name": "arm7_hand", "scale": 1.1}])


@scenes("world.collision_objects", "world.octomap")
def world_field(world):
    world.load(world={"collision_objects": [box("a"), box("b", 3, 0, 0)], "octomap": {"octomap": {"data": []}}})
    assert world.planner.object_names == ["a", "b"]
    world.scene_refused("octomap", world={"octomap": {"octomap": {"data": [1]}}})
    world.scene_refused("did you mean 'collision_objects'?", world={"collision_object": []})


# --- objects ----------------------------------------------------------------------------------------------------------


@objects("header", "pose", "id", "type", "primitives", "primitive_poses", "subframe_names", "subframe_poses")
def collision_objects(world):
    shapes = [
        {"type": kind, "dimensions": sizes}
        for kind, sizes in (("box", [0.1, 0.2, 0.3]), ("sphere", [0.1]), ("cylinder", [0.3, 0.1]), ("cone", [0.3, 0.1]))
    ]
    turned = at(1, 0, 0, xyzw=(0, 0, np.sqrt(0.5), np.sqrt(0.5)))  # a quarter turn about z
    rack = {"id": "rack", "type": {"key": "k", "db": ""}, "pose": turned, "primitives": shapes}
    rack |= {"primitive_poses": [at(0.1 * i, 0, 0) for i in range(4)]}
    rack |= {"subframe_names": ["top"], "subframe_poses": [at(0, 0, 1)]}
    unset = box("unset", pose=at(0, 0, 0, xyzw=(0, 0, 0, 0)))
    pose_of = world.planner.get_object_pose
    world.add(rack, unset)
    assert world.planner.object_names == ["rack", "rack_1", "rack_2", "rack_3", "unset"]
    assert near([pose_of(f"rack_{i}").p for i in (1, 2, 3)], [[1, 0.1, 0], [1, 0.2, 0], [1, 0.3, 0]])
    assert near(pose_of("unset").p, [2, 0, 0])
    world.add(box("on_it", 0, 0, 0.5, frame="rack/top"), box("beside", 1, 0, 0, frame="rack_1"), is_diff=True)
    assert near(pose_of("on_it").p, [1, 0, 1.5])
    assert near(pose_of("beside").p, [1, 1.1, 0])
    world.add(box("single", 0, 0, 1, pose=at(0, 0, 2)), is_diff=True)
    world.add(box("on_single", 0, 0, 0, frame="single"), is_diff=True)  # its frame is its pose, not its shape's
    assert near(pose_of("single").p, [0, 0, 3])
    assert near(pose_of("on_single").p, [0, 0, 2])
    saved = world.directory / "saved.json"
    world.planner.save_scene(str(saved))
    world.planner.load_scene(str(saved))
    assert near(target(world.goal(place(position(0.4, 0, 0, frame="rack/top")))), [1, 0.4, 1])
    wrong = rack | {"id": "wrong"}
    world.scene_refused("primitive_poses", world={"collision_objects": [wrong | {"primitive_poses": [at(0, 0, 0)]}]})
    world.scene_refused("subframe", world={"collision_objects": [wrong | {"subframe_poses": []}]})
    prism = [{"type": "prism", "dimensions": [1, 1]}] * 4
    world.scene_refused("prism", world={"collision_objects": [wrong | {"primitives": prism}]})
    world.scene_refused(
        "did you mean 'primitive_poses'?", world={"collision_objects": [wrong | {"primitve_poses": []}]}
    )


@objects("meshes", "mesh_poses")
def meshes(world):
    world.add({"id": "sheet", "meshes": [TRIANGLE], "mesh_poses": [at(0, 0, 3)]})
    assert near(world.planner.get_object_pose("sheet").p, [0, 0, 3])


@objects("planes", "plane_poses")
def planes(world):
    floor = {"id": "floor", "planes": [{"coef": [0, 0, 1, 0]}], "plane_poses": [at(0, 0, 0)]}
    world.scene_refused("plane", world={"collision_objects": [floor]})
    world.scene_refused("plane_poses", world={"collision_objects": [box(plane_poses=[at(0, 0, 0)])]})


@objects("operation")
def operations(world):
    pose_of = world.planner.get_object_pose
    handle = {"subframe_names": ["handle"], "subframe_poses": [at(0, 0, 0.1)]}
    world.add(box("a", **handle), box("b", 3, 0, 0))
    world.add(box("a", 4, 0, 0), is_diff=True)
    assert near(pose_of("a").p, [4, 0, 0])
    world.add(box("a", 0, 0, 1, operation=2, **handle), is_diff=True)
    assert near(pose_of("a_1").p, [4, 0, 1])
    world.add({"id": "a", "operation": "MOVE", "pose": at(0, 0, 5)}, is_diff=True)
    assert near([pose_of("a").p, pose_of("a_1").p], [[0, 0, 5], [0, 0, 6]])
    world.add(
        {"id": "a", "operation": 3, "pose": at(0, 0, 5), "primitive_poses": [at(1, 0, 0), at(2, 0, 0)]}, is_diff=True
    )
    assert near([pose_of("a").p, pose_of("a_1").p], [[1, 0, 5], [2, 0, 5]])
    assert near(target(world.goal(place(position(0.4, 0, 0, frame="a/handle")))), [0.4, 0, 5.1])
    world.add({"id": "a", "operation": 1}, is_diff=True)
    assert world.planner.object_names == ["b"]
    world.add({"operation": 1}, box("c"), is_diff=True)
    assert world.planner.object_names == ["c"]
    for wrong in (
        {"id": "gone", "operation": 1},
        {"id": "gone", "operation": 3},
        box("c", operation=3),
        box("c", operation=4),
        box("c", operation=2, pose=at(0, 0, 1)),
        {"id": "c", "operation": 3, "primitive_poses": [at(0, 0, 0)] * 2},
    ):
        world.scene_refused("", is_diff=True, world={"collision_objects": [wrong]})


# --- attached objects -------------------------------------------------------------------------------------------------


@attachments("link_name", "object", "touch_links", "detach_posture", "weight")
def attached_objects(world):
    pose_of = world.planner.get_object_pose

    def attach(*messages, **scene):
        return world.load(
            robot_state={"is_diff": True, "attached_collision_objects": list(messages)}, is_diff=True, **scene
        )

    world.planner.set_qpos("arm", world.ready)
    attach(attached(touch_links=["arm7_flange"], detach_posture={"joint_names": []}, weight=1.0))
    assert near(pose_of("cup").p, world.hand() @ [0, 0, 0.1])
    assert world.planner.allowed_collision("cup", "arm7_hand")
    assert world.planner.allowed_collision("cup", "arm7_flange")
    assert not world.planner.allowed_collision("cup", "arm7_elbow")
    held = pose_of("cup")
    attach({"object": {"id": "cup", "operation": 1}})
    world.planner.set_qpos("arm", world.ready + 0.2)
    assert near(pose_of("cup").p, held.p)
    attach({"link_name": "arm7_hand", "object": {"id": "cup"}})  # as it is
    assert near(pose_of("cup").p, held.p)
    world.planner.set_qpos("arm", world.ready)
    assert not near(pose_of("cup").p, held.p)
    attach({"link_name": "arm7_hand", "object": {"operation": 1}})
    for wrong, what in (
        (attached("arm7_hnad"), "did you mean 'arm7_hand'?"),
        (attached(touch_links=["arm7_flnage"]), "did you mean 'arm7_flange'?"),
        ({"link_name": "arm7_hand", "object": {"id": "gone"}}, "not in the scene"),
        ({"object": {"id": "cup", "operation": 1}}, "not attached"),
        ({"link_name": "arm7_hand", "object": {"id": "cup", "operation": 3}}, "moved"),
    ):
        state = {"is_diff": True, "attached_collision_objects": [wrong]}
        world.scene_refused(what, robot_state=state, is_diff=True)
    attach(attached())
    world.scene_refused(
        "detach it", is_diff=True, world={"collision_objects": [box("cup", operation=3) | {"primitives": []}]}
    )


@pytest.mark.parametrize(("section", "field"), [(section, field) for section in FIELDS for field in FIELDS[section]])
def test_every_row(section, field, world):
    SECTIONS[section][field](world)


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
