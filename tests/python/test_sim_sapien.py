"""SAPIEN: read, compared, executed, grasped."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import srmp

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of a machine without Vulkan
    sapien = pytest.importorskip("sapien", reason="pip install '.[sapien]' to test what is said of SAPIEN")
from srmp.sim.sapien import Sapien, _Masses

px = sapien.physx
HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])
TURNED = np.array([0.7, 0.3, 0.1, 0.2]) / np.linalg.norm([0.7, 0.3, 0.1, 0.2])
MATERIAL = px.PhysxMaterial(0.5, 0.5, 0.0)


def new_scene():
    scene = sapien.Scene([px.PhysxCpuSystem()])
    scene.set_timestep(1 / 240)
    return scene


def add(scene, name, place, *shapes, kind="static", turn=(1, 0, 0, 0), groups=None):
    """A body of these shapes; a dynamic one does not fall."""
    component = px.PhysxRigidStaticComponent() if kind == "static" else px.PhysxRigidDynamicComponent()
    if kind != "static":
        component.disable_gravity = True
        component.kinematic = kind == "kinematic"
    for shape in shapes:
        if groups is not None:
            shape.set_collision_groups(groups)
        component.attach(shape)
    entity = sapien.Entity()
    entity.name = name
    entity.add_component(component)
    entity.pose = sapien.Pose(place, list(turn))
    scene.add_entity(entity)
    return entity


def box(*half_size):
    return px.PhysxCollisionShapeBox(half_size, MATERIAL)


def mesh(vertices, triangles, scale=(1, 1, 1)):
    return px.PhysxCollisionShapeTriangleMesh(
        np.asarray(vertices, dtype=np.float32), np.asarray(triangles, dtype=np.uint32), scale, MATERIAL
    )


def hills():
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 9), np.linspace(-0.4, 0.4, 9))
    vertices = np.stack([x.ravel(), y.ravel(), 0.2 * np.random.default_rng(1).uniform(size=81)], axis=1)
    number = np.arange(81).reshape(9, 9)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    return mesh(vertices, np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]))


def bracket():
    """An L, 0.3 x 0.2 x 0.06 m."""
    corners = 0.2 * np.array([[0, 0], [1, 0], [1, 0.3], [0.3, 0.3], [0.3, 1], [0, 1]])
    vertices = np.concatenate([np.insert(corners, 2, z, axis=1) for z in (0, 0.06)])
    bottom = np.array([[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]])
    i, j = np.arange(6), np.roll(np.arange(6), -1)
    sides = [np.stack([i, j, j + 6], axis=1), np.stack([i, j + 6, i + 6], axis=1)]
    return mesh(vertices, np.concatenate([bottom, bottom[:, ::-1] + 6, *sides]), scale=(1.5, 1, 1))


def add_cabinet(scene):
    """An articulation that is no robot: a drawer, half open."""
    builder = scene.create_articulation_builder()
    builder.set_initial_pose(sapien.Pose([0.1, 0.75, 0.2]))
    body = builder.create_link_builder()
    body.set_name("body")
    body.add_box_collision(half_size=[0.2, 0.02, 0.2])
    drawer = builder.create_link_builder(body)
    drawer.set_name("drawer")
    drawer.set_joint_name("slide")
    drawer.add_box_collision(half_size=[0.15, 0.1, 0.05])
    along_y = [0.5**0.5, 0, 0, -(0.5**0.5)]
    drawer.set_joint_properties(
        "prismatic", [[0, 0.2]], sapien.Pose([0, -0.12, 0], along_y), sapien.Pose([0, 0, 0], along_y)
    )
    cabinet = builder.build(fix_root_link=True)
    cabinet.name = "cabinet"
    cabinet.qpos = [0.05]
    return cabinet


def add_panda(scene, mbm_dir: Path, directory: Path):
    """The Panda's URDF as SAPIEN reads it; links that always touch are kept apart by an SRDF."""
    text = (mbm_dir / "panda" / "panda.urdf").read_text().replace("package://", f"{mbm_dir}/panda/")
    (directory / "panda.urdf").write_text(re.sub(r"<visual>.*?</visual>|<mimic.*?</mimic>", "", text, flags=re.S))
    apart = [("panda_link7", "panda_hand"), ("panda_link5", "panda_link7"), ("panda_leftfinger", "panda_rightfinger")]
    pairs = "".join(f'<disable_collisions link1="{a}" link2="{b}" reason="Default"/>' for a, b in apart)
    (directory / "panda.srdf").write_text(f'<robot name="panda">{pairs}</robot>')
    panda = scene.create_urdf_loader().load(str(directory / "panda.urdf"))
    panda.name = "panda"
    panda.qpos = HOME
    return panda


