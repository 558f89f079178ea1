"""Makes a data set: shards that are not there yet, by workers, until all are."""

from __future__ import annotations

import datetime
import os
import resource
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import srmp
from srmp.datasets.recorder import MadeShard
from srmp.datasets.schema import need_pyarrow
from srmp.datasets.spec import Spec, read_spec
from srmp.datasets.store import Store, hash_of
from srmp.datasets.workers import made_by_processes, made_by_ray, made_here

_INDEX_PERIOD = 10.0  # [s]; the index is also written at the end
_LISTED = 10  # records in a message


@dataclass(frozen=True)
class Generated:
    """What generate made."""

    directory: Path
    records: int
    """Of the data set."""
    made: int
    """By this call; the others were there."""
    solved: int
    """Of those that this call made."""
    seconds: float
    sha256: str
    """Of the whole data set: the same for the same spec and versions."""


def generate(
    spec: str | Path | Mapping[str, Any] | Spec,
    directory: str | Path,
    *,
    workers: int | None = None,
    ray: str | None = None,
    progress: Callable[[int, int], object] | None = None,
    order: Callable[[Sequence[int]], Sequence[int]] | None = None,
) -> Generated:
    """Makes the data set of a spec in a directory, or goes on with it; shards that are whole are kept.

    spec: a YAML file, a dictionary laid out like one, or a Spec. workers: processes, default one for each core; 1: this
    process alone. ray: address of a Ray cluster, whose workers need no common file system. progress is called with the
    records that are there and all. order: the order in which shards are made, which does not matter to their content.

    Raises InvalidArgument for a spec that is wrong, naming the field; FileError where the directory cannot be written,
    is full, in use, or holds another data set; Error where a package is missing, or workers die without end, or,
    once all other shards are there, where records reached the time limit of their plans.
    """
    need_pyarrow()
    if workers is not None and workers < 1:
        raise srmp.InvalidArgument(f"workers {workers}: there must be at least 1.")
    spec = spec if isinstance(spec, Spec) else read_spec(spec)
    with Store(Path(directory), spec) as store:
        run = _Run(store, spec, progress)
        missing = [number for number in range(spec.shards) if number not in store.shards]
        missing = list(order(missing)) if order else missing
        if missing:
            run.collect(_makers(spec, store.directory, missing, workers, ray), workers, ray)
        return run.result()


def _makers(
    spec: Spec, directory: Path, numbers: Sequence[int], workers: int | None, ray: str | None
) -> Iterator[MadeShard]:
    if ray is not None:
        return made_by_ray(spec, numbers, ray, workers)
    count = min(workers or os.cpu_count() or 1, len(numbers))
    if count == 1:
        return made_here(spec, directory, numbers)
    return made_by_processes(spec, directory, numbers, count)


class _Run:
    """Counts what one call does."""

    def __init__(self, store: Store, spec: Spec, progress: Callable[[int, int], object] | None) -> None:
        self._store, self._spec, self._progress = store, spec, progress
        self._began = time.monotonic()
        self._made = self._solved = self._worker_memory = 0
        self._work_seconds = 0.0
        self._timed_out: list[int] = []

    def collect(self, shards: Iterator[MadeShard], workers: int | None, ray: str | None) -> None:
        indexed = time.monotonic()
        there = sum(shard.records for shard in self._store.shards.values())
        self._tell(there)
        try:
            for made in shards:
                if made.timed_out:
                    self._timed_out += made.timed_out
                    continue
                self._store.write_shard(made)
                self._made += made.count
                self._solved += made.solved
                self._work_seconds += made.seconds
                self._worker_memory = max(self._worker_memory, made.memory)
                self._tell(there + self._made)
                if time.monotonic() - indexed > _INDEX_PERIOD:
                    self._store.write_index()
                    indexed = time.monotonic()
        finally:
            shards.close()  # type: ignore[attr-defined]  # a generator: ends its workers
            self._store.write_index()
            self._store.add_run(self._about(workers, ray))
        self._require_in_time()

    def _require_in_time(self) -> None:
        """The clock is no part of a record: what reaches the time limit is not stored, and the run says so."""
        if not self._timed_out:
            return
        timed_out = sorted(self._timed_out)
        listed = ", ".join(map(str, timed_out[:_LISTED])) + (", …" if len(timed_out) > _LISTED else "")
        what = f"record {listed}" if len(timed_out) == 1 else f"{len(timed_out)} records ({listed})"
        raise srmp.Error(
            f"{what} reached planner.time_limit, {self._spec.time_limit:g} s, and no record may depend on the clock: "
            f"{len(self._store.shards)} of {self._spec.shards} shards are there; with a larger planner.time_limit, "
            "or with these records in the field skip, the same command goes on."
        )

    def _tell(self, records: int) -> None:
        if self._progress:
            self._progress(records, self._spec.count)

    def _about(self, workers: int | None, ray: str | None) -> dict[str, Any]:
        return {
            "ended": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
            "workers": workers,
            "ray": ray,
            "records": self._made,
            "solved": self._solved,
            "seconds": time.monotonic() - self._began,
            "worker_seconds": self._work_seconds,
            "driver_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "worker_memory_bytes": self._worker_memory,
        }

    def result(self) -> Generated:
        shards = [self._store.shards[number] for number in sorted(self._store.shards)]
        records = sum(shard.records for shard in shards)
        seconds = time.monotonic() - self._began
        return Generated(self._store.directory, records, self._made, self._solved, seconds, hash_of(shards))
