"""Re-checks the paths of `srmp bench mbm` with Pinocchio's and Coal's own Python packages, without any code of srmp.

    python bench/suites/recheck_mbm.py results.json --data DIR [--same-as other.json]

Samples every returned path, and the positions of its timed trajectory, in steps of 0.01 rad (largest joint difference),
checks the robot's collision meshes and names the pair in contact. The exit code is 1 when there is any contact, or when
a path differs from the other file's in a single bit. Needs pin, coal, PyYAML (pip install pin coal pyyaml).
"""

from __future__ import annotations

import argparse
import itertools
import json
import re
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import yaml

STEP = 0.01  # [rad or m]


def read_problem(directory: Path, robot: str, problem: str, kind: str) -> dict:
    scenario, number = problem.split("/")
    name = f"{scenario}_{robot}/{kind}{number}.yaml"
    if (directory / "problems").is_dir():
        return yaml.safe_load((directory / "problems" / name).read_text())
    with tarfile.open(directory / "problems.tar.bz2") as tar:
        if directory not in _members:
            _members[directory] = {
                member.name: tar.extractfile(member).read().decode()
                for member in tar.getmembers()
                if member.isfile() and member.name.endswith(".yaml")
            }
    text = next(text for path, text in _members[directory].items() if path.endswith(name))
    return yaml.safe_load(text)


_members: dict[Path, dict[str, str]] = {}


def to_shape(primitive: dict) -> coal.CollisionGeometry:
    size = primitive["dimensions"]
    if primitive["type"] == "box":
        return coal.Box(*size)
    if primitive["type"] == "cylinder":  # MoveIt: height, radius
        return coal.Cylinder(size[1], size[0])
    if primitive["type"] == "sphere":
        return coal.Sphere(size[0])
    raise ValueError(f"primitive {primitive['type']} is not supported here")


def to_se3(pose: dict) -> pin.SE3:
    quaternion = pin.Quaternion(np.array(pose["orientation"], dtype=float))  # x, y, z, w
    return pin.SE3(quaternion.normalized().matrix(), np.array(pose["position"], dtype=float))


class World:
    """The robot's collision meshes and one problem's objects."""

    def __init__(self, directory: Path, robot: str, urdf: Path, problem: str) -> None:
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.geometry = pin.buildGeomFromUrdf(
            self.model, str(urdf), pin.GeometryType.COLLISION, package_dirs=[str(directory), str(directory.parent)]
        )
        self.geometry.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, self.geometry, str(directory / f"{robot}.srdf"))
        parts = self.geometry.ngeoms
        for item in read_problem(directory, robot, problem, "scene")["world"]["collision_objects"]:
            placement = to_se3(item["pose"]) if "pose" in item else pin.SE3.Identity()
            for primitive, pose in zip(item["primitives"], item["primitive_poses"], strict=True):
                placed = pin.GeometryObject(item["id"], 0, 0, placement * to_se3(pose), to_shape(primitive))
                index = self.geometry.addGeometryObject(placed)
                for part in range(parts):
                    # A fixed base never moves relative to the objects, so no plan can cause a collision of it.
                    if self.geometry.geometryObjects[part].parentJoint != 0:
                        self.geometry.addCollisionPair(pin.CollisionPair(part, index))
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()
        state = read_problem(directory, robot, problem, "request")["start_state"]["joint_state"]
        self.default_q = pin.neutral(self.model)
        for name, value in zip(state["name"], state["position"], strict=True):
            self.set_joint(self.default_q, name, value)

    def set_joint(self, q: np.ndarray, name: str, value: float) -> None:
        if not self.model.existJointName(name):
            return
        joint = self.model.joints[self.model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]

    def touching(self, names: list[str], values: np.ndarray) -> str:
        q = self.default_q.copy()
        for name, value in zip(names, values, strict=True):
            self.set_joint(q, name, value)
        if not pin.computeCollisions(self.model, self.data, self.geometry, self.geometry_data, q, True):
            return ""
        for pair, result in zip(self.geometry.collisionPairs, self.geometry_data.collisionResults, strict=True):
            if result.isCollision():
                return " and ".join(self.geometry.geometryObjects[i].name for i in (pair.first, pair.second))
        return "unknown pair"


def samples(waypoints: np.ndarray) -> Iterator[np.ndarray]:
    yield waypoints[0]
    for a, b in itertools.pairwise(waypoints):
        count = max(1, int(np.ceil(np.abs(b - a).max() / STEP)))
        for i in range(1, count + 1):
            yield a + (b - a) * (i / count)


def recheck(results: dict, data: Path) -> list[str]:
    """One sentence for each path that is in collision."""
    options = results["header"]["options"]
    directory = data / options["robot"]
    suffix = "" if options["geometry"] == "urdf" else "_spherized"
    urdf = directory / f"{options['robot']}{suffix}.urdf"
    faults = []
    for row in results["rows"]:
        if row["status"] != "solved":
            continue
        world = World(directory, options["robot"], urdf, row["problem"])
        for what in ("path", "positions"):
            for q in samples(np.array(row[what])):
                if pair := world.touching(row["joint_names"], q):
                    faults.append(f"{row['problem']}: {pair} touch on the {what} at {np.round(q, 4).tolist()}")
                    break
    return faults


def differing(results: dict, other: dict) -> list[str]:
    """Problems whose paths are not the same bit for bit (JSON holds the shortest text that restores each double)."""
    paths = {row["problem"]: row["path"] for row in other["rows"]}
    return [row["problem"] for row in results["rows"] if row["path"] != paths.get(row["problem"])]


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("results", type=Path)
    parser.add_argument("--data", type=Path, required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--same-as", type=Path, help="results of another run: every path must be the same")
    arguments = parser.parse_args()
    results = json.loads(arguments.results.read_text())
    solved = sum(row["status"] == "solved" for row in results["rows"])
    faults = recheck(results, arguments.data)
    print("\n".join([*faults, f"{solved} paths, {len(faults)} of them in collision"]))
    if arguments.same_as:
        different = differing(results, json.loads(arguments.same_as.read_text()))
        print(
            f"{len(different)} paths differ from {arguments.same_as}{': ' if different else ''}{', '.join(different)}"
        )
        faults += different
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
