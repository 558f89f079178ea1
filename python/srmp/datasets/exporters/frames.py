"""What all exporters take from records: solved motions of all robots as one table of rows a period apart."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from srmp.datasets.dataset import Dataset


@dataclass(frozen=True)
class Motion:
    """A solved record: rows (n, dof) of all robots side by side, which rest where their motions end."""

    index: int
    scene: str
    times: np.ndarray
    """(n,) [s]."""
    positions: np.ndarray
    """[rad or m]."""
    velocities: np.ndarray
    """[rad/s or m/s]."""
    goal: np.ndarray
    """The last configuration, (dof,)."""
    clearance: float
    """[m]: the least that the certificates prove."""
    objects: list[dict]
    """As in the shard."""


def motions(dataset: Dataset) -> Iterator[Motion]:
    """The solved records, one after the other."""
    for record in dataset:
        if not record.solved:
            continue
        rows = [record.robot(name) for name in dataset.joint_names]
        times = max((row["times"] for row in rows), key=len)
        positions = np.hstack([_extended(row["positions"], len(times)) for row in rows])
        velocities = np.hstack([_extended(row["velocities"], len(times)) for row in rows])
        clearance = min(row["certificate"]["clearance_proved"] for row in rows)
        values = record.values
        yield Motion(
            record.index, record.scene, times, positions, velocities, positions[-1], clearance, values["objects"]
        )


def _extended(table: np.ndarray, rows: int) -> np.ndarray:
    """The table with its last row repeated, which is at rest."""
    return np.vstack([table, np.repeat(table[-1:], rows - len(table), axis=0)])


def all_joint_names(dataset: Dataset) -> list[str]:
    """Names of the columns: of joints, with the robot's name before them where there are several."""
    several = len(dataset.joint_names) > 1
    return [f"{name}/{joint}" if several else joint for name, joints in dataset.joint_names.items() for joint in joints]
