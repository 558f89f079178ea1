"""Measures what certificates cost, by kind of scene, and whether free motions are left unproved.

    python bench/suites/certificate_times.py [--data DIR] [--plans 2000] [--out certificate_times.json]

Plans between random free configurations of an arm and verifies every plan again: among boxes, in point clouds of 300 to
300 000 points, before a mesh of a million triangles, with an object in the gripper, and beside a second arm. Times are
CPU times of one thread for one certificate, the best of --repeats, with the checker made before. The arm is the
package's; with --data (the directory given to srmp bench mbm) every other plan is of MotionBenchMaker's Panda, made of
meshes.

The exit code is 1 when a motion with a clearance of 1 mm or more is not proved free.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm

CLEAR = 1e-3  # [m] free motions with this clearance must be proved
PERCENTILES = (50, 95, 99, 100)


class NoPlan(Exception):
    """Nothing is free in this scene."""


# --- scenes -----------------------------------------------------------------------------------------------------------


def add_arm(planner: srmp.PlannerInterface, data: str | None, name: str, pose: srmp.Pose) -> None:
    if data is None:
        urdf, srdf, end_effector = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf"), "arm7_hand"
        planner.add_articulation(urdf_path=urdf, srdf_path=srdf, name=name, end_effector=end_effector, base_pose=pose)
        return
    files = mbm.robot_files(data, "panda", "urdf")
    planner.add_articulation(
        urdf_path=str(files.urdf),
        srdf_path=str(files.srdf),
        name=name,
        end_effector="panda_hand",
        group=mbm.GROUPS["panda"],
        base_pose=pose,
    )


def random_pose(rng: np.random.Generator) -> srmp.Pose:
    angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.45, 0.85)
    place = [radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.0, 0.9)]
    return srmp.Pose.from_rpy(place, rng.uniform(-np.pi, np.pi, 3))


def add_boxes(planner: srmp.PlannerInterface, rng: np.random.Generator) -> None:
    planner.add_box("floor", size=[3, 3, 0.1], pose=srmp.Pose(p=[0, 0, -0.06]))
    for i in range(12):
        planner.add_box(f"box{i}", size=rng.uniform(0.03, 0.25, 3), pose=random_pose(rng))


def seen_points(count: int, rng: np.random.Generator) -> np.ndarray:
    """What a depth camera sees of a table, boxes on it and a wall behind: `count` points, with 1 mm of noise."""
    table, wall, *boxes = np.array_split(rng.uniform(-1, 1, (count, 3)), 8)
    parts = [[0.75, 0, 0] + table * [0.5, 0.8, 0], [1.25, 0, 0.6] + wall * [0, 0.8, 0.6]]
    for surface in boxes:
        axis = (np.arange(len(surface)), rng.integers(3, size=len(surface)))
        surface[axis] = np.sign(surface[axis])
        half = rng.uniform(0.02, 0.12, 3)
        parts.append([rng.uniform(0.4, 0.8), rng.uniform(-0.6, 0.6), half[2]] + half * surface)
    points = np.concatenate(parts)
    return points + rng.normal(0, 1e-3, points.shape)


def add_cloud(count: int) -> Callable[[srmp.PlannerInterface, np.random.Generator], None]:
    def add(planner: srmp.PlannerInterface, rng: np.random.Generator) -> None:
        planner.add_point_cloud("cloud", seen_points(count, rng), resolution=0.02 if count < 100_000 else 0.005)

    return add


def bumpy_ground(side: int, rng: np.random.Generator) -> np.ndarray:
    """(2 * side², 3, 3): the triangles of a landscape around the arm, 2.4 m wide."""
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, side + 1), np.linspace(-1.2, 1.2, side + 1), indexing="ij")
    away = np.clip(np.hypot(x, y) - 0.25, 0, 0.4)
    a, b, c = rng.uniform(5, 12, 3)
    z = -0.05 + away * (0.5 + 0.5 * np.sin(a * x) * np.cos(b * y) + 0.01 * np.sin(10 * c * x * y))
    points = np.stack([x, y, z], -1)
    p, q, r, s = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack([p, q, r], -2).reshape(-1, 3, 3), np.stack([p, r, s], -2).reshape(-1, 3, 3)])


def write_stl(path: Path, triangles: np.ndarray) -> None:
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("points", "<f4", (3, 3)), ("unused", "<u2")])
    rows["points"] = triangles
    path.write_bytes(bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes())


def add_mesh(planner: srmp.PlannerInterface, rng: np.random.Generator) -> None:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "ground.stl"
        write_stl(path, bumpy_ground(708, rng))
        planner.add_mesh("ground", str(path))


def hold(planner: srmp.PlannerInterface, rng: np.random.Generator) -> None:
    """A tray of 20 000 triangles at the flange, among boxes."""
    add_boxes(planner, rng)
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "tray.stl"
        write_stl(path, 0.08 * bumpy_ground(100, rng))
        planner.add_mesh("tray", str(path))
    link = planner.get_link_names("arm")[-1]
    planner.attach_object(
        "tray", "arm", link, touch_links=planner.get_link_names("arm")[-5:], pose_in_link=srmp.Pose(p=[0, 0, 0.15])
    )


KINDS: dict[str, Callable[[srmp.PlannerInterface, np.random.Generator], None]] = {
    "boxes": add_boxes,
    "cloud of 300": add_cloud(300),
    "cloud of 3 000": add_cloud(3_000),
    "cloud of 30 000": add_cloud(30_000),
    "cloud of 300 000": add_cloud(300_000),
    "mesh of 1 000 000": add_mesh,
    "held mesh": hold,
    "two arms": add_boxes,
}


# --- measurements -----------------------------------------------------------------------------------------------------


def free_configurations(planner: srmp.PlannerInterface, robot: str, rng: np.random.Generator) -> list[np.ndarray]:
    """Two of them, drawn at random."""
    limits = np.clip(np.array(planner.get_joint_limits(robot))[:, :2], -np.pi, np.pi)
    q = rng.uniform(limits[:, 0], limits[:, 1], (1000, len(limits)))
    free = q[planner.collision_checker(robot).are_free(q)]
    if len(free) < 2:
        raise NoPlan
    return list(free[:2])


def timed(run: Callable[[], Any], repeats: int) -> tuple[Any, float]:
    """The result, and the CPU time of the fastest of the runs."""
    times = []
    for _ in range(repeats + 1):  # the first warms the caches
        begin = time.process_time()
        result = run()
        times.append(time.process_time() - begin)
    return result, min(times[1:])


def row_of(certificates: list[srmp.Certificate], motion: srmp.Trajectory, cpu: float) -> dict[str, Any]:
    return {
        "cpu_s": cpu / len(certificates),
        "clearance_m": min(c.clearance for c in certificates),
        "clearance_proved_m": min(c.clearance_proved for c in certificates),
        "proved_free": all(c.proved_free for c in certificates),
        "rows": len(motion.times),
    }


def one_arm(planner: srmp.PlannerInterface, rng: np.random.Generator, repeats: int) -> dict[str, Any]:
    start, end = free_configurations(planner, "arm", rng)
    motion = planner.plan("arm", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, end))
    certificate, cpu = timed(lambda: planner.verify("arm", motion), repeats)
    return row_of([certificate], motion, cpu)


def two_arms(planner: srmp.PlannerInterface, rng: np.random.Generator, repeats: int) -> dict[str, Any]:
    """With the time to make the checkers, which verify_multi does not keep."""
    ends = {robot: free_configurations(planner, robot, rng) for robot in ("arm", "other")}
    starts = {robot: q[0] for robot, q in ends.items()}
    goals = {robot: srmp.GoalConstraint(srmp.GoalType.JOINTS, q[1]) for robot, q in ends.items()}
    motions = planner.plan_multi(starts, goals)
    certificates, cpu = timed(lambda: planner.verify_multi(motions), repeats)
    return row_of(list(certificates.values()), motions["arm"], cpu)


def rows_of(kind: str, data: str | None, plans: int, seed: int, repeats: int, limit: float) -> Iterator[dict[str, Any]]:
    """Plans in random scenes of a kind, up to ten in each."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), data is not None])
    while plans > 0:
        planner = srmp.PlannerInterface()
        add_arm(planner, data, "arm", srmp.Pose())
        if kind == "two arms":
            add_arm(planner, data, "other", srmp.Pose.from_rpy([0.9, 0, 0], [0, 0, np.pi]))
            planner.make_planner(["arm", "other"], {"planner_id": "auto", "time_limit": limit})
        KINDS[kind](planner, rng)
        planner.make_planner("arm", {"planner_id": "auto", "time_limit": limit, "certify": False})
        for _ in range(10 if kind != "mesh of 1 000 000" else 25):
            with contextlib.suppress(srmp.PlanningError, NoPlan):
                row = (two_arms if kind == "two arms" else one_arm)(planner, rng, repeats)
                plans -= 1
                yield {"kind": kind, "robot": "panda" if data else "arm7", **row}
                if plans == 0:
                    return


