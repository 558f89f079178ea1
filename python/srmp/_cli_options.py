"""Options and progress bars that the commands of the command line share."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
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
