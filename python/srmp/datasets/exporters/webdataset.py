"""WebDataset: archives of files that belong together by name."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from srmp._files import plain
from srmp.datasets.dataset import Dataset
from srmp.datasets.exporters.arrays import chunks
from srmp.datasets.exporters.frames import Motion, all_joint_names, motions

_TOGETHER = 1000


def to_webdataset(dataset: Dataset, out: Path) -> Iterator[int]:
    """Archives motions-<number>.tar of 1000 motions; yields how many were written, archive by archive.

    Of each motion: <index>.positions.npy, .velocities.npy, .times.npy, and .json with index, scene, clearance, objects
    and joint names.
    """
    out.mkdir(parents=True)
    names = all_joint_names(dataset)
    for number, some in enumerate(chunks(motions(dataset), _TOGETHER)):
        with tarfile.open(out / f"motions-{number:06d}.tar", "w") as archive:
            for motion in some:
                for ending, data in _files(motion, names):
                    about = tarfile.TarInfo(f"{motion.index:09d}.{ending}")
                    about.size = len(data)
                    archive.addfile(about, io.BytesIO(data))
        yield len(some)


def _files(motion: Motion, joint_names: list[str]) -> Iterator[tuple[str, bytes]]:
    for name in ("positions", "velocities", "times"):
        data = io.BytesIO()
        np.save(data, getattr(motion, name))
        yield f"{name}.npy", data.getvalue()
    about = {key: getattr(motion, key) for key in ("index", "scene", "clearance", "objects")}
    yield "json", json.dumps(plain({**about, "joint_names": joint_names})).encode()