def is_wrong(row: dict[str, Any]) -> bool:
    return row["clearance_m"] >= CLEAR and not row["proved_free"]


def run(data: str | None, plans: int, kinds: list[str], seed: int, repeats: int, limit: float) -> dict[str, Any]:
    rows: list[dict[str, Any]] = []
    arms = [None, data] if data else [None]
    for kind in kinds:
        for arm in arms:
            rows += rows_of(kind, arm, max(plans // len(kinds) // len(arms), 1), seed, repeats, limit)
        print(table([row for row in rows if row["kind"] == kind]), flush=True)
    options = {"plans": plans, "seed": seed, "repeats": repeats, "time_limit_s": limit, "panda": data is not None}
    return {"header": mbm.header("certificate_times", options=options), "rows": rows}


def table(rows: list[dict[str, Any]]) -> str:
    groups = [(kind, robot) for kind in [*KINDS, "all"] for robot in ("arm7", "panda")]
    lines = []
    for kind, robot in groups:
        group = [row for row in rows if kind in (row["kind"], "all") and row["robot"] == robot]
        if not group:
            continue
        times = [row["cpu_s"] for row in group]
        tightness = [row["clearance_proved_m"] / row["clearance_m"] for row in group if row["clearance_m"] > CLEAR]
        lines.append(
            [
                kind,
                robot,
                str(len(group)),
                str(sum(row["proved_free"] for row in group)),
                str(sum(map(is_wrong, group))),
                *(format_seconds(float(np.percentile(times, p))) for p in PERCENTILES),
                f"{100 * float(np.median(tightness)):.0f} %" if tightness else "-",
            ]
        )
    return format_table(
        ["scene", "robot", "plans", "proved", "wrong", "50 %", "95 %", "99 %", "most", "proved/clearance"], lines
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", help="the directory given to srmp bench mbm")
    parser.add_argument("--plans", type=int, default=2000, help="in all (default: %(default)s)")
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=list(KINDS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--limit", type=float, default=2.0, help="time limit of a plan [s] (default: %(default)s)")
    result = run_and_report(parser, run, lambda result: table(result["rows"]))
    return 1 if any(map(is_wrong, result["rows"])) else 0


if __name__ == "__main__":
    sys.exit(main())
