"""The command line: srmp demo, plan, verify, view, bench, generate, robots and more; srmp --help lists them."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

import srmp
from srmp._cli_bench import bench
from srmp._cli_datasets import audit, export, generate
from srmp._cli_options import decorated, keep_inputs, parse_key_values, planner_options, steps_bar
from srmp._cli_robots import robots, srdf

EXISTING_FILE = click.Path(exists=True, dir_okay=False)
EXIT_NO_PATH = 1  # a valid request, but there is no trajectory, it has faults, the state is in collision, …
EXIT_REFUSED = 2  # an invalid request: bad file, unknown name (click's own number for usage errors)


class _Group(click.Group):
    """Reports the library's errors as one sentence and an exit code."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except srmp.PlanningError as error:
            click.echo(f"{error.status.name}: {error}", err=True)
            ctx.exit(EXIT_NO_PATH)
        except srmp.Error as error:
            click.echo(f"error: {error}", err=True)
            ctx.exit(EXIT_REFUSED)
        except OSError as error:
            click.echo(f"error: {error.filename or ''}: {error.strerror or error}", err=True)
            ctx.exit(EXIT_REFUSED)


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(srmp.__version__, prog_name="srmp")
def main() -> None:
    """Search-based motion planning for robot arms."""


# --- shared options ---------------------------------------------------------------------------------------------------


_ROBOT_DETAILS = (
    click.option("--srdf", type=EXISTING_FILE, help="Its groups and allowed collisions."),
    click.option("--end-effector", default="", help="The link that goals refer to."),
    click.option("--group", default="", help="Planning group of the SRDF; default: the request's, or the chain."),
    click.option("--package-dir", "package_dirs", multiple=True, help="Where meshes are looked for; may be repeated."),
)
_JOINT_LIMITS = click.option(
    "--joint-limits", type=EXISTING_FILE, help="Limits of the joints: MoveIt's joint_limits.yaml; default: the URDF's."
)


def _robot_details(command: Any) -> Any:
    return decorated(command, _ROBOT_DETAILS)


def _robot_options(command: Any) -> Any:
    decorators = [
        click.option("--urdf", required=True, type=EXISTING_FILE, help="The robot."),
        *_ROBOT_DETAILS,
        click.option("--scene", type=EXISTING_FILE, help="Objects: MoveIt scene YAML."),
    ]
    return decorated(command, decorators)


def _make_world(
    urdf: str, srdf: str | None, end_effector: str, group: str, package_dirs: Sequence[str], scene: str | None
) -> srmp.PlannerInterface:
    """Says on stderr what of the robot's files was not used."""
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        planner.add_articulation(
            urdf_path=urdf,
            srdf_path=srdf or "",
            name="robot",
            end_effector=end_effector,
            group=group,
            package_dirs=list(package_dirs),
        )
    for warning in planner.warnings("robot"):
        click.echo(f"note: {warning}", err=True)
    if scene:
        for note in planner.load_moveit_scene(scene):
            click.echo(f"note: {scene}: {note}", err=True)
    return planner


def _apply_request(world: srmp.PlannerInterface, robot: str, request: srmp.MoveItRequest) -> srmp.MoveItProblem:
    """The request as a problem of the robot, whose link speeds it limits; says on stderr which joints were not used."""
    problem = world.apply_moveit_request(robot, request)
    if problem.link_speeds:
        world.set_motion_limits(robot, link_speeds=problem.link_speeds)
    if problem.ignored_joints:
        names = ", ".join(problem.ignored_joints)
        click.echo(f"note: {request.path} also places {names}, which are not movable joints of the robot", err=True)
    return problem


def _given(*parameters: str) -> dict[str, Any]:
    """The planner options that the command line says itself, which count more than those of a request."""
    context = click.get_current_context()
    keys = {"planner": "planner_id"}
    return {
        keys.get(name, name): context.params[name]
        for name in parameters
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    }


def _apply_joint_limits(world: srmp.PlannerInterface, robot: str, path: str | None) -> None:
    """Says on stderr which joints of the file were not used."""
    if path is not None and (unused := world.load_joint_limits(robot, path)):
        names = ", ".join(unused)
        click.echo(f"note: {path} also limits {names}, which are not planned joints of the robot", err=True)


