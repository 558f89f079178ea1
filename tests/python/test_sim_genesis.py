"""Genesis: read, compared, executed, grasped. One scene for all tests, as Genesis compiles for minutes to build one."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

import srmp
from srmp.sim import check_parity, shapes

pytest.importorskip("torch", reason="install torch and '.[genesis]' to test what is said of Genesis")
gs = pytest.importorskip("genesis", reason="pip install '.[genesis]' to test what is said of Genesis")
trimesh = pytest.importorskip("trimesh", reason="it comes with Genesis")

from srmp.sim.genesis import Genesis  # noqa: E402

HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])
READY = np.array([0, 0.5, 0, 1.2, 0, 0.6, 0])
OWN = {"panda": {"end_effector": "panda_hand"}}
ARM = {
    "arm": {
        "articulation": "arm7",
        "urdf_path": srmp.data_path("arm7.urdf"),
        "srdf_path": srmp.data_path("arm7.srdf"),
        "end_effector": "arm7_hand",
    }
}


def mjcf(name, pos, geoms):
    return gs.morphs.MJCF(
        file=f'<mujoco model="{name}"><worldbody><body name="{name}" pos="{pos}">{geoms}</body></worldbody></mujoco>'
    )


# A joint that does not begin at 0, two joints between two bodies, a slide, and a tree that flies.
DUO = """<mujoco model="duo"><worldbody>
<geom name="slab" type="box" size=".1 .1 .1" pos="-2 0 -.5"/>
<body name="swing" pos="-2 1 .5" quat=".8 .4 .2 .4">
  <joint name="s1" axis="0 0 1" pos=".02 0 .01" range="-90 120" ref="20"/><joint name="s2" axis="0 1 0" range="-90 90"/>
  <geom type="capsule" size=".03 .15" pos=".1 0 0"/>
  <body name="slider" pos=".3 0 0">
    <joint name="s3" type="slide" axis="1 0 0" range="0 .3"/><geom type="box" size=".05 .03 .04"/>
  </body>
</body>
<body name="flyer" pos="-2 -1.5 .5">
  <freejoint/><geom type="sphere" size=".1"/>
  <body name="tail" pos="0 0 .2">
    <joint name="t1" axis="1 0 0"/><geom type="box" size=".02 .02 .2" pos="0 0 .25"/>
  </body>
