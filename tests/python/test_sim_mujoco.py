"""MuJoCo: read, compared, executed, grasped."""

import re
from pathlib import Path

import numpy as np
import pytest

import srmp

pytest.importorskip("mujoco", reason="pip install '.[mujoco]' to test what is said of MuJoCo")

import mujoco
from mujoco_scenes import arm7_spec, read, small_scene

HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])


def panda_spec(mbm_dir: Path) -> "mujoco.MjSpec":
    """The Panda's URDF as MuJoCo reads it, the base a body of its own."""
    directory = mbm_dir / "panda"
    text = (directory / "panda.urdf").read_text().replace("package://", f"{directory}/")
    text = re.sub(r"<visual>.*?</visual>", "", text, flags=re.S)
    compiler = '<mujoco><compiler fusestatic="false" strippath="false" balanceinertia="true"/></mujoco>'
    return mujoco.MjSpec.from_string(re.sub(r"(<robot [^>]*>)", rf"\1{compiler}", text, count=1))


def every_geometry(mbm_dir: Path) -> "mujoco.MjModel":
    """A Panda among a plane, a box, a sphere, a cylinder, a capsule, an ellipsoid, a mesh, a height field and more."""
    spec = mujoco.MjSpec()
    world, kind, random = spec.worldbody, mujoco.mjtGeom, np.random.default_rng(0)
    world.add_geom(name="floor", type=kind.mjGEOM_PLANE, size=[0, 0, 0.1], pos=[0, 0, -0.6])
    spec.add_mesh(name="rock", uservert=(0.08 * random.normal(size=(40, 3))).ravel())
    hills = random.uniform(size=81).tolist()
    spec.add_hfield(name="hills", size=[0.4, 0.4, 0.2, 0.1], nrow=9, ncol=9, userdata=hills)
    turned = [0.7, 0.3, 0.1, 0.2]
    for name, place, geometry in (
        ("crate", {"pos": [0.5, 0.3, 0.1]}, {"type": kind.mjGEOM_BOX, "size": [0.1, 0.1, 0.2]}),
        ("sphere", {"pos": [0.5, -0.3, 0.5]}, {"type": kind.mjGEOM_SPHERE, "size": [0.1, 0, 0]}),
        ("pole", {"pos": [-0.4, 0.4, 0.3], "quat": turned}, {"type": kind.mjGEOM_CYLINDER, "size": [0.05, 0.4, 0]}),
        ("pill", {"pos": [-0.4, -0.4, 0.5], "quat": turned}, {"type": kind.mjGEOM_CAPSULE, "size": [0.07, 0.2, 0]}),
        ("egg", {"pos": [0, 0.5, 0.6], "quat": turned}, {"type": kind.mjGEOM_ELLIPSOID, "size": [0.1, 0.15, 0.2]}),
        ("rock", {"pos": [0, -0.5, 0.7]}, {"type": kind.mjGEOM_MESH, "meshname": "rock"}),
        ("hills", {"pos": [-0.6, 0, -0.2]}, {"type": kind.mjGEOM_HFIELD, "hfieldname": "hills"}),
        ("ghost", {"pos": [0.3, 0, 0.5]}, {"type": kind.mjGEOM_BOX, "size": [0.1] * 3, "contype": 2, "conaffinity": 2}),
    ):
        world.add_body(name=name, **place).add_geom(**geometry)
    for k in range(3):
        cube = world.add_body(name=f"cube{k}", pos=[0.3 + 0.1 * k, 0.5, 0.4 + 0.2 * k], gravcomp=1)
        cube.add_freejoint()
        cube.add_geom(type=kind.mjGEOM_BOX, size=[0.03] * 3)
    table = world.add_body(name="table", pos=[0, 0, -0.05])
    table.add_geom(name="top", type=kind.mjGEOM_BOX, size=[0.3, 0.3, 0.05])
    table.add_geom(name="leg", type=kind.mjGEOM_CYLINDER, size=[0.05, 0.25, 0], pos=[0, 0, -0.3])
    spec.attach(panda_spec(mbm_dir), prefix="panda/", frame=world.add_frame())
    return spec.compile()


def set_state(model, data, q, prefix="panda/panda_joint"):
    for number, value in enumerate(q, start=1):
        data.qpos[model.jnt_qposadr[model.joint(f"{prefix}{number}").id]] = value
    data.qvel[:] = 0


