"""Writes solved motions of data sets in the formats of others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import srmp
from srmp._files import whole
from srmp._names import did_you_mean
from srmp.datasets.dataset import Dataset
from srmp.datasets.exporters.arrays import to_hdf5, to_numpy
from srmp.datasets.exporters.lerobot import to_lerobot
from srmp.datasets.exporters.webdataset import to_webdataset

TARGETS: dict[str, Callable[[Dataset, Path], Iterator[int]]] = {
    "numpy": to_numpy,
    "hdf5": to_hdf5,
    "webdataset": to_webdataset,
    "lerobot": to_lerobot,
}


def export(
    source: str | Path | Dataset,
    out: str | Path,
    target: str,
    *,
    progress: Callable[[int, int], object] | None = None,
) -> int:
    """Writes the solved motions of a data set in another format, completely or not at all; returns how many.

    source: a data set or its directory. out: a directory, with hdf5 a file, that does not exist. target: numpy, hdf5,
    webdataset or lerobot (v3.0). progress is called with the motions that are written and the records of the data set.

    Raises InvalidArgument for an unknown target; FileError where `out` exists or cannot be written; Error where h5py is
    missing.
    """
    if target not in TARGETS:
        hint = did_you_mean(target, TARGETS) or f"; known: {', '.join(TARGETS)}."
        raise srmp.InvalidArgument(f"target '{target}'{hint}")
    dataset = source if isinstance(source, Dataset) else Dataset(source)
    path = Path(out)
    if path.exists():
        raise srmp.FileError(f"{path} exists already; name a new one.")
    written = 0
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole(path) as part:
            for count in TARGETS[target](dataset, part):
                written += count
                if progress:
                    progress(written, len(dataset))
    except OSError as error:
        raise srmp.FileError(f"{path} cannot be written: {error.strerror or error}.") from error
    return written
