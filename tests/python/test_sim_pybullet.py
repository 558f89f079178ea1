"""PyBullet: read, compared, executed, grasped."""

import re
from pathlib import Path

import numpy as np
import pytest

import srmp

pytest.importorskip("pybullet", reason="pip install '.[pybullet]' to test what is said of PyBullet")

import pybullet
from pybullet_scenes import body, collision, cuboid, read, tetrahedra, urdf_body

HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])
OWN = {"panda": {"end_effector": "panda_hand"}}
SELF_COLLISION = pybullet.URDF_USE_SELF_COLLISION


def panda_urdf(mbm_dir, tmp_path):
    """With the paths of its meshes, and without the visual meshes."""
    directory = mbm_dir / "panda"
    text = (directory / "panda.urdf").read_text().replace("package://", f"{directory}/")
    path = tmp_path / "panda.urdf"
    path.write_text(re.sub(r"<visual>.*?</visual>", "", text, flags=re.S))
    return str(path)


def stl(path):
    """A triangle's prism without lids."""
    lower = np.array([[0.12, 0, -0.2], [-0.1, 0.1, -0.2], [-0.1, -0.1, -0.2]])
    upper = lower + np.array([0, 0, 0.4])
    record = np.zeros(6, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    for k in range(3):
        a, b, c, d = lower[k], lower[(k + 1) % 3], upper[k], upper[(k + 1) % 3]
        record["corners"][2 * k], record["corners"][2 * k + 1] = (a, b, d), (a, d, c)
    path.write_bytes(bytes(80) + np.uint32(6).tobytes() + record.tobytes())
    return str(path)


def every_geometry(client, directory):
    """All that PyBullet collides: 18 bodies, one of them filtered, and none is a robot."""
    p, random = pybullet, np.random.default_rng(0)
    turned = np.array([0.3, 0.1, 0.2, 0.7]) / np.linalg.norm([0.3, 0.1, 0.2, 0.7])
    obj, prism = tetrahedra(directory / "two.obj"), stl(directory / "prism.stl")
    heights = random.uniform(0, 0.2, size=9 * 7).tolist()
    field = {
        "heightfieldData": heights,
        "numHeightfieldRows": 9,
        "numHeightfieldColumns": 7,
        "meshScale": [0.1, 0.12, 1],
    }
    body(client, "floor", (p.GEOM_PLANE, {"planeNormal": [0, 0, 1]}), [0, 0, -0.6])
    body(client, "crate", (p.GEOM_BOX, {"halfExtents": [0.1, 0.1, 0.2]}), [0.5, 0.3, 0.1])
    body(client, "sphere", (p.GEOM_SPHERE, {"radius": 0.1}), [0.5, -0.3, 0.5])
    body(client, "pole", (p.GEOM_CYLINDER, {"radius": 0.05, "height": 0.8}), [-0.4, 0.4, 0.3], turned)
    body(client, "pill", (p.GEOM_CAPSULE, {"radius": 0.07, "height": 0.4}), [-0.4, -0.4, 0.5], turned)
    body(client, "rock", (p.GEOM_MESH, {"vertices": 0.08 * random.normal(size=(40, 3))}), [0, -0.5, 0.7])
    body(client, "hulls", (p.GEOM_MESH, {"fileName": obj, "meshScale": [1, 1.2, 1]}), [0.1, 0.4, 0.7], turned)
    shell = {"fileName": obj, "flags": p.GEOM_FORCE_CONCAVE_TRIMESH, "collisionFramePosition": [-0.1, 0, 0]}
    body(client, "shell", (p.GEOM_MESH, shell), [-0.5, 0, 0.6], turned)
    body(
        client,
        "hills",
        (p.GEOM_HEIGHTFIELD, field),
        [-0.6, 0, -0.2],
        turned * [0, 0, 1, 1] / np.linalg.norm(turned[2:]),
    )
    for k in range(3):
        body(client, f"cube{k}", (p.GEOM_BOX, {"halfExtents": [0.03] * 3}), [0.3 + 0.1 * k, 0.5, 0.4 + 0.2 * k], mass=1)
    ghost = body(client, "ghost", (p.GEOM_BOX, {"halfExtents": [0.1] * 3}), [0.3, 0, 0.5])
    p.setCollisionFilterGroupMask(ghost, -1, 0, 0, physicsClientId=client)
    parts = p.createCollisionShapeArray(
        shapeTypes=[p.GEOM_BOX, p.GEOM_CYLINDER],
        halfExtents=[[0.3, 0.3, 0.05], [0, 0, 0]],
        radii=[0, 0.05],
        lengths=[0, 0.5],
        collisionFramePositions=[[0, 0, 0], [0, 0, -0.3]],
        physicsClientId=client,
    )
    table = p.createMultiBody(0, parts, basePosition=[0, 0, -0.055], physicsClientId=client)
    p.addUserData(table, "name", "table", physicsClientId=client)
    mixed = (
        collision('<cylinder radius="0.06" length="0.2"/>', rpy="0.4 0 0")
        + collision(f'<mesh filename="{obj}"/>', "0.1 0 0.1", "0 0.5 0")
        + collision('<sphere radius="0.05"/>', "0 0.2 0")
        + collision('<box size="0.1 0.05 0.2"/>', "0 0.25 0.1", "0 0 0.7")
    )
    urdf_body(client, directory, "mixed", mixed, [0.75, 0.05, 0.75], turned)
    urdf_body(
        client,
        directory,
        "prism",
        collision(f'<mesh filename="{prism}" scale="0.7 0.7 0.7"/>'),
        [0.1, -0.4, 0.3],
        turned,
    )
    tube = collision(f'<mesh filename="{prism}"/>', "0 0 0.1", concave="yes")
    urdf_body(client, directory, "tube", tube, [-0.2, 0.5, 0.8], turned)
    can = collision('<cylinder radius="0.1" length="0.2"/>')
    urdf_body(client, directory, "can", can, [0.35, -0.5, 0.1], turned, p.URDF_USE_IMPLICIT_CYLINDER)


def set_state(client, robot, q):
    joints = [j for j in range(pybullet.getNumJoints(robot, client)) if pybullet.getJointInfo(robot, j, client)[2] == 0]
    for joint, value in zip(joints, q, strict=True):
        pybullet.resetJointState(robot, joint, value, physicsClientId=client)


@pytest.fixture
def sim(client, mbm_dir, tmp_path):
    every_geometry(client, tmp_path)
    robot = pybullet.loadURDF(
        panda_urdf(mbm_dir, tmp_path), useFixedBase=True, flags=SELF_COLLISION, physicsClientId=client
    )
    set_state(client, robot, HOME)
    links = {pybullet.getJointInfo(robot, j, client)[12]: j for j in range(pybullet.getNumJoints(robot, client))}
    pybullet.setCollisionFilterPair(
        robot, robot, links[b"panda_hand"], links[b"panda_link7"], 0, client
    )  # they overlap
    return client


def test_every_geometry_of_the_simulators_own_model_agrees(sim, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "pybullet", articulations=OWN)
    assert len(planner.object_names) >= 12
    sim_checks.parity(planner, sim)


def test_a_urdf_agrees_but_for_its_shapes(sim, mbm_dir, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "pybullet", articulations={"panda": sim_checks.panda(mbm_dir)})
    sim_checks.parity(planner, sim)


def test_random_plans_are_executed(sim, sim_checks):
    world = srmp.PlannerInterface().read_sim(sim, "pybullet", articulations=OWN)
    sim_checks.executes_random_plans(world, "panda")


def test_what_moved_is_avoided(sim, sim_checks):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(sim, "pybullet", articulations=OWN)
    cube = next(unique for unique in range(30) if world.simulator.name_of(unique) == "cube0")

    def put(pose):
        pybullet.resetBasePositionAndOrientation(cube, pose.p, pose.q, physicsClientId=sim)

    sim_checks.avoids_what_moved(world, "panda", put, size=0.06)


def state_of(client):
    """All that PyBullet tells of the bodies' motion, and the contacts."""
    p, state = pybullet, []
    for unique in (p.getBodyUniqueId(k, physicsClientId=client) for k in range(p.getNumBodies(physicsClientId=client))):
        state.append((p.getBasePositionAndOrientation(unique, client), p.getBaseVelocity(unique, client)))
        for joint in range(p.getNumJoints(unique, client)):
            state.append(p.getJointState(unique, joint, client)[:2])
            state.append(p.getLinkState(unique, joint, 1, 1, client))
    return [*state, p.getContactPoints(physicsClientId=client)]


def test_reading_and_probing_change_nothing(sim):
    pybullet.setGravity(0, 0, -9.8, physicsClientId=sim)
    robot = pybullet.getNumBodies(physicsClientId=sim) - 1
    for joint in range(7):  # a control that is at work, before and after
        pybullet.setJointMotorControl2(robot, joint, pybullet.POSITION_CONTROL, 0.3, force=87, physicsClientId=sim)
    for _ in range(20):
        pybullet.stepSimulation(sim)
    start = pybullet.saveState(physicsClientId=sim)
    before = state_of(sim)

    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "pybullet", articulations=OWN)
    assert srmp.sim.check_parity(planner, sim, samples=20)
    assert state_of(sim) == before

    for _ in range(20):
        pybullet.stepSimulation(sim)
    after = [pybullet.getJointState(robot, joint, sim)[0] for joint in range(7)]
    pybullet.restoreState(start, physicsClientId=sim)
    for _ in range(20):
        pybullet.stepSimulation(sim)
    again = [pybullet.getJointState(robot, joint, sim)[0] for joint in range(7)]
    np.testing.assert_allclose(after, again, atol=1e-6)
    assert np.abs(np.array(after) - HOME).max() > 0.01