# --- commands ---------------------------------------------------------------------------------------------------------


@main.command()
@click.option(
    "-o", "--output", type=click.Path(file_okay=False), default=".", show_default=True, help="Directory for the files."
)
@planner_options(time_limit=30.0)
def demo(output: str, planner: str, options: tuple[str, ...], time_limit: float) -> None:
    """A 7-joint arm reaches into a shelf; writes demo.json and demo.png."""
    from srmp.demo import run

    chosen_options = {"planner_id": planner, "time_limit": time_limit, **parse_key_values(options)}
    result = run(chosen_options)
    directory = Path(output)
    directory.mkdir(parents=True, exist_ok=True)
    result.write(directory / "demo.json")
    click.echo(result.summary())
    click.echo(f"wrote {directory / 'demo.json'}")
    try:
        result.draw(directory / "demo.png")
    except ModuleNotFoundError as error:
        click.echo(f"no figure: {error.name} is not installed (pip install '.[demo]' in the checkout)", err=True)
    else:
        click.echo(f"wrote {directory / 'demo.png'}")


@main.command()
@_robot_options
@click.option(
    "--request", "request_path", required=True, type=EXISTING_FILE, help="Start and goals: MoveIt request YAML."
)
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False), help="Result file (JSON).")
@click.option("--save", type=click.Path(dir_okay=False), help="Write the whole problem too, for srmp replay (JSON).")
@_JOINT_LIMITS
@planner_options()
def plan(
    urdf: str,
    srdf: str | None,
    end_effector: str,
    group: str,
    package_dirs: tuple[str, ...],
    scene: str | None,
    request_path: str,
    output: str,
    save: str | None,
    joint_limits: str | None,
    planner: str,
    options: tuple[str, ...],
    time_limit: float,
) -> None:
    """Plan one request and write the timed trajectory.

    Exits with 1 and the reason when there is none; the result file then holds status and reason.
    """
    from srmp._files import write_json
    from srmp._table import format_seconds
    from srmp._verify import summary
    from srmp.result import plan_result

    request = srmp.load_moveit_request(request_path)
    chosen = group or (request.group_name if srdf else "")
    world = _make_world(urdf, srdf, end_effector, chosen, package_dirs, scene)
    problem = _apply_request(world, "robot", request)
    _apply_joint_limits(world, "robot", joint_limits)
    chosen_options = {"planner_id": planner, "time_limit": time_limit} | problem.options
    world.make_planner(["robot"], chosen_options | _given("planner", "time_limit") | parse_key_values(options))
    try:
        trajectory = world.plan(
            "robot",
            problem.start,
            problem.goals,
            constraints=problem.constraints,
            start_velocity=problem.start_velocity,
        )
    except srmp.PlanningError:
        write_json(output, plan_result(world.get_planning_stats(), world.get_joint_names("robot"), None))
        if save:
            world.save(save)
        raise
    stats = world.get_planning_stats()
    write_json(output, plan_result(stats, trajectory.joint_names, trajectory))
    click.echo(
        f"solved in {format_seconds(stats['plan_time_s'])}: {len(trajectory.waypoints)} waypoints, "
        f"{stats['path_cost_rad']:.2f} rad" + (f", {trajectory.duration:.2f} s long" if len(trajectory.times) else "")
    )
    if trajectory.certificate is not None:
        click.echo(f"certificate: {summary(trajectory.certificate)}")
    click.echo(f"wrote {output}")
    if save:
        world.save(save)
        click.echo(f"wrote {save}")


