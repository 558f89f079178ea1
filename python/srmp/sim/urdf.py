"""A URDF of a robot that only the simulator has: its joints and collision shapes, for the planner to read."""

from __future__ import annotations

import hashlib
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from srmp import NotSupported, Pose, cover_directory
from srmp._files import write_text
from srmp.sim.shapes import Box, Capsule, Cylinder, Mesh, Plane, Shape, Sphere, as_mesh, hull
from srmp.sim.simulator import Articulation, Joint

# Of joints that have none in the simulator: slow enough for any arm. set_motion_limits says better ones.
VELOCITY = {"revolute": 1.5, "continuous": 1.5, "prismatic": 0.2}  # [rad/s], [m/s]


def to_urdf(articulation: Articulation, links: Mapping[str, str], joints: Mapping[str, str]) -> str:
    """The text. `links` and `joints`: the names to use, by those in the simulator. Meshes go to mesh_directory()."""
    robot = Element("robot", name=articulation.name)
    for body in articulation.links:
        link = SubElement(robot, "link", name=links[body.name])
        for geometry in body.geometries:
            _add_collision(link, geometry.shape, geometry.pose)
    for joint in articulation.joints:
        _add_joint(robot, joint, links, joints)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode")


def mesh_directory() -> Path:
    """Where meshes of such robots are kept, beside the covers that are made of them (docs/covers.md)."""
    covers = cover_directory()
    return (Path(covers).parent if covers else Path(tempfile.gettempdir()) / "srmp") / "meshes"


def _add_joint(robot: Element, joint: Joint, links: Mapping[str, str], joints: Mapping[str, str]) -> None:
    element = SubElement(robot, "joint", name=joints[joint.name], type=joint.kind)
    _add_origin(element, joint.origin)
    SubElement(element, "parent", link=links[joint.parent])
    SubElement(element, "child", link=links[joint.child])
    if joint.kind not in ("fixed", *VELOCITY):
        raise NotSupported(
            f"joint '{joint.name}' of articulation '{robot.get('name')}' has more than one degree of freedom, or a "
            "kind that URDFs do not have; name a URDF of the robot, or leave the articulation out"
        )
    if joint.kind == "fixed":
        return
    SubElement(element, "axis", xyz=_numbers(joint.axis))
    limit = {"velocity": repr(float(joint.velocity or VELOCITY[joint.kind])), "effort": "0"}
    if joint.kind != "continuous":
        limit |= {"lower": repr(float(joint.lower)), "upper": repr(float(joint.upper))}
    SubElement(element, "limit", limit)


def _add_collision(link: Element, shape: Shape, pose: Pose) -> None:
    """One collision element, or three for a capsule, which URDFs do not have."""

    def add(kind: str, at: Pose, **attributes: str) -> None:
        collision = SubElement(link, "collision")
        _add_origin(collision, at)
        SubElement(SubElement(collision, "geometry"), kind, attributes)

    match shape:
        case Box(size):
            add("box", pose, size=_numbers(size))
        case Sphere(radius):
            add("sphere", pose, radius=repr(float(radius)))
        case Cylinder(radius, length):
            add("cylinder", pose, radius=repr(float(radius)), length=repr(float(length)))
        case Capsule(radius, length):
            add("cylinder", pose, radius=repr(float(radius)), length=repr(float(length)))
            for end in (-length / 2, length / 2):
                add("sphere", pose @ Pose(p=[0, 0, end]), radius=repr(float(radius)))
        case Plane():
            raise NotSupported(f"link '{link.get('name')}' has a plane, which is endless; a robot's shapes must not be")
        case _:
            add("mesh", pose, filename=str(_mesh_file(hull(as_mesh(shape)))))


def _mesh_file(mesh: Mesh) -> Path:
    """An OBJ file named after what it holds, so that it is written once."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(mesh.vertices, dtype=float).tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(mesh.triangles).tolist()]
    text = "\n".join(lines) + "\n"
    path = mesh_directory() / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.obj"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, text)
    return path


def _add_origin(element: Element, pose: Pose) -> None:
    SubElement(element, "origin", xyz=_numbers(pose.p), rpy=_numbers(pose.rpy()))


def _numbers(values: object) -> str:
    return " ".join(repr(float(value)) for value in values)  # type: ignore[attr-defined]