# --- the package's own arm


def load_arm7(client, position=(0, 0, 0), turn=(0, 0, 0, 1), flags=SELF_COLLISION, name=""):
    robot = pybullet.loadURDF(
        srmp.data_path("arm7.urdf"), position, turn, useFixedBase=True, flags=flags, physicsClientId=client
    )
    if name:
        pybullet.addUserData(robot, "name", name, physicsClientId=client)
    return robot


@pytest.fixture
def small(client):
    """The package's own arm, a floor, a post and a loose cube."""
    pybullet.setGravity(0, 0, -9.8, physicsClientId=client)
    load_arm7(client)
    body(client, "floor", (pybullet.GEOM_PLANE, {"planeNormal": [0, 0, 1]}), [0, 0, -0.001])
    cuboid(client, "post", [0.05, 0.05, 0.3], [0.4, 0.4, 0.3])
    cuboid(client, "cube", [0.03] * 3, [0.4, -0.4, 0.03], mass=0.1)
    return client


CUBE = 3  # its number in the small scene


def test_the_packages_own_arm_agrees_and_moves(small, sim_checks):
    planner, world = read(small)
    assert planner.robot_names == ["arm7"]
    assert planner.object_names == ["cube", "floor", "post"]
    assert planner.get_link_names("arm7")[0] == "arm7_base"
    assert [row[2] for row in planner.get_joint_limits("arm7")] == [2.2, 2.2, 2.4, 2.4, 3.0, 3.0, 3.0]
    assert world is planner.simulated_world
    sim_checks.parity(planner, small, samples=300)
    sim_checks.executes_random_plans(world, "arm7", count=3)


