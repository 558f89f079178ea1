"""The few facts that the Python side wants to know of a URDF; RobotModel is the one that understands it."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class UrdfJoint:
    name: str
    parent: str  # link
    child: str  # link
    type: str
    lower: float  # [rad or m]; -inf, inf: continuous
    upper: float
    mimics: str  # joint, or ""

    @property
    def moves(self) -> bool:
        """Has it one position?"""
        return self.type in ("revolute", "continuous", "prismatic")


def read_joints(urdf_path: str | Path) -> list[UrdfJoint]:
    """The joints of a URDF file, in its order."""
    return joints_of(ElementTree.parse(urdf_path).getroot())


def joints_of(urdf: ElementTree.Element) -> list[UrdfJoint]:
    """The joints of a URDF, in its order."""
    return [_joint(joint) for joint in urdf.findall("joint")]


def _joint(joint: ElementTree.Element) -> UrdfJoint:
    def attribute(element: str, name: str, default: str) -> str:
        found = joint.find(element)
        return default if found is None else found.get(name, default)

    bounded = joint.get("type") != "continuous"
    return UrdfJoint(
        name=joint.get("name", ""),
        parent=attribute("parent", "link", ""),
        child=attribute("child", "link", ""),
        type=joint.get("type", ""),
        lower=float(attribute("limit", "lower", "0")) if bounded else -np.inf,
        upper=float(attribute("limit", "upper", "0")) if bounded else np.inf,
        mimics=attribute("mimic", "joint", ""),
    )


def chain_links(joints: list[UrdfJoint], end: str) -> list[str]:
    """Links from the root to `end`."""
    parents = {joint.child: joint.parent for joint in joints}
    links = [end]
    while links[-1] in parents:
        links.append(parents[links[-1]])
    return links[::-1]


def link_poses_at_zero(urdf_path: str | Path) -> dict[str, np.ndarray]:
    """Homogeneous (4, 4) matrices of all links in the root's frame, with every joint at 0."""
    root = ElementTree.parse(urdf_path).getroot()
    origins = {}
    for joint in root.findall("joint"):
        parent, child, origin = joint.find("parent"), joint.find("child"), joint.find("origin")
        if parent is not None and child is not None:
            origins[child.get("link", "")] = (parent.get("link", ""), origin_matrix(origin))
    poses: dict[str, np.ndarray] = {}

    def pose_of(link: str) -> np.ndarray:
        if link not in poses:
            parent_name, transform = origins.get(link, ("", np.eye(4)))
            poses[link] = pose_of(parent_name) @ transform if parent_name else transform
        return poses[link]

    for link in root.findall("link"):
        pose_of(link.get("name", ""))
    return poses


def origin_matrix(origin: ElementTree.Element | None) -> np.ndarray:
    """The homogeneous (4, 4) matrix of an <origin>; the identity where there is none."""
    pose = np.eye(4)
    if origin is None:
        return pose
    roll, pitch, yaw = (float(x) for x in (origin.get("rpy") or "0 0 0").split())
    pose[:3, 3] = [float(x) for x in (origin.get("xyz") or "0 0 0").split()]
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    pose[:3, :3] = about_z @ about_y @ about_x
    return pose
