"""LeRobot's data set format, version 3.0: frames in Parquet files of many episodes, and relational metadata."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._files import write_json
from srmp.datasets.dataset import Dataset
from srmp.datasets.exporters.arrays import chunks
from srmp.datasets.exporters.frames import Motion, all_joint_names, motions
from srmp.datasets.schema import need_pyarrow

_EPISODES_PER_FILE = 1000
_FILES_PER_CHUNK = 1000
_COUNTERS = ("frame_index", "episode_index", "index", "task_index")


def to_lerobot(dataset: Dataset, out: Path) -> Iterator[int]:
    """A data set of LeRobot v3.0; yields how many episodes were written, file by file.

    An episode is a solved record, a frame one of its rows. observation.state: the configuration; action: that of the
    next row, where a policy should send the robot (the last row's own at the end), float32 as LeRobot has them. The
    task of an episode is the name of its scene. What LeRobot has no place for (scenes, certificates) stays in the data
    set: `srmp.index` of an episode is its record.
    """
    names = all_joint_names(dataset)
    period = float(srmp.planner_options(dict(dataset.spec.planner))["sample_period"])
    if abs(round(1 / period) - 1 / period) > 1e-6:
        raise srmp.InvalidArgument(
            f"planner.sample_period is {period:g} s; LeRobot counts whole frames per second, as 0.02 and 0.1 give."
        )
    tasks = {scene.name: k for k, scene in enumerate(dataset.spec.scenes)}
    statistics = {name: _Statistics() for name in ("observation.state", "action", "timestamp", *_COUNTERS)}
    episodes = frames = 0
    for number, some in enumerate(chunks(motions(dataset), _EPISODES_PER_FILE)):
        place = divmod(number, _FILES_PER_CHUNK)
        columns = _frames(some, tasks, episodes, frames)
        for name, values in columns.items():
            statistics[name].add(values)
        _write(out, "data", place, _frame_table(columns, len(names)))
        _write(out, "meta/episodes", place, _episode_table(some, episodes, frames, place))
        episodes += len(some)
        frames += len(columns["index"])
        yield len(some)
    _write_tasks(out, tasks)
    write_json(out / "meta" / "stats.json", {name: found.to_dict() for name, found in statistics.items() if frames})
    write_json(out / "meta" / "info.json", _info(names, round(1 / period), episodes, frames, len(tasks), dataset))


def _frames(some: list[Motion], tasks: dict[str, int], episodes: int, frames: int) -> dict[str, np.ndarray]:
    lengths = [len(motion.times) for motion in some]
    return {
        "observation.state": np.vstack([motion.positions for motion in some]).astype(np.float32),
        "action": np.vstack([_next(motion.positions) for motion in some]).astype(np.float32),
        "timestamp": np.concatenate([motion.times for motion in some]).astype(np.float32),
        "frame_index": np.concatenate([np.arange(length) for length in lengths]),
        "episode_index": np.repeat(np.arange(episodes, episodes + len(some)), lengths),
        "index": np.arange(frames, frames + sum(lengths)),
        "task_index": np.repeat([tasks[motion.scene] for motion in some], lengths),
    }


def _next(positions: np.ndarray) -> np.ndarray:
    return np.vstack([positions[1:], positions[-1:]])


def _frame_table(columns: dict[str, np.ndarray], dof: int) -> Any:
    pa = need_pyarrow()
    arrays = {}
    for name, values in columns.items():
        if values.ndim == 2:
            arrays[name] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), dof)
        else:
            arrays[name] = pa.array(values, pa.int64() if name in _COUNTERS else pa.float32())
    return pa.table(arrays)


def _episode_table(some: list[Motion], episodes: int, frames: int, place: tuple[int, int]) -> Any:
    pa = need_pyarrow()
    ends = frames + np.cumsum([len(motion.times) for motion in some])
    whole = {
        "episode_index": np.arange(episodes, episodes + len(some)),
        "length": [len(motion.times) for motion in some],
        "data/chunk_index": [place[0]] * len(some),
        "data/file_index": [place[1]] * len(some),
        "dataset_from_index": [frames, *ends[:-1]],
        "dataset_to_index": ends,
        "meta/episodes/chunk_index": [place[0]] * len(some),
        "meta/episodes/file_index": [place[1]] * len(some),
        "srmp.index": [motion.index for motion in some],
    }
    arrays = {name: pa.array(values, pa.int64()) for name, values in whole.items()}
    return pa.table({**arrays, "tasks": pa.array([[motion.scene] for motion in some], pa.list_(pa.string()))})


def _write_tasks(out: Path, tasks: dict[str, int]) -> None:
    """The tasks as pandas writes them with their texts as index, which is how LeRobot reads them."""
    pa = need_pyarrow()
    columns = [
        {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64"},
        {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object"},
    ]
    about = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [{**column, "metadata": None} for column in columns],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": None,
    }
    table = pa.table({"task_index": pa.array(list(tasks.values()), pa.int64()), "task": list(tasks)})
    (out / "meta").mkdir(parents=True, exist_ok=True)
    pa.parquet.write_table(table.replace_schema_metadata({"pandas": json.dumps(about)}), out / "meta/tasks.parquet")


def _write(out: Path, kind: str, place: tuple[int, int], table: Any) -> None:
    path = out / kind / f"chunk-{place[0]:03d}" / f"file-{place[1]:03d}.parquet"
    path.parent.mkdir(parents=True, exist_ok=True)
    need_pyarrow().parquet.write_table(table, path)


class _Statistics:
    """Least and greatest values, mean and standard deviation of rows that come in parts."""

    def __init__(self) -> None:
        self._count = 0

    def add(self, values: np.ndarray) -> None:
        rows = values.reshape(len(values), -1).astype(np.float64)
        low, high = rows.min(axis=0), rows.max(axis=0)
        total, squares = rows.sum(axis=0), (rows**2).sum(axis=0)
        if self._count:
            low, high = np.minimum(low, self._low), np.maximum(high, self._high)
            total, squares = total + self._total, squares + self._squares
        self._low, self._high, self._total, self._squares = low, high, total, squares
        self._count += len(rows)

    def to_dict(self) -> dict[str, Any]:
        mean = self._total / self._count
        variance = np.maximum(self._squares / self._count - mean**2, 0.0)
        return {"min": self._low, "max": self._high, "mean": mean, "std": np.sqrt(variance), "count": [self._count]}


def _info(names: list[str], fps: int, episodes: int, frames: int, tasks: int, dataset: Dataset) -> dict[str, Any]:
    vector = {"dtype": "float32", "shape": [len(names)], "names": names}
    single: dict[str, Any] = {"shape": [1], "names": None}
    path = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    return {
        "codebase_version": "v3.0",
        "robot_type": "_".join(dataset.joint_names),
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": tasks,
        "chunks_size": _FILES_PER_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{episodes}"},
        "data_path": f"data/{path}",
        "video_path": None,
        "features": {
            "observation.state": vector,
            "action": vector,
            "timestamp": {"dtype": "float32", **single},
            **{name: {"dtype": "int64", **single} for name in _COUNTERS},
        },
        "srmp": {"sha256": dataset.sha256, "identity": dataset.index["identity"]},
    }