@pytest.fixture
def sim(mbm_dir, tmp_path):
    """A Panda among a plane, boxes, a sphere, a cylinder, a capsule, meshes of both kinds, a cabinet and more."""
    scene = new_scene()
    scene.add_ground(-0.6, render=False)
    add(scene, "crate", [0.5, 0.3, 0.1], box(0.1, 0.1, 0.2))
    add(scene, "sphere", [0.5, -0.3, 0.5], px.PhysxCollisionShapeSphere(0.1, MATERIAL))
    add(scene, "pole", [-0.4, 0.4, 0.3], px.PhysxCollisionShapeCylinder(0.05, 0.4, MATERIAL), turn=TURNED)
    pill = px.PhysxCollisionShapeCapsule(0.07, 0.2, MATERIAL)
    add(scene, "pill", [-0.4, -0.4, 0.5], pill, turn=TURNED, kind="kinematic")
    points = np.random.default_rng(0).normal(size=(40, 3)).astype(np.float32)
    add(scene, "rock", [0, -0.5, 0.7], px.PhysxCollisionShapeConvexMesh(points, [0.08, 0.06, 0.1], MATERIAL))
    add(scene, "hills", [-0.6, 0, -0.2], hills())
    add(scene, "bracket", [0, 0.5, 0.5], bracket(), turn=TURNED, kind="kinematic")
    add(scene, "ghost", [0.3, 0, 0.5], box(0.1, 0.1, 0.1), groups=[2, 2, 0, 0])
    for k in range(3):
        add(scene, "cube", [0.3 + 0.1 * k, 0.5, 0.4 + 0.2 * k], box(0.03, 0.03, 0.03), kind="dynamic")
    add(scene, "", [-0.2, -0.6, 0.2], box(0.05, 0.05, 0.05))
    leg = px.PhysxCollisionShapeCylinder(0.05, 0.25, MATERIAL)
    leg.local_pose = sapien.Pose([0, 0, -0.3], [0.5**0.5, 0, 0.5**0.5, 0])
    add(scene, "table", [0, 0, -0.051], box(0.3, 0.3, 0.05), leg)
    add_cabinet(scene)
    add_panda(scene, mbm_dir, tmp_path)
    return scene


OWN = {"panda": {"end_effector": "panda_hand"}}


def test_every_geometry_of_the_simulators_own_model_agrees(sim, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "sapien", articulations=OWN)
    assert {"cube", "cube_2", "cube_3", "cabinet/drawer", "table/0", "table/1"} < set(planner.object_names)
    sim_checks.parity(planner, sim)


def test_a_urdf_agrees_but_for_its_shapes(sim, mbm_dir, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "sapien", articulations={"panda": sim_checks.panda(mbm_dir)})
    sim_checks.parity(planner, sim)


def state_of(scene):
    """Everything that a step would change, to the last bit."""
    system = scene.physx_system
    joints = [joint for arm in scene.get_all_articulations() for joint in arm.active_joints]
    controls = [(joint.stiffness, joint.damping, joint.drive_target, joint.drive_velocity_target) for joint in joints]
    contacts = [[(point.separation, *point.impulse) for point in contact.points] for contact in scene.get_contacts()]
    forces = [arm.qf.tobytes() for arm in scene.get_all_articulations()]
    return system.pack(), scene.pack_poses(), repr(controls), contacts, forces, px.get_scene_config().enable_pcm


