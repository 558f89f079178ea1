"""Compares a scene as boxes with the same scene as a point cloud: time to insert the cloud, time to check motions.

    python bench/micro/cloud.py --data DIR --out cloud.json

Draws --points points uniformly from the surfaces of each scene's objects and inserts them with --resolution. Motions
start at random configurations that are free in the cloud and move every joint by up to --size, in the scenes with the
numbers --problems. Times are CPU times of one thread, the best of --repeats; the two checkers are run alternately.
Needs PyYAML.
"""

from __future__ import annotations

import argparse
import re
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from checks import run_or_print
from tqdm import tqdm

import srmp
from srmp._table import format_table
from srmp.bench import mbm

# --- points on surfaces -----------------------------------------------------------------------------------------------


def transform(pose: dict) -> tuple[np.ndarray, np.ndarray]:
    x, y, z, w = np.array(pose["orientation"], dtype=float) / np.linalg.norm(pose["orientation"])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return rotation, np.array(pose["position"], dtype=float)


def area(kind: str, size: list[float]) -> float:
    if kind == "box":
        a, b, c = size
        return 2 * (a * b + b * c + a * c)
    if kind == "cylinder":  # MoveIt: height, radius
        return 2 * np.pi * size[1] * (size[1] + size[0])
    if kind == "sphere":
        return 4 * np.pi * size[0] ** 2
    raise ValueError(f"primitive {kind} is not supported here")


def on_box(size: list[float], count: int, rng: np.random.Generator) -> np.ndarray:
    edges = np.array(size)
    faces = np.prod(edges) / edges
    axis = rng.choice(3, count, p=faces / faces.sum())
    points = rng.uniform(-0.5, 0.5, (count, 3))
    points[np.arange(count), axis] = rng.choice([-0.5, 0.5], count)
    return points * edges


def on_cylinder(size: list[float], count: int, rng: np.random.Generator) -> np.ndarray:
    height, radius = size
    side = rng.random(count) < height / (height + radius)
    angle = rng.uniform(0, 2 * np.pi, count)
    r = np.where(side, radius, radius * np.sqrt(rng.random(count)))
    z = np.where(side, rng.uniform(-0.5, 0.5, count), rng.choice([-0.5, 0.5], count))
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), height * z])


def on_sphere(size: list[float], count: int, rng: np.random.Generator) -> np.ndarray:
    points = rng.normal(size=(count, 3))
    return points * (size[0] / np.linalg.norm(points, axis=1, keepdims=True))


SAMPLERS = {"box": on_box, "cylinder": on_cylinder, "sphere": on_sphere}


def surface_points(scene: Path, count: int) -> np.ndarray:
    """About `count` points (n, 3), for each object in proportion to its surface."""
    primitives = []
    for item in yaml.safe_load(scene.read_text())["world"]["collision_objects"]:
        outer = transform(item.get("pose", {"position": [0, 0, 0], "orientation": [0, 0, 0, 1]}))
        for shape, pose in zip(item["primitives"], item["primitive_poses"], strict=True):
            primitives.append((shape["type"], shape["dimensions"], outer, transform(pose)))
    rng = np.random.default_rng(0)
    areas = np.array([area(kind, size) for kind, size, _, _ in primitives])
    clouds = []
    for (kind, size, outer, inner), fraction in zip(primitives, areas / areas.sum(), strict=True):
        points = SAMPLERS[kind](size, max(1, round(count * fraction)), rng)
        for rotation, translation in (inner, outer):
            points = points @ rotation.T + translation
        clouds.append(points)
    return np.concatenate(clouds)


# --- measuring --------------------------------------------------------------------------------------------------------


def cpu_seconds(work: Callable[..., object], *arguments: object) -> float:
    start = time.thread_time()
    work(*arguments)
    return time.thread_time() - start


def motions(planner: srmp.PlannerInterface, checker: srmp.CollisionChecker, name: str, count: int, size: float):
    """Collision-free starts (count, dof) and ends (count, dof) of motions."""
    rng = np.random.default_rng(1)
    limits = np.clip(planner.get_joint_limits(name)[:, :2], -np.pi, np.pi)
    starts = np.empty((0, len(limits)))
    while len(starts) < count:
        q = rng.uniform(limits[:, 0], limits[:, 1], (count, len(limits)))
        starts = np.concatenate([starts, q[checker.are_free(q)]])
    steps = rng.uniform(-1, 1, (count, len(limits)))
    return starts[:count], starts[:count] + steps * (size / np.abs(steps).max(axis=1, keepdims=True))


