"""The few facts that the Python side wants to know of a URDF; RobotModel is the one that understands it."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class UrdfJoint:
    name: str
    kind: str  # revolute, continuous, prismatic, fixed …
    parent: str  # link
    child: str  # link
    mimics: str  # joint, or ""


def read_joints(urdf_path: str | Path) -> list[UrdfJoint]:
    """The joints of a URDF file, in its order."""
    joints = []
    for joint in ElementTree.parse(urdf_path).getroot().findall("joint"):
        parent, child, mimic = joint.find("parent"), joint.find("child"), joint.find("mimic")
        joints.append(
            UrdfJoint(
                name=joint.get("name", ""),
                kind=joint.get("type", ""),
                parent="" if parent is None else parent.get("link", ""),
                child="" if child is None else child.get("link", ""),
                mimics="" if mimic is None else mimic.get("joint", ""),
            )
        )
    return joints


def settable_joints(joints: list[UrdfJoint]) -> set[str]:
    """Names of the joints that have a position of their own: neither fixed nor mimics."""
    return {
        joint.name for joint in joints if joint.kind in ("revolute", "continuous", "prismatic") and not joint.mimics
    }


def chain_links(joints: list[UrdfJoint], tip: str) -> list[str]:
    """Links from the root to `tip`."""
    parents = {joint.child: joint.parent for joint in joints}
    links = [tip]
    while links[-1] in parents:
        links.append(parents[links[-1]])
    return links[::-1]
