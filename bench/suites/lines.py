"""Straight lines of the end effector in MotionBenchMaker's scenes: solved, straight, and how quickly.

    python bench/suites/lines.py --data DIR [--robot panda] [--lines 500] [--brute-force] [--out lines.json]

From random free configurations, lines of 10 to 40 cm in random directions, every other one with a turn of up to 45
degrees. Every trajectory is sampled at 1 kHz and its poses are computed by Pinocchio's own Python package. With
--brute-force, what was not solved is tried by exhaustion: hundreds of inverse kinematics solutions for each of the
poses, 5 mm apart, and all motions between them; every fourth line that was solved is tried in the same way, which shows
how much brute force finds. Needs pin.

The exit code is 1 when a trajectory leaves its line by more than 1 mm or half a degree, or touches anything, or when
brute force solves a line that was not solved.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm

CONTROL = 4  # of as many solved lines, brute force tries one
MAX_DEVIATION, MAX_ROTATION = 1e-3, np.radians(0.5)
STEP, JUMP = 0.005, 0.6  # [m] between poses of brute force; [rad] of a motion between them


class Kinematics:
    """Poses of the end effector by Pinocchio, in the frame of the base."""

    def __init__(self, urdf: str, link: str) -> None:
        self.model = pin.buildModelFromUrdf(urdf)
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(link)

    def pose(self, names: list[str], q: np.ndarray) -> pin.SE3:
        full = pin.neutral(self.model)
        for name, value in zip(names, q, strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            full[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else [np.cos(value), np.sin(value)]
        pin.framesForwardKinematics(self.model, self.data, full)
        return self.data.oMf[self.frame].copy()

    def leaves(self, trajectory: srmp.Trajectory, start: pin.SE3, goal: pin.SE3) -> tuple[float, float]:
        """How far the trajectory leaves the line at samples of 1 ms [m, rad]."""
        along, turn = goal.translation - start.translation, pin.log3(start.rotation.T @ goal.rotation)
        worst = np.zeros(2)
        for t in np.arange(0.0, trajectory.duration, 1e-3):
            pose = self.pose(trajectory.joint_names, trajectory.sample(t))
            passed = along @ (pose.translation - start.translation) / (along @ along)
            near = np.clip(passed + np.linspace(-1, 1, 41) * MAX_DEVIATION / np.linalg.norm(along), 0, 1)
            off = [
                (
                    np.linalg.norm(start.translation + at * along - pose.translation),
                    np.linalg.norm(pin.log3((start.rotation @ pin.exp3(at * turn)).T @ pose.rotation)),
                )
                for at in near
            ]
            worst = np.maximum(worst, min(off, key=of_tolerance))
        return float(worst[0]), float(worst[1])


def of_tolerance(deviation: tuple[float, float]) -> float:
    return max(deviation[0] / MAX_DEVIATION, deviation[1] / MAX_ROTATION)


def random_line(planner: srmp.PlannerInterface, robot: str, rng: np.random.Generator, turned: bool) -> Any:
    """A free configuration and the pose at the end of the line."""
    limits = np.clip(np.array(planner.get_joint_limits(robot))[:, :2], -np.pi, np.pi)
    q = rng.uniform(limits[:, 0], limits[:, 1], (2000, len(limits)))
    free = q[planner.collision_checker(robot).are_free(q)]
    if len(free) == 0:
        return None
    at = planner.compute_fk(robot, free[0])
    direction, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    turn = pin.Quaternion(pin.exp3(axis * rng.uniform(0, np.pi / 4) * turned))
    end = (turn * pin.Quaternion(*at.q[[3, 0, 1, 2]])).coeffs()
    return free[0], srmp.Pose(p=at.p + direction * rng.uniform(0.1, 0.4), q=end)


def brute_force(planner: srmp.PlannerInterface, robot: str, start: np.ndarray, goal: srmp.Pose) -> bool:
    """Whether close configurations, found for each pose from many seeds, lead along the line."""
    checker = planner.collision_checker(robot)
    at = planner.compute_fk(robot, start)
    a, b = (pin.Quaternion(*pose.q[[3, 0, 1, 2]]) for pose in (at, goal))
    count = max(int(np.ceil(np.linalg.norm(goal.p - at.p) / STEP)), 10)
    reached = np.array([start])
    for k in range(1, count + 1):
        pose = srmp.Pose(p=at.p + (goal.p - at.p) * k / count, q=a.slerp(k / count, b).coeffs())
        found = many_solutions(planner, robot, pose, reached)
        found = found[checker.are_free(found)]
        follows = set()
        for i, j in np.argwhere(np.abs(reached[:, None] - found).max(axis=2) < JUMP):
            if j in follows or not planner.is_motion_free(robot, reached[i], found[j]):
                continue
            middle = planner.compute_fk(robot, (reached[i] + found[j]) / 2).p
            between = (planner.compute_fk(robot, reached[i]).p + pose.p) / 2
            if np.linalg.norm(middle - between) < MAX_DEVIATION:
                follows.add(j)
        if not follows:
            return False
        reached = found[sorted(follows)]
    return True


def many_solutions(planner: srmp.PlannerInterface, robot: str, pose: srmp.Pose, reached: np.ndarray) -> np.ndarray:
    """Configurations at the pose (n, dof): from 400 seeds, and from some of those that were reached before it."""
    some = reached[:: -(-len(reached) // 20)]
    tries = [(reached[0], 400), *((q, 8) for q in some)]
    found = [planner.compute_ik(robot, pose, reference=q, max_solutions=n, seeds=n) for q, n in tries]
    return np.concatenate([np.reshape(each, (-1, reached.shape[1])) for each in found])


def rows_of(data: str, robot: str, lines: int, seed: int, exhaustion: bool) -> Iterator[dict[str, Any]]:
    files = mbm.robot_files(data, robot, "urdf")
    runner = mbm.Runner(files, "auto", {}, 10.0)
    rng = np.random.default_rng([seed, lines])
    solved = 0
    with mbm.open_problems(files.directory, robot) as problems:
        for number in range(lines):
            problem = problems[number * len(problems) // lines]
            planner, _ = runner.set_up(problem)
            kinematics = Kinematics(str(files.urdf), planner.get_end_effector(robot))
            if (line := random_line(planner, robot, rng, number % 2 == 1)) is None:
                continue
            row = {"problem": problem.name, **row_of(planner, robot, kinematics, *line)}
            solved += row["status"] == "solved"
            if exhaustion and (row["status"] != "solved" or solved % CONTROL == 0):
                row["brute_force"] = brute_force(planner, robot, *line)
            yield row


def row_of(
    planner: srmp.PlannerInterface, name: str, kinematics: Kinematics, start: np.ndarray, goal: srmp.Pose
) -> dict[str, Any]:
    trajectory = None
    with contextlib.suppress(srmp.PlanningError):
        trajectory = planner.plan_linear(name, start, goal)
    stats = planner.get_planning_stats()
    row = {key: stats[key] for key in ("reason", "plan_time_s", "total_time_s", "expansions")}
    row["status"] = mbm.status_name(stats["status"])
    if trajectory is None:
        return row
    names, base = planner.get_joint_names(name), planner.compute_fk(name, start, planner.get_link_names(name)[0])
    end = pin.SE3(pin.Quaternion(*goal.q[[3, 0, 1, 2]]), goal.p)
    in_base = pin.SE3(pin.Quaternion(*base.q[[3, 0, 1, 2]]), base.p).inverse() * end
    row["deviation_m"], row["rotation_rad"] = kinematics.leaves(trajectory, kinematics.pose(names, start), in_base)
    certificate = planner.verify(name, trajectory)
    row["clearance_m"], row["proved_free"] = certificate.clearance, certificate.proved_free
    proved = trajectory.certificate.cartesian_deviation
    row["proved_deviation_m"], row["proved_rotation_rad"] = proved.position, proved.rotation
    return row


def is_wrong(row: dict[str, Any]) -> bool:
    if row["status"] != "solved":
        return row.get("brute_force", False)
    seen = of_tolerance((row["deviation_m"], row["rotation_rad"]))
    proved = of_tolerance((row["proved_deviation_m"], row["proved_rotation_rad"]))
    return not (seen <= proved + 1e-3 and proved <= 1 and row["clearance_m"] > 0 and row["proved_free"])


def run(data: str, robot: str, lines: int, seed: int, brute_force: bool) -> dict[str, Any]:
    rows = list(rows_of(data, robot, lines, seed, brute_force))
    options = {"robot": robot, "lines": lines, "seed": seed, "brute_force": brute_force}
    return {"header": mbm.header("lines", options=options), "rows": rows}


def table(result: dict[str, Any]) -> str:
    rows = result["rows"]
    solved = [row for row in rows if row["status"] == "solved"]
    found_again = [row["brute_force"] for row in solved if "brute_force" in row]
    times = [[row[key] for row in solved] for key in ("plan_time_s", "total_time_s")]
    cells = [
        [
            f"{len(solved)}/{len(rows)}",
            str(sum(row.get("brute_force", False) for row in rows if row["status"] != "solved")),
            f"{sum(found_again)}/{len(found_again)}",
            *(format_seconds(float(np.percentile(of, p))) for of in times for p in (50, 95)),
            f"{1e3 * max(row['deviation_m'] for row in solved):.3f} mm",
            f"{np.degrees(max(row['rotation_rad'] for row in solved)):.3f}°",
            str(sum(map(is_wrong, rows))),
        ]
    ]
    titles = ["solved", "more by brute force", "of solved", "plan median", "p95", "total median", "p95"]
    titles += ["leaves", "turns", "wrong"]
    return format_table(titles, cells)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda", choices=sorted(mbm.GROUPS), help="default: panda")
    parser.add_argument("--lines", type=int, default=500, help="default: 500")
    parser.add_argument("--seed", type=int, default=0, help="default: 0")
    parser.add_argument("--brute-force", action="store_true", help="try by exhaustion what was not solved")
    return int(any(map(is_wrong, run_and_report(parser, run, table)["rows"])))


if __name__ == "__main__":
    sys.exit(main())