def measure(files: mbm.RobotFiles, scene: Path, arguments: argparse.Namespace) -> dict:
    name, repeats = files.name, range(arguments.repeats)
    points = surface_points(scene, arguments.points)
    boxes = mbm.load_robot(files, mbm.GROUPS[files.name])
    boxes.load_moveit_scene(str(scene))
    clouds = [mbm.load_robot(files, mbm.GROUPS[files.name]) for _ in repeats]
    insertion = [cpu_seconds(cloud.add_point_cloud, "cloud", points, arguments.resolution) for cloud in clouds]
    setup = min(cpu_seconds(clouds[0].collision_checker, name) for _ in repeats)
    checkers = {"boxes": boxes.collision_checker(name), "cloud": clouds[0].collision_checker(name)}
    a, b = motions(boxes, checkers["cloud"], name, arguments.motions, arguments.size)
    free = {key: checker.motions_free(a, b) for key, checker in checkers.items()}
    both = free["boxes"] & free["cloud"]
    times: dict[tuple[str, str], list[float]] = {}
    for _ in repeats:
        for key, checker in checkers.items():
            times.setdefault((key, "all"), []).append(cpu_seconds(checker.motions_free, a, b))
            times.setdefault((key, "free"), []).append(cpu_seconds(checker.motions_free, a[both], b[both]))
    seconds = {what: min(values) for what, values in times.items()}
    return {
        "points": len(points),
        "insertion_s": min(insertion),
        "checker_s": setup,
        "motions": len(a),
        "free_boxes": int(free["boxes"].sum()),
        "free_cloud": int(free["cloud"].sum()),
        "boxes_motion_s": seconds["boxes", "all"] / len(a),
        "cloud_motion_s": seconds["cloud", "all"] / len(a),
        "ratio": seconds["cloud", "all"] / seconds["boxes", "all"],
        "ratio_free": seconds["cloud", "free"] / seconds["boxes", "free"],
    }


def table(results: dict) -> str:
    header = ["scene", "inserted", "checker", "motion, boxes", "motion, cloud", "ratio", "ratio, free"]
    rows = [
        [
            row["problem"],
            f"{1e3 * row['insertion_s']:.1f} ms",
            f"{1e3 * row['checker_s']:.1f} ms",
            f"{1e6 * row['boxes_motion_s']:.1f} us",
            f"{1e6 * row['cloud_motion_s']:.1f} us",
            f"{row['ratio']:.1f}",
            f"{row['ratio_free']:.1f}",
        ]
        for row in results["rows"]
    ]
    worst = [max(row[key] for row in results["rows"]) for key in ("insertion_s", "ratio", "ratio_free")]
    medians = [statistics.median(row[key] for row in results["rows"]) for key in ("insertion_s", "ratio", "ratio_free")]
    for what, (insertion, ratio, ratio_free) in (("median", medians), ("worst", worst)):
        rows.append([what, f"{1e3 * insertion:.1f} ms", "", "", "", f"{ratio:.1f}", f"{ratio_free:.1f}"])
    return format_table(header, rows)


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    files = mbm.robot_files(arguments.data, arguments.robot, arguments.geometry)
    srmp.cover(str(files.urdf), package_dirs=[str(files.directory)])
    with mbm.open_problems(files.directory, arguments.robot, numbers=mbm.parse_numbers(arguments.problems)) as problems:
        rows = [
            {"problem": problem.name, **measure(files, problem.scene, arguments)}
            for problem in tqdm(problems, disable=None)
        ]
    keys = ("robot", "geometry", "problems", "points", "resolution", "motions", "size", "repeats")
    header = mbm.header("point clouds", options={key: getattr(arguments, key) for key in keys})
    return {"header": header, "rows": rows}


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--robot", choices=list(mbm.GROUPS), default="panda")
    parser.add_argument("--geometry", choices=["urdf", "spheres"], default="urdf")
    parser.add_argument("--problems", default="1", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--resolution", type=float, default=0.02, help="of the cloud [m] (default: %(default)s)")
    parser.add_argument("--motions", type=int, default=300, help="number in each scene (default: %(default)s)")
    parser.add_argument("--size", type=float, default=0.13, help="of the fastest joint [rad] (default: %(default)s)")
    parser.add_argument(
        "--repeats", type=int, default=3, help="runs, of which the best is reported (default: %(default)s)"
    )
    run_or_print(parser, run, table)


if __name__ == "__main__":
    main()
