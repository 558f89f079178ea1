"""Checks that certificates of plans hold, and that independent code agrees with them.

    python bench/suites/certificates.py --data DIR [--problems 1-10] [--geometry spheres] [--out certificates.json]

Plans MotionBenchMaker's problems with default options and checks every trajectory again at 1 kHz with Pinocchio's and
Coal's own Python packages and without any code of srmp: it evaluates the cubics between the rows, compares them with
the position, velocity and acceleration limits (those of the URDF; accelerations of 2/s times the velocity), and checks
their configurations for collisions. The exit code is 1 when a certificate does not hold or is contradicted. Needs pin,
coal, PyYAML (pip install pin coal pyyaml).
"""

from __future__ import annotations

import argparse
import itertools
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import recheck_mbm

import srmp
from srmp._files import write_json
from srmp._table import format_seconds, format_table
from srmp.bench import mbm
from srmp.recheck import cubics

RATE = 1000.0  # [Hz]
TOLERANCE = 1e-6  # of a limit
TIMES = ("plan_time_s", "total_time_s", "timing_time_s", "verification_time_s")


def states(trajectory: srmp.Trajectory) -> tuple[np.ndarray, ...]:
    """Positions, velocities and accelerations (k, dof) at 1 kHz and at the end."""
    times = trajectory.times
    at = cubics.instants(times[0], times[-1], RATE)
    return cubics.states(times, trajectory.positions, trajectory.velocities, at)


def broken_limits(world: recheck_mbm.World, trajectory: srmp.Trajectory) -> list[str]:
    position, velocity, acceleration = states(trajectory)
    model, found = world.model, []
    for j, name in enumerate(trajectory.joint_names):
        joint = model.joints[model.getJointId(name)]
        fastest = float(model.velocityLimit[joint.idx_v])
        q, lower, upper = position[:, j], *(limit[joint.idx_q] for limit in limits_of(model))
        for what, values, limit in (("velocity", velocity, fastest), ("acceleration", acceleration, 2 * fastest)):
            largest = float(np.abs(values[:, j]).max())
            if largest > limit * (1 + TOLERANCE):
                found.append(f"{name}: {what} {largest:.6g} is above {limit:.6g}")
        if joint.nq == 1 and (q.min() < lower - TOLERANCE or q.max() > upper + TOLERANCE):
            found.append(f"{name}: position from {q.min():.6g} to {q.max():.6g} leaves [{lower:.6g}, {upper:.6g}]")
    return found


def limits_of(model: Any) -> tuple[np.ndarray, np.ndarray]:
    return model.lowerPositionLimit, model.upperPositionLimit


def contradictions(world: recheck_mbm.World, trajectory: srmp.Trajectory) -> list[str]:
    """Violated limits and the first collision, at 1 kHz."""
    found = broken_limits(world, trajectory)
    for q in states(trajectory)[0]:
        if pair := world.touching(trajectory.joint_names, q):
            return [*found, f"{pair} touch at {np.round(q, 4).tolist()}"]
    return found


def check(runner: mbm.Runner, problem: mbm.Problem, files: mbm.RobotFiles) -> dict[str, Any]:
    planner, moveit_problem = runner.set_up(problem)
    try:
        trajectory = planner.plan(files.name, moveit_problem.start, moveit_problem.goals)
    except srmp.PlanningError as error:
        return {"problem": problem.name, "status": mbm.status_name(error.status)}
    world = recheck_mbm.World(files.directory, files.name, files.urdf, problem.name)
    certificate, stats = trajectory.certificate, planner.get_planning_stats()
    return {
        "problem": problem.name,
        "status": "solved",
        "holds": certificate.holds,
        "proved_free": certificate.proved_free,
        "clearance_m": certificate.clearance,
        "clearance_proved_m": certificate.clearance_proved,
        "deviation_m": certificate.deviation,
        "duration_s": trajectory.duration,
        "contradictions": contradictions(world, trajectory),
        **{key: stats[key] for key in TIMES},
    }


def run(data: str, robot: str, geometry: str, problems: str, scenarios: list[str] | None) -> dict[str, Any]:
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "auto", {}, 10.0)
    numbers = mbm.parse_numbers(problems) if problems else None
    with mbm.open_problems(files.directory, robot, scenarios or (), numbers) as chosen:
        rows = [check(runner, problem, files) for problem in chosen]
    options = {"robot": robot, "geometry": geometry, "problems": problems or "all", "rate_hz": RATE}
    return {"header": mbm.header("certificates", options=options), "rows": rows}


def is_wrong(row: dict[str, Any]) -> bool:
    return row["status"] == "solved" and (not row["holds"] or bool(row["contradictions"]))


def table(result: dict[str, Any]) -> str:
    def scenario(row: dict[str, Any]) -> str:
        return row["problem"].split("/")[0]

    groups = [(name, list(rows)) for name, rows in itertools.groupby(result["rows"], scenario)]
    return format_table(
        ["scenario", "solved", "hold", "proved free", "contradicted", "timing", "95 %", "proof", "95 %", "clearance"],
        [line(name, rows) for name, rows in [*groups, ("all", result["rows"])]],
    )


def line(name: str, rows: list[dict[str, Any]]) -> list[str]:
    solved = [row for row in rows if row["status"] == "solved"]
    counts = [sum(row["holds"] for row in solved), sum(row["proved_free"] for row in solved)]
    cells = [
        name,
        f"{len(solved)}/{len(rows)}",
        *map(str, counts),
        str(sum(bool(row["contradictions"]) for row in solved)),
    ]
    if not solved:
        return [*cells, *5 * ["-"]]
    for key in ("timing_time_s", "verification_time_s"):
        cells += [format_seconds(float(np.percentile([row[key] for row in solved], p))) for p in (50, 95)]
    return [*cells, f"{1e3 * float(np.median([row['clearance_m'] for row in solved])):.2g} mm"]


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--geometry", choices=["urdf", "spheres"], default="urdf")
    parser.add_argument("--problems", default="", help="numbers in each scenario; default: all")
    parser.add_argument("--scenarios", nargs="*")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    options = vars(parser.parse_args())
    out = options.pop("out")
    result = run(**options)
    print(table(result))
    for row in filter(is_wrong, result["rows"]):
        print(row["problem"], *row["contradictions"] or ["does not hold"], sep=": ")
    if out:
        write_json(out, result)
    return 1 if any(map(is_wrong, result["rows"])) else 0


if __name__ == "__main__":
    sys.exit(main())
