"""Checks of one record's motions against its robots' files and its scene, without the planner."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import srmp
from srmp._urdf import joints_of
from srmp.datasets.dataset import Dataset
from srmp.datasets.scene import pose_of

STEP = 0.02
"""Between configurations that are checked for collisions: the most that a joint moves [rad or m]."""
_TOLERANCE = 1e-6  # relative, of limits
_MISS = 1e-6  # of starts and goals [rad or m]
_POSE_MISS = (1e-3, 1e-2)  # of goal poses [m, rad]: the tolerances of a goal
_DISTANCE = 1e-5  # [m] by which a distance may be below what a certificate says


class MotionChecks:
    """The robots of a data set; their scene is set for each record."""

    def __init__(self, dataset: Dataset) -> None:
        try:
            from srmp.recheck import cubics
            from srmp.recheck.world import World
        except ModuleNotFoundError as error:
            raise srmp.Error(
                f"an audit needs the package {'pin' if error.name == 'pinocchio' else error.name}: pip install "
                '".[datasets]" in a checkout (or pip install pin coal).'
            ) from error
        self._cubics = cubics
        self._names = dataset.joint_names
        planner = dataset.robots()
        robots, self._limits, self._end_effectors = {}, {}, {}
        for robot in dataset.spec.robots:
            files = dataset.directory / "robots" / robot.name
            srdf = files / "robot.srdf"
            robots[robot.name] = {
                "urdf": files / "robot.urdf",
                "srdf": srdf if srdf.exists() else None,
                "package_dirs": [],
                "allowed": planner.get_always_colliding(robot.name),
                "fixed_joints": robot.fixed_joints,
                "base": robot.base,
            }
            self._limits[robot.name] = _limits(files / "robot.urdf", self._names[robot.name])
            self._end_effectors[robot.name] = f"{robot.name}/{robot.end_effector}"
        self._world = World({"robots": robots, "held": [], "objects": []})
        self._period = float(srmp.planner_options(dict(dataset.spec.planner))["sample_period"])

    def faults_of(self, row: Mapping[str, Any]) -> list[str]:
        """What is wrong with a robot's motion alone: one sentence for each fault."""
        name = row["name"]
        times, q, v, waypoints = (row[key] for key in ("times", "positions", "velocities", "waypoints"))
        dof = len(self._names[name])
        if len(row["start"]) != dof or len(times) < 2 or q.shape != (len(times), dof) or v.shape != q.shape:
            return [f"the arrays of '{name}' do not fit together."]
        if not all(np.all(np.isfinite(array)) for array in (times, q, v, waypoints)):
            return [f"the motion of '{name}' has a number that is not finite."]
        steps = np.diff(times)
        if np.any(steps <= 0):
            return [f"the times of '{name}' do not increase."]
        faults = []
        if times[0] != 0 or np.any(np.abs(steps[:-1] - self._period) > 1e-9) or steps[-1] > 1.02 * self._period:
            faults.append(f"the rows of '{name}' are not {self._period:g} s apart from 0 on.")
        faults += self._limit_faults(name, times, q, v)
        return faults + self._end_faults(row)

    def _limit_faults(self, name: str, times: np.ndarray, q: np.ndarray, v: np.ndarray) -> list[str]:
        """Extremes of the cubics: velocities where the acceleration is 0, positions at rows and on Bernstein's hull."""
        lower, upper, velocity = self._limits[name]
        h = np.diff(times)[:, None]
        inner = np.array([q[:-1] + v[:-1] * h / 3, q[1:] - v[1:] * h / 3])
        speeds = 3 * np.diff(np.concatenate([q[None, :-1], inner, q[None, 1:]]), axis=0) / h
        accelerations = 2 * np.diff(speeds, axis=0) / h
        fastest = np.maximum(np.abs(v).max(axis=0), self._peak_speeds(speeds))
        outside = np.maximum(lower - q.min(axis=0), q.max(axis=0) - upper)
        hardest = np.abs(accelerations).max(axis=(0, 1))
        checks = (
            ("a joint of '{}' leaves its position limits", outside, np.full(len(lower), 1e-9)),
            ("a joint of '{}' is faster than its limit", fastest - velocity, _TOLERANCE * velocity),
            ("a joint of '{}' accelerates beyond its limit", hardest - 2 * velocity, _TOLERANCE * 2 * velocity),
        )
        faults = []
        for text, difference, tolerance in checks:
            if np.any(difference > tolerance):
                joint = self._names[name][int(np.argmax(difference - tolerance))]
                faults.append(f"{text.format(name)}: {joint}, by {float(np.max(difference)):.3g}.")
        return faults

    def _peak_speeds(self, speeds: np.ndarray) -> np.ndarray:
        """Largest |velocity| inside segments, of the parabola with Bernstein's coefficients `speeds` (3, n, dof)."""
        a, b, c = speeds
        bend = a - 2 * b + c
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.where(bend != 0, (a - b) / bend, 0.0)
        u = np.clip(u, 0.0, 1.0)
        return np.abs((1 - u) ** 2 * a + 2 * u * (1 - u) * b + u**2 * c).max(axis=0)

    def _end_faults(self, row: Mapping[str, Any]) -> list[str]:
        name, q, v = row["name"], row["positions"], row["velocities"]
        faults = []
        for what, rows in (("trajectory", q), ("path", row["waypoints"])):
            miss = float(np.abs(rows[0] - row["start"]).max())
            if miss > _MISS:
                faults.append(f"the {what} of '{name}' misses its start by {miss:.3g}.")
        if np.abs(v[[0, -1]]).max() > _MISS:
            faults.append(f"'{name}' is not at rest at both ends.")
        if row["goal_type"] == "JOINTS":
            miss = float(np.abs(q[-1] - row["goal"]).max())
            if miss > _MISS:
                faults.append(f"'{name}' misses its goal by {miss:.3g}.")
        else:
            metres, radians = self._pose_miss(name, q[-1], row["goal"])
            if metres > _POSE_MISS[0] * math.sqrt(3) or radians > _POSE_MISS[1] * math.sqrt(3):
                faults.append(f"'{name}' misses its goal by {metres:.3g} m and {radians:.3g} rad.")
        return faults

    def _pose_miss(self, name: str, q: np.ndarray, goal: Sequence[float]) -> tuple[float, float]:
        import pinocchio as pin

        place = self._world.place(self._configuration({name: q}), self._end_effectors[name])
        difference = place.actInv(pin.XYZQUATToSE3(np.array(list(pose_of(goal)))))
        return float(np.linalg.norm(difference.translation)), float(np.linalg.norm(pin.log3(difference.rotation)))

    def _configuration(self, joints: Mapping[str, np.ndarray]) -> np.ndarray:
        q = self._world.default_q.copy()
        for robot, values in joints.items():
            for joint, value in zip(self._names[robot], values, strict=True):
                self._world.set_joint(q, f"{robot}/{joint}", value)
        return q

    def collisions_of(self, rows: Sequence[Mapping[str, Any]], objects: Sequence[Mapping[str, Any]]) -> list[str]:
        """The first contact of the robots' motion together, and certificates whose clearance is not there."""
        self._world.set_objects(objects)
        at = self._instants(rows)
        for time in at:
            if pair := self._world.touching(self._at(rows, time)):
                return [f"{pair} touch at {time:.3f} s."]
        return [fault for row in rows for fault in self._clearance_faults(rows, row)]

    def _instants(self, rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
        """Times so near to each other that no joint moves more than STEP in between."""
        last = max(row["times"][-1] for row in rows)
        fastest = max(float(np.abs(row["velocities"]).max()) for row in rows)
        return np.linspace(0.0, last, max(2, math.ceil(last * max(fastest, 1e-3) / STEP) + 1))

    def _at(self, rows: Sequence[Mapping[str, Any]], time: float) -> np.ndarray:
        joints = {}
        for row in rows:
            own = np.array([np.clip(time, 0.0, row["times"][-1])])
            joints[row["name"]] = self._cubics.states(row["times"], row["positions"], row["velocities"], own)[0][0]
        return self._configuration(joints)

    def _clearance_faults(self, rows: Sequence[Mapping[str, Any]], row: Mapping[str, Any]) -> list[str]:
        """Are the nearest bodies, where the certificate says they are nearest, as far apart as it says?

        They may be farther: the library takes a mesh of several parts in each way that it can be read.
        """
        proof, name = row["certificate"], row["name"]
        if math.isinf(proof["clearance"]):
            return []
        bodies = [self._world_name(name, body) for body in (proof["body_a"], proof["body_b"])]
        try:
            distance = self._world.distance(self._at(rows, proof["clearance_time"]), *bodies)
        except ValueError as error:
            return [f"the certificate of '{name}' is about bodies that are not there: {error}."]
        if distance < proof["clearance"] - _DISTANCE:
            return [
                f"{bodies[0]} and {bodies[1]} are {distance:.6g} m apart where the certificate of '{name}' says "
                f"{proof['clearance']:.6g} m."
            ]
        return []

    def _world_name(self, robot: str, body: str) -> str:
        return f"{robot}/{body}" if f"{robot}/{body}" in self._world.links else body


def _limits(urdf: Any, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lower and upper limits and velocity limits of the joints, as the URDF has them (1 where it gives none)."""
    root = ElementTree.parse(urdf).getroot()
    joints = {joint.name: joint for joint in joints_of(root)}
    speeds = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        speed = float(limit.get("velocity", "0")) if limit is not None else 0.0
        speeds[joint.get("name", "")] = speed if 0 < speed <= 1e6 else 1.0
    bounds = [(joints[name].lower, joints[name].upper, speeds[name]) for name in names]
    lower, upper, velocity = np.array(bounds).T
    return lower, upper, velocity