</body>
</worldbody></mujoco>"""


def panda(directory):
    """Its URDF, all links but the hand merged where joints are fixed."""
    text = (directory / "panda.urdf").read_text().replace("package://", f"{directory}/")
    text = re.sub(r"<visual>.*?</visual>", "", text, flags=re.S)
    return gs.morphs.URDF(file=text, fixed=True, links_to_keep=["panda_hand"])


def angle_iron():
    """An L of 0.3 m, 0.1 m thick and 0.2 m high."""
    corners = [(0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.3), (0, 0.3)]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for i, j in zip(range(6), (1, 2, 3, 4, 5, 0), strict=True) for t in ((i, j, j + 6), (i, j + 6, i + 6))]
    triangles = [cap[::-1] for cap in caps] + [tuple(i + 6 for i in cap) for cap in caps] + sides
    return trimesh.Trimesh([(x, y, z) for z in (0, 0.2) for x, y in corners], triangles, process=False)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Two arms among a plane, boxes, a sphere, a cylinder, a capsule, an ellipsoid, meshes, a terrain and more."""
    directory, random, m = tmp_path_factory.mktemp("meshes"), np.random.default_rng(0), gs.morphs
    trimesh.convex.convex_hull(0.08 * random.normal(size=(40, 3))).export(directory / "rock.obj")
    angle_iron().export(directory / "angle.obj")
    gs.destroy()  # another test may have begun it
    gs.init(backend=gs.cpu, precision="64", logging_level="error")
    scene = gs.Scene(show_viewer=False, rigid_options=gs.options.RigidOptions(use_gjk_collision=True))
    turned = {"quat": (0.8, 0.4, 0.2, 0.4), "fixed": True}
    named = {
        "floor": m.Plane(pos=(0, 0, -0.6)),
        "crate": m.Box(size=(0.2, 0.2, 0.4), pos=(0.5, 0.3, 0.1), fixed=True),
        "sphere": m.Sphere(radius=0.1, pos=(0.5, -0.3, 0.5), fixed=True),
        "pole": m.Cylinder(radius=0.05, height=0.8, pos=(-0.4, 0.4, 0.3), **turned),
        "pill": mjcf("pill", "-0.4 -0.4 0.5", '<geom type="capsule" size="0.07 0.2" quat="0.8 0.4 0.2 0.4"/>'),
        "egg": mjcf("egg", "0 0.5 0.6", '<geom type="ellipsoid" size="0.1 0.15 0.2" quat="0.8 0.4 0.2 0.4"/>'),
        "rock": m.Mesh(file=str(directory / "rock.obj"), pos=(0, -0.5, 0.7), fixed=True),
        "angle": m.Mesh(file=str(directory / "angle.obj"), pos=(0.45, -0.1, 0.75), fixed=True, convexify=False),
        "bracket": m.Mesh(
            file=str(directory / "angle.obj"), pos=(-0.5, -0.15, 0.75), decompose_object_error_threshold=0.0, **turned
        ),
        "hills": m.Terrain(
            height_field=random.integers(0, 40, size=(9, 7)),
            horizontal_scale=0.1,
            vertical_scale=0.005,
            pos=(-0.9, -0.3, -0.2),
        ),
        "ghost": m.Box(size=(0.2, 0.2, 0.2), pos=(0.3, 0, 0.5), fixed=True, contype=2, conaffinity=2),
        "table": mjcf(
            "table",
            "0 0 -0.05",
            '<geom name="top" type="box" size="0.3 0.3 0.05"/>'
            '<geom name="leg" type="cylinder" size="0.05 0.25" pos="0 0 -0.3"/>',
        ),
    }
    data = os.environ.get("SRMP_MBM_DIR", "")
    if data and Path(data, "panda", "panda.urdf").exists():
        scene.add_entity(panda(Path(data, "panda")), name="panda")
    scene.add_entity(m.URDF(file=srmp.data_path("arm7.urdf"), fixed=True, pos=(1.0, 0, 0)))  # Genesis makes up a name
    for name, morph in named.items():
        scene.add_entity(morph, name=name)
    scene.add_entity(m.MJCF(file=DUO), name="duo")
    for k in range(3):
        cube = m.Box(size=(0.06,) * 3, pos=(0.3 + 0.1 * k, 0.5, 0.4 + 0.2 * k))
        scene.add_entity(cube, name=f"cube{k}", material=gs.materials.Rigid(gravity_compensation=1.0))
    scene.build()
    for robot in robots(scene):
        robot.set_dofs_kp([4500, 4500, 3500, 3500, 2000, 2000, 2000])
        robot.set_dofs_kv([450, 450, 350, 350, 200, 200, 200])
    return scene


def robots(scene):
    return [entity for entity in scene.entities if entity.n_dofs == 7]


@pytest.fixture
def sim(scene):
    scene.reset()
    for robot, q in zip(robots(scene), (HOME, READY) if len(robots(scene)) == 2 else (READY,), strict=True):
        robot.set_qpos(q)
        robot.control_dofs_position(q)
    return scene


def base(planner):
    return planner.compute_fk("arm", planner.get_qpos("arm"), "arm7_base")


def read(sim, articulations, **options):
    planner = srmp.PlannerInterface()
    return planner, planner.read_sim(sim, "genesis", articulations=articulations, **options)


def test_every_geometry_of_the_simulators_own_model_agrees(mbm_dir, sim, sim_checks):
    planner, _ = read(sim, OWN)
    assert len(planner.object_names) >= 12
    sim_checks.parity(planner, sim)


def test_a_urdf_agrees_but_for_its_shapes(mbm_dir, sim, sim_checks):
    planner, world = read(sim, {"panda": sim_checks.panda(mbm_dir)})
    assert world.differences == [
        "link of robot 'panda' is part of link 'panda_link7' in the simulator: panda_link8",
        "link of robot 'panda' is part of link 'panda_hand' in the simulator: panda_leftfinger, panda_rightfinger, "
        "panda_grasptarget",
    ]
    sim_checks.parity(planner, sim)