@pytest.fixture
def sim(mbm_dir):
    model = every_geometry(mbm_dir)
    data = mujoco.MjData(model)
    set_state(model, data, HOME)
    return model, data


OWN = {"panda": {"end_effector": "panda_hand"}}


def test_every_geometry_of_the_simulators_own_model_agrees(sim, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "mujoco", articulations=OWN)
    sim_checks.parity(planner, sim)


def test_a_urdf_agrees_but_for_its_shapes(sim, mbm_dir, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "mujoco", articulations={"panda": sim_checks.panda(mbm_dir)})
    sim_checks.parity(planner, sim)


def test_random_plans_are_executed(sim, sim_checks):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(sim, "mujoco", articulations=OWN)
    sim_checks.executes_random_plans(world, "panda")


def test_what_moved_is_avoided(sim, sim_checks):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(sim, "mujoco", articulations=OWN)
    model, data = sim

    def put(pose):
        data.qpos[model.jnt_qposadr[model.body("cube0").jntadr[0]] :][:3] = pose.p
        data.qvel[:] = 0

    sim_checks.avoids_what_moved(world, "panda", put, size=0.06)


def test_the_packages_own_arm_agrees(sim_checks):
    spec = small_scene()
    planner, world, model, data = read(spec, articulations=None)
    assert planner.robot_names == ["arm"]
    assert planner.object_names == ["cube", "floor", "post"]
    assert planner.get_link_names("arm")[0] == "arm7_base"  # without the prefix that all of them have
    assert world is planner.simulated_world
    sim_checks.parity(planner, (model, data), samples=300)


def servo(actuator):
    actuator.set_to_position(kp=2000, kv=200)


def motor(actuator):
    actuator.set_to_motor()


@pytest.mark.parametrize("actuator", [None, servo, motor])
def test_every_kind_of_control_follows(actuator, sim_checks):
    _, world, _, _ = read(small_scene([actuator] * 7 if actuator else ()))
    sim_checks.executes_random_plans(world, "arm", count=3)


def test_an_actuator_of_another_kind_is_refused():
    planner, world, _, _ = read(small_scene([lambda actuator: actuator.set_to_velocity(kv=3)]))
    with pytest.raises(srmp.NotSupported, match=r"actuator 'a1' of joint 'arm/arm7_joint1' is neither"):
        world.execute(srmp.Trajectory(planner.get_joint_names("arm"), np.zeros((2, 7)), times=[0, 1]))


def test_filters_become_allowed_collisions():
    spec = small_scene()
    ghost = spec.worldbody.add_body(name="ghost", pos=[0.2, 0, 0.5])
    ghost.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1] * 3, contype=2, conaffinity=2)
    spec.add_exclude(bodyname1="arm/arm7_elbow", bodyname2="post")
    visual = spec.worldbody.add_body(name="visual")
    visual.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1] * 3, contype=0, conaffinity=0)
    planner, _, _, _ = read(spec)
    assert "visual" not in planner.object_names
    assert all(planner.allowed_collision(link, "ghost") for link in planner.get_link_names("arm")[:-3])
    assert planner.allowed_collision("arm7_elbow", "post")
    assert not planner.allowed_collision("arm7_forearm", "post")
    assert planner.allowed_collision("arm7_base", "floor")  # neither can move
    assert not planner.allowed_collision("arm7_shoulder", "floor")


def test_refresh_sees_shapes_that_change_in_the_model():
    """In place, as domain randomisation changes them."""
    spec = small_scene()
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    spec.add_mesh(name="rock", uservert=np.ravel(corners))
    rock = spec.worldbody.add_body(name="rock", pos=[0, 0, 2])
    rock.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="rock")
    spec.add_hfield(name="hills", nrow=3, ncol=3, size=[0.2, 0.2, 0.5, 0.1], userdata=[0] * 8 + [1])
    spec.worldbody.add_body(name="hills", pos=[0, 0, 3]).add_geom(type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname="hills")
    planner, world, model, data = read(spec)

    model.geom_size[model.body("post").geomadr[0]] = [0.3, 0.3, 0.3]
    model.mesh_vert[:] *= 15
    model.hfield_data[:] = 1
    world.refresh()
    again = srmp.PlannerInterface()
    again.read_sim((model, data), "mujoco", articulations=["arm"])
    random = np.random.default_rng(0)
    for q in random.uniform(-2, 2, (50, 7)):
        assert planner.is_state_colliding("arm", q) == again.is_state_colliding("arm", q)
        assert planner.distance_to_collision("arm", q) == again.distance_to_collision("arm", q)


