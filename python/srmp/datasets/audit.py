"""Audits a data set without the planner: files, schema, limits, starts, goals and collisions of its motions.

Positions, velocities and accelerations are those of the cubics between the rows, by code of srmp.recheck; collisions
and distances are by Pinocchio's and Coal's own packages.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp.datasets.dataset import Dataset, arrays_of
from srmp.datasets.motion_checks import MotionChecks
from srmp.datasets.schema import CERTIFICATE, SCHEMA_VERSION, need_pyarrow, schema
from srmp.datasets.spec import identity_of
from srmp.datasets.store import Shard, hash_of, parse_shard_name, read_index, read_shards, shard_name

STATUSES = (
    "solved",
    "timed_out",
    "exhausted",
    "start_invalid",
    "goal_invalid",
    "not_certified",
    "no_problem",
    "skipped",
)


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with a data set."""

    where: str
    """A file, or "record 17"."""
    text: str
    """What is wrong, as a sentence."""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"


@dataclass
class Audit:
    """What an audit found."""

    directory: Path
    records: int = 0
    """That were read."""
    checked: int = 0
    """Whose motions were checked for collisions."""
    faults: list[Fault] = field(default_factory=list)
    more_faults: int = 0
    """Beyond those that are listed."""
    statuses: dict[str, Counter[str]] = field(default_factory=dict)
    """By scene: how many records ended with each status."""
    figures: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in FIGURES})
    """Of solved records, by name of FIGURES."""

    @property
    def passed(self) -> bool:
        """Whether there are no faults."""
        return not self.faults


FIGURES = {"length": "rad", "duration": "s", "clearance": "m", "waypoints": ""}
_MAX_FAULTS = 1000


def audit(
    directory: str | Path, *, sample: int | None = 1000, progress: Callable[[int, int], object] | None = None
) -> Audit:
    """Checks a data set without the planner: every file, every record, and the collisions of a sample of the records.

    sample: how many records' motions are checked for collisions, spread evenly; None: all. progress is called with the
    records that were read and all. Faults are listed, not raised.

    Raises FileError where there is no data set, Error where the packages pyarrow, pin or coal are missing.
    """
    need_pyarrow()
    if sample is not None and sample < 0:
        raise srmp.InvalidArgument(f"sample {sample}: it must not be below 0.")
    auditor = _Auditor(Path(directory))
    auditor.check_files()
    auditor.check_records(sample, progress)
    return auditor.result