def test_the_comparison_leaves_the_scene_as_it_was(sim):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "sapien", articulations=OWN)
    for _ in range(3):
        sim.step()
    before = state_of(sim)
    srmp.sim.check_parity(planner, sim, samples=20)
    assert state_of(sim) == before


def test_random_plans_are_executed(sim, sim_checks):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(sim, "sapien", articulations=OWN)
    sim_checks.executes_random_plans(world, "panda")


def test_what_moved_is_avoided(sim, sim_checks):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(sim, "sapien", articulations=OWN)
    cube = next(entity for entity in sim.entities if entity.name == "cube")

    def put(pose):
        cube.pose = sapien.Pose(pose.p)

    sim_checks.avoids_what_moved(world, "panda", put, size=0.06)


def add_arm7(scene, name="arm", place=(0, 0, 0), turn=(1, 0, 0, 0)):
    arm = scene.create_urdf_loader().load(srmp.data_path("arm7.urdf"))
    arm.name = name
    arm.root_pose = sapien.Pose(list(place), list(turn))
    return arm


def small_scene():
    """The package's own arm, a box and a loose cube."""
    scene = new_scene()
    scene.add_ground(0, render=False)
    add(scene, "post", [0.4, 0.4, 0.3], box(0.05, 0.05, 0.3))
    cube = add(scene, "cube", [0.4, -0.4, 0.03], box(0.03, 0.03, 0.03), kind="dynamic")
    return scene, add_arm7(scene), cube


def read(scene, **options):
    planner = srmp.PlannerInterface()
    options.setdefault("articulations", ["arm"])
    return planner, planner.read_sim(scene, "sapien", **options)


def base_of(planner, robot):
    return planner.compute_fk(robot, planner.get_qpos(robot), "arm7_base")


def test_the_packages_own_arm_agrees(sim_checks):
    scene, arm, _ = small_scene()
    planner, world = read(scene, articulations=None)
    assert planner.robot_names == ["arm"]
    assert planner.object_names == ["cube", "ground", "post"]
    assert planner.get_link_names("arm")[0] == "arm7_base"  # without the articulation's name
    assert world is planner.simulated_world
    assert world.simulator.name_of(arm) == "arm"
    sim_checks.parity(planner, scene, samples=300)


def test_articulations_are_named_by_their_handles_too():
    scene, arm, _ = small_scene()
    planner, _ = read(scene, articulations=[arm])
    assert planner.robot_names == ["arm"]


def test_what_has_no_name_or_not_its_own_gets_a_number():
    scene = new_scene()
    for x in (0, 2):
        scene.create_urdf_loader().load(srmp.data_path("arm7.urdf")).root_pose = sapien.Pose([x, 0, 0])
    entities = [add(scene, "", [0, 1 + k, 0], box(0.1, 0.1, 0.1)) for k in range(2)]
    planner, world = read(scene, articulations=None)
    assert planner.robot_names == ["arm7_base", "arm7_base_2"]
    assert base_of(planner, "arm7_base_2").p[0] == 2
    names = [f"body{entity.per_scene_id}" for entity in entities]
    assert planner.object_names == names
    scene.remove_entity(entities[0])
    world.refresh()
    assert planner.object_names == names[1:]


def no_drive(joint):
    pass


def drive(joint):
    joint.set_drive_properties(stiffness=2000, damping=200)


@pytest.mark.parametrize("control", [no_drive, drive])
def test_joints_with_and_without_drives_follow(control, sim_checks):
    scene, arm, _ = small_scene()
    for joint in arm.active_joints:
        control(joint)
    _, world = read(scene)
    sim_checks.executes_random_plans(world, "arm", count=3)
    stiffness = {joint.stiffness for joint in arm.active_joints}
    assert stiffness == ({2000.0} if control is drive else {3e5})


