"""Measures how long Ctrl-C takes in the calls that may take long.

    python bench/suites/interrupts.py [--tries 12] [--calls plan prepare …] [--out interrupts.json]

Repeats each call until Ctrl-C comes, after 5 ms to --longest, and measures the time until KeyboardInterrupt is raised,
by the clock and as CPU time of the process. The clock counts what the machine does for others too; CPU time counts all
threads of the process, so it can be the longer one. The robot is the package's, and no cache is used.

The exit code is 1 when a call takes more than 0.1 s by both.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from certificate_times import write_stl
from overshoot import turned, two_arms
from report import run_and_report

import srmp
from srmp._table import format_seconds, format_table
from srmp.bench import mbm

AIM = 0.1  # [s]
PLAN = {"planner_id": "wAstar", "heuristic": "bfs", "bfs_resolution": 0.01, "time_limit": 60.0}
Call = Callable[[], object]


def joints(q: np.ndarray) -> srmp.GoalConstraint:
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


def among_points() -> srmp.PlannerInterface:
    """Two arms between which nothing is easy: points in the air."""
    planner = two_arms()
    points = np.random.default_rng(0).uniform([0.2, -0.6, 0.55], [0.4, 0.6, 1.0], (3000, 3))
    planner.add_point_cloud("points", points, 0.01)
    return planner


def scattered(count: int) -> np.ndarray:
    """(count, 3, 3): triangles."""
    random = np.random.default_rng(0)
    return random.uniform(-1, 1, (count, 1, 3)) + random.uniform(0, 0.01, (count, 3, 3))


def arm_with_base(size: float) -> str:
    """The URDF of an arm whose base link holds a plate of this size [m]."""
    cylinder = '<geometry><cylinder radius="0.09" length="0.12"/></geometry>'
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    return urdf.replace(cylinder, f'<geometry><box size="{size} {size} 0.02"/></geometry>', 1)


def chain(links: int) -> str:
    """The URDF of a chain whose links are all the mesh m.stl."""
    mesh = "<collision><geometry><mesh filename='m.stl'/></geometry></collision>"
    limit = "<limit lower='-1' upper='1' velocity='1' effort='1'/>"
    parts = [f"<link name='l{i}'>{mesh}</link>" for i in range(links)]
    parts += [
        f"<joint name='j{i}' type='revolute'><parent link='l{i}'/><child link='l{i + 1}'/>{limit}</joint>"
        for i in range(links - 1)
    ]
    return f"<robot name='chain'>{''.join(parts)}</robot>"


# --- calls ------------------------------------------------------------------------------------------------------------


def plan() -> Call:
    planner = among_points()
    planner.make_planner("left", PLAN)
    return lambda: planner.plan("left", turned(-1.4), joints(turned(1.4)))


def search() -> Call:
    """A* with steps of 3 degrees behind a wall stores millions of states."""
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7")
    planner.add_box("wall", [0.8, 0.05, 1.2], srmp.Pose([0.55, 0, 0.6]))
    planner.make_planner("arm7", {"planner_id": "Astar", "resolution": np.deg2rad(3), "time_limit": 60.0})
    start = np.array([-1.2, 0.9, 0, -1.2, 0, 0.9, 0])
    return lambda: planner.plan("arm7", start, joints(start * [-1, 1, 1, 1, 1, 1, 1]))


def plan_multi() -> Call:
    planner = among_points()
    planner.make_planner(["left", "right"], {"planner_id": "auto", "time_limit": 60.0, "improve_time": 60.0})
    starts = {"left": turned(-1.4), "right": turned(-1.4)}
    goals = {name: joints(turned(1.4)) for name in starts}
    return lambda: planner.plan_multi(starts, goals)


def plan_multi_many() -> Call:
    """25 arms that are timed and proved together for about as long as they are planned."""
    planner, random = srmp.PlannerInterface(), np.random.default_rng(1)
    starts, goals = {}, {}
    for k in range(25):
        name = f"arm{k}"
        planner.add_robot("arm7", name=name, base_pose=srmp.Pose(p=[0.6 * (k % 5), 0.6 * (k // 5), 0]))
        ready = np.array(planner.get_group_states(name)["ready"])
        starts[name], goals[name] = ready, ready + random.uniform(-0.4, 0.4, 7)
    planner.make_planner(list(starts), {"planner_id": "auto", "time_limit": 60.0})
    return lambda: planner.plan_multi(starts, {name: joints(q) for name, q in goals.items()})


def plan_many() -> Call:
    planner = among_points()
    planner.make_planner("left", PLAN)
    request = srmp.PlanRequest("left", turned(-1.4), joints(turned(1.4)))
    return lambda: planner.plan_many([request] * 8, 2)


def plan_sequence() -> Call:
    planner = among_points()
    planner.make_planner("left", PLAN)
    segments = [srmp.Segment.move(turned(1.4)), srmp.Segment.move(turned(-1.4))] * 4
    return lambda: planner.plan_sequence("left", turned(-1.4), segments)


def follow() -> Call:
    planner = two_arms()
    planner.make_planner("left", {"planner_id": "auto", "time_limit": 60.0})
    here = planner.compute_fk("left", turned(0.0))
    angles = np.linspace(0, 2 * pi, 400)
    poses = [srmp.Pose(here.p + 0.05 * np.array([0, np.sin(a), np.cos(a) - 1]), here.q) for a in angles]
    return lambda: planner.follow("left", turned(0.0), poses)


def time_parameterize() -> Call:
    ends = np.zeros(7), np.array([0.5, 0.2, 0.1, -0.3, 0.4, 0.2, 0.1])
    limits = srmp.MotionLimits(np.ones(7), np.full(7, 2.0), np.full(7, 20.0))
    names = [f"joint{i}" for i in range(7)]
    return lambda: srmp.time_parameterize(np.tile(ends, (50_000, 1)), names, limits)


def prepare() -> Call:
    sizes = itertools.count(1)

    def call() -> None:
        planner = srmp.PlannerInterface()
        planner.add_articulation(urdf_text=arm_with_base(0.3 + 1e-4 * next(sizes)), name="arm")
        planner.prepare()

    return call


def mesh_file() -> Call:
    write_stl(Path("big.stl"), scattered(400_000))
    return lambda: srmp.PlannerInterface().add_mesh("mesh", "big.stl")


def allowed_collisions() -> Call:
    write_stl(Path("m.stl"), scattered(3000))
    return lambda: srmp.PlannerInterface().add_articulation(urdf_text=chain(30), urdf_directory=".")


def load() -> Call:
    planner = two_arms()
    planner.add_point_cloud("points", np.random.default_rng(0).uniform(1, 2, (100_000, 3)), 0.01)
    planner.make_planner("left", PLAN)
    planner.save("problem.json")
    return lambda: srmp.PlannerInterface.load("problem.json")


def motions_free() -> Call:
    checker = among_points().collision_checker("left", "coal")
    q = np.zeros((9999, 7))
    return lambda: checker.motions_free(q, q + 3)


def certify() -> Call:
    planner = among_points()
    rows = np.random.default_rng(0).uniform(-2, 2, (2000, 7))
    motion = srmp.Trajectory(planner.get_joint_names("left"), rows, np.arange(2000.0), np.zeros(rows.shape))
    planner.make_planner("left", PLAN)
    return lambda: planner.verify("left", motion)


CALLS = {
    call.__name__: call
    for call in (
        plan,
        search,
        plan_multi,
        plan_multi_many,
        plan_many,
        plan_sequence,
        follow,
        time_parameterize,
        prepare,
        mesh_file,
        allowed_collisions,
        load,
        motions_free,
        certify,
    )
}


# --- measurements -----------------------------------------------------------------------------------------------------


CTRL_C = """
import os, signal, sys, time
pid = os.getppid()
for line in sys.stdin:
    time.sleep(float(line))
    sent = time.perf_counter(), time.clock_gettime((~pid << 3) | 2)  # CPU time of that process
    os.kill(pid, signal.SIGINT)
    print(*sent, flush=True)
