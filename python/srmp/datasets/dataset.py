"""Reads data sets: lazily one record after the other, any record by its index, failures, whole columns."""

from __future__ import annotations

import bisect
import functools
import operator
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._names import did_you_mean
from srmp.datasets.scene import SceneObject
from srmp.datasets.schema import need_pyarrow, schema
from srmp.datasets.spec import Spec
from srmp.datasets.store import read_index, read_shards

_ARRAYS = ("positions", "velocities", "waypoints")


class RecordMissing(srmp.InvalidArgument, IndexError):
    """There is no record at this place."""


def open(directory: str | Path) -> Dataset:
    """The data set in a directory, complete or not. Raises FileError where there is none that can be read."""
    return Dataset(directory)


class Record:
    """One record: a problem with its trajectories, or with the reason why it has none."""

    def __init__(self, values: dict[str, Any], dataset: Dataset) -> None:
        self.values = values
        """As the shard holds it: the fields of docs/datasets.md."""
        self._dataset = dataset

    def __repr__(self) -> str:
        return f"<Record {self.index}: {self.scene}, {self.status}>"

    @property
    def index(self) -> int:
        """Its place in the data set, from 0."""
        return self.values["index"]

    @property
    def scene(self) -> str:
        """The name of the spec's scene that it was drawn from."""
        return self.values["scene"]

    @property
    def status(self) -> str:
        """solved, or how it failed."""
        return self.values["status"]

    @property
    def reason(self) -> str:
        """Why it has no trajectory, as a sentence; "" where it has."""
        return self.values["reason"]

    @property
    def solved(self) -> bool:
        """Whether it has a certified trajectory of every robot."""
        return self.status == "solved"

    @property
    def objects(self) -> list[SceneObject]:
        """The objects of its scene."""
        return [SceneObject.from_dict(item) for item in self.values["objects"]]

    def robot(self, name: str | None = None) -> dict[str, Any]:
        """What it holds of a robot (default: the only one), arrays as NumPy: times (n,), positions (n, dof), …

        Raises InvalidArgument for an unknown name, or none where there are several robots.
        """
        rows = {row["name"]: row for row in self.values["robots"]}
        if name is None and len(rows) == 1:
            name = next(iter(rows))
        if name is None or name not in rows:
            what = "name the robot" if name is None else f"record {self.index} has no robot '{name}'"
            raise srmp.InvalidArgument(f"{what}{did_you_mean(name, rows) or ''}; it has {', '.join(rows) or 'none'}.")
        return arrays_of(rows[name])

    def trajectory(self, robot: str | None = None) -> srmp.Trajectory:
        """The trajectory of a robot, without its certificate. Raises InvalidArgument where there is none."""
        row = self.robot(robot)
        if row["positions"] is None:
            raise srmp.InvalidArgument(f"record {self.index} has no trajectory: {self.status}: {self.reason}")
        names = self._dataset.joint_names[row["name"]]
        return srmp.Trajectory(names, row["positions"], row["times"], row["velocities"], waypoints=row["waypoints"])

    def planner(self) -> srmp.PlannerInterface:
        """A new world with its robots at their starts and its objects."""
        planner = self._dataset.robots()
        for item in self.objects:
            item.add_to(planner)
        for row in self.values["robots"]:
            planner.set_qpos(row["name"], row["start"])
        return planner


def arrays_of(row: dict[str, Any]) -> dict[str, Any]:
    """A robot's row with NumPy arrays in their shapes."""
    arrays = {key: None if row[key] is None else np.array(row[key]) for key in ("start", "goal", "goal_pose", "times")}
    dof = len(row["start"])
    tables = {key: None if row[key] is None else np.reshape(row[key], (-1, dof)) for key in _ARRAYS}
    return {**row, **arrays, **tables}