def test_refresh_sees_filters_that_change():
    planner, world, model, _ = read(small_scene())
    post = model.body("post").geomadr[0]
    links = planner.get_link_names("arm")[:-3]
    planner.set_allowed_collision("arm/arm7_hand", "cube")  # the user's own rule stays
    for affinity in (2, 1, 2, 1):
        model.geom_contype[post] = model.geom_conaffinity[post] = affinity
        world.refresh()
        for link in links[1:]:
            assert planner.allowed_collision(link, "post") == (affinity == 2)
        assert planner.allowed_collision("arm7_hand", "cube")
        assert not planner.allowed_collision("arm7_forearm", "cube")
    flags = model.opt.disableflags
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    world.refresh()
    assert all(planner.allowed_collision(link, "cube") for link in links)
    model.opt.disableflags = flags
    world.refresh()
    assert not planner.allowed_collision("arm7_forearm", "cube")


def test_refresh_moves_adds_and_removes():
    spec = small_scene()
    planner, world, model, data = read(spec)
    data.joint("arm/arm7_joint2").qpos[0] = 0.5
    data.body("cube")
    data.qpos[model.jnt_qposadr[model.body("cube").jntadr[0]]] = 0.7
    world.refresh()
    assert planner.get_qpos("arm")[1] == 0.5
    assert planner.get_object_pose("cube").p[0] == 0.7

    spec.delete(spec.body("post"))
    sphere = spec.worldbody.add_body(name="sphere", pos=[0, 0.5, 0.5])
    sphere.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0])
    sim = spec.recompile(model, data)
    world.refresh(sim)
    assert planner.object_names == ["cube", "floor", "sphere"]
    assert planner.get_qpos("arm")[1] == 0.5
    assert planner.is_state_colliding("arm", [np.pi / 2, 1.1, 0, 0, 0, 0, 0])


def test_what_is_grasped_is_held_where_it_is():
    planner, world, model, data = read(small_scene())
    address = model.jnt_qposadr[model.body("cube").jntadr[0]]
    hand = planner.compute_fk("arm", planner.get_qpos("arm"))
    data.qpos[address : address + 3] = hand @ np.array([0.001, 0.002, 0.01])
    world.grasp("cube", "arm")
    q = planner.get_qpos("arm") + np.array([0.3, 0.2, 0, 0, 0, 0, 0])
    planner.set_qpos("arm", q)
    held = planner.compute_fk("arm", q).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.001, 0.002, 0.01], atol=1e-9)
    with pytest.raises(srmp.InvalidArgument, match="attached"):
        world.grasp("cube", "arm")

    data.qpos[address] += 0.004  # it slips
    world.refresh()
    held = planner.compute_fk("arm", planner.get_qpos("arm")).inverse() @ planner.get_object_pose("cube")
    np.testing.assert_allclose(held.p, [0.005, 0.002, 0.01], atol=1e-9)

    data.qpos[address] = 0.6
    world.release("cube")
    assert planner.get_object_pose("cube").p[0] == 0.6
    with pytest.raises(srmp.InvalidArgument, match="'cube' is not held"):
        world.release("cube")


def test_what_touches_the_cube_may_touch_it():
    planner, world, model, data = read(small_scene())
    address = model.jnt_qposadr[model.body("cube").jntadr[0]]
    hand = planner.compute_fk("arm", planner.get_qpos("arm"))
    data.qpos[address : address + 3] = hand @ np.array([0, 0, -0.05])  # into the palm
    world.grasp("cube", "arm")
    assert planner.allowed_collision("arm7_palm", "cube")
    assert not planner.allowed_collision("arm7_forearm", "cube")