"""
"""Another process, as a terminal is: a thread of this one would have to wait for the GIL."""


def time_to_interrupt(terminal: subprocess.Popen[str], call: Call, delay: float) -> tuple[float, float]:
    """By the clock and CPU time [s], from Ctrl-C after `delay` to the exception."""
    assert terminal.stdin and terminal.stdout
    try:
        terminal.stdin.write(f"{delay}\n")
        terminal.stdin.flush()
        while True:
            try:
                call()
            except srmp.PlanningError as error:
                if error.status in (srmp.Status.start_invalid, srmp.Status.goal_invalid):
                    raise  # there is nothing to interrupt
                time.sleep(0.001)
    except KeyboardInterrupt:
        now = time.perf_counter(), time.process_time()
    clock, cpu = map(float, terminal.stdout.readline().split())
    return now[0] - clock, now[1] - cpu


@contextmanager
def other_process() -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", CTRL_C]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as terminal:
        yield terminal
        terminal.stdin.close()


@contextmanager
def empty_directory() -> Iterator[None]:
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)
        try:
            yield
        finally:
            os.chdir(before)


def run(calls: list[str], tries: int, longest: float) -> dict[str, Any]:
    os.environ["SRMP_CACHE_DIR"] = ""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background of a shell ignore it
    rows: list[dict[str, Any]] = []
    for name in calls:
        with empty_directory(), other_process() as terminal:
            call = CALLS[name]()
            for delay in np.geomspace(0.005, longest, tries).tolist():
                clock, cpu = time_to_interrupt(terminal, call, delay)
                rows.append({"call": name, "delay_s": delay, "clock_s": clock, "cpu_s": cpu})
    options = {"calls": calls, "tries": tries, "longest_s": longest}
    return {"header": mbm.header("interrupts", options=options), "rows": rows}


def is_slow(row: dict[str, Any]) -> bool:
    return min(row["clock_s"], row["cpu_s"]) > AIM


def table(result: dict[str, Any]) -> str:
    lines = []
    for name in dict.fromkeys(row["call"] for row in result["rows"]):
        group = [row for row in result["rows"] if row["call"] == name]
        clock, cpu = ([row[key] for row in group] for key in ("clock_s", "cpu_s"))
        numbers = [f(values) for values in (clock, cpu) for f in (np.median, np.max)]
        lines.append([name, *(format_seconds(float(x)) for x in numbers), str(sum(map(is_slow, group)))])
    return format_table(["Ctrl-C in", "clock 50 %", "most", "CPU 50 %", "most", "slow"], lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--calls", nargs="*", choices=CALLS, default=list(CALLS))
    parser.add_argument("--tries", type=int, default=12)
    parser.add_argument("--longest", type=float, default=1.0, help="[s] of the waits before Ctrl-C")
    result = run_and_report(parser, run, table)
    return 1 if any(map(is_slow, result["rows"])) else 0


if __name__ == "__main__":
    sys.exit(main())
