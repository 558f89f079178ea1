"""Runs the problems of a benchmark: in this process, in several, or on the machines of a Ray cluster; resumable.

The rows are in the order of the problems, and the same (except measured times) however they are distributed. With a
journal, every row is written as soon as it and those before it are there: a run that was killed goes on from there.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import IO, Any, Protocol, TypeAlias, TypeVar

import srmp
from srmp._files import plain

_Problem = TypeVar("_Problem")
Row: TypeAlias = dict[str, Any]
Steps: TypeAlias = Callable[[int, int], object]  # done and all, as PlannerInterface.prepare tells
Progress: TypeAlias = Callable[[Sequence[_Problem]], contextlib.AbstractContextManager[Iterator[_Problem]]]


class Solver(Protocol):
    """What makes the row of a problem."""

    def run(self, problem: Any, /) -> Row:
        """The row of the result file. What it raises ends the benchmark."""


@dataclass(frozen=True)
class Execution:
    """Where problems are solved, and where rows are kept until all are there."""

    workers: int | None = None
    """Processes; with `ray`, workers of the cluster. None: this process alone; with `ray`, one for each CPU."""
    ray: str | None = None
    """Address of a Ray cluster: "auto", "ray://host:10001"; "local" starts one on this machine. Needs the package ray.

    The data must have the same path on all its machines.
    """
    journal: Path | None = None
    """Rows are kept here. The caller removes it (`finish`) once the results are written."""

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise srmp.InvalidArgument(f"workers {self.workers}: there must be at least 1.")

    @classmethod
    def beside(cls, out: str | Path | None, workers: int | None = None, ray: str | None = None) -> Execution:
        """With the journal `out`.part; without one where there is no result file."""
        return cls(workers, ray, Path(f"{out}.part") if out else None)

    @property
    def distributed(self) -> bool:
        """Whether other processes than this one solve problems."""
        return self.ray is not None or (self.workers or 1) > 1

    def finish(self) -> None:
        """Removes the journal of a run that is complete."""
        if self.journal:
            self.journal.unlink(missing_ok=True)


def run_rows(
    problems: Sequence[_Problem],
    make_solver: Callable[[], Solver],
    *,
    request: Mapping[str, Any],
    solver: Solver | None = None,
    execution: Execution | None = None,
    progress: Progress[_Problem] | None = None,
) -> tuple[list[Row], bool]:
    """The rows of the problems, and whether they are all: Ctrl-C ends it early, with the rows that were finished.

    make_solver: makes the Solver of a worker, which may be in another process, so that it must be picklable; problems
    must be too, and have a `name`. solver: solves in this process where there are no workers, instead of a new one.
    request: says in plain values what is run. The journal of another request, or of other versions, is refused.

    Rows are plain: arrays are lists.
    """
    execution = execution or Execution()
    with contextlib.ExitStack() as stack:
        journal = stack.enter_context(Journal(execution.journal, request)) if execution.journal else None
        rows: list[Row] = list(journal.rows) if journal else []
        todo = problems[len(rows) :]
        if not todo:
            return rows, True
        try:
            sequence = stack.enter_context(progress(todo) if progress else contextlib.nullcontext(iter(todo)))
            found = stack.enter_context(_solved(todo, make_solver, solver, execution))
            for _, row in zip(sequence, found, strict=True):  # the problem first: its name is shown meanwhile
                row = _as_read(row)
                if journal:
                    journal.write(row)
                rows.append(row)
        except KeyboardInterrupt:
            return rows, False
    return rows, True


def _as_read(row: Row) -> Row:
    """As it is read back from the journal: with lists for arrays; infinity stays."""
    return json.loads(_line(row))


def _line(row: Mapping[str, Any]) -> str:
    return json.dumps(row, default=plain, ensure_ascii=False)


# --- workers ----------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def _solved(
    problems: Sequence[_Problem], make_solver: Callable[[], Solver], solver: Solver | None, execution: Execution
) -> Iterator[Iterator[Row]]:
    """The rows in the order of the problems, as they come."""
    if execution.ray is not None:
        with connect_to_ray(execution.ray) as ray:
            yield _solved_by_ray(ray, problems, make_solver, execution.workers)
    elif execution.distributed:
        with _solved_by_processes(problems, make_solver, execution) as rows:
            yield rows
    else:
        alone = solver or make_solver()
        yield (alone.run(problem) for problem in problems)


_of_this_process: Solver


def _begin_worker(make_solver: Callable[[], Solver]) -> None:
    global _of_this_process
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    _of_this_process = make_solver()


def _solve(problem: Any) -> Row:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # Ctrl-C ends the plan, not the worker
    try:
        return _as_read(_of_this_process.run(problem))
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextlib.contextmanager
def _solved_by_processes(
    problems: Sequence[_Problem], make_solver: Callable[[], Solver], execution: Execution
) -> Iterator[Iterator[Row]]:
    # Spawned, not forked: the library has threads, which a fork would lose.
    pool = ProcessPoolExecutor(
        min(execution.workers or 1, len(problems)), get_context("spawn"), _begin_worker, (make_solver,)
    )
    try:
        with ctrl_c_later():  # workers begin with the signal blocked, and ignore it once they can
            futures = [pool.submit(_solve, problem) for problem in problems]
        yield (future.result() for future in futures)
    except BrokenProcessPool as error:
        rest = f" {execution.journal} keeps the rows so far: run the same again to go on." if execution.journal else ""
        raise srmp.Error(f"a worker could not begin, or was killed (too little memory?).{rest}") from error
    finally:
        pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def ctrl_c_later() -> Iterator[None]:
    """Blocks Ctrl-C inside; processes that begin there begin with it blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def connect_to_ray(address: str) -> Iterator[Any]:
    """The module ray, connected to the cluster. Raises Error where it is not installed, or there is no cluster."""
    try:
        import ray
    except ModuleNotFoundError as error:
        raise srmp.Error(
            'Ray is not installed: pip install ".[ray]" in a checkout (or pip install ray), or use --workers alone.'
        ) from error
    try:
        ray.init(address=address, log_to_driver=False)
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise srmp.Error(f"there is no Ray cluster at '{address}': {str(error).rstrip('.')}.") from error
    try:
        yield ray
    finally:
        ray.shutdown()


