"""Re-checks the results of `srmp bench multi` with Pinocchio's and Coal's own Python packages, without the planner.

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
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from srmp.recheck import cubics
from srmp.recheck.world import World

GOAL_TOLERANCE = 1e-6  # [rad or m]


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
