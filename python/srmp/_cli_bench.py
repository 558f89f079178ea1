"""The commands srmp bench mbm, multi and paper."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from srmp._cli_options import execution_options, parse_key_values, planner_options, steps_bar

if TYPE_CHECKING:
    from srmp.bench.runner import Execution


_OUT = click.option(
    "--out",
    type=click.Path(dir_okay=False),
    help="Result file (JSON): a header and one row for each problem. A run that was killed goes on from OUT.part.",
)


@click.group()
def bench() -> None:
    """Benchmarks on public problem sets."""


@bench.command()
@click.option(
    "--data", required=True, type=click.Path(exists=True, file_okay=False), help="Directory with <robot>/problems…"
)
@click.option("--robot", required=True, help="panda, ur5 or fetch.")
@click.option("--scenario", "scenarios", multiple=True, help="Only this one; may be repeated.")
@click.option("--problems", default="", help="Numbers in each scenario, such as 1-10 or 1,3,5-7; default: all.")
@planner_options()
@click.option(
    "--geometry", type=click.Choice(["urdf", "spheres"]), default="urdf", show_default=True, help="Collision model."
)
@execution_options
@_OUT
def mbm(
    data: str,
    robot: str,
    scenarios: tuple[str, ...],
    problems: str,
    planner: str,
    options: tuple[str, ...],
    time_limit: float,
    geometry: str,
    workers: int | None,
    ray: str | None,
    out: str | None,
) -> None:
    """MotionBenchMaker: solve its problems and print a table per scenario."""
    from srmp.bench import mbm as benchmark

    _require_directory(out)
    chosen_options = parse_key_values(options)
    execution = _execution(out, workers, ray)
    with steps_bar() as steps:
        result = benchmark.run(
            data,
            robot,
            scenarios=scenarios,
            problems=problems,
            planner_id=planner,
            options=chosen_options,
            geometry=geometry,
            time_limit=time_limit,
            execution=execution,
            progress=_progress_bar,
            steps=steps,
        )
    _report(result, benchmark.format_statistics, out, execution)


@bench.command()
@click.option("--scenario", required=True, help="A file, or ring, binpick, shelves, grid or mixed.")
@click.option("--robots", type=int, help="How many, of generated scenarios.")
@click.option("--problems", default="", help="Numbers, such as 1-10 or 1,3,5-7; default: all, or the first 50.")
@planner_options(time_limit=20.0)
@click.option("--seed", type=int, default=0, show_default=True, help="Of generated problems.")
@click.option(
    "--data",
    type=click.Path(exists=True, file_okay=False),
    help="Directory with MotionBenchMaker's robots; default: those of example-robot-data.",
)
@click.option(
    "--geometry",
    type=click.Choice(["urdf", "spheres"]),
    default="urdf",
    show_default=True,
    help="Of the robots; spheres are those of MotionBenchMaker's spherized URDFs (--data).",
)
@execution_options
@_OUT
def multi(
    scenario: str,
    robots: int | None,
    problems: str,
    planner: str,
    options: tuple[str, ...],
    time_limit: float,
    seed: int,
    data: str | None,
    geometry: str,
    workers: int | None,
    ray: str | None,
    out: str | None,
) -> None:
    """Several robots at once: solve the problems of a scenario and print a table."""
    from srmp.bench import multi as benchmark

    _require_directory(out)
    chosen_options = parse_key_values(options)
    execution = _execution(out, workers, ray)
    with steps_bar() as steps:
        result = benchmark.run(
            scenario,
            robots,
            problems=problems,
            planner_id=planner,
            options=chosen_options,
            time_limit=time_limit,
            seed=seed,
            data=data,
            geometry=geometry,
            execution=execution,
            progress=_progress_bar,
            steps=steps,
        )
    _report(result, benchmark.format_statistics, out, execution)


@bench.command()
@click.option("--experiments", default="a,b,c", show_default=True, help="Which of the three.")
@click.option(
    "--planner", "planners", multiple=True, help="Only this one: a name of the tables, or an id; may be repeated."
)
@click.option(
    "--problems",
    multiple=True,
    metavar="[LETTER=]NUMBERS",
    help="Base problems, and numbers in MotionBenchMaker's scenarios, such as 1-5; c=1-5 for that experiment only.",
)
@click.option("--repetitions", type=click.IntRange(min=1), help="Of each base problem; default: 10 (a), 5 (b).")
@click.option(
    "--time-limit",
    multiple=True,
    metavar="[LETTER=]SECONDS",
    help="Seconds; default: 5 (a), 20 (b), 10 (c); b=10 for that experiment only.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of generated problems, and of OMPL's planners.")
@click.option(
    "--data",
    type=click.Path(exists=True, file_okay=False),
    help="Directory with MotionBenchMaker's robots and problems; without it (c) is not run.",
)
@execution_options
@click.option(
    "--out",
    default="experiments",
    show_default=True,
    type=click.Path(file_okay=False),
    help="Directory of experiments.md, .json, and figures. A run that was killed goes on from experiments.json.part.",
)
@click.option(
    "--table",
    "earlier",
    type=click.Path(exists=True, dir_okay=False),
    help="Run nothing: write page and figures of an earlier run's experiments.json again.",
)
def paper(out: str, workers: int | None, ray: str | None, earlier: str | None, **options: Any) -> None:
    """The paper's experiments, beside OMPL's planners: tables, figures and a page."""
    from srmp.bench.paper import page, run

    directory = Path(out)
    directory.mkdir(parents=True, exist_ok=True)
    if earlier:
        for note in page.write(page.read(earlier), directory):
            click.echo(note)
        return
    execution = _execution(str(directory / "experiments.json"), workers, ray)
    result = run.run(**options, execution=execution, progress=_progress_bar)
    for note in (*result["header"]["notes"], *page.write(result, directory)):
        click.echo(note)
    if not result["header"]["complete"]:
        raise click.Abort
    execution.finish()


def _require_directory(out: str | None) -> None:
    if out and not Path(out).parent.is_dir():
        raise click.BadParameter(f"--out: the directory {Path(out).parent} does not exist.")


def _execution(out: str | None, workers: int | None, ray: str | None) -> Execution:
    """Says when a run that was killed goes on."""
    from srmp.bench.runner import Execution

    execution = Execution.beside(out, workers, ray)
    if execution.journal and execution.journal.exists():
        click.echo(f"{execution.journal} exists: going on where that run ended", err=True)
    return execution


def _report(
    result: dict[str, Any], table: Callable[[Sequence[Any]], str], out: str | None, execution: Execution
) -> None:
    """The table, the problems that are none, and the result file."""
    from srmp._files import write_json

    if result["rows"]:
        click.echo(table(result["rows"]))
    for row in result["rows"]:
        if row["status"] in ("start_invalid", "goal_invalid"):
            click.echo(f"{row['problem']} is not a valid problem: {row['reason']}")
    if out:
        write_json(out, result)
        click.echo(f"wrote {out}")
    if not result["header"]["complete"]:
        raise click.Abort
    execution.finish()


@contextlib.contextmanager
def _progress_bar(problems: Sequence[Any]) -> Iterator[Iterator[Any]]:
    """Shows what is being solved on stderr, where that is a terminal."""
    from tqdm import tqdm

    with tqdm(problems, unit="problem", disable=None, leave=False, dynamic_ncols=True) as bar:

        def named() -> Iterator[Any]:
            for problem in bar:
                bar.set_description(problem.name)
                yield problem

        yield named()
