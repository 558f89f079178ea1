"""Compares the collision checker's modes with Coal, and its instruction sets with each other.

    python bench/suites/agreement.py --data DIR --out agreement.json [--configurations 1000000]

Checks random configurations and motions of Panda, UR5 and Fetch in seven MotionBenchMaker scenarios, a quarter as many
motions as configurations. It counts four types of faults, and the exit code is 1 unless all counts are 0:
- exact: the mode `exact` gives another result than Coal alone
- conservative: the mode `conservative` reports free where Coal does not
- simd: an instruction set gives another result than the first one, or another layer resolves it (a process for each)
- independent: Pinocchio's and Coal's own Python packages find a free configuration in collision (for a fraction
  --recheck of the configurations). The reverse case is counted as `stricter` and is not a fault: closed convex meshes
  are solids in srmp and surfaces there, and a mesh with several materials is read in two ways.
The proof may fail for a motion whose clearance is below 22 µm (Checker::motion_floor), while another subdivision of the
same motion proves it. Such motions are counted as `grazing` and are not faults.

Needs PyYAML, and pin and coal for --recheck (pip install pin coal pyyaml).
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from tqdm import tqdm

import srmp
from srmp._files import write_json
from srmp.bench import mbm

SCENARIOS = ["bookshelf_small", "bookshelf_tall", "bookshelf_thin", "box", "cage", "table_pick", "table_under_pick"]
FAULTS = ("exact", "conservative", "simd", "independent")
BACKENDS = ("portable", "avx2", "avx512")
FLOOR = 2.2e-5  # [m]
CHUNK = 4000  # configurations checked at a time


# --- also used by the tests -------------------------------------------------------------------------------------------


def random_states(planner: srmp.PlannerInterface, name: str, count: int, seed: int = 0) -> np.ndarray:
    limits = np.clip(planner.get_joint_limits(name)[:, :2], -np.pi, np.pi)
    return np.random.default_rng(seed).uniform(limits[:, 0], limits[:, 1], (count, len(limits)))


def random_motions(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Motions from the first quarter of the configurations towards the second quarter."""
    quarter = len(q) // 4
    return q[:quarter], q[:quarter] + 0.05 * (q[quarter : 2 * quarter] - q[:quarter])