@main.command()
@click.argument("problem", type=EXISTING_FILE)
@click.option("--package-dir", "package_dirs", multiple=True, help="Where meshes are looked for; may be repeated.")
def replay(problem: str, package_dirs: tuple[str, ...]) -> None:
    """Plan the request of a problem file again, of one robot or many: is the result the same, bit for bit?

    Exits with 1 when it is not, and says where it differs first.
    """
    from srmp._replay import first_difference, plan_again
    from srmp._verify import load_with_result

    world = load_with_result(problem, package_dirs)
    before, request = world.last_result, world.last_request
    assert before is not None
    assert request is not None
    with contextlib.suppress(srmp.PlanningError):
        plan_again(world, request)
    now = world.last_result
    assert now is not None
    if difference := first_difference(before, now):
        click.echo(f"differs: {difference}")
        raise click.exceptions.Exit(EXIT_NO_PATH)
    click.echo(f"the same: {before.status.name}{f', {before.trajectory!r}' if before.solved else ''}")


@main.command()
@click.argument("plan", type=EXISTING_FILE)
@click.option(
    "--scene", type=EXISTING_FILE, help="Scene or problem file; with --urdf MoveIt scene YAML. Default: that of PLAN."
)
@click.option("--urdf", type=EXISTING_FILE, help="The robot, where no scene or problem file has it.")
@_robot_details
@click.option("--robot", help="Whose trajectory it is; default: the robot with these joints.")
@click.option("--request", "request_path", type=EXISTING_FILE, help="Start and goals: MoveIt request YAML.")
@_JOINT_LIMITS
@click.option("--jerk", is_flag=True, help="Verify the jerk limits too.")
@click.option("--max-deviation", type=float, help="Largest deviation from its waypoints [m]; default: any.")
@click.option("--in-motion", is_flag=True, help="It may begin and end in motion, as a slice does.")
def verify(
    plan: str,
    scene: str | None,
    urdf: str | None,
    srdf: str | None,
    end_effector: str,
    group: str,
    package_dirs: tuple[str, ...],
    robot: str | None,
    request_path: str | None,
    joint_limits: str | None,
    jerk: bool,
    max_deviation: float | None,
    in_motion: bool,
) -> None:
    """Verify a trajectory in a scene: limits at every instant, collisions between samples too, start and goals.

    PLAN is a trajectory file, what srmp plan writes, or a problem file, which says scene and request itself; one of
    plan_multi has all robots verified against each other too. Exits with 1 and every fault when it has some.
    """
    from srmp import _verify

    if _verify.is_multi(plan):
        for_one = {"--scene": scene, "--urdf": urdf, "--robot": robot, "--request": request_path}
        for_one |= {"--srdf": srdf, "--end-effector": end_effector, "--group": group, "--joint-limits": joint_limits}
        if given := [option for option, value in for_one.items() if value]:
            raise click.UsageError(f"{given[0]} is for one robot; {plan} holds a plan_multi, which says all itself.")
        many = _verify.load_with_result(plan, package_dirs, solved=True)
        return _print_certificates(
            _verify.verify_multi(many, jerk=jerk, max_deviation=max_deviation, at_rest=not in_motion)
        )
    trajectory = srmp.Trajectory.load(plan)
    request = srmp.load_moveit_request(request_path) if request_path else None
    if urdf:
        chosen = group or (request.group_name if request and srdf else "")
        world = _make_world(urdf, srdf, end_effector, chosen, package_dirs, scene)
    elif srdf or end_effector or group:
        raise click.UsageError("--srdf, --end-effector and --group are for the robot of --urdf, which is not given.")
    else:
        world = _load_world(scene, plan, package_dirs)
    name = robot or _verify.robot_of(world, trajectory)
    given_request: Any = world.last_request
    if request:
        given_request = _apply_request(world, name, request)
    elif not isinstance(given_request, srmp.PlanRequest) or given_request.robot != name:
        given_request = None
    _apply_joint_limits(world, name, joint_limits)
    certificate = world.verify(
        name,
        trajectory,
        start=given_request.start if given_request else None,
        goals=given_request.goals if given_request else None,
        jerk=jerk,
        max_deviation=max_deviation,
        at_rest=not in_motion,
    )
    _print_certificates({"": certificate})


def _print_certificates(certificates: Mapping[str, srmp.Certificate]) -> None:
    """By robot; "" where there is one. Exits with 1 when one does not hold."""
    from srmp import _verify

    for robot, certificate in certificates.items():
        if robot:
            click.echo(f"robot '{robot}':")
        click.echo(certificate.report(), nl=False)
        click.echo(_verify.summary(certificate))
    if not all(certificate.holds for certificate in certificates.values()):
        raise click.exceptions.Exit(EXIT_NO_PATH)


