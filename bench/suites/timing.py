"""How much longer do timed paths take than the fastest motion along them that the `toppra` Python package finds?

    python bench/suites/timing.py [--paths 200] [--seed 1] [--out timing.json]

Random paths (2 to 12 waypoints, 1 to 8 joints, limits of all sizes) are timed by srmp.time_parameterize and, with the
corners rounded in the same way, by toppra (Pham, Pham 2018), which is given a finer grid. Prints the ratio of durations
and how far either exceeds a limit at 1 kHz: toppra keeps them at grid points only. Exit code 1 when a ratio is above
1.05. Needs toppra (pip install ".[bench]").
"""

from __future__ import annotations

import argparse
import importlib.metadata
import logging
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
from toppra import algorithm, constraint
from toppra.interpolator import AbstractGeometricPath

import srmp
from srmp._files import write_json
from srmp._table import format_table
from srmp.bench import mbm

ALLOWED = 1.05
PER_STRAIGHT, PER_CORNER = 100, 20  # grid intervals of toppra's


class RoundedPath(AbstractGeometricPath):
    """Straight segments and parabolas from stop to stop; s is the time that it takes at full speed."""

    def __init__(self, pieces: list[tuple[np.ndarray, ...]]) -> None:
        self.lengths, self.starts, self.ways, self.bends = map(np.array, zip(*pieces, strict=True))
        self.begins = np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def dof(self) -> int:
        return self.starts.shape[1]

    @property
    def path_interval(self) -> np.ndarray:
        return self.begins[[0, -1]]

    @property
    def waypoints(self) -> tuple[np.ndarray, np.ndarray]:
        return self.begins, self(self.begins)

    def __call__(self, s: Any, order: int = 0) -> np.ndarray:
        i = np.clip(np.searchsorted(self.begins, s, side="right") - 1, 0, len(self.lengths) - 1)
        u = np.expand_dims(np.asarray(s) - self.begins[i], -1)
        if order == 0:
            return self.starts[i] + u * self.ways[i] + 0.5 * u**2 * self.bends[i]
        return self.ways[i] + u * self.bends[i] if order == 1 else self.bends[i]

    def grid(self) -> np.ndarray:
        counts = np.where(self.bends.any(axis=1), PER_CORNER, PER_STRAIGHT)
        inner = [np.linspace(*self.begins[i : i + 2], n, endpoint=False) for i, n in enumerate(counts)]
        return np.append(np.concatenate(inner), self.begins[-1])


def rounded(waypoints: np.ndarray, velocity: np.ndarray, deviation: float) -> list[RoundedPath]:
    """As src/srmp/trajectory/rounded_path.cpp says, where all is free and each joint reaches 1 m/rad."""
    steps = np.diff(waypoints, axis=0)
    lengths = np.abs(steps / velocity).max(axis=1)
    ways = steps / lengths[:, None]
    paths: list[list[tuple[np.ndarray, ...]]] = []
    before = 0.0
    for i, (length, way) in enumerate(zip(lengths, ways, strict=True)):
        after = 0.0
        if i + 1 < len(lengths):
            off, most = np.abs(ways[i + 1] - way).sum(), 0.5 * min(length, lengths[i + 1])
            after = min(most, 4.0 * deviation / off) if off > 0 else most
        if before == 0.0:
            paths.append([])
        if length - before - after > 1e-6 * length:
            paths[-1].append((length - before - after, waypoints[i] + before * way, way, 0 * way))
        if after > 0.0:
            corner = waypoints[i + 1] - after * way
            paths[-1].append((2 * after, corner, way, (ways[i + 1] - way) / (2 * after)))
        before = after
    return [RoundedPath(pieces) for pieces in paths]


