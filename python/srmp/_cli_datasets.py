"""The commands srmp generate, audit and export."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from srmp._cli_options import execution_options


@click.command()
@click.argument("spec", type=click.Path(exists=True, dir_okay=False))
@click.option("-o", "--output", required=True, type=click.Path(), help="Directory of the data set.")
@execution_options
def generate(spec: str, output: str, workers: int | None, ray: str | None) -> None:
    """Make a data set of certified motions from SPEC (YAML), or go on with it.

    A run that was ended in any way goes on when the same command is given again. Without --workers, one process for
    each core makes shards.
    """
    from srmp import datasets

    with _bar("motion") as progress:
        made = datasets.generate(spec, output, workers=workers, ray=ray, progress=progress)
    if made.made:
        rate = made.made / made.seconds
        click.echo(f"made {made.made} records, {made.solved} of them solved, in {made.seconds:.1f} s ({rate:.1f}/s)")
    click.echo(f"{made.directory}: {made.records} records, SHA-256 {made.sha256}")


@click.command()
@click.argument("directory", type=click.Path(exists=True, file_okay=False))
@click.option(
    "--sample", type=click.IntRange(min=0), default=1000, show_default=True, help="Motions checked for collisions."
)
@click.option("--all", "every", is_flag=True, help="Check all motions for collisions.")
@click.option("--report", type=click.Path(dir_okay=False), help="Write figures and faults to this page (HTML).")
def audit(directory: str, sample: int, every: bool, report: str | None) -> None:
    """Check a data set without the planner: files, schema, limits, starts, goals, collisions.

    Collisions are checked by Pinocchio's and Coal's own packages. Exits with 1 and every fault when it has some.
    """
    from srmp import datasets
    from srmp.datasets.audit_report import summary, write

    if report and not Path(report).parent.is_dir():
        raise click.BadParameter(f"--report: the directory {Path(report).parent} does not exist.")
    with _bar("record") as progress:
        found = datasets.audit(directory, sample=None if every else sample, progress=progress)
    click.echo(summary(found))
    if report:
        write(found, report)
        click.echo(f"wrote {report}")
    if not found.passed:
        raise click.exceptions.Exit(1)


@click.command()
@click.argument("directory", type=click.Path(exists=True, file_okay=False))
@click.option(
    "--to",
    "target",
    required=True,
    type=click.Choice(["numpy", "hdf5", "webdataset", "lerobot"]),
    help="Format.",
)
@click.option("-o", "--output", required=True, type=click.Path(), help="Directory, or file of hdf5; must not exist.")
def export(directory: str, target: str, output: str) -> None:
    """Write the solved motions of a data set in another format."""
    from srmp import datasets

    with _bar("record") as progress:
        count = datasets.export(directory, output, target, progress=progress)
    click.echo(f"wrote {count} motions to {output}")


@contextlib.contextmanager
def _bar(unit: str) -> Iterator[Callable[[int, int], None]]:
    """Shows records done, rate and time left on stderr, where that is a terminal."""
    from tqdm import tqdm

    with tqdm(unit=unit, disable=None, dynamic_ncols=True, smoothing=0.1) as bar:
        begun = []

        def show(done: int, total: int) -> None:
            if not begun:  # what was there before does not count for the rate
                bar.initial = bar.n = done
                begun.append(True)
            bar.total = total
            bar.update(done - bar.n)

        yield show