def test_frames_of_links_with_turned_inertial_frames(client, tmp_path, sim_checks):
    inertial = '<inertial><origin xyz="0.03 -0.02 0.05" rpy="0.4 0.3 -0.6"/><mass value="1"/>'
    inertial += '<inertia ixx="0.02" iyy="0.03" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'

    def link(name, geometry):
        return f'<link name="{name}">{inertial}{collision(geometry, "0.02 0.05 0.1", "0.2 0 0.5")}</link>'

    def joint(name, kind, parent, child, axis):
        origin = '<origin xyz="0.1 0.02 0.25" rpy="0.3 -0.2 0.5"/>'
        limit = "" if kind == "continuous" else '<limit lower="-0.4" upper="0.3" velocity="1"/>'
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return f'<joint name="{name}" type="{kind}">{origin}{ends}<axis xyz="{axis}"/>{limit}</joint>'

    parts = [
        link("base", '<box size="0.1 0.1 0.2"/>'),
        joint("turn", "continuous", "base", "first", "0 0.6 0.8"),
        link("first", '<capsule radius="0.05" length="0.2"/>'),
        joint("lift", "prismatic", "first", "second", "1 0 0"),
        link("second", '<sphere radius="0.06"/>'),
        joint("glue", "fixed", "second", "third", "1 0 0"),
        link("third", '<box size="0.1 0.2 0.05"/>'),
        joint("lean", "revolute", "third", "fourth", "0 0 1"),
        link("fourth", '<cylinder radius="0.04" length="0.3"/>'),
    ]
    path = tmp_path / "odd.urdf"
    path.write_text(f'<robot name="odd">{"".join(parts)}</robot>')
    turn = np.array([0.1, 0.2, 0.3, 0.9]) / np.linalg.norm([0.1, 0.2, 0.3, 0.9])
    pybullet.loadURDF(str(path), [0.1, 0.2, 0.3], turn, useFixedBase=True, flags=SELF_COLLISION, physicsClientId=client)
    cuboid(client, "post", [0.1, 0.1, 0.5], [0.5, 0.2, 0.8])
    planner, _ = read(client)
    assert planner.get_joint_names("odd") == ["turn", "lift", "lean"]
    limits = planner.get_joint_limits("odd")
    assert limits[0, 1] == np.inf
    np.testing.assert_allclose(limits[1], [-0.4, 0.3, 1.0])
    sim_checks.parity(planner, client, samples=300)


