"""The few facts that the Python side wants to know of a URDF; RobotModel is the one that understands it."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class UrdfJoint:
    name: str
    parent: str  # link
    child: str  # link


def read_joints(urdf_path: str | Path) -> list[UrdfJoint]:
    """The joints of a URDF file, in its order."""
    joints = []
    for joint in ElementTree.parse(urdf_path).getroot().findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        joints.append(
            UrdfJoint(
                name=joint.get("name", ""),
                parent="" if parent is None else parent.get("link", ""),
                child="" if child is None else child.get("link", ""),
            )
        )
    return joints


def chain_links(joints: list[UrdfJoint], tip: str) -> list[str]:
    """Links from the root to `tip`."""
    parents = {joint.child: joint.parent for joint in joints}
    links = [tip]
    while links[-1] in parents:
        links.append(parents[links[-1]])
    return links[::-1]
