"""Arms that are in each other's way: what the tests of plan_multi plan for."""

import numpy as np
from support import arms, joints, turned

from srmp import Pose


def world(bases, planner_id="xECBS", **options):
    """Arms of the package at (x, y, yaw), by name."""
    planner = arms({name: Pose.from_rpy([x, y, 0], [0, 0, yaw]) for name, (x, y, yaw) in bases.items()})
    planner.make_planner(list(bases), {"planner_id": planner_id, "time_limit": 20, **options})
    return planner


def two(planner_id="xECBS", distance=0.7, **options):
    """Face to face; at 0.7 m hands that are both ready overlap, at 0.9 m they pass each other."""
    return world({"left": (0, 0, 0), "right": (distance, 0, np.pi)}, planner_id, **options)


def ring(**options):
    """Four arms around a point that each of them reaches over."""
    bases = {
        f"arm{i}": (0.38 * np.cos(yaw), 0.38 * np.sin(yaw), yaw + np.pi)
        for i, yaw in enumerate(np.arange(4) * np.pi / 2)
    }
    return world(bases, **options)


STARTS = {"left": turned(0.6), "right": turned(0.6)}
GOALS = {"left": joints(turned(-0.6)), "right": joints(turned(-0.6))}


def in_contact(planner, trajectory):
    """Instants, 1 ms apart, at which robots touch each other or an object."""
    merged = trajectory.merged()
    found = []
    for t in np.arange(0.0, merged.duration + 1e-3, 1e-3):
        positions = {name: one.sample(min(t, one.duration)) for name, one in trajectory.items()}
        for name, q in positions.items():
            planner.set_qpos(name, q)
        if any(planner.is_state_colliding(name, q) for name, q in positions.items()):
            found.append(t)
    return found


def quarter_turns():
    """Starts and goals of the ring's arms: their hands meet in the middle."""
    names = [f"arm{i}" for i in range(4)]
    return {name: turned(0.6) for name in names}, {name: joints(turned(-0.6)) for name in names}


def outcome(planner):
    """The bytes of the motion of quarter_turns, and counts of how it was found."""
    trajectory = planner.plan_multi(*quarter_turns()).merged()
    statistics = planner.get_planning_stats()
    counts = [statistics[key] for key in ("expansions", "generated", "tree_nodes", "states", "edge_checks", "bound")]
    return trajectory.positions.tobytes() + trajectory.times.tobytes(), counts
