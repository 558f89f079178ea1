"""NumPy archives and HDF5."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp.datasets.dataset import Dataset
from srmp.datasets.exporters.frames import Motion, all_joint_names, motions

_TOGETHER = 1000


def chunks(items: Iterable[Motion], size: int) -> Iterator[list[Motion]]:
    """The motions in lists of at most `size`."""
    rest = iter(items)
    while some := list(itertools.islice(rest, size)):
        yield some


def to_numpy(dataset: Dataset, out: Path) -> Iterator[int]:
    """Archives motions-<number>.npz of 1000 motions, padded, with a mask; yields how many were written, chunk by chunk.

    positions, velocities (n, rows, dof); times (n, rows); mask (n, rows), False where a row is padding (the last row
    again); goal (n, dof); index, scene, clearance (n,); joint_names (dof,).
    """
    out.mkdir(parents=True)
    for number, some in enumerate(chunks(motions(dataset), _TOGETHER)):
        rows = max(len(motion.times) for motion in some)
        arrays: dict[str, Any] = {
            name: np.stack([_padded(getattr(motion, name), rows) for motion in some])
            for name in ("times", "positions", "velocities")
        }
        arrays["mask"] = np.stack([np.arange(rows) < len(motion.times) for motion in some])
        for name in ("goal", "index", "scene", "clearance"):
            arrays[name] = np.array([getattr(motion, name) for motion in some])
        np.savez_compressed(out / f"motions-{number:06d}.npz", joint_names=all_joint_names(dataset), **arrays)
        yield len(some)


def _padded(table: np.ndarray, rows: int) -> np.ndarray:
    return np.concatenate([table, np.repeat(table[-1:], rows - len(table), axis=0)])


def to_hdf5(dataset: Dataset, out: Path) -> Iterator[int]:
    """One file: rows of all motions one after the other, and where each begins; yields how many were written.

    times (rows,), positions and velocities (rows, dof); first_row, rows, index, scene, clearance (n,), goal (n, dof).
    Attributes: joint_names, sha256 of the data set.
    """
    try:
        import h5py
    except ModuleNotFoundError as error:
        raise srmp.Error('HDF5 needs h5py: pip install ".[hdf5]" in a checkout (or pip install h5py).') from error
    dof = len(all_joint_names(dataset))
    widths = {"times": (), "positions": (dof,), "velocities": (dof,), "goal": (dof,)}
    types = {"first_row": np.int64, "rows": np.int64, "index": np.int64, "scene": h5py.string_dtype()}
    with h5py.File(out, "w-") as file:
        file.attrs["joint_names"], file.attrs["sha256"] = all_joint_names(dataset), dataset.sha256
        tables = {}
        for name in ("times", "positions", "velocities", "goal", "first_row", "rows", "index", "scene", "clearance"):
            width = widths.get(name, ())
            kind = types.get(name, np.float64)
            tables[name] = file.create_dataset(name, (0, *width), kind, maxshape=(None, *width), chunks=(1024, *width))
        for some in chunks(motions(dataset), _TOGETHER):
            lengths = np.array([len(motion.times) for motion in some])
            begin = len(tables["times"])
            columns: dict[str, Any] = {
                name: np.concatenate([getattr(motion, name) for motion in some])
                for name in ("times", "positions", "velocities")
            }
            columns["first_row"], columns["rows"] = begin + np.cumsum(lengths) - lengths, lengths
            for name in ("goal", "index", "scene", "clearance"):
                columns[name] = [getattr(motion, name) for motion in some]
            for name, values in columns.items():
                table = tables[name]
                table.resize(len(table) + len(values), axis=0)
                table[-len(values) :] = values
            yield len(some)
