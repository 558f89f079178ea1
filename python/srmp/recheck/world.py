"""Collisions of recorded motions by Pinocchio's and Coal's own Python packages, without any code of the planner.

What `srmp audit` and bench/suites/recheck_multi.py rest on. Needs the packages pin and coal.
"""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin


def to_shape(item: Mapping[str, Any]) -> coal.CollisionGeometry:
    """Coal's geometry of an object: type, size [m], and for meshes vertices and triangles, flat or in rows."""
    shapes = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}
    shapes["cone"] = coal.Cone
    if item["type"] in shapes:
        return shapes[item["type"]](*item["size"])
    if item["type"] not in ("mesh", "convex"):
        raise ValueError(f"{item['name']} is a {item['type']}, which is not supported here")
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for point in np.reshape(item["vertices"], (-1, 3)).astype(float):
        points.append(point)
    for triangle in np.reshape(item["triangles"], (-1, 3)).tolist():
        triangles.append(coal.Triangle(*triangle))
    if item["type"] == "convex":
        return coal.Convex(points, triangles)
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(points))
    model.addSubModel(points, triangles)
    model.endModel()
    return model


def to_se3(pose: Sequence[float]) -> pin.SE3:
    """From x, y, z [m] and the quaternion x, y, z, w."""
    return pin.XYZQUATToSE3(np.array(pose, dtype=float))


def prefixed(urdf: Path, prefix: str) -> str:
    """The URDF, with the prefix added to every name of a link or a joint."""
    root = ElementTree.parse(urdf).getroot()
    named = [*root.findall("link"), *root.findall("joint")]
    for element in named:
        element.set("name", prefix + element.get("name", ""))
    for element, key in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
        for reference in root.findall(f"joint/{element}"):
            reference.set(key, prefix + reference.get(key, ""))
    return ElementTree.tostring(root, encoding="unicode")


def mimicked(urdf: str, values: Mapping[str, float]) -> dict[str, float]:
    """Values of the joints that mimic one of `values`."""
    found = {}
    for joint in ElementTree.fromstring(urdf).findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and (leader := mimic.get("joint", "")) in values:
            scale, offset = (float(mimic.get(key, default)) for key, default in (("multiplier", 1), ("offset", 0)))
            found[joint.get("name", "")] = scale * values[leader] + offset
    return found


def pairs_allowed(name: str, robot: Mapping[str, Any]) -> Iterator[frozenset[str]]:
    """Pairs of this robot's links that may touch, from its SRDF and from the header."""
    if robot.get("srdf"):
        for pair in ElementTree.parse(robot["srdf"]).getroot().iter("disable_collisions"):
            yield frozenset((f"{name}/{pair.get('link1')}", f"{name}/{pair.get('link2')}"))
    for a, b in robot.get("allowed", []):
        yield frozenset((f"{name}/{a}", f"{name}/{b}"))


