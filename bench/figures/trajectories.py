"""Draws the figures of docs/trajectories.md.

python bench/figures/trajectories.py [DIRECTORY, default: docs]

Writes rounded-corner.png and profiles.png. Needs matplotlib (pip install ".[bench]").
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import srmp
from srmp import demo

WAYPOINTS = np.array([[0.0, 0.0], [0.15, 0.0], [0.2, 0.12]])  # two joints [rad], each of which reaches 1 m
LIMITS = srmp.MotionLimits([1.0, 1.0], [3.0, 3.0], [50.0, 50.0])
BLENDS = {0.0: "stop at the corner", 0.005: "5 mm", 0.02: "20 mm"}


def rounded_corner(path: Path) -> None:
    figure, (path_axes, speed_axes) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    path_axes.plot(*WAYPOINTS.T, "-", color="0.75", linewidth=5, solid_capstyle="round", label="checked path")
    for blend, name in BLENDS.items():
        motion = srmp.time_parameterize(WAYPOINTS, ["a", "b"], LIMITS, blend_deviation=blend)
        times = np.linspace(0.0, motion.duration, 2000)
        positions, velocities, _, _ = motion.state(times)
        (line,) = path_axes.plot(*positions.T, linewidth=1.3)
        path_axes.plot(*motion.positions.T, ".", color=line.get_color(), markersize=5)
        speed_axes.plot(
            times, np.linalg.norm(velocities, axis=1), color=line.get_color(), label=f"{name}: {times[-1]:.2f} s"
        )
    path_axes.set(
        xlabel="joint a [rad]", ylabel="joint b [rad]", xlim=(0.09, 0.19), ylim=(-0.008, 0.06), title="around a corner"
    )
    path_axes.set_aspect("equal")
    path_axes.legend(loc="upper left", frameon=False)
    speed_axes.set(
        xlabel="time [s]", ylabel="speed [rad/s]", ylim=(0, 1.05), title="the less it leaves the path, the slower"
    )
    speed_axes.legend(loc="upper left", frameon=False)
    figure.savefig(path, dpi=110)


def profiles(path: Path) -> None:
    demo.run().trajectory.plot(str(path), title="srmp demo")


def shrink(path: Path, width: int) -> None:
    """Scales the image and reduces it to 64 colours, to keep the repository small."""
    with Image.open(path) as image:
        small = image.convert("RGB").resize(
            (width, round(image.height * width / image.width)), Image.Resampling.LANCZOS
        )
    small.quantize(64).save(path, optimize=True)


def main() -> None:
    directory = Path(sys.argv[1] if len(sys.argv) > 1 else "docs")
    rounded_corner(directory / "rounded-corner.png")
    profiles(directory / "profiles.png")
    for name in ("rounded-corner.png", "profiles.png"):
        shrink(directory / name, 900)


if __name__ == "__main__":
    main()