def test_the_packaged_arm_agrees_though_its_fixed_links_were_merged(sim, sim_checks):
    planner, world = read(sim, ARM)
    merged = "link of robot 'arm' is part of link 'arm7_flange' in the simulator: arm7_palm, arm7_hand"
    assert world.differences == [merged]
    np.testing.assert_allclose(base(planner).p, [1, 0, 0], atol=1e-6)
    sim_checks.parity(planner, sim)


def test_trees_of_any_kind_agree(sim):
    planner, world = read(sim, ["duo/swing", "duo/flyer"])
    assert list(planner.get_all_joint_limits("duo/swing")) == ["s1", "s2", "s3"]
    assert world.differences == []
    report = check_parity(planner, sim, samples=100)
    assert report, str(report)


def test_random_plans_are_executed(mbm_dir, sim, sim_checks):
    _, world = read(sim, OWN)
    sim_checks.executes_random_plans(world, "panda")


def test_what_moved_is_avoided(mbm_dir, sim, sim_checks):
    _, world = read(sim, OWN)
    sim_checks.avoids_what_moved(world, "panda", lambda pose: sim.get_entity("cube0").set_pos(pose.p), size=0.06)


def test_the_packaged_arm_plans_and_moves(sim, sim_checks):
    _, world = read(sim, ARM)
    sim_checks.executes_random_plans(world, "arm", count=3)


def test_two_arms_move_at_once(mbm_dir, sim):
    planner, world = read(sim, {**OWN, **ARM})
    planner.make_planner(["panda", "arm"], {"planner_id": "xECBS", "time_limit": 30})
    goals = {"panda": HOME + 0.6 * np.eye(7)[0], "arm": READY - 0.6 * np.eye(7)[0]}
    trajectory = planner.plan_multi(
        {name: planner.get_qpos(name) for name in goals},
        {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, goal) for name, goal in goals.items()},
    )
    execution = world.execute(trajectory)
    assert execution.final_error <= 0.01
    assert not execution.unexpected_contacts


def test_filters_become_allowed_collisions(sim):
    planner, _ = read(sim, ARM)
    assert planner.allowed_collision("arm/arm7_flange", "ghost")
    assert planner.allowed_collision("arm/arm7_base", "crate")  # neither ever moves
    assert not planner.allowed_collision("arm/arm7_flange", "crate")
    assert not planner.allowed_collision("arm/arm7_flange", "cube0")


def test_names_are_kept_and_made_where_there_are_none(sim):
    planner, world = read(sim, [robots(sim)[-1]])
    assert planner.robot_names == ["arm7"]
    assert {"crate", "table/top", "table/leg", "bracket/0", "bracket/1", "cube2"} <= set(planner.object_names)
    assert world.differences == []


def test_what_moved_is_read_again(sim):
    planner, world = read(sim, ARM)
    arm = robots(sim)[-1]
    sim.get_entity("cube1").set_pos([0.1, 0.2, 0.9])
    arm.set_qpos(READY + 0.1)
    world.refresh()
    np.testing.assert_allclose(planner.get_object_pose("cube1").p, [0.1, 0.2, 0.9], atol=1e-6)
    np.testing.assert_allclose(planner.get_qpos("arm"), READY + 0.1, atol=1e-6)
    arm.set_pos([1.1, 0, 0.05])
    world.refresh()
    np.testing.assert_allclose(base(planner).p, [1.1, 0, 0.05], atol=1e-6)


def test_a_grasped_cube_goes_with_the_hand(sim):
    planner, world = read(sim, ARM)
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    hand = planner.compute_fk("arm", planner.get_qpos("arm"))
    cube, flange = sim.get_entity("cube0"), robots(sim)[-1].get_link("arm7_flange")
    cube.set_pos((hand @ srmp.Pose(p=[0, 0, 0.005])).p)
    cube.set_quat(np.asarray(hand.q)[[3, 0, 1, 2]])
    sim.rigid_solver.add_weld_constraint(cube.base_link.idx, flange.idx)
    world.grasp("cube0", "arm", touch_links=["arm7_palm"])
    before = (hand.inverse() @ planner.get_object_pose("cube0")).p
    np.testing.assert_allclose(before, [0, 0, 0.005], atol=1e-5)
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, READY + np.array([0.5, -0.2, 0, 0, 0, 0, 0]))
    execution = world.execute(planner.plan("arm", planner.get_qpos("arm"), goal))
    assert execution.final_error <= 0.01 and not execution.unexpected_contacts
    hand = planner.compute_fk("arm", planner.get_qpos("arm"))
    np.testing.assert_allclose((hand.inverse() @ planner.get_object_pose("cube0")).p, before, atol=2e-3)
    sim.rigid_solver.delete_weld_constraint(cube.base_link.idx, flange.idx)
    world.release("cube0")
    np.testing.assert_allclose(planner.get_object_pose("cube0").p, cube.get_pos().numpy(), atol=1e-6)
    with pytest.raises(srmp.InvalidArgument, match="'cube0' is not held"):
        world.release("cube0")