def fastest(path: RoundedPath, velocity: np.ndarray, acceleration: np.ndarray) -> tuple[float, float]:
    """Toppra's duration [s], and the largest share of an acceleration limit that its pieces need at their ends."""
    limits = [
        constraint.JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    grid = path.grid()
    solver = algorithm.TOPPRA(limits, path, gridpoints=grid, solver_wrapper="seidel")
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    if speed is None:
        return float("nan"), float("nan")
    rate = np.diff(speed**2) / (2 * np.diff(grid))
    share = 0.0
    bend = path(grid[:-1], 2)  # of the piece after each point
    for end in (0, 1):
        tangent = path(grid[:-1], 1) + end * np.diff(grid)[:, None] * bend
        needed = tangent * rate[:, None] + bend * (speed[end : len(rate) + end, None] ** 2)
        share = max(share, float(np.abs(needed / acceleration).max()))
    return float(np.sum(2 * np.diff(grid) / (speed[:-1] + speed[1:]))), share


def random_path(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    dof, count = rng.integers(1, 9), rng.integers(2, 13)
    velocity = np.exp(rng.uniform(np.log(0.3), np.log(3.0), dof))
    acceleration = velocity * np.exp(rng.uniform(np.log(1.0), np.log(10.0), dof))
    steps = rng.uniform(-1.0, 1.0, (count, dof)) * rng.choice([0.1, 1.0], (count, 1))
    return np.cumsum(steps, axis=0), velocity, acceleration


def largest_share(trajectory: srmp.Trajectory, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    _, v, a, _ = trajectory.state(np.arange(trajectory.times[0], trajectory.times[-1], 1e-3))
    return float(max(np.abs(v / velocity).max(), np.abs(a / acceleration).max()))


def compare(rng: np.random.Generator, deviation: float) -> dict[str, Any]:
    waypoints, velocity, acceleration = random_path(rng)
    names = [f"joint{j}" for j in range(waypoints.shape[1])]
    limits = srmp.MotionLimits(velocity, acceleration, 100 * acceleration)
    mine = srmp.time_parameterize(waypoints, names, limits, blend_deviation=deviation)
    found = [fastest(path, velocity, acceleration) for path in rounded(waypoints, velocity, deviation)]
    theirs = sum(duration for duration, _ in found)
    return {
        "waypoints": len(waypoints),
        "dof": len(names),
        "deviation_m": deviation,
        "duration_s": mine.duration,
        "toppra_s": theirs,
        "ratio": mine.duration / theirs,
        "share": largest_share(mine, velocity, acceleration),
        "toppra_share": max(share for _, share in found),
    }


def run(paths: int, seed: int) -> dict[str, Any]:
    logging.getLogger("toppra").setLevel(logging.ERROR)
    rng = np.random.default_rng(seed)
    rows = [compare(rng, (0.005, 0.05)[i % 2]) for i in range(paths)]
    header = mbm.header("timing", options={"paths": paths, "seed": seed}, toppra=importlib.metadata.version("toppra"))
    return {"header": header, "rows": rows}


def table(result: dict[str, Any]) -> str:
    def line(name: str, rows: list[dict[str, Any]]) -> list[str]:
        ratios = [row["ratio"] for row in rows if np.isfinite(row["ratio"])]
        shares = [f"{100 * max(row[key] for row in rows):.3f} %" for key in ("share", "toppra_share")]
        quantiles = [f"{np.percentile(ratios, p):.4f}" for p in (0, 50, 95, 100)]
        return [name, f"{len(ratios)}/{len(rows)}", *quantiles, *shares]

    rows = result["rows"]
    by_deviation = {deviation: [row for row in rows if row["deviation_m"] == deviation] for deviation in (0.005, 0.05)}
    lines = [line(f"{1e3 * deviation:.0f} mm", group) for deviation, group in by_deviation.items() if group]
    header = ["blend", "timed by both", "least ratio", "median", "95 %", "largest", "limits used", "by toppra"]
    return format_table(header, [*lines, line("all", rows)])


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--paths", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    options = vars(parser.parse_args())
    out = options.pop("out")
    result = run(**options)
    print(table(result))
    if out:
        write_json(out, result)
    return 1 if any(row["ratio"] > ALLOWED for row in result["rows"]) else 0


if __name__ == "__main__":
    sys.exit(main())