def test_forces_hold_and_accelerate_the_links():
    """PhysX knows the weight of all links, Pinocchio the inertia; links may be told not to feel gravity."""
    _scene, arm, _ = small_scene()
    arm.qpos = [0.3, 0.5, -0.4, 1.0, 0.2, 0.6, 0.1]
    accelerations = np.array([1.0, -2, 3, -4, 5, -6, 7])

    def forces(accelerations, of):
        for link in arm.links:
            link.disable_gravity = link.name not in of
        return _Masses(arm, np.array([0, 0, -9.81])).forces(accelerations)

    names = {link.name for link in arm.links}
    some = {"arm7_forearm", "arm7_palm"}
    weight = forces(np.zeros(7), names)
    np.testing.assert_allclose(weight, arm.compute_passive_force(coriolis_and_centrifugal=False), atol=1e-4)
    np.testing.assert_allclose(forces(np.zeros(7), some) + forces(np.zeros(7), names - some), weight, atol=1e-9)
    inertia = arm.create_pinocchio_model(gravity=[0, 0, 0]).compute_inverse_dynamics(
        arm.qpos, np.zeros(7), accelerations
    )
    np.testing.assert_allclose(forces(accelerations, set()), inertia, atol=1e-4)


def test_filters_become_allowed_collisions():
    scene, arm, cube = small_scene()
    add(scene, "ghost", [0.2, 0, 0.5], box(0.1, 0.1, 0.1), groups=[2, 2, 0, 0])
    add(scene, "other_scene", [0.2, 0.3, 0.5], box(0.1, 0.1, 0.1), groups=[1, 1, 0, 1 << 16])
    add(scene, "one_way", [0.2, -0.3, 0.5], box(0.1, 0.1, 0.1), groups=[0, 1, 0, 0])
    add(scene, "of_the_elbow", [0.2, 0.6, 0.5], box(0.1, 0.1, 0.1), groups=[1, 1, 4, 7])
    for shape in arm.find_link_by_name("arm7_elbow").collision_shapes:
        shape.set_collision_groups([1, 1, 6, 7])
    forearm = arm.find_link_by_name("arm7_forearm").entity
    scene.create_drive(forearm, sapien.Pose(), cube, sapien.Pose())
    planner, _ = read(scene)
    links = ["arm7_base", "arm7_shoulder", "arm7_elbow", "arm7_forearm", "arm7_palm"]
    assert all(planner.allowed_collision(link, "ghost") for link in links)
    assert all(planner.allowed_collision(link, "other_scene") for link in links)
    # neither can be pushed: a fixed base, and what is static or kinematic
    assert [link for link in links if planner.allowed_collision(link, "one_way")] == ["arm7_base"]
    assert [link for link in links if planner.allowed_collision(link, "of_the_elbow")] == ["arm7_base", "arm7_elbow"]
    assert [link for link in links if planner.allowed_collision(link, "cube")] == ["arm7_forearm"]
    assert planner.allowed_collision("arm7_shoulder", "arm7_upper_arm")
    assert not planner.allowed_collision("arm7_shoulder", "arm7_forearm")