def check_all(checker: srmp.CollisionChecker, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether each configuration (n,) and each motion (n / 4,) is free."""
    return checker.are_free(q), checker.motions_free(*random_motions(q))


def compare_modes(planner: srmp.PlannerInterface, name: str, q: np.ndarray) -> tuple[Counter, np.ndarray]:
    """Compares `exact` and `conservative` with Coal. Returns the counts, and which configurations are free."""
    coal = planner.collision_checker(name, "coal")
    truth, moves = check_all(coal, q), random_motions(q)
    counts = Counter(dict.fromkeys(("exact", "conservative", "grazing"), 0))
    counts.update(configurations=len(truth[0]), motions=len(truth[1]))
    counts.update({"free": int(truth[0].sum()), "motions free": int(truth[1].sum())})
    for mode in ("exact", "conservative"):
        states, motions = check_all(planner.collision_checker(name, mode), q)
        wrong, differing = states != truth[0], motions != truth[1]
        if mode == "conservative":
            wrong, differing = wrong & states, differing & motions
        grazing = sum(smallest_clearance(coal, moves[0][i], moves[1][i]) < FLOOR for i in np.flatnonzero(differing))
        counts[mode] += int(wrong.sum() + differing.sum()) - grazing
        counts["grazing"] += grazing
    return counts, truth[0]


def smallest_clearance(checker: srmp.CollisionChecker, a: np.ndarray, b: np.ndarray) -> float:
    """The smallest clearance of the motion [m], from 201 samples, refined twice around the smallest one."""
    low, high = 0.0, 1.0
    for _ in range(3):
        t = np.linspace(low, high, 201)
        clearance = checker.clearance(a + t[:, None] * (b - a))
        middle, width = t[clearance.argmin()], t[1] - t[0]
        low, high = max(0.0, middle - width), min(1.0, middle + width)
    return float(clearance.min())


# --- scenes -----------------------------------------------------------------------------------------------------------


def load_robot(data: Path, robot: str) -> srmp.PlannerInterface:
    return mbm.load_robot(mbm.robot_files(data, robot, "urdf"), mbm.GROUPS[robot])


def load_scene(planner: srmp.PlannerInterface, scene: str) -> None:
    for name in planner.object_names:
        planner.remove_object(name)
    planner.load_moveit_scene(scene)


class Backend:
    """A process with SRMP_SIMD set, which holds one robot."""

    def __init__(self, name: str, data: Path, robot: str) -> None:
        self.name = name
        self._pool = ProcessPoolExecutor(1, get_context("spawn"), _start_worker, (name, data, robot))

    def digest(self, scene: str, seed: int, count: int) -> str:
        return self._pool.submit(_digest, scene, seed, count).result()

    def close(self) -> None:
        self._pool.shutdown()


_worker: dict = {}


def _start_worker(backend: str, data: Path, robot: str) -> None:
    os.environ["SRMP_SIMD"] = backend
    _worker.update(planner=load_robot(data, robot), robot=robot, scene="")


def _digest(scene: str, seed: int, count: int) -> str:
    """A hash of all results, and of the number of queries that each layer resolved."""
    if _worker["scene"] != scene:
        load_scene(_worker["planner"], scene)
        _worker["scene"] = scene
    planner, robot = _worker["planner"], _worker["robot"]
    q = random_states(planner, robot, count, seed)
    text = hashlib.sha256()
    for mode in ("exact", "conservative"):
        checker = planner.collision_checker(robot, mode)
        for free in check_all(checker, q):
            text.update(free.tobytes())
        text.update(json.dumps(checker.stats(), sort_keys=True).encode())
    return text.hexdigest()


def available(backend: str) -> bool:
    """Whether this CPU has the instruction set."""
    before = os.environ.get("SRMP_SIMD")
    os.environ["SRMP_SIMD"] = backend
    try:
        planner = srmp.PlannerInterface()
        planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), name="arm", end_effector="arm7_hand")
        planner.collision_checker("arm")
        return True
    except srmp.InvalidArgument:
        return False
    finally:
        os.environ.pop("SRMP_SIMD")
        if before is not None:
            os.environ["SRMP_SIMD"] = before


# --- the suite --------------------------------------------------------------------------------------------------------


def recheck(data: Path, robot: str, problem: str, names: list[str], q: np.ndarray, free: np.ndarray) -> Counter:
    """Checks the same configurations without srmp."""
    sys.path.insert(0, str(Path(__file__).parent))
    from recheck_mbm import World  # needs pin and coal

    world = World(data / robot, robot, data / robot / f"{robot}.urdf", problem)
    counts = Counter(rechecked=len(q), independent=0, stricter=0)
    for row, reported_free in zip(q, free, strict=True):
        touching = bool(world.touching(names, row))
        counts["independent"] += bool(reported_free) and touching
        counts["stricter"] += not reported_free and not touching
    return counts


def run_robot(data: Path, robot: str, arguments: argparse.Namespace, bar: tqdm) -> Iterator[dict]:
    """Yields one row per scene."""
    planner = load_robot(data, robot)
    backends = [Backend(name, data, robot) for name in BACKENDS if available(name)]
    names = list(planner.get_joint_names(robot))
    per_scene = -(-arguments.configurations // (len(arguments.robots) * len(SCENARIOS) * len(arguments.numbers)))
    with mbm.open_problems(data / robot, robot, SCENARIOS, arguments.numbers) as problems:
        for problem in problems:
            load_scene(planner, str(problem.scene))
            bar.set_description(f"{robot} {problem.name}")
            counts: Counter = Counter(dict.fromkeys(FAULTS, 0))
            for first in range(0, per_scene, CHUNK):
                count = min(CHUNK, per_scene - first)
                seed = int.from_bytes(
                    hashlib.sha256(f"{arguments.seed} {problem.name} {first}".encode()).digest()[:4], "big"
                )
                q = random_states(planner, robot, count, seed)
                found, free = compare_modes(planner, robot, q)
                digests = [backend.digest(str(problem.scene), seed, count) for backend in backends]
                found["simd"] = len(set(digests)) - 1
                rechecked = round(count * arguments.recheck)
                if rechecked:
                    found.update(recheck(data, robot, problem.name, names, q[:rechecked], free[:rechecked]))
                counts.update(found)
                bar.update(count)
            yield {"robot": robot, "problem": problem.name, "backends": [b.name for b in backends], **counts}
    for backend in backends:
        backend.close()


def run(arguments: argparse.Namespace) -> dict:
    start = time.perf_counter()
    rows: list[dict] = []
    with tqdm(total=arguments.configurations, unit="q", disable=None, dynamic_ncols=True) as bar:
        for robot in arguments.robots:
            files = mbm.robot_files(arguments.data, robot, "urdf")
            srmp.cover(str(files.urdf), package_dirs=[str(files.directory)])
            rows += run_robot(arguments.data, robot, arguments, bar)
    total: Counter = Counter()
    for row in rows:
        total.update({key: value for key, value in row.items() if isinstance(value, int)})
    keys = ("configurations", "robots", "problems", "recheck", "seed")
    header = mbm.header(
        "agreement",
        seconds=time.perf_counter() - start,
        options={key: getattr(arguments, key) for key in keys},
    )
    return {"header": header, "total": dict(total), "rows": rows}


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", type=Path, required=True, help="MotionBenchMaker's robots and problems")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    parser.add_argument("--configurations", type=int, default=1_000_000, help="total number (default: %(default)s)")
    parser.add_argument("--robots", nargs="+", choices=list(mbm.GROUPS), default=list(mbm.GROUPS))
    parser.add_argument("--problems", default="1-4", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument(
        "--recheck", type=float, default=0.01, help="fraction checked with pin and coal too (default: %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    arguments.numbers = mbm.parse_numbers(arguments.problems)
    results = run(arguments)
    if arguments.out:
        write_json(arguments.out, results)
    total = results["total"]
    print(", ".join(f"{key}: {value}" for key, value in total.items()))
    return 1 if any(total[fault] for fault in FAULTS) else 0


if __name__ == "__main__":
    sys.exit(main())
