"""srmp robots and srmp srdf: known robots, and allowed collisions for a robot without an SRDF."""

from __future__ import annotations

import warnings
from pathlib import Path

import click

import srmp
from srmp._cli_options import steps_bar


@click.command()
@click.argument("names", nargs=-1)
@click.option("--installed", is_flag=True, help="Only those whose package is installed.")
@click.option("--pictures", type=click.Path(file_okay=False), help="Draw each one that is installed: DIR/NAME.png.")
def robots(names: tuple[str, ...], installed: bool, pictures: str | None) -> None:
    """List the robots that planner.add_robot knows by name: all, or NAMES.

    Columns: name, number of joints that are planned, what it is, where it comes from, planning groups of its SRDF.
    """
    import srmp.robots

    chosen = [srmp.robots.find(name) for name in names] or list(srmp.robots.available().values())
    chosen = [robot for robot in chosen if robot.installed or not installed]
    for robot in chosen:
        where = robot.package or str(robot.listed_in)
        missing = "" if robot.installed else ", not installed"
        groups = f"; groups: {', '.join(robot.groups)}" if robot.groups else ""
        refused = f"; cannot be planned: {robot.refused}" if robot.refused else ""
        click.echo(f"{robot.name:<26} {robot.title} ({where}{missing}){groups}{refused}")
        if names and robot.installed and not robot.refused:
            _describe(robot.name)
    if pictures is not None:
        _draw_all(chosen, Path(pictures))


def _planner_with(name: str) -> srmp.PlannerInterface:
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        planner.add_robot(name)
    return planner


def _describe(name: str) -> None:
    planner = _planner_with(name)
    click.echo(f"    end effector: {planner.get_end_effector(name)}")
    for joint, (lower, upper, velocity) in zip(
        planner.get_joint_names(name), planner.get_joint_limits(name), strict=True
    ):
        click.echo(f"    {joint}: {lower:.4g} to {upper:.4g}, at most {velocity:.4g} a second")


def _draw_all(chosen: list[srmp.robots.Robot], directory: Path) -> None:
    """Each robot where the planner puts it at first, with its visual geometry or, without any, with the collision's."""
    from tqdm import tqdm

    from srmp.viewer._scene import read_scene

    directory.mkdir(parents=True, exist_ok=True)
    drawn = 0
    for robot in tqdm([robot for robot in chosen if robot.installed and not robot.refused], disable=None, leave=False):
        try:
            planner = _planner_with(robot.name)
            if read_scene(planner).bodies:
                planner.plot(directory / f"{robot.name}.png", title=robot.title or robot.name)
                drawn += 1
            else:
                click.echo(f"{robot.name}: no picture, no link has geometry", err=True)
        except srmp.Error as error:
            click.echo(f"{robot.name}: no picture, {error}", err=True)
    click.echo(f"wrote {drawn} pictures to {directory}")


@click.command()
@click.argument("urdf", type=click.Path(exists=True, dir_okay=False))
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False), help="The SRDF to write.")
@click.option("--samples", type=int, default=10_000, show_default=True, help="Random configurations.")
@click.option("--seed", type=int, default=0, show_default=True, help="The same seed gives the same file.")
@click.option("--end-effector", default="", help="Write a planning group too: the chain from the root to this link.")
@click.option("--group", default="arm", show_default=True, help="Name of that group.")
@click.option("--package-dir", "package_dirs", multiple=True, help="Where meshes are looked for; may be repeated.")
def srdf(
    urdf: str, output: str, samples: int, seed: int, end_effector: str, group: str, package_dirs: tuple[str, ...]
) -> None:
    """Write an SRDF for a robot that has none: allowed collisions of its links, found by sampling.

    Prints how many pairs of links are allowed for which reason, and every pair that stays checked and was seen in
    contact.
    """
    from srmp.robots import sample_allowed_collisions

    with steps_bar("sampling") as progress:
        found = sample_allowed_collisions(
            urdf,
            samples=samples,
            seed=seed,
            end_effector=end_effector,
            group=group,
            package_dirs=package_dirs,
            progress=progress,
        )
    found.save(output)
    for warning in found.warnings:
        click.echo(f"note: {warning}", err=True)
    click.echo(found.report())
    click.echo(f"wrote {output}")
