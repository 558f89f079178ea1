"""Options and progress bars that the commands of the command line share."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click


def decorated(command: Any, decorators: Sequence[Callable[[Any], Any]]) -> Any:
    for decorator in reversed(decorators):
        command = decorator(command)
    return command


def planner_options(time_limit: float = 10.0) -> Callable[[Any], Any]:
    def decorate(command: Any) -> Any:
        decorators = [
            click.option("--planner", default="auto", show_default=True, help="Planner id."),
            click.option(
                "--option", "options", multiple=True, metavar="KEY=VALUE", help="Planner option; may be repeated."
            ),
            click.option(
                "--time-limit", type=float, default=time_limit, show_default=True, help="Seconds for each plan."
            ),
        ]
        return decorated(command, decorators)

    return decorate


def execution_options(command: Any) -> Any:
    """--workers and --ray of benchmarks."""
    decorators = [
        click.option(
            "--workers",
            type=click.IntRange(min=1),
            help="Processes that solve problems; with --ray, workers of the cluster (default: all its CPUs).",
        ),
        click.option(
            "--ray",
            metavar="ADDRESS",
            help='Solve on a Ray cluster: "auto", "ray://host:10001"; "local": start one here.',
        ),
    ]
    return decorated(command, decorators)


def keep_inputs(command: click.Command) -> None:
    """Has the command, and those of a group, refuse to write one file twice, or over what it reads."""
    if isinstance(command, click.Group):
        for part in command.commands.values():
            keep_inputs(part)
        return
    callback = command.callback
    assert callback is not None

    @functools.wraps(callback)
    def checked(**values: Any) -> Any:
        _refuse_same_files([(param, values[param.name]) for param in command.params if values.get(param.name or "")])
        return callback(**values)

    command.callback = checked


def _refuse_same_files(given: Sequence[tuple[click.Parameter, Any]]) -> None:
    files = [(param, param.type, Path(value).resolve()) for param, value in given if isinstance(param.type, click.Path)]
    used = {path: f"{_shown(param)} reads" for param, kind, path in files if kind.exists}
    for param, kind, path in files:
        if not kind.exists and path in used:
            raise click.UsageError(f"{_shown(param)} is the file that {used[path]}: {path}; name another.")
        used.setdefault(path, f"{_shown(param)} writes")


def _shown(param: click.Parameter) -> str:
    return max(param.opts, key=len) if isinstance(param, click.Option) else (param.name or "").upper()


def parse_key_values(pairs: Sequence[str]) -> dict[str, str]:
    """["weight=10"] as a dictionary; the planner checks keys and values."""
    values: dict[str, str] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise click.BadParameter(f"'{pair}' is not KEY=VALUE.")
        if key.strip() in values:
            raise click.BadParameter(f"'{key.strip()}' is given twice.")
        values[key.strip()] = value.strip()
    return values


@contextlib.contextmanager
def steps_bar(what: str = "covering") -> Iterator[Callable[[int, int], None]]:
    """Shows steps done of steps in all on stderr, where that is a terminal."""
    from tqdm import tqdm

    bars = []

    def show(done: int, total: int) -> None:
        if not bars:
            bars.append(tqdm(desc=what, total=total, disable=None, leave=False, dynamic_ncols=True))
        bars[0].total = total
        bars[0].update(done - bars[0].n)
        if done >= total:
            bars.pop().close()

    try:
        yield show
    finally:
        for bar in bars:
            bar.close()
