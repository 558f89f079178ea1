"""Where packages of PyPI that hold robots have been installed."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path


def _srmp() -> Path | None:
    return Path(__file__).parents[1] / "data"


def _example_robot_data() -> Path | None:
    """share/ of cmeel's prefix: URIs of the meshes begin with package://example-robot-data."""
    for path in sys.path:
        share = Path(path) / "cmeel.prefix" / "share"
        if (share / "example-robot-data" / "robots").is_dir():
            return share
    return None


def _pybullet() -> Path | None:
    """pybullet_data, which the package pybullet brings."""
    spec = importlib.util.find_spec("pybullet_data")
    return Path(spec.origin).parent if spec and spec.origin else None


PACKAGES: dict[str, Callable[[], Path | None]] = {
    "srmp-cpp": _srmp,
    "example-robot-data": _example_robot_data,
    "pybullet": _pybullet,
}
