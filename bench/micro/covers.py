"""Sphere covers of many robots: the table of docs/covers.md.

    pip install example-robot-data
    python bench/micro/covers.py --data DIR --out covers.json      one robot after the other, nothing else running
    python bench/micro/covers.py --table covers.json               prints the table of an earlier run

DIR holds MotionBenchMaker's panda, ur5 and fetch; the others come from example-robot-data. Each robot is covered in a
process and a cache directory of its own, by all cores, counting wall and CPU time, then read back (best of 5).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tqdm import tqdm

import srmp
from srmp._cover import statistics
from srmp._files import write_json
from srmp.bench import mbm
from srmp.bench.scenes import example_robot_data

# name: (a robot of MotionBenchMaker, or a file of example-robot-data)
ROBOTS = {
    "Panda, MotionBenchMaker": ("panda", ""),
    "UR5, MotionBenchMaker": ("ur5", ""),
    "Fetch, MotionBenchMaker": ("fetch", ""),
    "Panda, example-robot-data": ("", "panda_description/urdf/panda.urdf"),
    "xArm 7": ("", "xarm_description/urdf/xarm7.urdf"),
    "Kinova with two fingers": ("", "kinova_description/robots/kinova.urdf"),
    "Z1": ("", "z1_description/urdf/z1.urdf"),
    "SO-101": ("", "so_arm_description/urdf/so101.urdf"),
    "UR3": ("", "ur_description/urdf/ur3_robot.urdf"),
    "UR5 with Robotiq gripper": ("", "ur_description/urdf/ur5_gripper.urdf"),
    "UR10": ("", "ur_description/urdf/ur10_robot.urdf"),
}


def locate(data: Path | None, examples: Path | None, robot: str, file: str) -> tuple[Path, list[str]] | None:
    """URDF and package directories; nothing when its collection is not there."""
    if robot:
        return (data / robot / f"{robot}.urdf", [str(data / robot)]) if data else None
    return (examples / file, [str(examples.parents[1])]) if examples else None


def cover(urdf: Path, packages: list[str], max_coarse: int) -> srmp.RobotCover:
    return srmp.cover(str(urdf), package_dirs=packages, max_coarse=max_coarse)


def measure(urdf: Path, packages: list[str]) -> dict:
    with tempfile.TemporaryDirectory() as directory:
        os.environ["SRMP_CACHE_DIR"] = directory
        cpu = time.process_time()
        built = cover(urdf, packages, 160)
        cpu = time.process_time() - cpu
        unlimited = cover(urdf, packages, 0)
        loaded = [cover(urdf, packages, 160) for _ in range(5)]
    assert not built.from_cache
    assert all(other.from_cache for other in loaded)
    counts = statistics(built)
    return {
        **counts,
        "coarse_without_limit": statistics(unlimited)["coarse"]["spheres"],
        "built_s": built.seconds,
        "built_cpu_s": cpu,
        "loaded_s": min(other.seconds for other in loaded),
    }


def measure_in_process(urdf: Path, packages: list[str]) -> dict:
    """In a process of its own: what another robot left in memory must not help."""
    command = [sys.executable, __file__, "--one", str(urdf), *packages]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def table(results: dict) -> str:
    lines = [
        "| robot | coarse spheres (largest) | at 15 mm | fine spheres (largest, mean) | built (CPU) | loaded |",
        "|---|---|---|---|---|---|",
    ]
    for row in results["rows"]:
        coarse, fine = row["coarse"], row["fine"]
        cells = [
            row["robot"],
            f"{coarse['spheres']} ({1e3 * coarse['max_inflation']:.1f} mm)",
            str(row["coarse_without_limit"]),
            f"{fine['spheres']} ({1e3 * fine['max_inflation']:.1f}, {1e3 * fine['mean_inflation']:.1f} mm)",
            f"{row['built_s']:.1f} s ({row['built_cpu_s']:.1f} s)",
            f"{1e3 * row['loaded_s']:.1f} ms",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", type=Path, help="MotionBenchMaker's robots; without it, the other robots only")
    parser.add_argument("--examples", type=Path, default=example_robot_data(), help="robots/ of example-robot-data")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    parser.add_argument(
        "--table", type=Path, metavar="RESULTS", help="print the table of these results, measure nothing"
    )
    parser.add_argument("--only", default="", help="robots whose name contains this")
    parser.add_argument("--one", nargs="+", metavar=("URDF", "PACKAGES"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(measure(Path(arguments.one[0]), arguments.one[1:])))
        return
    if arguments.table:
        print(table(json.loads(arguments.table.read_text())))
        return
    found = {
        name: where
        for name, source in ROBOTS.items()
        if arguments.only.lower() in name.lower() and (where := locate(arguments.data, arguments.examples, *source))
    }
    if not found:
        parser.error("no robot is there: give --data, or install example-robot-data")
    rows = [{"robot": name, **measure_in_process(*found[name])} for name in tqdm(found, disable=None)]
    header = mbm.header("covers", cores=os.cpu_count(), load_before=os.getloadavg()[0])
    results = {"header": header, "rows": rows}
    if arguments.out:
        write_json(arguments.out, results)
    print(table(results))


if __name__ == "__main__":
    main()