def test_two_arms_at_once():
    spec = mujoco.MjSpec()
    for name, x, quat in (("left", 0.0, [1, 0, 0, 0]), ("right", 0.8, [0, 0, 0, 1])):
        spec.attach(arm7_spec(), prefix=f"{name}/", frame=spec.worldbody.add_frame(pos=[x, 0, 0], quat=quat))
    planner, world, _, _ = read(spec, articulations=["left", "right"])
    planner.make_planner(["left", "right"], {"planner_id": "xECBS", "time_limit": 20})
    lean = np.array([0.4, 0.8, 0, 0.9, 0, 0.4, 0])
    goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, lean) for name in ("left", "right")}
    trajectory = planner.plan_multi({name: planner.get_qpos(name) for name in goals}, goals)
    execution = world.execute(trajectory)
    assert execution.final_error <= 0.01
    assert set(execution.positions) == {"left", "right"}
    assert not execution.unexpected_contacts
    planner.make_planner("left", {"planner_id": "auto"})
    execution = srmp.sim.execute(
        planner,
        planner.plan("left", planner.get_qpos("left"), srmp.GoalConstraint(srmp.GoalType.JOINTS, np.zeros(7))),
        robot="left",
    )
    assert execution.final_error <= 0.01


def test_joints_off_the_bodys_origin_several_of_them_and_with_a_reference(sim_checks):
    model = mujoco.MjModel.from_xml_string(
        """
        <mujoco>
          <worldbody>
            <body name="post" pos="0.6 0 0.4"><geom type="box" size="0.1 0.1 0.4"/></body>
            <body name="base" pos="0 0 0.1" euler="0 0 30"><geom type="box" size="0.1 0.1 0.1"/>
              <body name="first" pos="0 0 0.15" euler="10 20 30">
                <joint name="turn" axis="0 0 1" pos="0.02 0.01 0" range="-170 170"/>
                <joint name="lift" axis="0 0 1" type="slide" range="0 0.3"/>
                <joint name="lean" axis="0.3 1 0" pos="0 0 0.05" ref="20" range="-100 100"/>
                <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.04"/>
                <body name="second" pos="0.35 0 0">
                  <joint name="spin" axis="1 0 0"/>
                  <geom type="ellipsoid" size="0.2 0.05 0.1" pos="0.1 0 0"/>
                </body>
              </body>
            </body>
          </worldbody>
        </mujoco>
        """
    )
    data = mujoco.MjData(model)
    planner = srmp.PlannerInterface()
    planner.read_sim((model, data), "mujoco")
    assert planner.robot_names == ["base"]
    assert planner.get_joint_names("base") == ["turn", "lift", "lean", "spin"]
    assert planner.get_joint_limits("base")[3, 1] == np.inf
    sim_checks.parity(planner, (model, data), samples=300)


# --- what users' scenes have, and what users do


def cabinet(spec):
    """A drawer that is no robot."""
    body = spec.worldbody.add_body(name="cabinet", pos=[0, 0.8, 0.3])
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.01, 0.2], pos=[0, 0.1, 0])
    drawer = body.add_body(name="drawer")
    drawer.add_joint(name="slide", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, -1, 0], range=[0, 0.3])
    drawer.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.18, 0.01, 0.05])


def test_a_drawer_follows_its_joint_without_mj_forward():
    spec = small_scene()
    cabinet(spec)
    planner, world, _, data = read(spec)
    before = planner.get_object_pose("drawer").p
    data.joint("slide").qpos[0] = 0.2
    world.refresh()
    np.testing.assert_allclose(planner.get_object_pose("drawer").p - before, [0, -0.2, 0], atol=1e-12)


def test_without_robots_objects_move_too():
    planner, world, _, data = read(small_scene(), articulations=[])
    data.qpos[0] = 0.7
    world.refresh()
    assert planner.get_object_pose("cube").p[0] == 0.7
    with pytest.raises(srmp.InvalidArgument, match="no robot was read"):
        srmp.sim.check_parity(planner)


def test_names_that_are_taken_get_a_number():
    spec = small_scene()
    for z in (1.0, 2.0):
        spec.worldbody.add_geom(
            name="post" if z == 1 else "cube", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1] * 3, pos=[0, 1, z]
        )
    planner, _, _, _ = read(spec)
    assert planner.object_names == ["cube", "cube_2", "floor", "post", "post_2"]
    planner, _, _, _ = read(spec, exclude=["post_2"])
    assert planner.object_names == ["cube", "cube_2", "floor", "post"]


