"""Who makes shards: this process, several on this machine, or the machines of a Ray cluster.

All hand shards over as bytes, which only the driver writes, so that workers need no common file system. No more than
two shards a worker are under way: what waits to be written stays small.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import platform
import signal
import tempfile
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import srmp
from srmp.bench.runner import connect_to_ray, ctrl_c_later
from srmp.datasets.recorder import MadeShard, Recorder
from srmp.datasets.schema import versions
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


def _serve(connection: Connection, directory: Path) -> None:
    """A worker: takes the spec, then numbers of shards, hands over the shards, or the exception that ended it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal; the driver ends them
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_driver, daemon=True).start()
    try:
        recorder = Recorder(connection.recv(), directory)
        while True:
            connection.send(recorder.shard(connection.recv()))
    except EOFError:
        return
    except Exception as error:
        with contextlib.suppress(OSError):  # the driver is dead
            connection.send(error)


def _end_with_driver() -> None:
    """A driver that is killed leaves no workers behind."""
    if driver := multiprocessing.parent_process():
        driver.join()
        os._exit(1)


class _Process:
    """A worker as the driver sees it.

    Each has a connection of its own. In a queue that workers share, as ProcessPoolExecutor has, one that is killed
    while it hands over a shard keeps the lock, and the driver waits for the rest of the shard for ever. The spec, with
    its files, comes this way too: Process.start never ends where a process is killed before it has read many bytes.
    """

    def __init__(self, directory: Path) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.numbers: deque[int] = deque()
        """Shards that it has in work, in their order."""
        with ctrl_c_later():
            self._process = context.Process(target=_serve, args=(theirs, directory), daemon=True)
            self._process.start()
        theirs.close()

    def begin(self, spec: Spec) -> None:
        """Before anything else."""
        self._send(spec)

    def give(self, number: int) -> None:
        """A shard to make."""
        self.numbers.append(number)
        self._send(number)

    def _send(self, message: Any) -> None:
        with contextlib.suppress(OSError):  # a worker that is dead is found when it is asked
            self.connection.send(message)

    def take(self) -> MadeShard | None:
        """What it made; None where it is dead. Raises what ended it."""
        try:
            made = self.connection.recv()
        except (EOFError, OSError):
            return None
        if isinstance(made, Exception):
            raise made
        self.numbers.popleft()
        return made

    def end(self) -> None:
        """At once: what it has in work is lost, and nothing else."""
        self._process.kill()
        self._process.join()
        self.connection.close()


def made_by_processes(spec: Spec, directory: Path, numbers: Sequence[int], workers: int) -> Iterator[MadeShard]:
    """Shards by processes, as they come; those of a worker that dies are made again."""
    todo, deaths = deque(numbers), 0
    processes: list[_Process] = []
    try:
        while todo or any(process.numbers for process in processes):
            while len(processes) < workers and todo:
                processes.append(_Process(directory))
                processes[-1].begin(spec)
                processes[-1].give(todo.popleft())
            for process in processes:
                while todo and len(process.numbers) < _AHEAD:
                    process.give(todo.popleft())
            busy = {process.connection: process for process in processes if process.numbers}
            for connection in wait(list(busy)):
                process = busy[connection]
                if made := process.take():
                    deaths = 0
                    yield made
                    continue
                deaths += 1
                if deaths > _MAX_DEATHS:
                    raise srmp.Error(
                        f"{deaths} workers in a row were killed (too little memory?); the same command goes on."
                    )
                todo.extendleft(reversed(process.numbers))
                processes.remove(process)
                process.end()
    finally:
        for process in processes:
            process.end()


# --- Ray --------------------------------------------------------------------------------------------------------------


class _RayWorker:
    """An actor: keeps a Recorder, and the spec's files in a directory of its own."""

    def __init__(self, spec: Spec, driver: Mapping[str, str]) -> None:
        """driver: the versions of its process."""
        self._driver = driver
        self._directory = tempfile.TemporaryDirectory(prefix="srmp-")
        unpack(spec.files, Path(self._directory.name))
        self._recorder = Recorder(spec, Path(self._directory.name))

    def make(self, number: int) -> MadeShard:
        require_same_versions(self._driver)
        return self._recorder.shard(number)


def require_same_versions(driver: Mapping[str, str]) -> None:
    """Raises Error where this process, a worker, would make other bytes than the driver."""
    own = versions()
    if different := [f"{name} {own.get(name)} ({driver[name]})" for name in driver if driver[name] != own.get(name)]:
        raise srmp.Error(
            f"a worker on {platform.node()} has other versions than the driver: {', '.join(different)}; "
            "all must have the same, so that records are the same whoever makes them."
        )


def made_by_ray(spec: Spec, numbers: Sequence[int], address: str, workers: int | None) -> Iterator[MadeShard]:
    """Shards by actors of a Ray cluster, as they come; an actor that dies is started again, its shards made again."""
    with connect_to_ray(address) as ray:
        count = min(workers or int(ray.cluster_resources().get("CPU", 1)), len(numbers))
        shared = ray.put(spec)
        actor = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)(_RayWorker)
        yield from _from_actors(ray, [actor.remote(shared, versions()) for _ in range(count)], numbers)


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