def _solved_by_ray(
    ray: Any, problems: Sequence[_Problem], make_solver: Callable[[], Solver], workers: int | None
) -> Iterator[Row]:
    class Worker:
        def __init__(self) -> None:
            self._solver = make_solver()

        def solve(self, problem: Any) -> Row:
            return _as_read(self._solver.run(problem))

    from ray.util import ActorPool

    count = workers or int(ray.cluster_resources().get("CPU", 1))
    remote = ray.remote(num_cpus=1)(Worker)
    pool = ActorPool([remote.remote() for _ in range(min(count, len(problems)))])
    return iter(pool.map(lambda worker, problem: worker.solve.remote(problem), problems))


# --- journal ----------------------------------------------------------------------------------------------------------

_FORMAT = "srmp bench journal"


class Journal:
    """A file of lines of JSON: a header that holds the request, then one row a line. A context manager."""

    def __init__(self, path: Path, request: Mapping[str, Any]) -> None:
        """Raises FileError when it is not a journal, of another request, or in use by another run."""
        self._path = path
        self._header = {"format": _FORMAT, "request": json.loads(_line(request))}
        self.rows: list[Row] = []
        """Those that it held when it was opened."""
        self._file: IO[bytes] = path.open("a+b")
        try:
            self._lock()
            self._read()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, line: Mapping[str, Any]) -> None:
        """Writes a row; it stays even if this process is killed next."""
        self._file.write(_line(line).encode() + b"\n")
        self._file.flush()

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise srmp.FileError(f"{self._path} is in use by another run.") from error

    def _read(self) -> None:
        self._file.seek(0)
        # What follows the last line break is a line that was torn when the run was killed.
        whole, line_break, torn = self._file.read().rpartition(b"\n")
        own_header = _line(self._header).encode()
        try:
            header, *rows = [json.loads(line) for line in (whole if line_break else own_header).split(b"\n")]
            if header["format"] != _FORMAT or not (line_break or own_header.startswith(torn)):
                raise ValueError("it does not begin as one")
            written = dict(header["request"])
        except (ValueError, KeyError, TypeError) as error:
            raise srmp.FileError(f"{self._path} is not the journal of a benchmark: {error}.") from error
        if different := _differences(written, self._header["request"]):
            raise srmp.FileError(
                f"{self._path} is the journal of another run ({different}): finish that run, choose another --out, or "
                "remove the file."
            )
        self.rows = rows
        self._file.truncate(len(whole) + len(line_break))
        if not line_break:
            self.write(self._header)


def _differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    keys = [key for key in dict.fromkeys((*there, *here)) if there.get(key) != here.get(key)]
    return ", ".join(f"{key}: {json.dumps(there.get(key))} there, {json.dumps(here.get(key))} here" for key in keys)
