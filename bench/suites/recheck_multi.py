"""Re-checks the results of `srmp bench multi` with Pinocchio's and Coal's own Python packages, without srmp.

    python bench/suites/recheck_multi.py results.json [--rate 1000] [--out recheck.json]

Builds the scenario that the result file's header describes, evaluates the cubics of all timed trajectories on the
common clock 1000 times a second, and names the pair in contact: among links of one robot and of different robots,
objects and attached objects. It also names robots that do not begin at their start or end at their goal. Links of one
robot may touch where its SRDF allows it; without an SRDF, links with one joint between them may touch, and those that
the header lists. Fixed bases, objects and other bases never move and are not compared with each other. The exit code is
1 when a fault is found. Needs pin, coal (pip install pin coal).
"""

from __future__ import annotations

import argparse
import itertools
import json
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import coal
import cubics
import numpy as np
import pinocchio as pin

GOAL_TOLERANCE = 1e-6  # [rad or m]


def to_shape(item: Mapping[str, Any]) -> coal.CollisionGeometry:
    shapes = {"box": coal.Box, "cylinder": coal.Cylinder}
    if item["type"] not in shapes:
        raise ValueError(f"{item['name']} is a {item['type']}, which is not supported here")
    return shapes[item["type"]](*item["size"])


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
    """All robots with their attached objects, and the objects of the scene."""

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        self.model, self.geometry = pin.Model(), pin.GeometryModel()
        self._allowed: set[frozenset[str]] = set()
        self._fixed_joints: dict[str, float] = {}
        loader = coal.CachedMeshLoader(coal.NODE_TYPE.BV_OBBRSS)
        for name, robot in scenario["robots"].items():
            self._add_robot(name, robot, loader)
        for item in scenario["held"]:
            self._add_held(item)
        for item in scenario["objects"]:
            self.geometry.addGeometryObject(
                pin.GeometryObject(item["name"], 0, 0, to_se3(item["pose"]), to_shape(item))
            )
        self._choose_pairs()
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()
        self.manager = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(
            self.model, self.geometry, self.geometry_data
        )
        self.default_q = pin.neutral(self.model)
        for joint, value in self._fixed_joints.items():
            self.set_joint(self.default_q, joint, value)

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


def motion(world: World, robots: Mapping[str, Any], rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) [s] and configurations (k, nq) of all robots; each is stationary before and after its own times."""
    tables = {name: {key: np.array(robot[key]) for key in _TABLES} for name, robot in robots.items()}
    first, last = min(t["times"][0] for t in tables.values()), max(t["times"][-1] for t in tables.values())
    at = cubics.instants(first, last, rate)
    q = np.tile(world.default_q, (len(at), 1))
    for name, robot in robots.items():
        times, positions, velocities = (tables[name][key] for key in _TABLES)
        own = np.clip(at, times[0], times[-1])
        moved = cubics.states(times, positions, velocities, own)[0] if len(times) > 1 else positions
        for joint, values in zip(
            robot["joint_names"], np.broadcast_to(moved, (len(at), moved.shape[1])).T, strict=True
        ):
            set_column(world, q, f"{name}/{joint}", values)
    return at, q


_TABLES = ("times", "positions", "velocities")


def set_column(world: World, q: np.ndarray, joint_name: str, values: np.ndarray) -> None:
    joint = world.model.joints[world.model.getJointId(joint_name)]
    columns = [values] if joint.nq == 1 else [np.cos(values), np.sin(values)]
    q[:, joint.idx_q : joint.idx_q + joint.nq] = np.array(columns).T


def faults_of(world: World, row: Mapping[str, Any], rate: float) -> list[str]:
    """One sentence for the first contact, and one for each start or goal that is missed."""
    found = []
    for name, robot in row["robots"].items():
        for what, end in (("start", 0), ("goal", -1)):
            miss = float(np.abs(np.array(robot["positions"][end]) - robot[what]).max())
            if miss > GOAL_TOLERANCE:
                found.append(f"{row['problem']}: {name} misses its {what} by {miss:.3g}")
    for time, q in zip(*motion(world, row["robots"], rate), strict=True):
        if pair := world.touching(q):
            return [*found, f"{row['problem']}: {pair} touch at {time:.3f} s"]
    return found


def recheck(results: Mapping[str, Any], rate: float = 1000.0) -> dict[str, Any]:
    world = World(results["header"]["scenario"])
    solved = [row for row in results["rows"] if row["status"] == "solved"]
    faults = [fault for row in solved for fault in faults_of(world, row, rate)]
    return {"checked": len(solved), "rate_hz": rate, "faults": faults}


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("results", type=Path)
    parser.add_argument("--rate", type=float, default=1000.0, help="configurations per second")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    arguments = parser.parse_args()
    outcome = recheck(json.loads(arguments.results.read_text()), arguments.rate)
    print("\n".join([*outcome["faults"], f"{outcome['checked']} results, {len(outcome['faults'])} faults"]))
    if arguments.out:
        arguments.out.write_text(json.dumps(outcome, indent=2) + "\n")
    return 1 if outcome["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
