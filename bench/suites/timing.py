"""Compares the durations of timed paths with those of the `toppra` Python package on the same paths.

    python bench/suites/timing.py [--paths 200] [--seed 1] [--out timing.json]

Random paths (2 to 12 waypoints, 1 to 8 joints, limits of all sizes) are timed by srmp.time_parameterize and, with the
same rounded corners, by toppra (Pham, Pham 2018) on a finer grid. Prints the ratio of durations and the largest use of
a limit at 1 kHz, which may exceed 100 % for toppra, because toppra enforces limits at grid points only. The exit code
is 1 when a ratio is above 1.05. Needs toppra (pip install ".[bench]").
"""

from __future__ import annotations

import argparse
import importlib.metadata
import logging
import re
import sys
from typing import Any

import numpy as np
from report import run_and_report
from toppra import algorithm, constraint
from toppra.interpolator import AbstractGeometricPath

import srmp
from srmp._table import format_table
from srmp.bench import mbm

ALLOWED = 1.05
PER_STRAIGHT, PER_CORNER = 100, 20  # intervals of toppra's grid for a straight segment, for a corner


class RoundedPath(AbstractGeometricPath):
    """Straight segments and parabolas between two stops; s is the time at full speed."""

    def __init__(self, segments: list[tuple[np.ndarray, ...]]) -> None:
        self.lengths, self.starts, self.directions, self.curvatures = map(np.array, zip(*segments, strict=True))
        self.knots = np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def dof(self) -> int:
        return self.starts.shape[1]

    @property
    def path_interval(self) -> np.ndarray:
        return self.knots[[0, -1]]

    @property
    def waypoints(self) -> tuple[np.ndarray, np.ndarray]:
        return self.knots, self(self.knots)

    def __call__(self, s: Any, order: int = 0) -> np.ndarray:
        i = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.lengths) - 1)
        u = np.expand_dims(np.asarray(s) - self.knots[i], -1)
        if order == 0:
            return self.starts[i] + u * self.directions[i] + 0.5 * u**2 * self.curvatures[i]
        return self.directions[i] + u * self.curvatures[i] if order == 1 else self.curvatures[i]

    def grid(self) -> np.ndarray:
        counts = np.where(self.curvatures.any(axis=1), PER_CORNER, PER_STRAIGHT)
        inner = [np.linspace(*self.knots[i : i + 2], n, endpoint=False) for i, n in enumerate(counts)]
        return np.append(np.concatenate(inner), self.knots[-1])


def rounded(waypoints: np.ndarray, velocity: np.ndarray, deviation: float) -> list[RoundedPath]:
    """Rounds corners as srmp does (trajectory/rounded_path.cpp) where everything is free and joints reach 1 m/rad."""
    steps = np.diff(waypoints, axis=0)
    lengths = np.abs(steps / velocity).max(axis=1)
    directions = steps / lengths[:, None]
    paths: list[list[tuple[np.ndarray, ...]]] = []
    before = 0.0
    for i, (length, direction) in enumerate(zip(lengths, directions, strict=True)):
        after = 0.0
        if i + 1 < len(lengths):
            change, longest = np.abs(directions[i + 1] - direction).sum(), 0.5 * min(length, lengths[i + 1])
            after = min(longest, 4.0 * deviation / change) if change > 0 else longest
        if before == 0.0:
            paths.append([])
        if length - before - after > 1e-6 * length:
            paths[-1].append((length - before - after, waypoints[i] + before * direction, direction, 0 * direction))
        if after > 0.0:
            corner = waypoints[i + 1] - after * direction
            paths[-1].append((2 * after, corner, direction, (directions[i + 1] - direction) / (2 * after)))
        before = after
    return [RoundedPath(segments) for segments in paths]


def fastest(path: RoundedPath, velocity: np.ndarray, acceleration: np.ndarray) -> tuple[float, float]:
    """Toppra's duration [s], and the largest fraction of an acceleration limit used at the ends of its intervals."""
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
    limit_use = 0.0
    curvature = path(grid[:-1], 2)  # of the interval after each grid point
    for end in (0, 1):
        tangent = path(grid[:-1], 1) + end * np.diff(grid)[:, None] * curvature
        required = tangent * rate[:, None] + curvature * (speed[end : len(rate) + end, None] ** 2)
        limit_use = max(limit_use, float(np.abs(required / acceleration).max()))
    return float(np.sum(2 * np.diff(grid) / (speed[:-1] + speed[1:]))), limit_use


def random_path(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    dof, count = rng.integers(1, 9), rng.integers(2, 13)
    velocity = np.exp(rng.uniform(np.log(0.3), np.log(3.0), dof))
    acceleration = velocity * np.exp(rng.uniform(np.log(1.0), np.log(10.0), dof))
    steps = rng.uniform(-1.0, 1.0, (count, dof)) * rng.choice([0.1, 1.0], (count, 1))
    return np.cumsum(steps, axis=0), velocity, acceleration


def largest_limit_use(trajectory: srmp.Trajectory, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    _, v, a, _ = trajectory.state(np.arange(trajectory.times[0], trajectory.times[-1], 1e-3))
    return float(max(np.abs(v / velocity).max(), np.abs(a / acceleration).max()))


def compare(rng: np.random.Generator, deviation: float) -> dict[str, Any]:
    waypoints, velocity, acceleration = random_path(rng)
    names = [f"joint{j}" for j in range(waypoints.shape[1])]
    limits = srmp.MotionLimits(velocity, acceleration, 100 * acceleration)
    trajectory = srmp.time_parameterize(waypoints, names, limits, blend_deviation=deviation)
    found = [fastest(path, velocity, acceleration) for path in rounded(waypoints, velocity, deviation)]
    toppra_duration = sum(duration for duration, _ in found)
    return {
        "waypoints": len(waypoints),
        "dof": len(names),
        "deviation_m": deviation,
        "duration_s": trajectory.duration,
        "toppra_s": toppra_duration,
        "ratio": trajectory.duration / toppra_duration,
        "limit_use": largest_limit_use(trajectory, velocity, acceleration),
        "toppra_limit_use": max(limit_use for _, limit_use in found),
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
        uses = [f"{100 * max(row[key] for row in rows):.3f} %" for key in ("limit_use", "toppra_limit_use")]
        quantiles = [f"{np.percentile(ratios, p):.4f}" for p in (0, 50, 95, 100)]
        return [name, f"{len(ratios)}/{len(rows)}", *quantiles, *uses]

    rows = result["rows"]
    by_deviation = {deviation: [row for row in rows if row["deviation_m"] == deviation] for deviation in (0.005, 0.05)}
    lines = [line(f"{1e3 * deviation:.0f} mm", group) for deviation, group in by_deviation.items() if group]
    header = ["blend", "timed by both", "smallest ratio", "median", "95 %", "largest", "limits used", "by toppra"]
    return format_table(header, [*lines, line("all", rows)])


def main() -> int:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--paths", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    result = run_and_report(parser, run, table)
    return 1 if any(row["ratio"] > ALLOWED for row in result["rows"]) else 0


if __name__ == "__main__":
    sys.exit(main())
