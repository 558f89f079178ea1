"""MoveIt's requests, start states and goals: every row of their tables in docs/moveit.md has a test here."""

import numpy as np
import pytest
from moveit_messages import (
    IN_REQUESTS,
    SECTIONS,
    TRIANGLE,
    World,
    at,
    attached,
    box,
    joint_goal,
    near,
    orientation,
    place,
    position,
    row,
    rows_of,
    target,
)

import srmp
from srmp import GoalType, Pose


@pytest.fixture
def world(tmp_path):
    return World(tmp_path)


def requests(*fields):
    return row("Motion plan requests", *fields)


def starts(*fields):
    return row("Start states", *(f"start_state.{field}" for field in fields))


def goals(*fields):
    return row("Goals", *fields)


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


@pytest.mark.parametrize(("section", "field"), rows_of(IN_REQUESTS))
def test_every_row(section, field, world):
    SECTIONS[section][field](world)