class World:
    """All robots with their attached objects, and the objects of the scene, which may be replaced."""

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        """scenario: robots, objects and held, laid out as in the header of `srmp bench multi`'s result file."""
        self.model, self.geometry = pin.Model(), pin.GeometryModel()
        self._allowed: set[frozenset[str]] = set()
        self._fixed_joints: dict[str, float] = {}
        loader = coal.CachedMeshLoader(coal.NODE_TYPE.BV_OBBRSS)
        for name, robot in scenario["robots"].items():
            self._add_robot(name, robot, loader)
        for item in scenario["held"]:
            self._add_held(item)
        self.data = self.model.createData()
        self.default_q = pin.neutral(self.model)
        for joint, value in self._fixed_joints.items():
            self.set_joint(self.default_q, joint, value)
        self._robots_only = self.geometry.copy()
        self.set_objects(scenario["objects"])

    def set_objects(self, objects: Sequence[Mapping[str, Any]]) -> None:
        """Replaces the objects; the robots stay."""
        self.geometry = self._robots_only.copy()
        for item in objects:
            self.geometry.addGeometryObject(
                pin.GeometryObject(item["name"], 0, 0, to_se3(item["pose"]), to_shape(item))
            )
        self._choose_pairs()
        self.geometry_data = self.geometry.createData()
        self.manager = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(
            self.model, self.geometry, self.geometry_data
        )

    def _add_robot(self, name: str, robot: Mapping[str, Any], loader: coal.MeshLoader) -> None:
        text = prefixed(Path(robot["urdf"]), f"{name}/")
        directory = Path(robot["urdf"]).parent
        model = pin.buildModelFromXML(text)
        directories = [*robot["package_dirs"], str(directory), str(directory.parent)]
        geometry = pin.buildGeomFromUrdfString(
            model, text, pin.GeometryType.COLLISION, package_dirs=directories, mesh_loader=loader
        )
        self.model, self.geometry = pin.appendModel(
            self.model, model, self.geometry, geometry, 0, to_se3(robot["base"])
        )
        self._allowed.update(pairs_allowed(name, robot))
        if not robot["srdf"]:
            self._allowed.update(self._neighbours(name))
        fixed = {f"{name}/{joint}": float(value) for joint, value in robot["fixed_joints"].items()}
        self._fixed_joints.update(fixed)
        self._fixed_joints.update(mimicked(text, fixed))

    def _neighbours(self, robot: str) -> Iterator[frozenset[str]]:
        """Pairs of links with one joint between them."""
        parts = [part for part in self.geometry.geometryObjects if self.body(part).startswith(f"{robot}/")]
        for a, b in itertools.permutations(parts, 2):
            if self.model.parents[b.parentJoint] == a.parentJoint:
                yield frozenset((self.body(a), self.body(b)))

    def _add_held(self, item: Mapping[str, Any]) -> None:
        frame = self.model.frames[self.model.getFrameId(f"{item['robot']}/{item['link']}")]
        placement = frame.placement * to_se3(item["pose"])
        held = pin.GeometryObject(item["name"], frame.parentJoint, 0, placement, to_shape(item))
        self.geometry.addGeometryObject(held)
        touched = {item["link"], *item["may_touch"]}
        self._allowed.update(frozenset((item["name"], f"{item['robot']}/{link}")) for link in touched)

    def body(self, geometry: pin.GeometryObject) -> str:
        """The name of the link, "robot/link", or of the object, attached or not."""
        frame = self.model.frames[geometry.parentFrame].name
        return geometry.name if geometry.parentFrame == 0 else frame

    def _choose_pairs(self) -> None:
        """Chooses all pairs but allowed ones, and those of bodies that never move relative to each other."""
        bodies = [(self.body(item), item.parentJoint) for item in self.geometry.geometryObjects]
        chosen = np.zeros((len(bodies), len(bodies)), dtype=bool)
        for (i, (a, joint_a)), (j, (b, joint_b)) in itertools.combinations(enumerate(bodies), 2):
            chosen[i, j] = joint_a != joint_b and frozenset((a, b)) not in self._allowed
        self.geometry.setCollisionPairs(chosen, True)

    def set_joint(self, q: np.ndarray, name: str, value: float) -> None:
        """Sets a joint, "robot/joint", in the configuration `q` [rad or m]; unknown joints are left out."""
        if not self.model.existJointName(name):
            return
        joint = self.model.joints[self.model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]

    def touching(self, q: np.ndarray) -> str:
        """The first pair in contact that is found, or an empty text."""
        callback = pin.CollisionCallBackDefault(self.geometry, self.geometry_data, True)
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, q)
        self.manager.update(True)
        if not pin.computeCollisions(self.manager, callback):
            return ""
        pair = self.geometry.collisionPairs[callback.collisionPairIndex]
        return " and ".join(self.body(self.geometry.geometryObjects[i]) for i in (pair.first, pair.second))

    @property
    def links(self) -> set[str]:
        """Names of all links, "robot/link"."""
        return {frame.name for frame in self.model.frames if frame.type == pin.FrameType.BODY}

    def place(self, q: np.ndarray, link: str) -> pin.SE3:
        """The pose of a link, "robot/link", in the world."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.model.getFrameId(link)]

    def distance(self, q: np.ndarray, a: str, b: str) -> float:
        """The distance of two bodies [m], by the names that `body` gives; negative: how deep they penetrate."""
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, q)
        parts = list(enumerate(self.geometry.geometryObjects))
        pairs = itertools.product(
            [i for i, part in parts if self.body(part) == a], [j for j, part in parts if self.body(part) == b]
        )
        distances = [self._distance_of(i, j) for i, j in pairs]
        if not distances:
            raise ValueError(f"there are no bodies '{a}' and '{b}'")
        return min(distances)

    def _distance_of(self, i: int, j: int) -> float:
        first, second = (self.geometry.geometryObjects[k].geometry for k in (i, j))
        placements = [
            coal.Transform3s(m.rotation, m.translation) for m in (self.geometry_data.oMg[i], self.geometry_data.oMg[j])
        ]
        return float(
            coal.distance(first, placements[0], second, placements[1], coal.DistanceRequest(), coal.DistanceResult())
        )
