"""Upright motions in MotionBenchMaker's scenes: solved, kept upright, free, and how quickly.

    python bench/suites/constrained.py --data DIR [--robot panda] [--problems 1-100] [--out upright.json]

Problems of bookshelf_thin, box, table_pick and table_under_pick: the axis of the end effector that is nearest to the
vertical at the goal is to stay within 5 degrees of the vertical. Starts and goals are solved again to keep that: the
position of the end effector stays, its axis becomes vertical, turned about the vertical as little as leaves a free
configuration, of which that near the original one is taken. Problems without one at both ends are left out. Every
trajectory is sampled at 1 kHz, and poses and contacts are computed by Pinocchio's and Coal's own Python packages. Needs
pin, coal, PyYAML.

Where the module _srmp_ompl was built (docs/cli.md), OMPL's RRTConnect solves the same problems in OMPL's
ProjectedStateSpace, with our collision checker: "OMPL" proves motions free with it, "OMPL, sampled" checks the states
of that space only, which are 0.05 rad apart. Its paths are checked in the same way, every 0.01 rad.

The exit code is 1 when a trajectory tilts by more than 5 degrees or by more than its certificate says, or touches
anything.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from recheck_mbm import World, samples
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm
from srmp.bench.paper.contestants import NO_OMPL, ompl_module

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
OMPL = {"OMPL": False, "OMPL, sampled": True}


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

    def look(self, names: list[str], configurations: Iterable[np.ndarray], axis: np.ndarray) -> dict[str, Any]:
        """The largest tilt [rad] and a pair that touches ("": none)."""
        largest, pair = 0.0, ""
        for values in configurations:
            q = self.world.default_q.copy()
            for name, value in zip(names, values, strict=True):
                self.world.set_joint(q, name, value)
            pin.framesForwardKinematics(self.world.model, self.world.data, q)
            largest = max(largest, tilt(self.world.data.oMf[self.frame].rotation, axis))
            pair = pair or self.world.touching(names, values)
        return {"tilt_rad": largest, "touching": pair}


def row_of(planner: srmp.PlannerInterface, robot: str, q: Any, recheck: Recheck) -> dict[str, Any]:
    start, goal, axis = q
    motion = None
    with contextlib.suppress(srmp.PlanningError):
        motion = planner.plan(robot, start, goal, constraints=[upright(axis)])
    stats = planner.get_planning_stats()
    row = {key: stats[key] for key in STATISTICS}
    row["status"] = mbm.status_name(stats["status"])
    row["straight_rad"] = float(np.linalg.norm(goal - start))
    if motion is None:
        return row
    (kept,) = motion.certificate.constraints
    row["proved_rad"], row["proved_free"] = kept.deviation, motion.certificate.proved_free
    times = np.append(np.arange(0.0, motion.duration, 1e-3), motion.duration)
    row |= recheck.look(motion.joint_names, map(motion.sample, times), axis)
    row["waypoints"], row["duration_s"] = len(motion.waypoints), motion.duration
    return row


def upright(axis: np.ndarray) -> srmp.PathConstraint:
    return srmp.PathConstraint.cone(axis, [0, 0, 1], TOLERANCE)


def ompl_row(
    planner: srmp.PlannerInterface, robot: str, q: Any, recheck: Recheck, seed: int, time_limit: float, sampled: bool
) -> dict[str, Any]:
    start, goal, axis = q
    found = ompl_module().plan(
        planner,
        [robot],
        start,
        goal,
        "RRT-Connect",
        time_limit,
        seed,
        cone=upright(axis),
        sampled=sampled,
    )
    row = {key: found[key] for key in ("status", "plan_time_s", "search_time_s")}
    if row["status"] != "solved":
        return row
    path = np.array(found["waypoints"])
    row["path_cost_rad"] = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    row["leads_rad"] = float(np.abs(path[[0, -1]] - [start, goal]).max())
    return row | recheck.look(planner.get_joint_names(robot), samples(path), axis)


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
                continue
            recheck = Recheck(files, robot, problem.name, planner.get_end_effector(robot))
            row = {"problem": problem.name, **row_of(planner, robot, q, recheck)}
            row["no_ompl"] = why_no_ompl(planner.get_joint_limits(robot))
            seed = 1 + zlib.crc32(problem.name.encode()) % 2**31
            for name, sampled in () if row["no_ompl"] else OMPL.items():
                row[name] = ompl_row(planner, robot, q, recheck, seed, time_limit, sampled)
            yield row


def why_no_ompl(limits: np.ndarray) -> str:
    """Why OMPL does not plan for joints with these limits; empty where it does."""
    if ompl_module() is None:
        return NO_OMPL
    return "" if np.isfinite(limits[:, :2]).all() else "OMPL was not run: its constrained spaces need joint limits."


def is_wrong(row: dict[str, Any]) -> bool:
    """Of a row, or of OMPL's part of it, which has no certificate."""
    if row["status"] != "solved":
        return False
    proved = row.get("proved_rad", TOLERANCE)
    kept = row["tilt_rad"] <= proved + 1e-6 and proved <= TOLERANCE * (1 + 1e-6)
    return not kept or bool(row["touching"]) or row.get("leads_rad", 0.0) > 1e-6


def run(data: str, robot: str, problems: str, planner: str, time_limit: float) -> dict[str, Any]:
    rows = list(rows_of(data, robot, problems, planner, time_limit))
    options = {"robot": robot, "problems": problems, "planner": planner, "time_limit": time_limit}
    module = ompl_module()
    return {"header": mbm.header("constrained", options=options, ompl=module and module.version), "rows": rows}


def cells(name: str, rows: list[dict[str, Any]]) -> list[str]:
    solved = [row for row in rows if row["status"] == "solved"]
    times = [[row[key] for row in solved if key in row] for key in ("plan_time_s", "total_time_s")]
    return [
        name,
        f"{len(solved)}/{len(rows)}",
        *(format_seconds(float(np.percentile(of, p))) if of else "-" for of in times for p in (50, 95)),
        f"{np.median([row['path_cost_rad'] for row in solved]):.2f}" if solved else "-",
        f"{np.degrees(max((row['tilt_rad'] for row in solved), default=0.0)):.3f}°",
        str(sum(map(is_wrong, rows))),
    ]


def table(result: dict[str, Any]) -> str:
    rows = [row for row in result["rows"] if row["status"] != "left out"]
    named = [(name, [row for row in rows if row["problem"].startswith(name + "/")]) for name in SCENARIOS]
    lines = [cells(*part) for part in [*named, ("all", rows)]]
    notes = sorted({row["no_ompl"] for row in rows} - {""})
    for other in () if notes else OMPL:
        lines += [cells(f"{name}, {other}", [row[other] for row in of]) for name, of in [*named, ("all", rows)]]
    titles = ["scenario", "solved", "plan median", "p95", "total median", "p95", "length [rad]", "tilt", "wrong"]
    return "\n".join([format_table(titles, lines), "", f"{len(result['rows']) - len(rows)} were left out.", *notes])


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
