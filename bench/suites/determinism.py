"""Checks that results are the same, bit for bit, on every run, for every number of threads and every instruction set.

    python bench/suites/determinism.py --data DIR [--geometry spheres] [--out determinism.json]

Plans MotionBenchMaker's first problems of each scenario repeatedly: with `auto` by plan_many on 1, 2 and 4 threads, and
some of them with wPASE with as many threads inside one plan. Each instruction set that the CPU has is tested in a
process of its own (SRMP_SIMD). A result is hashed: waypoints, samples and times of the trajectory, or status and
reason. The exit code is 1 when any problem has two different hashes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import srmp
from srmp._files import write_json
from srmp.bench import mbm

BACKENDS = ("portable", "avx2", "avx512")
TIME_LIMIT = 120.0  # [s], never reached: a limit that cuts a plan short may change its result
WPASE_PROBLEMS = ("bookshelf_thin/0001", "cage/0001", "table_under_pick/0001")


def result_hash(result: srmp.PlanResult) -> str:
    digest = hashlib.sha256()
    if result.status == srmp.Status.timed_out:
        raise RuntimeError(f"{result.reason}: results of plans that timed out cannot be compared")
    if result.solved:
        trajectory = result.trajectory
        for array in (trajectory.waypoints, trajectory.positions, trajectory.times):
            digest.update(array.tobytes())
    else:
        digest.update(f"{result.status.name}: {result.reason}".encode())
    return digest.hexdigest()


def hashes_of(
    data: str, robot: str, geometry: str, scenarios: str, problems: str, repeats: int, threads: list[int]
) -> dict[str, list[str]]:
    """The different hashes of each problem, with this process's instruction set."""
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "auto", {}, TIME_LIMIT)
    found: dict[str, list[str]] = {}

    named = scenarios.split(",") if scenarios else ()
    with mbm.open_problems(files.directory, robot, named, mbm.parse_numbers(problems)) as chosen:
        for problem in chosen:
            planner, moveit_problem = runner.set_up(problem)
            auto = srmp.PlanRequest(robot, moveit_problem.start, moveit_problem.goals)
            hashes = [result_hash(r) for count in threads for r in planner.plan_many([auto] * repeats, count)]
            found[f"auto {problem.name}"] = sorted(set(hashes))
            if problem.name in WPASE_PROBLEMS:
                options = [srmp.WPASE(num_threads=count, time_limit=TIME_LIMIT) for count in threads]
                parallel = [
                    srmp.PlanRequest(robot, moveit_problem.start, moveit_problem.goals, option) for option in options
                ]
                hashes = [result_hash(r) for r in planner.plan_many(parallel * repeats, 1)]
                found[f"wPASE {problem.name}"] = sorted(set(hashes))
    return found


def run_in_process(backend: str, arguments: list[str]) -> dict[str, list[str]] | None:
    """hashes_of with an instruction set; None if the CPU does not have it."""
    command = [sys.executable, __file__, "--here", *arguments]
    done = subprocess.run(command, env={**os.environ, "SRMP_SIMD": backend}, capture_output=True, text=True)
    if "which this CPU does not have" in done.stderr:
        return None
    if done.returncode:
        raise RuntimeError(f"{backend}: {done.stderr}")
    return json.loads(done.stdout)


def merge(by_backend: dict[str, dict[str, list[str]]]) -> dict[str, list[str]]:
    """The different hashes of each problem over all instruction sets."""
    problems = dict.fromkeys(problem for found in by_backend.values() for problem in found)
    return {p: sorted({h for found in by_backend.values() for h in found.get(p, ["missing"])}) for p in problems}


def run(
    data: str,
    robot: str = "panda",
    geometry: str = "urdf",
    scenarios: str = "",
    problems: str = "1-5",
    repeats: int = 20,
    threads: str = "1,2,4",
) -> dict[str, Any]:
    """The header, the different hashes of each problem, and the problems that have more than one."""
    arguments = [f"--data={data}", f"--robot={robot}", f"--geometry={geometry}", f"--scenarios={scenarios}"]
    arguments += [f"--problems={problems}", f"--repeats={repeats}", f"--threads={threads}"]
    by_backend = {}
    for backend in BACKENDS:
        if (found := run_in_process(backend, arguments)) is not None:
            by_backend[backend] = found
    hashes = merge(by_backend)
    header = mbm.header(
        "determinism",
        instruction_sets=list(by_backend),
        options={
            "robot": robot,
            "geometry": geometry,
            "scenarios": scenarios or "all",
            "problems": problems,
            "repeats": repeats,
            "threads": threads,
        },
    )
    return {
        "header": header,
        "hashes": hashes,
        "differing": [problem for problem, found in hashes.items() if len(found) != 1],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--geometry", choices=["urdf", "spheres"], default="urdf")
    parser.add_argument("--scenarios", default="", help="comma-separated; default: all")
    parser.add_argument("--problems", default="1-5", help="numbers in each scenario")
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--threads", default="1,2,4")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    parser.add_argument(
        "--here", action="store_true", help="run in this process, with its SRMP_SIMD, and print the hashes"
    )
    options = vars(parser.parse_args())
    here, out = options.pop("here"), options.pop("out")
    if here:
        options["threads"] = [int(count) for count in options["threads"].split(",")]
        print(json.dumps(hashes_of(**options)))
        return 0
    result = run(**options)
    if out:
        write_json(out, result)
    sets = ", ".join(result["header"]["instruction_sets"])
    print("\n".join([*result["differing"], f"{len(result['hashes'])} problems on {sets}:"]))
    print(f"{len(result['differing'])} have more than one result")
    return 1 if result["differing"] else 0


if __name__ == "__main__":
    sys.exit(main())