class _Auditor:
    def __init__(self, directory: Path) -> None:
        self.result = Audit(directory)
        self._directory = directory
        self._index = read_index(directory)
        self._shards = read_shards(self._index)

    def _fault(self, where: str, text: str) -> None:
        if len(self.result.faults) < _MAX_FAULTS:
            self.result.faults.append(Fault(where, text))
        else:
            self.result.more_faults += 1

    # --- files

    def check_files(self) -> None:
        """Checks index.json, the files that the data set carries, and that all shards are there."""
        index, spec = self._index, self._index["spec"]
        for name, sha256 in spec.get("files", {}).items():
            path = self._directory / name
            if not path.is_file():
                self._fault(name, "the file is missing.")
            elif hashlib.sha256(path.read_bytes()).hexdigest() != sha256:
                self._fault(name, "its content is not what the index says.")
        if identity_of(spec) != index["identity"]:
            self._fault("index.json", "the spec was changed after the data set was begun.")
        if hash_of(self._shards) != index["sha256"]:
            self._fault("index.json", "its hash is not that of its shards.")
        if index["records"] != sum(shard.records for shard in self._shards):
            self._fault("index.json", "its number of records is not that of its shards.")
        self._check_numbers(int(spec["count"]), int(spec["records_per_shard"]))
        listed = {shard.name for shard in self._shards}
        for path in sorted(self._directory.iterdir()):
            if path.suffix == ".part" or (parse_shard_name(path.name) and path.name not in listed):
                self._fault(path.name, "the index does not list this file.")

    def _check_numbers(self, count: int, per_shard: int) -> None:
        expected = -(-count // per_shard)
        there = Counter(shard.number for shard in self._shards)
        for number in range(expected):
            if there[number] != 1:
                times = "is not in the index" if not there[number] else f"is {there[number]} times in the index"
                self._fault("index.json", f"shard {number} of {expected} {times}.")
        for shard in self._shards:
            if not 0 <= shard.number < expected:
                self._fault("index.json", f"shard {shard.number} is none of the {expected} of the spec.")
            if shard.name != shard_name(shard.number, shard.sha256):
                self._fault(shard.name, "its name does not have its number and its hash.")

    # --- records

    def check_records(self, sample: int | None, progress: Callable[[int, int], object] | None) -> None:
        """Reads all shards, one after the other."""
        total = sum(shard.records for shard in self._shards)
        every = 1 if sample is None else math.inf if sample == 0 else max(1.0, total / sample)
        checks = self._motion_checks()
        next_checked = 0.0
        for shard in self._shards:
            for place, record in enumerate(self._read(shard)):
                self._check_place(shard, place, record)
                complete = self._check_record(record)
                if complete and record["status"] == "solved" and checks:
                    sampled = every < math.inf and self.result.records >= next_checked
                    self._check_motions(checks, record, collisions=sampled)
                    if sampled:
                        self.result.checked += 1
                        next_checked += every
                self.result.records += 1
                if progress:
                    progress(self.result.records, total)

    def _motion_checks(self) -> MotionChecks | None:
        try:
            return MotionChecks(Dataset(self._directory))
        except (srmp.FileError, srmp.InvalidArgument, OSError, KeyError, TypeError) as error:
            self._fault("robots", f"the robots cannot be read, so that no motion was checked: {error}")
            return None

    def _read(self, shard: Shard) -> Iterator[dict[str, Any]]:
        path = self._directory / shard.name
        if not path.is_file():
            self._fault(shard.name, "the shard is missing.")
            return
        if hashlib.sha256(path.read_bytes()).hexdigest() != shard.sha256:
            self._fault(shard.name, "its content is not what its hash says.")
        pa = need_pyarrow()
        try:
            file = pa.parquet.ParquetFile(path)
            about = {key.decode(): value.decode() for key, value in (file.schema_arrow.metadata or {}).items()}
            if about.get("srmp.schema_version") != str(SCHEMA_VERSION):
                self._fault(shard.name, f"its schema has version {about.get('srmp.schema_version')}.")
            if about.get("srmp.spec") != self._index["identity"]:
                self._fault(shard.name, "it was made from another spec.")
            if not file.schema_arrow.equals(schema()):
                self._fault(shard.name, "its columns are not those of the schema.")
                return
            if file.metadata.num_rows != shard.records:
                self._fault(shard.name, f"it has {file.metadata.num_rows} records; the index says {shard.records}.")
            for group in range(file.num_row_groups):
                yield from file.read_row_group(group).to_pylist()
        except (OSError, pa.ArrowException, UnicodeDecodeError) as error:
            self._fault(shard.name, f"it cannot be read as Parquet: {' '.join(str(error).split())}")

    def _check_place(self, shard: Shard, place: int, record: Mapping[str, Any]) -> None:
        expected = shard.number * int(self._index["spec"]["records_per_shard"]) + place
        if record["index"] != expected:
            self._fault(shard.name, f"record {record['index']} is where record {expected} belongs.")
        if record["seed"] != self._index["identity"][:32]:
            self._fault(f"record {record['index']}", "its seed is not that of the spec.")
        if json.loads(record["versions"]) != self._index["versions"]:
            self._fault(f"record {record['index']}", "its versions are not those of the index.")

    def _check_record(self, record: Mapping[str, Any]) -> bool:
        """Status, reason and what must be there; False where its motions cannot be checked."""
        where = f"record {record['index']}"
        counts = self.result.statuses.setdefault(record["scene"], Counter())
        counts[record["status"]] += 1
        before = len(self.result.faults)
        scenes = {scene["name"]: scene["kind"] for scene in self._index["spec"]["scenes"]}
        if scenes.get(record["scene"]) != record["kind"]:
            self._fault(where, f"its scene '{record['scene']}' of kind '{record['kind']}' is none of the spec.")
        if record["status"] not in STATUSES:
            self._fault(where, f"its status '{record['status']}' is none that there is.")
        if (record["status"] == "skipped") != (record["index"] in self._index["spec"]["skip"]):
            self._fault(where, "it is not one that the spec skips, or it is one, and was not skipped.")
        solved = record["status"] == "solved"
        if solved == bool(record["reason"]):
            self._fault(where, "it is solved and gives a reason." if solved else "it failed without a reason.")
        names = [robot["name"] for robot in self._index["spec"]["robots"]]
        if record["status"] not in ("no_problem", "skipped") and [row["name"] for row in record["robots"]] != names:
            self._fault(where, f"its robots are not {', '.join(names)}.")
        for row in record["robots"]:
            present = [key for key in ("times", "positions", "velocities", "waypoints", "certificate") if row[key]]
            if solved and len(present) < 5:
                self._fault(where, f"it is solved, but '{row['name']}' has no whole trajectory with its certificate.")
            elif not solved and present:
                self._fault(where, f"it failed, but '{row['name']}' has {present[0]}.")
            elif solved:
                self._check_certificate(where, row)
        return len(self.result.faults) == before

    def _check_certificate(self, where: str, row: Mapping[str, Any]) -> None:
        proof = row["certificate"]
        if any(proof[key] is None for key in CERTIFICATE):
            self._fault(where, f"the certificate of '{row['name']}' is not whole.")
        elif not (proof["holds"] and proof["proved_free"]):
            self._fault(where, f"the certificate of '{row['name']}' does not hold, or leaves parts unproved.")
        elif proof["clearance_proved"] > proof["clearance"]:
            self._fault(where, f"the certificate of '{row['name']}' proves more clearance than it found.")

    def _check_motions(self, checks: MotionChecks, record: Mapping[str, Any], *, collisions: bool) -> None:
        where = f"record {record['index']}"
        rows = [arrays_of(row) for row in record["robots"]]
        faults = [fault for row in rows for fault in checks.faults_of(row)]
        if not faults and collisions:
            faults = checks.collisions_of(rows, record["objects"])
        for text in faults:
            self._fault(where, text)
        figures = self.result.figures
        figures["length"].append(
            sum(float(np.linalg.norm(np.diff(r["waypoints"], axis=0), axis=1).sum()) for r in rows)
        )
        figures["duration"].append(max(float(row["times"][-1]) for row in rows))
        figures["clearance"].append(min(row["certificate"]["clearance"] for row in rows))
        figures["waypoints"].append(sum(len(row["waypoints"]) for row in rows))