def test_contacts_are_those_that_physx_finds():
    """Of a crowd, in which everything overlaps, a step finds what may_collide says and the probe found."""
    scene = new_scene()
    for k, kind in enumerate(["static", "kinematic", "dynamic"]):
        add(scene, f"box_{kind}", [0.01 * k, 0, 0.05], box(0.1, 0.1, 0.1), kind=kind)
        add(scene, f"bracket_{kind}", [-0.2, -0.1 + 0.01 * k, 0.05], bracket(), kind=kind)
    scene.add_ground(0, render=False)
    for name, place in (("one", [0, 0, 0]), ("two", [0.02, 0.02, 0])):
        add_arm7(scene, name, place)
    loader = scene.create_urdf_loader()
    loader.fix_root_link = False
    loader.load(srmp.data_path("arm7.urdf"))
    simulator = Sapien(scene)
    simulator.articulations()
    with simulator.probe() as probe:
        probed = {frozenset((touch.a, touch.b)) for touch in probe.touching()}
    scene.step()
    found = {frozenset((touch.a, touch.b)) for touch in simulator.touching() if touch.depth > 1e-6}
    assert len(found) > 60
    assert found <= probed
    for pair in probed:
        a, b = pair
        assert simulator.may_collide(a, b)
        assert simulator.may_collide(b, a)
    names = {key: known.component.entity.name for key, known in simulator._known.items()}
    seen = {frozenset((names[a], names[b])) for a, b in found}
    assert frozenset(("box_dynamic", "arm7_base")) in seen
    assert frozenset(("box_static", "arm7_shoulder")) in seen
    for a, b in (("box_static", "box_kinematic"), ("bracket_static", "bracket_dynamic"), ("ground", "bracket_dynamic")):
        assert frozenset((a, b)) not in seen


def test_refresh_sees_filters_that_change():
    scene, _, _ = small_scene()
    planner, world = read(scene)
    post = next(entity for entity in scene.entities if entity.name == "post")
    (shape,) = post.find_component_by_type(px.PhysxRigidBaseComponent).collision_shapes
    for groups in ([2, 2, 0, 0], [1, 1, 0, 0]):
        shape.set_collision_groups(groups)
        world.refresh()
        assert planner.allowed_collision("arm7_forearm", "post") == (groups[0] == 2)


def test_refresh_moves_adds_and_removes():
    scene, arm, cube = small_scene()
    planner, world = read(scene)
    arm.qpos = [0, 0.5, 0, 0, 0, 0, 0]
    arm.root_pose = sapien.Pose([0, 0.125, 0])
    cube.pose = sapien.Pose([0.75, 0, 0.5])
    world.refresh()
    assert planner.get_qpos("arm")[1] == 0.5
    assert base_of(planner, "arm").p[1] == 0.125
    assert planner.get_object_pose("cube").p[0] == 0.75

    scene.remove_entity(next(entity for entity in scene.entities if entity.name == "post"))
    add(scene, "sphere", [0, 0.625, 0.5], px.PhysxCollisionShapeSphere(0.1, MATERIAL))
    world.refresh()
    assert planner.object_names == ["cube", "ground", "sphere"]
    assert planner.is_state_colliding("arm", [np.pi / 2, 1.1, 0, 0, 0, 0, 0])

    scene.remove_articulation(arm)
    with pytest.raises(srmp.InvalidArgument, match="unknown articulation 'arm'; known: none"):
        world.refresh()


def test_other_articulations_follow_their_joints():
    scene, _, _ = small_scene()
    cabinet = add_cabinet(scene)
    planner, world = read(scene)
    at = planner.get_object_pose("cabinet/drawer").p
    cabinet.qpos = [0.15]
    world.refresh()
    np.testing.assert_allclose(planner.get_object_pose("cabinet/drawer").p, at - np.array([0, 0.1, 0]), atol=1e-6)


def test_what_is_grasped_is_held_where_it_is():
    scene, arm, cube = small_scene()
    planner, world = read(scene)
    hand = arm.find_link_by_name("arm7_hand").entity
    cube.pose = hand.pose * sapien.Pose([0.001, 0.002, 0.01])
    world.grasp("cube", "arm")
    q = planner.get_qpos("arm") + np.array([0.3, 0.2, 0, 0, 0, 0, 0])
    planner.set_qpos("arm", q)
    held = planner.compute_fk("arm", q).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.001, 0.002, 0.01], atol=1e-6)
    cube.pose = hand.pose * sapien.Pose([0.005, 0.002, 0.01])  # it slips
    world.refresh()
    held = planner.compute_fk("arm", planner.get_qpos("arm")).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.005, 0.002, 0.01], atol=1e-6)
    cube.pose = sapien.Pose([0.625, 0, 0.1])
    world.release("cube")
    assert planner.get_object_pose("cube").p[0] == 0.625


