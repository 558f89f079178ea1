"""Measures by how much plans overshoot their time limit.

    python bench/suites/overshoot.py --data DIR [--plans 1000] [--kinds problems,dense,…] [--out overshoot.json]

Plans with limits from 1 ms to 1 s, spaced evenly on a logarithmic scale, as many times for each kind:

- problems: hard ones of MotionBenchMaker (cage, table_under_pick), with each planner alternately
- committed: around committed motions of another robot (two arms across a table)
- dense: among clouds of 30 000 points and meshes of 3000 scattered triangles, with 29 goals
- several: 4 to 8 robots in generated scenarios, half of them with improve_time up to the limit
- sample period: easy problems with sample periods from 10 ms to 10 µs
- interrupt: the problems without a limit, and Ctrl-C after so long

Prints percentiles of total_time_s - time_limit, or of the time from Ctrl-C to its exception; a plan that returns in
time counts as 0. On a shared machine the scheduler's pauses count too. Therefore plans that overshoot by more than
--doubt are run again, up to --reruns times, and count with their smallest overshoot; the result file holds all of them.
It also says how much CPU time the calling thread spent after the limit (cpu_s); the table has rows of its own for that.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from math import pi
from typing import Any

import numpy as np
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm
from srmp.bench.scenarios import find

SCENARIOS = ("cage", "table_under_pick")
PLANNERS: dict[str, dict[str, Any]] = {
    "wAstar": {"planner_id": "wAstar"},
    "ARAstar": {"planner_id": "ARAstar"},
    "MHAstar, bfs": {"planner_id": "MHAstar"},
    "wPASE": {"planner_id": "wPASE", "num_threads": 2},
    "auto": {"planner_id": "auto"},
    "wAstar, fine bfs": {"planner_id": "wAstar", "heuristic": "bfs", "bfs_resolution": 0.01},
    "auto, pose goal": {"planner_id": "auto"},
}
COMMITTED = "xECBS, obstacles"
# Times [s] and base-joint angles [rad] of the committed robot; base-joint angles at the planned robot's start and goal.
# The planned robot waits or takes another path; moves away and returns; arrives after its goal was swept; cannot leave
# its start in time; and twice the same beside a motion of several minutes.
AMONG_COMMITTED = (
    ((0, 10), (-0.3, 0.3), -0.9, 0.9),
    ((0, 1, 3, 4, 6), (-1.5, -1.5, 1.5, 1.5, -1.5), -0.3, 0.0),
    ((0, 3, 5), (-1.5, -1.5, 1.5), -0.9, 0.0),
    ((0, 0.4), (-0.9, 0.9), 0.0, 0.9),
    ((0, 200), (-0.3, 0.3), -0.9, 0.9),
    ((0, 0.2, 300), (-0.9, 0.9, 0.91), 0.0, 0.9),
)
DENSE: dict[str, dict[str, Any]] = {
    "dense, MHAstar": {"planner_id": "MHAstar"},
    "dense, wAstar, fine bfs": {"planner_id": "wAstar", "heuristic": "bfs", "bfs_resolution": 0.02},
    "dense, auto": {"planner_id": "auto"},
}
SEVERAL = (("grid", 8), ("ring", 8), ("binpick", 4), ("ring", 5))
SEVERAL_OPTIONS: dict[str, dict[str, Any]] = {
    "several, auto": {"planner_id": "auto"},
    "several, xECBS": {"planner_id": "xECBS"},
    "several, auto improving": {"planner_id": "auto", "improve_time": 1.0},
}
SAMPLE_PERIODS = (1e-2, 1e-3, 1e-4, 1e-5)  # [s]; shorter ones give more rows than a plan may have
PERCENTILES = (50, 90, 99, 99.9, 100)


def phases(stats: dict[str, Any]) -> dict[str, float]:
    return {key: value for key, value in stats.items() if key.endswith("time_s") and value > 1e-3}


class TimeAfter:
    """CPU time [s] that the calling thread spends in a `with` block after its first `delay` seconds."""

    def __init__(self, delay: float) -> None:
        self.clock = time.pthread_getcpuclockid(threading.get_ident())
        self.at_delay: float | None = None
        self.timer = threading.Timer(delay, self.note)

    def note(self) -> None:
        self.at_delay = time.clock_gettime(self.clock)

    def __enter__(self) -> TimeAfter:
        self.timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        now = time.clock_gettime(self.clock)
        self.timer.cancel()
        self.timer.join()
        self.cpu_s = 0.0 if self.at_delay is None else max(0.0, now - self.at_delay)


def overshoot(planner: srmp.PlannerInterface, plan: Callable[[], object], limit: float) -> dict[str, Any]:
    with TimeAfter(limit) as after, contextlib.suppress(srmp.PlanningError):
        plan()
    stats = planner.get_planning_stats()
    return {
        "status": stats["status"].name,
        "overshoot_s": max(0.0, stats["total_time_s"] - limit),
        "cpu_s": after.cpu_s,
        "phases": phases(stats),
    }


def smallest_overshoot(
    planner: srmp.PlannerInterface, plan: Callable[[], object], limit: float, doubt: float, reruns: int
) -> dict[str, Any]:
    tries = [overshoot(planner, plan, limit)]
    while tries[-1]["overshoot_s"] > doubt and len(tries) <= reruns:
        tries.append(overshoot(planner, plan, limit))
    smallest = min(tries, key=lambda row: row["overshoot_s"])
    return {"limit_s": limit, **smallest, "tries_s": [row["overshoot_s"] for row in tries]}


def measure(
    data: str, robot: str, geometry: str, plans: int, problems: str, doubt: float, reruns: int
) -> Iterator[dict[str, Any]]:
    """Yields one row per plan. Consecutive plans have the same scene and similar limits, and alternate the planners."""
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "wAstar", {}, 1.0)
    with mbm.open_problems(files.directory, robot, SCENARIOS, mbm.parse_numbers(problems)) as chosen:
        limits = np.geomspace(1e-3, 1.0, plans).tolist()
        names = list(PLANNERS)
        for at, problem in enumerate(chosen):
            planner, moveit_problem = runner.set_up(problem)
            target = planner.compute_fk(robot, moveit_problem.goals[0].targets[0])
            pose = srmp.GoalConstraint(srmp.GoalType.POSE, target)
            for i in range(at, plans, len(chosen)):
                name = names[(i // len(chosen)) % len(names)]
                planner.make_planner(robot, {**PLANNERS[name], "time_limit": limits[i]})
                goals = [pose] if name.endswith("pose goal") else moveit_problem.goals
                plan = functools.partial(planner.plan, robot, moveit_problem.start, goals)
                row = smallest_overshoot(planner, plan, limits[i], doubt, reruns)
                yield {"problem": problem.name, "planner": name, **row}


def two_arms() -> srmp.PlannerInterface:
    planner = srmp.PlannerInterface()
    for name, pose in (("left", srmp.Pose()), ("right", srmp.Pose.from_rpy([0.6, 0, 0], [0, 0, pi]))):
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_path=srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=pose,
        )
    planner.add_box("table", size=[3, 3, 0.1], pose=srmp.Pose(p=[0.3, 0, -0.051]))
    return planner


def turned(angle: float) -> np.ndarray:
    """The end effector in front of the arm, with the base joint at this angle."""
    return np.array([angle, 0, 0, pi / 2, 0, pi / 2, 0])


def measure_among_committed(plans: int, doubt: float, reruns: int) -> Iterator[dict[str, Any]]:
    planner = two_arms()
    joints = planner.get_joint_names("right")
    for i, limit in enumerate(np.geomspace(1e-3, 1.0, plans).tolist()):
        number = i % len(AMONG_COMMITTED)
        times, angles, start, end = AMONG_COMMITTED[number]
        rows = np.array([turned(angle) for angle in angles])
        obstacle = srmp.Trajectory(joints, rows, times, np.zeros(rows.shape))
        planner.make_planner("left", {"planner_id": "xECBS", "time_limit": limit})
        goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, turned(end))
        plan = functools.partial(planner.plan_multi, {"left": turned(start)}, {"left": goal}, {"right": obstacle})
        row = smallest_overshoot(planner, plan, limit, doubt, reruns)
        yield {"problem": f"committed {number + 1}", "planner": COMMITTED, **row}


def dense_scene(data: str, number: int) -> tuple[srmp.PlannerInterface, np.ndarray]:
    """A robot among a cloud and a mesh, and free configurations of it."""
    generator = np.random.default_rng(number)
    files = mbm.robot_files(data, "ur5", "urdf")
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        str(files.urdf), str(files.srdf), name="ur5", package_dirs=[str(files.directory)], group=mbm.GROUPS["ur5"]
    )
    spread = np.array([1, 2, 1]) * generator.choice([0.2, 1], 3)
    points = np.array([0.5, 0, 0.4]) + generator.uniform(-0.5, 0.5, (30000, 3)) * spread
    planner.add_point_cloud("cloud", points, 0.01 if number % 2 else 0.02)
    middles = generator.uniform(-0.3, 0.3, (3000, 1, 3))
    vertices = (middles + generator.uniform(-0.03, 0.03, (3000, 3, 3))).reshape(-1, 3)
    triangles = np.arange(len(vertices)).reshape(-1, 3)
    planner.add_mesh("mesh", vertices=vertices, triangles=triangles, pose=srmp.Pose([-0.5, 0.1, 0.5]))
    rows = generator.uniform(-3, 3, (3000, 6))
    return planner, rows[planner.collision_checker("ur5").are_free(rows)][:30]


def measure_dense(data: str, plans: int, doubt: float, reruns: int) -> Iterator[dict[str, Any]]:
    scenes = [dense_scene(data, number) for number in range(12)]
    names = list(DENSE)
    for i, limit in enumerate(np.geomspace(1e-3, 1.0, plans).tolist()):
        number, name = i % len(scenes), names[i // len(scenes) % len(names)]
        planner, rows = scenes[number]
        planner.make_planner("ur5", {**DENSE[name], "time_limit": limit})
        goals = srmp.GoalConstraint(srmp.GoalType.JOINTS, rows[1:])
        plan = functools.partial(planner.plan, "ur5", rows[0], goals)
        yield {"problem": f"dense {number}", "planner": name, **smallest_overshoot(planner, plan, limit, doubt, reruns)}


def measure_several(data: str, plans: int, doubt: float, reruns: int) -> Iterator[dict[str, Any]]:
    scenarios = [find(name, robots, 0, data) for name, robots in SEVERAL]
    worlds = [scenario.world.build() for scenario in scenarios]
    names = list(SEVERAL_OPTIONS)
    for i, limit in enumerate(np.geomspace(1e-2, 3.0, plans).tolist()):
        scenario, planner = scenarios[i % len(SEVERAL)], worlds[i % len(SEVERAL)]
        name = names[i // len(SEVERAL) % len(names)]
        problem = scenario.problem(1 + i // len(SEVERAL) % 10)
        goals = {robot: srmp.GoalConstraint(srmp.GoalType.JOINTS, q) for robot, q in problem.goals.items()}
        planner.make_planner(list(goals), {**SEVERAL_OPTIONS[name], "time_limit": limit})
        plan = functools.partial(planner.plan_multi, problem.starts, goals)
        row = smallest_overshoot(planner, plan, limit, doubt, reruns)
        yield {"problem": f"{scenario.name}/{problem.number:04d}", "planner": name, **row}


def measure_sample_periods(plans: int, doubt: float, reruns: int) -> Iterator[dict[str, Any]]:
    planner = two_arms()
    for i, limit in enumerate(np.geomspace(1e-3, 1.0, plans).tolist()):
        period = SAMPLE_PERIODS[i % len(SAMPLE_PERIODS)]
        planner.make_planner("left", {"planner_id": "auto", "time_limit": limit, "sample_period": period})
        goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, turned(1.2))
        plan = functools.partial(planner.plan, "left", turned(0.6), goal)
        row = smallest_overshoot(planner, plan, limit, doubt, reruns)
        yield {"problem": f"sample period {period:g} s", "planner": "sample period", **row}


def time_to_interrupt(plan: Callable[[], object], delay: float) -> float:
    """From Ctrl-C after `delay` [s] to the exception; 0 when the plan has ended before."""
    sent = [float("inf")]

    def interrupt() -> None:
        sent[0] = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(delay, interrupt)
    try:
        timer.start()
        with contextlib.suppress(srmp.PlanningError):
            plan()
        timer.cancel()
        timer.join()  # it may be under way: then its exception comes here
        time.sleep(0.001)
    except KeyboardInterrupt:
        return time.perf_counter() - sent[0]
    return 0.0


def measure_interrupts(
    data: str, robot: str, geometry: str, plans: int, problems: str, doubt: float, reruns: int
) -> Iterator[dict[str, Any]]:
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "wAstar", {}, 1.0)
    names = list(PLANNERS)
    with mbm.open_problems(files.directory, robot, SCENARIOS, mbm.parse_numbers(problems)) as chosen:
        for at, problem in enumerate(chosen):
            planner, moveit_problem = runner.set_up(problem)
            for i in range(at, plans, len(chosen)):
                name = names[(i // len(chosen)) % len(names)]
                planner.make_planner(robot, {**PLANNERS[name], "time_limit": 60.0})
                plan = functools.partial(planner.plan, robot, moveit_problem.start, moveit_problem.goals)
                delay = 1e-3 * 1e3 ** (i / plans)
                tries = [time_to_interrupt(plan, delay)]
                while tries[-1] > doubt and len(tries) <= reruns:
                    tries.append(time_to_interrupt(plan, delay))
                row = {"limit_s": delay, "overshoot_s": min(tries), "tries_s": tries}
                yield {"problem": problem.name, "planner": f"interrupt, {name}", "status": "cancelled", **row}


def percentiles(rows: list[dict[str, Any]], first: bool = False) -> dict[str, float]:
    return percentiles_of([row["tries_s"][0] if first else row["overshoot_s"] for row in rows])


def percentiles_of(values: list[float]) -> dict[str, float]:
    return {str(p): float(np.percentile(values, p)) for p in PERCENTILES}


def run(
    data: str, robot: str, geometry: str, plans: int, problems: str, kinds: str, doubt: float, reruns: int
) -> dict[str, Any]:
    measures: dict[str, Callable[[], Iterator[dict[str, Any]]]] = {
        "problems": lambda: measure(data, robot, geometry, plans, problems, doubt, reruns),
        "committed": lambda: measure_among_committed(plans, doubt, reruns),
        "dense": lambda: measure_dense(data, plans, doubt, reruns),
        "several": lambda: measure_several(data, plans, doubt, reruns),
        "sample period": lambda: measure_sample_periods(plans, doubt, reruns),
        "interrupt": lambda: measure_interrupts(data, robot, geometry, plans, problems, doubt, reruns),
    }
    chosen = [kind.strip() for kind in kinds.split(",")] if kinds else list(measures)
    rows = [{"kind": kind, **row} for kind in chosen for row in measures[kind]()]
    options = {
        "robot": robot,
        "geometry": geometry,
        "plans": plans,
        "problems": problems,
        "doubt_s": doubt,
        "reruns": reruns,
    }

    def by(key: str) -> dict[str, dict[str, float]]:
        groups = dict.fromkeys(row[key] for row in rows)
        return {group: percentiles([row for row in rows if row[key] == group]) for group in groups}

    return {
        "header": mbm.header("overshoot", options=options, planners={**PLANNERS, **DENSE, **SEVERAL_OPTIONS}),
        "percentiles_s": percentiles(rows),
        "percentiles_of_first_tries_s": percentiles(rows, first=True),
        "percentiles_by_kind_s": by("kind"),
        "percentiles_of_cpu_by_kind_s": {
            kind: percentiles_of([row["cpu_s"] for row in rows if row["kind"] == kind and "cpu_s" in row])
            for kind in dict.fromkeys(row["kind"] for row in rows if "cpu_s" in row)
        },
        "percentiles_by_planner_s": by("planner"),
        "rows": rows,
    }


def table(result: dict[str, Any]) -> str:
    lines = [
        *result["percentiles_by_planner_s"].items(),
        *((f"all of {kind}", values) for kind, values in result["percentiles_by_kind_s"].items()),
        ("all, first tries", result["percentiles_of_first_tries_s"]),
        *((f"CPU time, {kind}", values) for kind, values in result["percentiles_of_cpu_by_kind_s"].items()),
        ("all", result["percentiles_s"]),
    ]
    header = ["overshoot", *(f"{p} %" for p in PERCENTILES)]
    return format_table(header, [[name, *map(format_seconds, values.values())] for name, values in lines])


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--geometry", choices=["urdf", "spheres"], default="urdf")
    parser.add_argument("--plans", type=int, default=1000)
    parser.add_argument("--problems", default="1-10", help="numbers in each scenario")
    parser.add_argument("--kinds", default="", help="separated by commas; default: all")
    parser.add_argument("--doubt", type=float, default=0.01, help="plans that overshoot by more are run again [s]")
    parser.add_argument("--reruns", type=int, default=4)
    run_and_report(parser, run, table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
