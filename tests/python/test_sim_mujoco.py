"""MuJoCo: read, compared, executed, grasped."""

import re
from pathlib import Path

import numpy as np
import pytest

import srmp

mujoco = pytest.importorskip("mujoco", reason="pip install 'srmp[mujoco]' to test what is said of MuJoCo")


HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])


def panda_spec(mbm_dir: Path) -> "mujoco.MjSpec":
    """The Panda's URDF as MuJoCo reads it, the base a body of its own."""
    folder = mbm_dir / "panda"
    text = (folder / "panda.urdf").read_text().replace("package://", f"{folder}/")
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
        ("ball", {"pos": [0.5, -0.3, 0.5]}, {"type": kind.mjGEOM_SPHERE, "size": [0.1, 0, 0]}),
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


def urdf_of(mbm_dir):
    folder = mbm_dir / "panda"
    return {
        "urdf_path": str(folder / "panda.urdf"),
        "srdf_path": str(folder / "panda.srdf"),
        "end_effector": "panda_hand",
        "package_dirs": [str(folder)],
    }


OWN = {"panda": {"end_effector": "panda_hand"}}


def test_every_geometry_of_the_simulators_own_model_agrees(sim, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "mujoco", articulations=OWN)
    sim_checks.parity(planner, sim)


def test_a_urdf_agrees_but_for_its_shapes(sim, mbm_dir, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "mujoco", articulations={"panda": urdf_of(mbm_dir)})
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