class Dataset:
    """A data set: a sequence of records that is read shard by shard, only as far as it is used."""

    def __init__(self, directory: str | Path) -> None:
        need_pyarrow()
        self.directory = Path(directory)
        self.index = read_index(self.directory)
        """The content of index.json."""
        self.shards = read_shards(self.index)
        self._ends = np.cumsum([shard.records for shard in self.shards]).tolist()

    def __repr__(self) -> str:
        return f"<Dataset {self.directory}: {len(self)} records in {len(self.shards)} shards>"

    def __len__(self) -> int:
        """The records that are there."""
        return self._ends[-1] if self._ends else 0

    @property
    def complete(self) -> bool:
        """Whether all records of the spec are there."""
        return bool(self.index["complete"])

    @property
    def sha256(self) -> str:
        """Of all shards together."""
        return self.index["sha256"]

    @functools.cached_property
    def spec(self) -> Spec:
        """The spec that it was made from, with the files that it carries."""
        names = self.index["spec"]["files"]
        return Spec.from_dict(self.index["spec"], {name: (self.directory / name).read_bytes() for name in names})

    def robots(self) -> srmp.PlannerInterface:
        """A new world with the robots alone."""
        planner = srmp.PlannerInterface()
        for robot in self.spec.robots:
            robot.add_to(planner, self.directory)
        return planner

    @functools.cached_property
    def joint_names(self) -> dict[str, list[str]]:
        """The joint names of each robot, in the order of configurations."""
        planner = self.robots()
        return {name: planner.get_joint_names(name) for name in planner.robot_names}

    def __iter__(self) -> Iterator[Record]:
        """The records in their order; no more than a few are in memory."""
        for shard in range(len(self.shards)):
            file = self._file(shard)
            for group in range(file.num_row_groups):
                for values in file.read_row_group(group).to_pylist():
                    yield Record(values, self)

    def __getitem__(self, place: int) -> Record:
        """The record at a place, which is its index in a data set without gaps; negative: from the end."""
        try:
            number = operator.index(place)
        except TypeError as error:
            raise srmp.InvalidArgument(f"record {place!r}: a record is named by a whole number.") from error
        number = number + len(self) if number < 0 else number
        if not 0 <= number < len(self):
            raise RecordMissing(f"record {place}: the data set has {len(self)}.")
        shard = bisect.bisect_right(self._ends, number)
        within = number - (self._ends[shard - 1] if shard else 0)
        file = self._file(shard)
        for group in range(file.num_row_groups):
            rows = file.metadata.row_group(group).num_rows
            if within < rows:
                return Record(self._group(shard, group).slice(within, 1).to_pylist()[0], self)
            within -= rows
        raise srmp.FileError(f"{self.shards[shard].name} has fewer records than the index says.")

    def table(self, columns: Sequence[str] | None = None) -> Any:
        """The records, or these columns of them, as one pyarrow.Table: to join, group and filter."""
        pa = need_pyarrow()
        known = schema().names
        for column in columns or ():
            if column.split(".")[0] not in known:
                hint = did_you_mean(column, known) or f"; known: {', '.join(known)}."
                raise srmp.InvalidArgument(f"there is no column '{column}'{hint}")
        parts = [self._file(k).read(columns=columns) for k in range(len(self.shards))]
        return pa.concat_tables(parts).replace_schema_metadata(None) if parts else schema().empty_table()

    def failures(self) -> Any:
        """Index, scene, status and reason of records without a trajectory: a pyarrow.Table, to join by `index`."""
        pa = need_pyarrow()
        table = self.table(["index", "scene", "kind", "status", "reason", "attempts"])
        return table.filter(pa.compute.not_equal(table["status"], "solved"))

    def _file(self, shard: int) -> Any:
        path = self.directory / self.shards[shard].name
        pa = need_pyarrow()
        try:
            return pa.parquet.ParquetFile(path)
        except (OSError, pa.ArrowException) as error:
            raise srmp.FileError(f"{path} cannot be read: {error}.") from error

    @functools.lru_cache(maxsize=4)  # noqa: B019  (a few row groups, for reads of neighbours)
    def _group(self, shard: int, group: int) -> Any:
        return self._file(shard).read_row_group(group)
