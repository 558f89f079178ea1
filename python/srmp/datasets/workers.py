"""Who makes shards: this process, several on this machine, or the machines of a Ray cluster.

All hand shards over as bytes, which only the driver writes, so that workers need no common file system. No more than
two shards a worker are under way: what waits to be written stays small.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import tempfile
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import srmp
from srmp.bench.runner import connect_to_ray, ctrl_c_later
from srmp.datasets.recorder import MadeShard, Recorder
from srmp.datasets.spec import Spec, unpack

_AHEAD = 2
_MAX_DEATHS = 10
"""Workers that may die one after the other without any shard in between."""


def made_here(spec: Spec, directory: Path, numbers: Sequence[int]) -> Iterator[MadeShard]:
    """Shards by this process."""
    recorder = Recorder(spec, directory)
    for number in numbers:
        yield recorder.shard(number)


# --- processes --------------------------------------------------------------------------------------------------------

_recorder: Recorder


def _begin_worker(spec: Spec, directory: Path) -> None:
    global _recorder
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal; the driver ends them
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_driver, daemon=True).start()
    _recorder = Recorder(spec, directory)


def _end_with_driver() -> None:
    """A driver that is killed leaves no workers behind."""
    if driver := multiprocessing.parent_process():
        driver.join()
        os._exit(1)


def _make(number: int) -> MadeShard:
    return _recorder.shard(number)


def made_by_processes(spec: Spec, directory: Path, numbers: Sequence[int], workers: int) -> Iterator[MadeShard]:
    """Shards by processes, as they come; those of a worker that dies are made again."""
    todo, deaths = deque(numbers), 0
    while todo:
        waiting: dict[Future[MadeShard], int] = {}
        pool = ProcessPoolExecutor(
            min(workers, len(todo)), multiprocessing.get_context("spawn"), _begin_worker, (spec, directory)
        )
        try:
            while todo or waiting:
                with ctrl_c_later():
                    while todo and len(waiting) < _AHEAD * workers:
                        waiting[pool.submit(_make, todo[0])] = todo[0]
                        todo.popleft()
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    made = future.result()
                    del waiting[future]
                    yield made
                    deaths = 0
        except BrokenProcessPool as error:
            deaths += 1
            if deaths > _MAX_DEATHS:
                raise srmp.Error(
                    f"{deaths} workers in a row could not begin, or were killed (too little memory?); the same command "
                    "goes on."
                ) from error
            todo.extendleft(sorted(waiting.values(), reverse=True))
        finally:
            _end(pool)


def _end(pool: ProcessPoolExecutor) -> None:
    """Ends the workers at once: what they have in work is lost, and nothing else."""
    for process in list((getattr(pool, "_processes", None) or {}).values()):
        with contextlib.suppress(OSError, ValueError):
            process.kill()
    pool.shutdown(wait=True, cancel_futures=True)


# --- Ray --------------------------------------------------------------------------------------------------------------


class _RayWorker:
    """An actor: keeps a Recorder, and the spec's files in a directory of its own."""

    def __init__(self, spec: Spec) -> None:
        self._directory = tempfile.TemporaryDirectory(prefix="srmp-")
        unpack(spec.files, Path(self._directory.name))
        self._recorder = Recorder(spec, Path(self._directory.name))

    def make(self, number: int) -> MadeShard:
        return self._recorder.shard(number)


def made_by_ray(spec: Spec, numbers: Sequence[int], address: str, workers: int | None) -> Iterator[MadeShard]:
    """Shards by actors of a Ray cluster, as they come; an actor that dies is started again, its shards made again."""
    with connect_to_ray(address) as ray:
        count = min(workers or int(ray.cluster_resources().get("CPU", 1)), len(numbers))
        shared = ray.put(spec)
        actor = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)(_RayWorker)
        yield from _from_actors(ray, [actor.remote(shared) for _ in range(count)], numbers)


def _from_actors(ray: Any, actors: Sequence[Any], numbers: Sequence[int]) -> Iterator[MadeShard]:
    todo = deque(numbers)
    waiting: dict[Any, Any] = {}
    for actor in [actor for _ in range(_AHEAD) for actor in actors]:
        if todo:
            waiting[actor.make.remote(todo.popleft())] = actor
    while waiting:
        (ready,), _ = ray.wait(list(waiting), num_returns=1)
        actor = waiting.pop(ready)
        try:
            made = ray.get(ready)
        except ray.exceptions.RayTaskError as error:
            raise error.as_instanceof_cause() from error
        except ray.exceptions.RayError as error:
            raise srmp.Error(f"a worker of the Ray cluster was lost: {error}; the same command goes on.") from error
        if todo:
            waiting[actor.make.remote(todo.popleft())] = actor
        del ready
        yield made