def test_an_arm_whose_links_go_through_each_other(client, sim_checks):
    """Without URDF_USE_SELF_COLLISION the planner keeps its own mind, and the report says that it does."""
    load_arm7(client, flags=0)
    planner, _ = read(client)
    report = srmp.sim.check_parity(planner, client, samples=2000)
    assert report, report
    assert report.collisions["planner"] > 0
    assert report.collisions["pybullet"] == 0
    assert set(report.not_compared.values()) == {"pybullet lets them through each other"}


def test_filters_become_allowed_collisions(small):
    p = pybullet
    ghost = cuboid(small, "ghost", [0.1] * 3, [0.2, 0, 0.5])
    p.setCollisionFilterGroupMask(ghost, -1, 0, 0, physicsClientId=small)
    links = {p.getJointInfo(0, j, small)[12].decode(): j for j in range(p.getNumJoints(0, small))}
    p.setCollisionFilterPair(0, 2, links["arm7_elbow"], -1, 0, physicsClientId=small)
    p.setCollisionFilterPair(0, 0, links["arm7_hand"], links["arm7_upper_arm"], 0, physicsClientId=small)
    second = load_arm7(small, [1, 0, 0], name="second")
    p.setCollisionFilterPair(0, second, links["arm7_hand"], links["arm7_hand"], 0, physicsClientId=small)
    planner, _ = read(small)
    allowed = planner.allowed_collision
    assert all(allowed(f"arm7/{link}", "ghost") for link in planner.get_link_names("arm7"))
    assert allowed("arm7/arm7_elbow", "post")
    assert not allowed("arm7/arm7_forearm", "post")
    assert allowed("arm7/arm7_base", "floor")  # neither can move
    assert not allowed("arm7/arm7_shoulder", "floor")
    assert allowed("arm7/arm7_hand", "arm7/arm7_upper_arm")
    assert not allowed("arm7/arm7_wrist", "arm7/arm7_shoulder")
    assert allowed("arm7/arm7_hand", "second/arm7_hand")
    assert not allowed("arm7/arm7_hand", "second/arm7_palm")


def test_refresh_moves_adds_and_removes(small):
    p = pybullet
    planner, world = read(small)
    p.resetJointState(0, 1, 0.5, physicsClientId=small)
    p.resetBasePositionAndOrientation(CUBE, [0.7, 0, 0.5], [0, 0, 0, 1], physicsClientId=small)
    world.refresh()
    assert planner.get_qpos("arm7")[1] == 0.5
    assert planner.get_object_pose("cube").p[0] == 0.7

    p.removeBody(2, physicsClientId=small)  # the post; its number goes to the next body
    sphere = body(small, "sphere", (p.GEOM_SPHERE, {"radius": 0.1}), [0, 0.5, 0.5])
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=0.1, physicsClientId=small)
    unnamed = p.createMultiBody(0, shape, -1, [9, 0, 0], physicsClientId=small)
    world.refresh()
    assert sphere == 2
    assert planner.object_names == [f"body{unnamed}", "cube", "floor", "sphere"]
    assert planner.is_state_colliding("arm7", [np.pi / 2, 1.1, 0, 0, 0, 0, 0])

    p.removeBody(sphere, physicsClientId=small)
    assert cuboid(small, "sphere", [0.1] * 3, [0, 0.5, 0.5]) == sphere  # the same name, place and size: another shape
    world.refresh()
    planner.set_qpos("arm7", [0.0] * 7)
    planner.add_sphere("probe", radius=0.01, pose=srmp.Pose(p=[0.09, 0.59, 0.59]))
    shape = next(b for b in world.simulator.bodies() if b.name == "sphere").geometries[0].shape
    assert isinstance(shape, srmp.sim.shapes.Box)


