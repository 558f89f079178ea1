"""PyBullet: read, compared, executed, grasped."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import srmp

pybullet = pytest.importorskip("pybullet", reason="pip install 'srmp[pybullet]' to test what is said of PyBullet")

HOME = np.array([0, -0.5, 0, -2.2, 0, 1.8, 0.8])
OWN = {"panda": {"end_effector": "panda_hand"}}
SELF_COLLISION = pybullet.URDF_USE_SELF_COLLISION


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    if pybullet.isConnected(number):
        pybullet.disconnect(number)


def panda_urdf(mbm_dir, tmp_path):
    """With the paths of its meshes, and without the meshes to look at."""
    folder = mbm_dir / "panda"
    text = (folder / "panda.urdf").read_text().replace("package://", f"{folder}/")
    path = tmp_path / "panda.urdf"
    path.write_text(re.sub(r"<visual>.*?</visual>", "", text, flags=re.S))
    return str(path)


def tetrahedra(path):
    """An OBJ file of two objects, and triangles between them that no hull has."""
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]])
    lines = []
    for k, shift in enumerate(([0, 0, 0], [0.3, 0.1, 0])):
        lines.append(f"o part{k}")
        lines += [f"v {x} {y} {z}" for x, y, z in corners + shift]
        lines += [
            f"f {a + 1 + 4 * k} {b + 1 + 4 * k} {c + 1 + 4 * k}" for a, b, c in itertools.combinations(range(4), 3)
        ]
    path.write_text("\n".join(lines) + "\n")
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


def body(client, name, shape, position=(0, 0, 0), turn=(0, 0, 0, 1), mass=0.0, **options):
    """A body of one collision shape: createCollisionShape's type and arguments."""
    kind, arguments = shape
    number = pybullet.createCollisionShape(kind, **arguments, physicsClientId=client)
    unique = pybullet.createMultiBody(mass, number, -1, position, turn, physicsClientId=client, **options)
    pybullet.addUserData(unique, "name", name, physicsClientId=client)
    return unique


URDF_BODY = """
<robot name="{name}"><link name="body">
  <inertial><origin xyz="0.03 0.02 -0.01" rpy="0.3 0.2 0.1"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  {collisions}
</link></robot>
"""


def urdf_body(client, folder, name, collisions, position, turn=(0, 0, 0, 1), flags=0):
    path = Path(folder, f"{name}.urdf")
    path.write_text(URDF_BODY.format(name=name, collisions=collisions))
    return pybullet.loadURDF(str(path), position, turn, useFixedBase=True, flags=flags, physicsClientId=client)


def collision(geometry, xyz="0 0 0", rpy="0 0 0", **attributes):
    said = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f'<collision {said}><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'


def every_geometry(client, folder):
    """All that PyBullet collides: 18 bodies, one of them filtered, and none is a robot."""
    p, random = pybullet, np.random.default_rng(0)
    turned = np.array([0.3, 0.1, 0.2, 0.7]) / np.linalg.norm([0.3, 0.1, 0.2, 0.7])
    obj, prism = tetrahedra(folder / "two.obj"), stl(folder / "prism.stl")
    heights = random.uniform(0, 0.2, size=9 * 7).tolist()
    field = {
        "heightfieldData": heights,
        "numHeightfieldRows": 9,
        "numHeightfieldColumns": 7,
        "meshScale": [0.1, 0.12, 1],
    }
    body(client, "floor", (p.GEOM_PLANE, {"planeNormal": [0, 0, 1]}), [0, 0, -0.6])
    body(client, "crate", (p.GEOM_BOX, {"halfExtents": [0.1, 0.1, 0.2]}), [0.5, 0.3, 0.1])
    body(client, "ball", (p.GEOM_SPHERE, {"radius": 0.1}), [0.5, -0.3, 0.5])
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
    urdf_body(client, folder, "mixed", mixed, [0.5, 0, 0.75], turned)
    urdf_body(
        client, folder, "prism", collision(f'<mesh filename="{prism}" scale="0.7 0.7 0.7"/>'), [0.1, -0.4, 0.3], turned
    )
    tube = collision(f'<mesh filename="{prism}"/>', "0 0 0.1", concave="yes")
    urdf_body(client, folder, "tube", tube, [-0.2, 0.5, 0.8], turned)
    can = collision('<cylinder radius="0.1" length="0.2"/>')
    urdf_body(client, folder, "can", can, [0.35, -0.5, 0.1], turned, p.URDF_USE_IMPLICIT_CYLINDER)


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
    return client


def urdf_of(mbm_dir):
    folder = mbm_dir / "panda"
    return {
        "urdf_path": str(folder / "panda.urdf"),
        "srdf_path": str(folder / "panda.srdf"),
        "end_effector": "panda_hand",
        "package_dirs": [str(folder)],
    }


def test_every_geometry_of_the_simulators_own_model_agrees(sim, sim_checks):
    planner = srmp.PlannerInterface()
    planner.read_sim(sim, "pybullet", articulations=OWN)
    assert len(planner.object_names) >= 12
    sim_checks.parity(planner, sim)