def test_a_probe_leaves_no_trace(sim):
    for _ in range(5):
        sim.step()
    simulator = Genesis(sim)
    before = sim.rigid_solver.__getstate__().arrays
    with simulator.probe() as probe:
        probe.put("arm7", {"arm7_joint2": 1.5, "arm7_joint4": 0.3})
        probe.touching()
        assert probe.link_poses("arm7")
    after = sim.rigid_solver.__getstate__().arrays
    for name, value in before.items():
        assert np.array_equal(np.asarray(value), np.asarray(after[name]), equal_nan=True), name


@pytest.mark.parametrize(("kp", "kv"), [(100, 40), (0, 0)], ids=["soft", "without gains"])
def test_motion_needs_no_stiff_joints(sim, kp, kv):
    """Gravity and inertia are fed forward, and joints without gains pushed."""
    arm = robots(sim)[-1]
    gains = arm.get_dofs_kp(), arm.get_dofs_kv()
    arm.set_dofs_kp(np.full(7, kp))
    arm.set_dofs_kv(np.full(7, kv))
    planner, world = read(sim, ARM)
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, READY + np.array([0.5, -0.2, 0, 0.3, 0, 0, 0]))
    try:
        assert world.execute(planner.plan("arm", planner.get_qpos("arm"), goal)).final_error <= 0.01
    finally:
        arm.set_dofs_kp(gains[0])
        arm.set_dofs_kv(gains[1])


def test_joints_that_no_command_names_stay_or_go_where_the_user_says(sim):
    arm = robots(sim)[-1]
    for control, told, expected in (
        (arm.control_dofs_force, np.zeros(7), READY),
        (arm.control_dofs_position, READY + 0.1, READY + 0.1),
    ):
        arm.set_qpos(READY)
        arm.set_dofs_velocity(np.zeros(7))
        control(told)
        simulator = Genesis(sim)
        simulator.hold("arm7")
        for _ in range(150):
            simulator.step()
        np.testing.assert_allclose(list(simulator.joint_positions("arm7").values()), expected, atol=0.01)


def expect(sim, message, articulations=ARM, kind="genesis", error=srmp.InvalidArgument):
    """One sentence, and nothing half-read."""
    planner = srmp.PlannerInterface()
    with pytest.raises(error, match=message) as caught:
        planner.read_sim(sim, kind, articulations=articulations)
    assert "\n" not in str(caught.value)
    assert planner.robot_names == [] and planner.object_names == [] and planner.simulated_world is None


def test_bad_input_is_refused_in_a_sentence(sim, monkeypatch):
    expect({"a": 1}, "a Genesis scene is a gs.Scene, not dict")
    expect(gs.Scene(show_viewer=False), "not built yet; call its build")
    expect(sim, "unknown articulation 'arm'; did you mean 'arm7'", {"arm": {}})
    expect(sim, "entity 'crate' is no articulation; there are .*arm7", [sim.get_entity("crate")])
    text = Path(srmp.data_path("arm7.urdf")).read_text().replace("arm7_joint3", "elbow")
    renamed = {"arm7": {"urdf_text": text, "end_effector": "arm7_hand"}}
    expect(sim, "has a joint 'elbow', articulation 'arm7' has none of that name", renamed)
    with monkeypatch.context() as patched:
        patched.setattr(sim, "n_envs", 4)
        expect(sim, "has 4 environments; build it with one")
    with monkeypatch.context() as patched:
        patched.setattr(Genesis, "_shape", lambda *_: shapes.Unreadable("a geom of type sdf"))
        expect(sim, "a geom of type sdf cannot be read", error=srmp.NotSupported)


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "genesis", None)
    expect(object(), "needs the Python package 'genesis-world'", error=srmp.NotSupported)