def grasp(client, planner, in_hand):
    """The cube at this place in the hand, with a constraint."""
    at = planner.compute_fk("arm7", planner.get_qpos("arm7")) @ srmp.Pose(p=in_hand)
    pybullet.resetBasePositionAndOrientation(CUBE, at.p, at.q, physicsClientId=client)
    hand = pybullet.getNumJoints(0, client) - 1
    fixed = pybullet.JOINT_FIXED
    return pybullet.createConstraint(0, hand, CUBE, -1, fixed, [0] * 3, in_hand, [0] * 3, physicsClientId=client)


def test_what_is_grasped_is_held_where_it_is(small):
    p = pybullet
    planner, world = read(small)
    constraint = grasp(small, planner, [0.001, 0.002, -0.001])
    world.grasp(CUBE, "arm7")  # the name "cube" would do, too
    planner.make_planner("arm7", {"planner_id": "auto", "time_limit": 10})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, planner.get_qpos("arm7") + np.array([0.4, 0.3, 0, 0.2, 0, 0, 0]))
    execution = world.execute(planner.plan("arm7", planner.get_qpos("arm7"), goal))
    assert execution.final_error <= 0.01
    assert not execution.unexpected_contacts
    held = planner.compute_fk("arm7", planner.get_qpos("arm7")).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.001, 0.002, -0.001], atol=1e-3)  # the constraint is soft
    there = p.getBasePositionAndOrientation(CUBE, small)[0]
    np.testing.assert_allclose(planner.get_object_pose("cube").p, there, atol=1e-6)
    with pytest.raises(srmp.InvalidArgument, match="attached"):
        world.grasp("cube", "arm7")

    p.removeConstraint(constraint, physicsClientId=small)
    p.resetBasePositionAndOrientation(CUBE, [0.6, 0, 0.03], [0, 0, 0, 1], physicsClientId=small)
    world.release("cube")
    assert planner.get_object_pose("cube").p[0] == 0.6
    with pytest.raises(srmp.InvalidArgument, match="'cube' is not held"):
        world.release("cube")


def test_what_touches_the_cube_may_touch_it(small):
    planner, world = read(small)
    grasp(small, planner, [0, 0, -0.05])  # into the palm
    world.grasp("cube", "arm7")
    assert planner.allowed_collision("arm7/arm7_palm", "cube")
    assert not planner.allowed_collision("arm7/arm7_forearm", "cube")


def test_two_arms_at_once(client):
    pybullet.setGravity(0, 0, -9.8, physicsClientId=client)
    load_arm7(client, name="left")
    load_arm7(client, [0.8, 0, 0], [0, 0, 1, 0], name="right")
    planner, world = read(client, articulations=[0, 1])
    assert planner.robot_names == ["left", "right"]
    planner.make_planner(["left", "right"], {"planner_id": "xECBS", "time_limit": 20})
    lean = np.array([0.4, 0.8, 0, 0.9, 0, 0.4, 0])
    goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, lean) for name in ("left", "right")}
    execution = world.execute(planner.plan_multi({name: planner.get_qpos(name) for name in goals}, goals))
    assert execution.final_error <= 0.01
    assert set(execution.positions) == {"left", "right"}
    assert not execution.unexpected_contacts


def test_names(client):
    """Of the URDF, of the user, or of the number; two of one name are told apart, and keep their names."""
    directory = str(Path(pytest.importorskip("pybullet_data").getDataPath()))
    spheres = [pybullet.loadURDF(f"{directory}/sphere_small.urdf", [k, 0, 1], physicsClientId=client) for k in range(2)]
    load_arm7(client)
    second = load_arm7(client, [3, 0, 0])
    robot = pybullet.loadURDF(f"{directory}/r2d2.urdf", [6, 0, 1], physicsClientId=client)
    planner, world = read(client, articulations=["arm7", second])
    assert planner.robot_names == ["arm7", f"arm7_{second}"]
    assert {"urdf_robot", f"urdf_robot_{spheres[1]}"} <= set(planner.object_names)
    assert "physics/head" in planner.object_names  # of an articulation that is no robot
    pybullet.removeBody(spheres[0], physicsClientId=client)
    world.refresh()
    assert "urdf_robot" not in planner.object_names
    assert f"urdf_robot_{spheres[1]}" in planner.object_names
    assert world.simulator.name_of(robot) == "physics"


def test_two_clients_and_the_ways_to_name_one(small):
    from pybullet_utils.bullet_client import BulletClient

    other = BulletClient(pybullet.DIRECT)
    other.createMultiBody(0, other.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1))
    planner, world = read(other)
    assert planner.object_names == ["body0"]
    assert world.simulator.is_of(other._client)
    planner, world = read(small)
    assert planner.robot_names == ["arm7"]
    with pytest.raises(srmp.InvalidArgument, match="not the scene that the planner has read"):
        srmp.sim.check_parity(planner, other)
    if small == 0:
        assert world.simulator.is_of(pybullet)


