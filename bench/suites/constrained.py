"""Upright motions in MotionBenchMaker's scenes: solved, kept upright, free, and how quickly.

    python bench/suites/constrained.py --data DIR [--robot panda] [--problems 1-100] [--out upright.json]

Problems of bookshelf_thin, box, table_pick and table_under_pick: the axis of the end effector that is nearest to the
vertical at the goal is to stay within 5 degrees of the vertical. Starts and goals are solved again to keep that: the
position of the end effector stays, its axis becomes vertical, turned about the vertical as little as leaves a free
configuration, of which that near the original one is taken. Problems without one at both ends are left out. Every
trajectory is sampled at 1 kHz, and poses and contacts are computed by Pinocchio's and Coal's own Python packages. Needs
pin, coal, PyYAML.

The exit code is 1 when a trajectory tilts by more than 5 degrees or by more than its certificate says, or touches
anything.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from recheck_mbm import World
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm

SCENARIOS = ("bookshelf_thin", "box", "table_pick", "table_under_pick")
TOLERANCE = np.radians(5)
STATISTICS = (
    "reason",
    "plan_time_s",
    "total_time_s",
    "search_time_s",
    "shortcut_time_s",
    "timing_time_s",
    "verification_time_s",
    "edge_checks",
    "path_cost_rad",
)
STARTS_TOLERANCE = np.radians(2)  # of starts and goals that are solved again


def nearest_axis(pose: srmp.Pose) -> np.ndarray:
    """The axis of the frame that is nearest to the vertical, pointing up."""
    up = np.asarray(pose.matrix())[2, :3]
    axis = np.zeros(3)
    axis[np.abs(up).argmax()] = np.sign(up[np.abs(up).argmax()])
    return axis


def tilt(rotation: np.ndarray, axis: np.ndarray) -> float:
    """[rad] of the axis from the vertical."""
    direction = rotation @ axis
    return float(np.arctan2(np.hypot(direction[0], direction[1]), direction[2]))


def upright_pose(pose: srmp.Pose, axis: np.ndarray, yaw: float) -> srmp.Pose:
    """The same position, turned by the smallest rotation that makes the axis vertical, then about the vertical."""
    q = pin.Quaternion(*np.asarray(pose.q)[[3, 0, 1, 2]])
    turn = pin.Quaternion().setFromTwoVectors(q.matrix() @ axis, np.array([0, 0, 1.0]))
    about = pin.Quaternion(pin.rpy.rpyToMatrix(0, 0, yaw))
    return srmp.Pose(p=pose.p, q=(about * turn * q).normalized().coeffs())


def solved_again(planner: srmp.PlannerInterface, robot: str, q: np.ndarray, axis: np.ndarray) -> np.ndarray | None:
    """A free configuration near q that is upright; None: there is none."""
    at = planner.compute_fk(robot, q)
    if tilt(np.asarray(at.matrix())[:3, :3], axis) <= STARTS_TOLERANCE:
        return q
    for yaw in np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120, 150, -150, 180]):
        found = planner.compute_ik(robot, upright_pose(at, axis, yaw), reference=q, max_solutions=16, seeds=64)
        for other in map(np.asarray, found):
            if not planner.is_state_colliding(robot, other):
                return other
    return None


def ends(planner: srmp.PlannerInterface, robot: str, problem: srmp.MoveItProblem) -> Any:
    """Start, goal and axis; None where there is no upright goal or start."""
    plain = planner.plan(robot, problem.start, problem.goals)
    axis = nearest_axis(planner.compute_fk(robot, plain.positions[-1]))
    start = solved_again(planner, robot, np.asarray(problem.start), axis)
    goal = solved_again(planner, robot, plain.positions[-1], axis)
    return None if start is None or goal is None else (start, goal, axis)


class Recheck:
    """Tilts and contacts by Pinocchio and Coal alone."""

    def __init__(self, files: Any, robot: str, problem: str, link: str) -> None:
        self.world = World(Path(files.directory), robot, Path(files.urdf), problem)
        self.frame = self.world.model.getFrameId(link)

    def look(self, motion: srmp.Trajectory, axis: np.ndarray) -> tuple[float, str]:
        """The largest tilt [rad] and a pair that touches ("": none)."""
        largest, pair = 0.0, ""
        times = np.append(np.arange(0.0, motion.duration, 1e-3), motion.duration)
        for t in times:
            q = self.world.default_q.copy()
            for name, value in zip(motion.joint_names, motion.sample(t), strict=True):
                self.world.set_joint(q, name, value)
            pin.framesForwardKinematics(self.world.model, self.world.data, q)
            largest = max(largest, tilt(self.world.data.oMf[self.frame].rotation, axis))
            pair = pair or self.world.touching(motion.joint_names, motion.sample(t))
        return largest, pair


def row_of(planner: srmp.PlannerInterface, robot: str, q: Any, files: Any, problem: str) -> dict[str, Any]:
    start, goal, axis = q
    upright = srmp.PathConstraint.cone(axis, [0, 0, 1], TOLERANCE)
    motion = None
    with contextlib.suppress(srmp.PlanningError):
        motion = planner.plan(robot, start, goal, constraints=[upright])
    stats = planner.get_planning_stats()
    row = {key: stats[key] for key in STATISTICS}
    row["status"] = mbm.status_name(stats["status"])
    row["straight_rad"] = float(np.linalg.norm(goal - start))
    if motion is None:
        return row
    (kept,) = motion.certificate.constraints
    row["proved_rad"], row["proved_free"] = kept.deviation, motion.certificate.proved_free
    row["tilt_rad"], row["touching"] = Recheck(files, robot, problem, planner.get_end_effector(robot)).look(
        motion, axis
    )
    row["waypoints"], row["duration_s"] = len(motion.waypoints), motion.duration
    return row


def rows_of(data: str, robot: str, problems: str, planner_id: str, time_limit: float) -> Iterator[dict[str, Any]]:
    files = mbm.robot_files(data, robot, "urdf")
    runner = mbm.Runner(files, planner_id, {}, time_limit)
    with mbm.open_problems(files.directory, robot, SCENARIOS, mbm.parse_numbers(problems)) as found:
        for problem in found:
            planner, request = runner.set_up(problem)
            try:
                q = ends(planner, robot, request)
            except srmp.PlanningError:
                q = None
            if q is None:
                yield {"problem": problem.name, "status": "left out"}
            else:
                yield {"problem": problem.name, **row_of(planner, robot, q, files, problem.name)}


def is_wrong(row: dict[str, Any]) -> bool:
    if row["status"] != "solved":
        return False
    kept = row["tilt_rad"] <= row["proved_rad"] + 1e-6 and row["proved_rad"] <= TOLERANCE * (1 + 1e-6)
    return not kept or bool(row["touching"])


def run(data: str, robot: str, problems: str, planner: str, time_limit: float) -> dict[str, Any]:
    rows = list(rows_of(data, robot, problems, planner, time_limit))
    options = {"robot": robot, "problems": problems, "planner": planner, "time_limit": time_limit}
    return {"header": mbm.header("constrained", options=options), "rows": rows}


def cells(name: str, rows: list[dict[str, Any]]) -> list[str]:
    given = [row for row in rows if row["status"] != "left out"]
    solved = [row for row in given if row["status"] == "solved"]
    times = [[row[key] for row in solved] for key in ("plan_time_s", "total_time_s")]
    return [
        name,
        f"{len(solved)}/{len(given)}",
        str(len(rows) - len(given)),
        *(format_seconds(float(np.percentile(of, p))) if of else "-" for of in times for p in (50, 95)),
        f"{np.degrees(max((row['tilt_rad'] for row in solved), default=0.0)):.3f}°",
        str(sum(map(is_wrong, rows))),
    ]


def table(result: dict[str, Any]) -> str:
    rows = result["rows"]
    named = [(name, [row for row in rows if row["problem"].startswith(name + "/")]) for name in SCENARIOS]
    titles = ["scenario", "solved", "left out", "plan median", "p95", "total median", "p95", "tilt", "wrong"]
    return format_table(titles, [cells(*part) for part in [*named, ("all", rows)]])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda", choices=sorted(mbm.GROUPS), help="default: panda")
    parser.add_argument("--problems", default="1-100", help="numbers of the problems of each scenario; default: 1-100")
    parser.add_argument("--planner", default="auto", help="default: auto")
    parser.add_argument("--time-limit", type=float, default=10.0, help="[s] of each plan; default: 10")
    return int(any(map(is_wrong, run_and_report(parser, run, table)["rows"])))


if __name__ == "__main__":
    sys.exit(main())