def test_arms_under_a_common_prefix_are_two(sim_checks):
    pair = mujoco.MjSpec()
    for name, x in (("left", 0.0), ("right", 0.6)):
        pair.attach(arm7_spec(), prefix=f"{name}/", frame=pair.worldbody.add_frame(pos=[x, 0, 0]))
    spec = mujoco.MjSpec()
    spec.attach(pair, prefix="env/", frame=spec.worldbody.add_frame())
    planner, world, model, data = read(spec, articulations=None)
    assert planner.robot_names == ["env/left", "env/right"]
    sim_checks.parity(planner, (model, data), samples=200)
    names, lean = planner.get_joint_names("env/left"), np.array([0, 1.57, 0, 0, 0, 0, 0])
    execution = world.execute(srmp.Trajectory(names, [0 * lean, lean], times=[0, 1]), robot="env/left")
    assert any({contact.body_a[:9], contact.body_b[:9]} == {"env/left/", "env/right"} for contact in execution.contacts)


def test_refresh_puts_back_what_the_planners_user_moved_or_removed():
    planner, world, _, _ = read(small_scene())
    planner.set_object_pose("cube", srmp.Pose(p=[0, 0, 5]))
    planner.remove_object("post")
    planner.set_base_pose("arm", srmp.Pose(p=[0, 0, 5]))
    planner.add_box("mine", size=[0.1] * 3, pose=srmp.Pose(p=[2, 2, 2]))
    world.refresh()
    assert planner.object_names == ["cube", "floor", "mine", "post"]
    assert planner.get_object_pose("cube").p[2] == 0.03
    assert planner.compute_fk("arm", np.zeros(7), "arm7_base").p[2] == 0
    for undo in (world.refresh, lambda: world.release("cube")):
        world.grasp("cube", "arm")
        planner.detach_object("cube")  # instead of release()
        undo()
        with pytest.raises(srmp.InvalidArgument, match="'cube' is not held"):
            world.release("cube")


def test_parity_beside_what_only_the_planner_has_and_with_full_hands():
    planner, world, model, data = read(small_scene())
    planner.add_box("mine", size=[1] * 3, pose=srmp.Pose(p=[0.8, 0, 0.5]))
    planner.add_articulation(
        name="other",
        urdf_path=srmp.data_path("arm7.urdf"),
        end_effector="arm7_hand",
        base_pose=srmp.Pose(p=[0.5, 0, 0]),
    )
    address = model.jnt_qposadr[model.body("cube").jntadr[0]]
    data.qpos[address : address + 3] = planner.compute_fk("arm", np.zeros(7)).p
    world.grasp("cube", "arm")
    report = srmp.sim.check_parity(planner, samples=200)
    assert report, str(report)
    reasons = set(report.not_compared.values())
    assert "mujoco does not have one of the two" in reasons
    assert any(reason.startswith("a robot holds one") for reason in reasons)


def test_a_trajectory_of_no_time_takes_one_step():
    planner, world, _, _ = read(small_scene())
    at_once = srmp.Trajectory(planner.get_joint_names("arm"), np.zeros((1, 7)), times=[0])
    execution = world.execute(at_once, settle_time=0)
    assert len(execution.times) == 1
    assert execution.largest_error <= 0.01


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_after_an_error_in_on_step_the_planner_knows_where_the_robot_is(error):
    planner, world, _, data = read(small_scene())

    def stop(now):
        if now > 0.05:
            raise error("the user's")

    names = planner.get_joint_names("arm")
    with pytest.raises(error, match="the user's"):
        world.execute(srmp.Trajectory(names, [[0.0] * 7, [0.3] * 7], times=[0, 0.2]), on_step=stop)
    assert planner.get_qpos("arm")[0] == data.joint("arm/arm7_joint1").qpos[0] > 0.05