# --- what is refused: one sentence, and nothing was read


def refused(error, match, sim, **options):
    planner = srmp.PlannerInterface()
    planner.add_box("mine", size=[0.1] * 3)
    with pytest.raises(error, match=match):
        planner.read_sim(sim, "pybullet", **options)
    assert planner.robot_names == []
    assert planner.object_names == ["mine"]
    assert planner.simulated_world is None


@pytest.mark.parametrize(
    ("match", "articulations"),
    [
        (r"unknown articulation 'arm6'; did you mean 'arm7'\?", ["arm6"]),
        (r"unknown articulation 'gripper'; known: arm7", {"gripper": {}}),
        (r"unknown articulation 'cube'", ["cube"]),
        (r"PyBullet's client \d+ has no body 77", [77]),
    ],
)
def test_robots_that_are_not_there(match, articulations, small):
    refused(srmp.InvalidArgument, match, small, articulations=articulations)


def test_a_joint_that_does_not_match(small):
    text = Path(srmp.data_path("arm7.urdf")).read_text().replace("arm7_joint4", "arm7_join4")
    match = r"robot 'arm7' has a joint 'arm7_join4', articulation 'arm7' has none of that name; did you mean"
    description = {"urdf_text": text, "end_effector": "arm7_hand"}
    refused(srmp.InvalidArgument, match, small, articulations={"arm7": description})


def test_scenes_of_another_kind(small):
    refused(srmp.InvalidArgument, "a PyBullet scene is a client's number, .*, not dict", {})
    refused(srmp.InvalidArgument, "a PyBullet scene is a client's number, .*, not bool", True)
    refused(srmp.InvalidArgument, "PyBullet's client 77 is not connected", 77)
    refused(srmp.InvalidArgument, "a PyBullet scene is a client's number, .*, not NoneType", None)


def test_a_client_that_is_gone(client):
    other = pybullet.connect(pybullet.DIRECT)
    load_arm7(other)
    planner, world = read(other)
    pybullet.disconnect(other)
    for use in (world.refresh, lambda: srmp.sim.check_parity(planner, other)):
        with pytest.raises(srmp.InvalidArgument, match=f"PyBullet's client {other} is not connected"):
            use()


def test_shapes_that_cannot_be_read(small):
    p = pybullet
    box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.1] * 3, physicsClientId=small)
    far = p.createMultiBody(1, box, -1, [5, 0, 3], useMaximalCoordinates=True, physicsClientId=small)
    p.addUserData(far, "name", "far", physicsClientId=small)
    match = r"object 'far': a body with useMaximalCoordinates cannot be read; exclude=\['far'\] leaves it out"
    refused(srmp.NotSupported, match, small)
    planner, _ = read(small, exclude=["far"])
    assert planner.object_names == ["cube", "floor", "post"]
    p.removeBody(far, physicsClientId=small)

    corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
    faces = [0, 1, 2, 0, 1, 3, 0, 2, 3, 1, 2, 3]
    surface = p.createCollisionShape(p.GEOM_MESH, vertices=corners, indices=faces, physicsClientId=small)
    p.createMultiBody(0, surface, -1, [5, 0, 3], physicsClientId=small)
    refused(srmp.NotSupported, "object 'body4': a mesh of triangles without a file cannot be read", small)


def test_a_soft_body(client, tmp_path):
    pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD, physicsClientId=client)
    directory = pytest.importorskip("pybullet_data").getDataPath()
    pybullet.loadSoftBody(f"{directory}/cloth_z_up.obj", mass=1, useMassSpring=1, physicsClientId=client)
    refused(srmp.NotSupported, "object 'cloth_z_up': a soft body cannot be read", client)


def test_a_missing_package(small, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pybullet", None)
    refused(srmp.NotSupported, r"needs the Python package 'pybullet'.*pip install pybullet", small)


def test_a_clock_of_its_own(small):
    planner, world = read(small)
    pybullet.setRealTimeSimulation(1, physicsClientId=small)
    with pytest.raises(srmp.NotSupported, match=r"setRealTimeSimulation\(0\)"):
        world.execute(srmp.Trajectory(planner.get_joint_names("arm7"), np.zeros((2, 7)), times=[0, 1]))
