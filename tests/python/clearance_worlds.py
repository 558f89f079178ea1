"""Random worlds, and distances of all pairs of bodies along motions, by Pinocchio and Coal alone."""

import numpy as np
import pytest
from support import arms, recheck_scenario

import srmp

CLEARANCE = 0.015
TOLERANCE = 3e-5  # [m] that the rule at the ends allows, and Coal's rounding
BUILT_CLOSE = frozenset(("arm/arm7_wrist", "arm/arm7_flange"))  # 20 mm, wherever the joint between them is


def random_objects(rng, count=8):
    objects = []
    for k in range(count):
        kind = ("box", "sphere", "cylinder")[k % 3]
        size = rng.uniform(0.04, 0.2, {"box": 3, "sphere": 1, "cylinder": 2}[kind])
        angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.35, 0.8)
        p = [radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.0, 0.9)]
        objects.append({"name": f"object{k}", "type": kind, "size": size.tolist(), "pose": [*p, 0, 0, 0, 1]})
    return objects


def add(planner, item):
    pose = srmp.Pose(p=item["pose"][:3])
    adders = {"box": planner.add_box, "sphere": planner.add_sphere, "cylinder": planner.add_cylinder}
    size = [item["size"]] if item["type"] == "box" else item["size"]
    adders[item["type"]](item["name"], *size, pose)


ARM_BASE = {"arm": [0, 0, 0, 0, 0, 0, 1]}
FACING_BASES = {"arm": [0, 0, 0, 0, 0, 0, 1], "other": [1.1, 0, 0, 0, 0, 1, 0]}


def make_arms(bases=ARM_BASE):
    return arms({name: srmp.Pose(p=base[:3], q=base[3:]) for name, base in bases.items()})


class Measured:
    """Distances of all pairs of bodies along a motion, by Pinocchio and Coal alone."""

    def __init__(self, suite, objects, held=(), bases=ARM_BASE):
        self.pin = pytest.importorskip("pinocchio")
        suite("recheck_multi")
        from srmp.recheck.world import World

        self.world = World(recheck_scenario(bases, objects, held))
        parts = [self.world.body(part) for part in self.world.geometry.geometryObjects]
        pairs = self.world.geometry.collisionPairs
        self.pairs = [frozenset((parts[pair.first], parts[pair.second])) for pair in pairs]

    def at(self, positions):
        """[m] of each pair; `positions` by "robot/joint"."""
        world = self.world
        q = world.default_q.copy()
        for name, value in positions.items():
            world.set_joint(q, name, value)
        self.pin.updateGeometryPlacements(world.model, world.data, world.geometry, world.geometry_data, q)
        self.pin.computeDistances(world.geometry, world.geometry_data)
        return np.array([result.min_distance for result in world.geometry_data.distanceResults])

    def along(self, motions):
        """(instants, pairs) [m], of bodies, at instants that no joint moves by more than 4 mrad between."""
        times = set()
        for motion in motions.values():
            rows = zip(motion.positions, motion.positions[1:], motion.times, motion.times[1:], strict=False)
            times |= {motion.times[0]}
            for a, b, t, u in rows:
                steps = int(np.ceil(np.abs(b - a).max() / 4e-3)) + 1
                times |= set(np.linspace(t, u, steps + 1)[1:].tolist())
        times = sorted(times)
        found = np.array([self.at(positions_at(motions, t)) for t in times])
        bodies = list(dict.fromkeys(self.pairs))
        of = [[k for k, pair in enumerate(self.pairs) if pair == body] for body in bodies]
        return np.array(times), bodies, np.stack([found[:, columns].min(axis=1) for columns in of], axis=1)


def positions_at(motions, t):
    return {
        f"{robot}/{joint}": value
        for robot, motion in motions.items()
        for joint, value in zip(motion.joint_names, motion.sample(min(t, motion.times[-1])), strict=True)
    }


def require_kept(distances, clearance):
    """One pair's: above the clearance but near ends that are closer, and there never less than nearer to that end."""
    kept = np.flatnonzero(distances >= clearance - TOLERANCE)
    assert len(kept)
    first, last = kept[0], kept[-1]
    assert (distances[first : last + 1] >= clearance - TOLERANCE).all()
    for way in (distances[: first + 1], distances[last:][::-1]):
        assert (way >= np.maximum.accumulate(way) - TOLERANCE).all()


def ends(planner, rng, count):
    """Free configurations, many of them close to something."""
    limits = np.clip(np.array(planner.get_joint_limits("arm"))[:, :2], -2.9, 2.9)
    q = rng.uniform(limits[:, 0], limits[:, 1], (400, len(limits)))
    q = q[planner.collision_checker("arm").are_free(q)]
    distance = np.array([planner.distance_to_collision("arm", row) for row in q])
    close, far = q[(distance > 2e-3) & (distance < CLEARANCE)], q[distance > CLEARANCE]
    picked = [close if k % 2 else far for k in range(count)]
    return [rows[k // 2] for k, rows in enumerate(picked)]