def test_a_simulation_that_diverges_is_an_error(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes MUJOCO_LOG.TXT
    planner, world, _, data = read(small_scene())

    def spoil(now):
        data.qvel[:] = 1e12 if now > 0.05 else data.qvel

    still = srmp.Trajectory(planner.get_joint_names("arm"), np.zeros((2, 7)), times=[0, 0.2])
    with pytest.raises(srmp.Error, match="the simulation diverged: MuJoCo found a state that is not finite or too"):
        world.execute(still, on_step=spoil)


def test_a_planner_and_its_world_are_freed():
    import gc
    import weakref

    model = small_scene().compile()
    planner, data = srmp.PlannerInterface(), mujoco.MjData(model)
    world = weakref.ref(planner.read_sim((model, data), "mujoco"))
    del planner
    gc.collect()
    assert world() is None


GRIPPER = """
<mujoco>
  <compiler angle="radian"/>
  <option integrator="implicitfast" impratio="10" cone="elliptic"/>
  <default>
    <default class="lift">
      <joint type="slide" armature="0.1" damping="1"/>
      <default class="finger"><joint axis="0 1 0" range="0 0.04"/><geom type="box" friction="2 0.05 0.0001"/></default>
    </default>
  </default>
  <worldbody>
    <body name="table"><geom type="box" size="0.3 0.3 0.05" pos="0 0 -0.05"/></body>
    <body name="cube" pos="0 0 0.02"><freejoint/>
      <geom type="box" size="0.02 0.02 0.02" mass="0.05" friction="2 0.05 0"/></body>
    <body name="gantry" pos="0 0 0.6" childclass="lift">
      <geom type="box" size="0.02 0.02 0.02"/>
      <body name="hand" pos="0 0 -0.25"><joint name="down" axis="0 0 -1" range="0 0.3"/>
        <joint name="along" axis="1 0 0" range="-0.2 0.2"/>
        <geom type="box" size="0.02 0.08 0.02"/>
        <body name="left"><joint name="f1" class="finger"/>
          <geom class="finger" size="0.01 0.006 0.01" pos="0 0.006 -0.06"/></body>
        <body name="right" euler="0 0 3.14159265"><joint name="f2" class="finger"/>
          <geom class="finger" size="0.01 0.006 0.01" pos="0 0.006 -0.06"/></body>
      </body>
    </body>
  </worldbody>
  <tendon><fixed name="split"><joint joint="f1" coef="0.5"/><joint joint="f2" coef="0.5"/></fixed></tendon>
  <equality><joint joint1="f1" joint2="f2" solimp="0.95 0.99 0.001" solref="0.005 1"/></equality>
  <contact><exclude body1="gantry" body2="hand"/></contact>
  <actuator>
    <general joint="down" biastype="affine" gainprm="4500" biasprm="0 -4500 -450"/>
    <general joint="along" biastype="affine" gainprm="4500" biasprm="0 -4500 -450"/>
    <general tendon="split" biastype="affine" ctrlrange="0 255" gainprm="0.0157" biasprm="0 -100 -10"/>
  </actuator>
  <keyframe><key name="open" qpos="0 0 0.02 1 0 0 0  0 0 0.04 0.04" ctrl="0 0 255"/></keyframe>
</mujoco>
"""


def test_fingers_on_a_tendon_hold_a_cube_by_friction():
    model = mujoco.MjModel.from_xml_string(GRIPPER)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    planner = srmp.PlannerInterface()
    world = planner.read_sim((model, data), "mujoco", articulations={"gantry": {"end_effector": "hand"}})
    assert planner.get_joint_names("gantry") == ["down", "along"]
    assert srmp.sim.check_parity(planner, samples=100)
    planner.make_planner("gantry", {"planner_id": "auto", "time_limit": 5})

    def go(*q):
        goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, q)
        execution = world.execute(planner.plan("gantry", planner.get_qpos("gantry"), goal))
        assert execution.final_error <= 0.01
        assert not execution.unexpected_contacts, [str(contact) for contact in execution.unexpected_contacts]

    def squeeze(control):
        data.ctrl[-1] = control
        mujoco.mj_step(model, data, nstep=300)

    go(0.27, 0.0)
    squeeze(0)
    world.grasp("cube", "gantry")
    assert [link for link in planner.get_link_names("gantry") if planner.allowed_collision(link, "cube")] == [
        "hand",
        "left",
        "right",
    ]
    planner.set_allowed_collision("cube", "table")  # it lies on it
    go(0.1, 0.0)
    planner.set_allowed_collision("cube", "table", allowed=False)
    go(0.1, 0.15)
    np.testing.assert_allclose(data.body("cube").xpos, [0.15, 0, 0.19], atol=0.01)
    np.testing.assert_allclose(planner.get_object_pose("cube").p, data.body("cube").xpos, atol=1e-9)
    assert srmp.sim.check_parity(planner, samples=100)
    squeeze(255)
    world.release("cube")
    assert planner.get_object_pose("cube").p[2] < 0.1