def _load_world(scene: str | None, plan: str, package_dirs: Sequence[str]) -> srmp.PlannerInterface:
    from srmp._verify import has_scene

    try:
        return srmp.PlannerInterface.load(scene or plan, package_dirs=list(package_dirs))
    except srmp.FileError as error:
        if not scene and not has_scene(plan):
            hint = "say with --scene what the trajectory is to be verified against"
        elif scene and Path(scene).suffix in (".yaml", ".yml"):
            hint = "a MoveIt scene needs its robot too: --urdf"
        else:
            raise
        raise srmp.FileError(f"{error}; {hint}") from error


@main.command()
@_robot_options
@click.option("--request", "request_path", type=EXISTING_FILE, help="Check the start of this MoveIt request.")
@click.option("--state", help="Check these joints: NAME=VALUE,NAME=VALUE,… [rad or m], or just the values in order.")
def check(
    urdf: str,
    srdf: str | None,
    end_effector: str,
    group: str,
    package_dirs: tuple[str, ...],
    scene: str | None,
    request_path: str | None,
    state: str | None,
) -> None:
    """Is this state free? If not, why. Exits with 1 when it is not."""
    if (request_path is None) == (state is None):
        raise click.UsageError("give either --request or --state.")
    if request_path is not None:
        request = srmp.load_moveit_request(request_path)
        world = _make_world(
            urdf, srdf, end_effector, group or (request.group_name if srdf else ""), package_dirs, scene
        )
        q = _apply_request(world, "robot", request).start
    else:
        world = _make_world(urdf, srdf, end_effector, group, package_dirs, scene)
        q = _parse_state(world, state or "")
    reasons = _limit_violations(world, q) + [str(contact) for contact in world.contacts("robot", q)]
    for reason in reasons:
        click.echo(reason)
    if reasons:
        raise click.exceptions.Exit(EXIT_NO_PATH)
    nearest = world.nearest("robot", q)
    click.echo("free" if nearest is None else f"free, nearest: {nearest}")


def _parse_state(world: srmp.PlannerInterface, text: str) -> list[float]:
    """The planned joints' positions; other joints that are named are set in the world."""
    parts = [part.strip() for part in text.split(",")] if text.strip() else []
    names = world.get_joint_names("robot")
    if "=" not in text:
        if len(parts) != len(names):
            raise click.BadParameter(f"--state has {len(parts)} values; the planned joints are {', '.join(names)}.")
        return [_position(name, value) for name, value in zip(names, parts, strict=True)]
    values = {name: _position(name, value) for name, value in parse_key_values(parts).items()}
    if others := {name: value for name, value in values.items() if name not in names}:
        world.set_joint_positions("robot", others)
    if missing := [name for name in names if name not in values]:
        raise click.BadParameter(f"--state has no position for joint '{missing[0]}'.")
    return [values[name] for name in names]


def _position(joint: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"--state: '{text}', of joint '{joint}', is not a number.") from None


def _limit_violations(world: srmp.PlannerInterface, q: Sequence[float]) -> list[str]:
    names, limits = world.get_joint_names("robot"), world.get_joint_limits("robot")
    return [
        f"{name}: {value:g} is outside its limits [{lower:g}, {upper:g}]"
        for name, value, (lower, upper, _) in zip(names, q, limits, strict=True)
        if not lower - 1e-9 <= value <= upper + 1e-9
    ]