def test_what_touches_the_cube_may_touch_it():
    scene, arm, cube = small_scene()
    planner, world = read(scene)
    cube.pose = arm.find_link_by_name("arm7_hand").entity.pose * sapien.Pose([0, 0, -0.05])  # into the palm
    world.grasp("cube", "arm")
    assert planner.allowed_collision("arm7_palm", "cube")
    assert not planner.allowed_collision("arm7_forearm", "cube")


def test_a_held_cube_is_carried_with_the_arm():
    """A real grasp: a drive between hand and cube, and the motion executed."""
    scene, arm, cube = small_scene()
    planner, world = read(scene)
    hand = arm.find_link_by_name("arm7_hand").entity
    cube.pose = hand.pose * sapien.Pose([0.01, 0, 0])
    drive = scene.create_drive(hand, sapien.Pose([0.01, 0, 0]), cube, sapien.Pose())
    for lock in (drive.set_limit_x, drive.set_limit_y, drive.set_limit_z):
        lock(0, 0)
    drive.set_drive_property_slerp(100, 10)
    world.grasp("cube", "arm", touch_links=["arm7_palm"])
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, [0.5, 0.6, 0, 0.9, 0, 0.4, 0])
    execution = world.execute(planner.plan("arm", planner.get_qpos("arm"), goal))
    assert execution.final_error <= 0.01
    assert not execution.unexpected_contacts, [str(contact) for contact in execution.unexpected_contacts]
    held = planner.compute_fk("arm", planner.get_qpos("arm")).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.01, 0, 0], atol=1e-3)


def test_two_arms_at_once():
    scene = new_scene()
    for name, x, turn in (("left", 0.0, [1, 0, 0, 0]), ("right", 0.8, [0, 0, 0, 1])):
        add_arm7(scene, name, [x, 0, 0], turn)
    planner, world = read(scene, articulations=["left", "right"])
    planner.make_planner(["left", "right"], {"planner_id": "xECBS", "time_limit": 20})
    lean = np.array([0.4, 0.8, 0, 0.9, 0, 0.4, 0])
    goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, lean) for name in ("left", "right")}
    trajectory = planner.plan_multi({name: planner.get_qpos(name) for name in goals}, goals)
    execution = world.execute(trajectory)
    assert execution.final_error <= 0.01
    assert set(execution.positions) == {"left", "right"}
    assert not execution.unexpected_contacts


def test_joints_of_every_kind_and_a_base_that_is_not_fixed(sim_checks):
    scene = new_scene()
    add(scene, "post", [0.4, 0, 0.3], box(0.05, 0.3, 0.3))
    builder = scene.create_articulation_builder()
    builder.set_initial_pose(sapien.Pose([0, 0, 0.1], TURNED))
    link = builder.create_link_builder()
    link.set_name("cart")
    link.add_box_collision(half_size=[0.1, 0.1, 0.1])
    kinds = [
        ("revolute_unwrapped", [[-2, 1.5]]),
        ("prismatic", [[-0.1, 0.2]]),
        ("fixed", []),
        ("revolute", [[-np.inf, np.inf]]),
    ]
    for number, (kind, limits) in enumerate(kinds):
        link = builder.create_link_builder(link)
        link.add_capsule_collision(sapien.Pose([0.05, 0, 0.1], TURNED), radius=0.04, half_length=0.08)
        turn = sapien.Pose([0.02, 0.01, 0.12], np.roll(TURNED, number))
        link.set_joint_properties(kind, limits, turn, sapien.Pose([-0.03, 0.02, -0.02], np.roll(TURNED, 1)))
    robot = builder.build(fix_root_link=False)
    robot.joints[1].max_velocity = 0.75
    planner, _ = read(scene, articulations=None)
    assert planner.robot_names == ["cart"]
    assert planner.get_joint_names("cart") == ["joint1", "joint2", "joint4"]
    limits = planner.get_joint_limits("cart")
    np.testing.assert_allclose(limits[:2], [[-2, 1.5, 0.75], [-0.1, 0.2, 0.2]], atol=1e-6)
    assert limits[2, 1] == np.inf
    sim_checks.parity(planner, scene, samples=300)


