"""Bodies of PyBullet, and a planner that has read them."""

import itertools
from pathlib import Path

import numpy as np
import pybullet

import srmp


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


def body(client, name, shape, position=(0, 0, 0), turn=(0, 0, 0, 1), mass=0.0, **options):
    """A body of one collision shape: createCollisionShape's type and arguments."""
    kind, arguments = shape
    number = pybullet.createCollisionShape(kind, **arguments, physicsClientId=client)
    unique = pybullet.createMultiBody(mass, number, -1, position, turn, physicsClientId=client, **options)
    pybullet.addUserData(unique, "name", name, physicsClientId=client)
    return unique


def cuboid(client, name, half, position, mass=0.0):
    return body(client, name, (pybullet.GEOM_BOX, {"halfExtents": half}), position, mass=mass)


URDF_BODY = """
<robot name="{name}"><link name="body">
  <inertial><origin xyz="0.03 0.02 -0.01" rpy="0.3 0.2 0.1"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  {collisions}
</link></robot>
"""


def urdf_body(client, directory, name, collisions, position, turn=(0, 0, 0, 1), flags=0):
    path = Path(directory, f"{name}.urdf")
    path.write_text(URDF_BODY.format(name=name, collisions=collisions))
    return pybullet.loadURDF(str(path), position, turn, useFixedBase=True, flags=flags, physicsClientId=client)


def collision(geometry, xyz="0 0 0", rpy="0 0 0", **attributes):
    said = " ".join(f'{key}="{value}"' for key, value in attributes.items())
    return f'<collision {said}><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{geometry}</geometry></collision>'


def read(client, **options):
    planner = srmp.PlannerInterface()
    return planner, planner.read_sim(client, "pybullet", **options)