@main.command()
@click.argument("file", type=EXISTING_FILE)
@click.option("--scene", type=EXISTING_FILE, help="Of a trajectory: scene or problem file; of a URDF: MoveIt YAML.")
@click.option("--urdf", type=EXISTING_FILE, help="The robot of a trajectory or a MoveIt scene.")
@_robot_details
@click.option("--as", "kinds", multiple=True, help="Draw robots as visual, collision or spheres; may be repeated.")
@click.option("--html", type=click.Path(dir_okay=False), help="Write a page that plays without a server, and end.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Where the viewer is served.")
@click.option("--port", type=click.IntRange(0, 65535), default=8080, show_default=True, help="0: any that is free.")
@click.option("--no-browser", is_flag=True, help="Do not open a browser.")
def view(
    file: str,
    scene: str | None,
    urdf: str | None,
    srdf: str | None,
    end_effector: str,
    group: str,
    package_dirs: tuple[str, ...],
    kinds: tuple[str, ...],
    html: str | None,
    host: str,
    port: int,
    no_browser: bool,
) -> None:
    """See a robot, a scene, a motion, or why a plan failed, in the browser.

    FILE is a problem or scene file, a trajectory file or what srmp plan writes (with --scene or --urdf), a URDF, or a
    MoveIt scene (with --urdf). Ctrl-C ends the viewer.
    """
    from srmp import viewer
    from srmp._view_file import open_file

    def robot_world(path: str, moveit_scene: str | None) -> srmp.PlannerInterface:
        return _make_world(path, srdf, end_effector, group, package_dirs, moveit_scene)

    world, trajectory = open_file(file, scene, urdf, package_dirs, robot_world)
    if html:
        viewer.to_html(world, html, trajectory, title=Path(file).name, kinds=kinds or None)
        click.echo(f"wrote {html}")
        return
    with viewer.show(world, trajectory, kinds=kinds or None, host=host, port=port, open_browser=not no_browser) as page:
        click.echo(f"{page.url} (Ctrl-C ends)")
        page.wait()


@main.command()
@click.argument("urdf", type=EXISTING_FILE)
@click.option("--package-dir", "package_dirs", multiple=True, help="Where meshes are looked for; may be repeated.")
@click.option("--accuracy", type=float, default=4.0, show_default=True, help="How far fine spheres may stick out [mm].")
@click.option(
    "--coarse", type=float, default=15.0, show_default=True, help="How far coarse spheres may stick out [mm]."
)
@click.option(
    "--max-spheres",
    type=click.IntRange(min=0),
    default=160,
    show_default=True,
    help="Coarse spheres in all; they grow where more would be needed. 0: no limit.",
)
@click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")
@click.option("-o", "--output", type=click.Path(dir_okay=False), help="Write the spheres (JSON, link frames, metres).")
@click.option("--figure", type=click.Path(dir_okay=False), help="Draw them with all joints at 0 (PNG, PDF or SVG).")
def cover(
    urdf: str,
    package_dirs: tuple[str, ...],
    accuracy: float,
    coarse: float,
    max_spheres: int,
    no_cache: bool,
    output: str | None,
    figure: str | None,
) -> None:
    """Cover a robot's links with spheres that provably contain them."""
    from srmp import _cover

    for path in (output, figure):
        if path and not Path(path).parent.is_dir():
            raise click.BadParameter(f"the directory {Path(path).parent} does not exist.")
    with steps_bar() as progress:
        result = srmp.cover(
            urdf,
            package_dirs=list(package_dirs),
            accuracy=accuracy * 1e-3,
            coarse_accuracy=coarse * 1e-3,
            max_coarse=max_spheres,
            cache=not no_cache,
            progress=progress,
        )
    click.echo(_cover.format_report(result, coarse))
    if output:
        _cover.write(result, output)
        click.echo(f"wrote {output}")
    if figure:
        try:
            _cover.draw(result, urdf, figure)
        except ModuleNotFoundError as error:
            click.echo(f"no figure: {error.name} is not installed (pip install '.[demo]' in the checkout)", err=True)
        except ValueError as error:  # a format that matplotlib does not know
            raise click.BadParameter(f"--figure: {error}.") from error
        else:
            click.echo(f"wrote {figure}")


@main.command("cmake-dir")
def cmake_dir() -> None:
    """Print the directory of srmpConfig.cmake, for -Dsrmp_DIR=…"""
    click.echo(srmp.get_cmake_dir())


for command in (robots, srdf, bench, generate, audit, export):
    main.add_command(command)
keep_inputs(main)


if __name__ == "__main__":
    main()