# --- what is refused: one sentence, and nothing was read


def refused(error, match, scene, **options):
    planner = srmp.PlannerInterface()
    planner.add_box("mine", size=[0.1] * 3)
    with pytest.raises(error, match=match):
        planner.read_sim(scene, "sapien", **options)
    assert planner.robot_names == []
    assert planner.object_names == ["mine"]
    assert planner.simulated_world is None


def test_robots_that_are_not_there():
    scene, _, _ = small_scene()
    refused(srmp.InvalidArgument, r"unknown articulation 'arn'; did you mean 'arm'\?", scene, articulations=["arn"])
    refused(srmp.NotSupported, r"articulations of sapien are named by strings, not by 3", scene, articulations=[3])
    other = add_arm7(new_scene(), "other")
    refused(srmp.InvalidArgument, r"articulation 'other' is not in this SAPIEN scene", scene, articulations=[other])


def test_a_joint_that_does_not_match():
    text = Path(srmp.data_path("arm7.urdf")).read_text().replace("arm7_joint4", "arm7_join4")
    match = r"robot 'arm' has a joint 'arm7_join4', articulation 'arm' has none of that name; did you mean"
    description = {"urdf_text": text, "end_effector": "arm7_hand"}
    refused(srmp.InvalidArgument, match, small_scene()[0], articulations={"arm": description})


def test_a_scene_of_another_kind():
    refused(srmp.InvalidArgument, r"a SAPIEN scene is a sapien.Scene, not int", 3)
    refused(srmp.InvalidArgument, r"needs physics on the CPU: sapien.Scene", sapien.Scene([]))


def test_a_geometry_that_cannot_be_read(monkeypatch):
    scene, _, _ = small_scene()
    monkeypatch.setattr(px, "PhysxCollisionShapeSphere", type("PhysxCollisionShapeOther", (), {}))
    add(scene, "sphere", [0, 0.6, 0.5], sapien.pysapien.physx.PhysxCollisionShapeCapsule(0.1, 0.1, MATERIAL))
    monkeypatch.setattr(px, "PhysxCollisionShapeCapsule", type("PhysxCollisionShapeOther", (), {}))
    match = r"object 'sphere': a PhysxCollisionShapeCapsule cannot be read; exclude=\['sphere'\] leaves it out"
    refused(srmp.NotSupported, match, scene, articulations=[])


def test_a_link_that_is_endless():
    scene = new_scene()
    builder = scene.create_articulation_builder()
    base = builder.create_link_builder()
    base.set_name("base")
    base.add_plane_collision()
    arm = builder.create_link_builder(base)
    arm.set_name("arm")
    arm.set_joint_properties("revolute", [[-1, 1]], sapien.Pose(), sapien.Pose())
    builder.build(fix_root_link=True).name = "robot"
    refused(srmp.NotSupported, "link 'base' has a plane, which is endless", scene)


def test_a_missing_package(monkeypatch):
    scene, _, _ = small_scene()
    monkeypatch.setitem(__import__("sys").modules, "sapien", None)
    refused(srmp.NotSupported, r"needs the Python package 'sapien'.*pip install sapien", scene)


def test_queries_of_another_scene():
    scene, _, _ = small_scene()
    planner, _ = read(scene)
    with pytest.raises(srmp.InvalidArgument, match="not the scene that the planner has read"):
        srmp.sim.check_parity(planner, small_scene()[0])
