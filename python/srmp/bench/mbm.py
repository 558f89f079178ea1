"""MotionBenchMaker (Chamzas et al., RA-L 2022): runs its problems and writes one row for each.

The data directory holds, for each robot, its URDF and SRDF, meshes, and MoveIt's files
problems/<scenario>_<robot>/{scene,request}NNNN.yaml, unpacked or as problems.tar.bz2 (unpacked into a temporary
directory, never into the data).
"""

from __future__ import annotations

import contextlib
import datetime
import difflib
import functools
import importlib.metadata
import math
import os
import platform
import re
import tarfile
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._moveit import require_unconstrained
from srmp._table import format_seconds, format_table
from srmp.bench.runner import Execution, Progress, Steps, run_rows

# The link whose path length is reported; other robots: the end of the planning group.
END_EFFECTORS = {"panda": "panda_hand", "ur5": "ee_link", "fetch": "gripper_link"}
# The planning group that the problems are for, where no request says it.
GROUPS = {"panda": "panda_arm", "ur5": "manipulator", "fetch": "arm_with_torso"}
_ENTRY = re.compile(r"(?:^|/)(?P<scenario>[^/]+)/(?P<kind>scene|request)(?P<number>\d+)\.yaml$")
STATISTICS = (
    *("plan_time_s", "total_time_s", "search_time_s", "timing_time_s", "verification_time_s"),
    *("found_by", "expansions", "memory_bytes", "edge_checks"),
    *("edges_free_by_spheres", "edges_colliding_by_spheres", "edges_free_by_coal", "edges_colliding_by_coal"),
)
PROFILES = ("times", "positions", "velocities", "accelerations")
COSTS = ("path_cost_rad", "straight_cost_rad", "ee_cost_m")


# --- problems ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Problem:
    """A problem of MotionBenchMaker: its scene and its request."""

    scenario: str
    number: int
    scene: Path
    request: Path

    @property
    def name(self) -> str:
        """The name in result files, such as "cage/0001"."""
        return f"{self.scenario}/{self.number:04d}"


@dataclass(frozen=True)
class RobotFiles:
    """The files of a robot in the data directory."""

    name: str
    directory: Path
    urdf: Path
    srdf: Path


def robot_files(data: str | Path, robot: str, geometry: str) -> RobotFiles:
    """Finds URDF (geometry "urdf") or sphere model ("spheres") and SRDF of a robot in the data directory."""
    data = Path(data)
    directory = data / robot
    if not directory.is_dir():
        raise srmp.FileError(f"{directory} is not a directory{_nearest(robot, _directories(data))}.")
    if geometry not in ("urdf", "spheres"):
        raise srmp.InvalidArgument(f"geometry '{geometry}' is neither 'urdf' nor 'spheres'.")
    urdf = directory / (f"{robot}.urdf" if geometry == "urdf" else f"{robot}_spherized.urdf")
    srdf = directory / f"{robot}.srdf"
    for file in (urdf, srdf):
        if not file.is_file():
            raise srmp.FileError(f"{file} does not exist.")
    return RobotFiles(robot, directory, urdf, srdf)


def load_robot(files: RobotFiles, group: str) -> srmp.PlannerInterface:
    """A planner with the robot, called as in `files`, and nothing else."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=str(files.urdf),
        srdf_path=str(files.srdf),
        name=files.name,
        end_effector=END_EFFECTORS.get(files.name, ""),
        group=group,
        package_dirs=[str(files.directory)],
    )
    return planner


def parse_numbers(text: str) -> set[int]:
    """ "1-10" or "1,3,5-7" as a set of problem numbers."""
    numbers: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        if not match:
            raise srmp.InvalidArgument(
                f"problems '{text}': '{part.strip()}' is neither a number nor a range like 1-10."
            )
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise srmp.InvalidArgument(f"problems '{text}': the range {first}-{last} runs backwards.")
        numbers.update(range(first, last + 1))
    return numbers


@contextlib.contextmanager
def open_problems(
    directory: str | Path, robot: str, scenarios: Sequence[str] = (), numbers: set[int] | None = None
) -> Iterator[list[Problem]]:
    """The chosen problems in the order (scenario, number); their files exist until the context ends."""
    directory = Path(directory)
    with contextlib.ExitStack() as stack:
        if (directory / "problems").is_dir():
            root = directory / "problems"
        elif (directory / "problems.tar.bz2").is_file():
            root = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="srmp-mbm-")))
            _unpack(directory / "problems.tar.bz2", root)
        else:
            raise srmp.FileError(f"{directory} has neither problems/ nor problems.tar.bz2.")
        yield _select(_discover(root, robot), scenarios, numbers)


def _unpack(archive: Path, root: Path) -> None:
    try:
        with tarfile.open(archive) as tar:
            entries = [entry for entry in tar.getmembers() if entry.isfile() and _ENTRY.search(entry.name)]
            for entry in entries:  # plain files only, so this is all that Pythons without data_filter need
                if Path(entry.name).is_absolute() or ".." in Path(entry.name).parts:
                    raise tarfile.TarError(f"{entry.name} would lie outside the directory")
            safely = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
            tar.extractall(root, entries, **safely)
    except (tarfile.TarError, EOFError, OSError) as error:
        raise srmp.FileError(f"{archive} cannot be unpacked: {error}.") from error


def _discover(root: Path, robot: str) -> list[Problem]:
    scenes: dict[tuple[str, int], Path] = {}
    requests: dict[tuple[str, int], Path] = {}
    for path in root.rglob("*.yaml"):
        if match := _ENTRY.search(path.as_posix()):
            key = (match["scenario"].removesuffix(f"_{robot}"), int(match["number"]))
            (scenes if match["kind"] == "scene" else requests)[key] = path
    if unpaired := sorted(scenes.keys() ^ requests.keys()):
        scenario, number = unpaired[0]
        raise srmp.FileError(f"Problem {scenario}/{number:04d} has only one of scene and request.")
    return [Problem(*key, scenes[key], requests[key]) for key in sorted(scenes)]


def _select(problems: list[Problem], scenarios: Sequence[str], numbers: set[int] | None) -> list[Problem]:
    known = sorted({problem.scenario for problem in problems})
    for scenario in scenarios:
        if scenario not in known:
            raise srmp.InvalidArgument(
                f"scenario '{scenario}' is not one of {', '.join(known)}{_nearest(scenario, known)}."
            )
    chosen = [
        problem
        for problem in problems
        if (not scenarios or problem.scenario in scenarios) and (numbers is None or problem.number in numbers)
    ]
    if not chosen:
        there = [problem.number for problem in problems if not scenarios or problem.scenario in scenarios]
        given = ", ".join(map(str, sorted(numbers or ())))
        raise srmp.InvalidArgument(f"no problem has the numbers {given}; there are {min(there)} … {max(there)}.")
    return chosen


def _directories(path: Path) -> list[str]:
    return sorted(child.name for child in path.iterdir() if child.is_dir()) if path.is_dir() else []


def _nearest(name: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f", did you mean '{near[0]}'?" if near else ""


# --- running ----------------------------------------------------------------------------------------------------------


class Runner:
    """Plans one problem after the other with one robot model; the scene is emptied in between."""

    def __init__(
        self,
        files: RobotFiles,
        planner_id: str,
        options: Mapping[str, str],
        time_limit: float,
        steps: Steps | None = None,
    ) -> None:
        self._steps = steps
        self._files = files
        self._options = {"planner_id": planner_id, "time_limit": time_limit, **options}
        self._planner: srmp.PlannerInterface | None = None
        self._group = ""
        self._unpacked = contextlib.ExitStack()

    def _planner_for(self, group: str) -> srmp.PlannerInterface:
        """The planner with an empty scene; the robot is read once a planning group."""
        if self._planner is None or self._group != group:
            planner = load_robot(self._files, group)
            planner.prepare(self._steps)
            planner.make_planner([self._files.name], self._options)
            self._planner, self._group = planner, group
        for name in self._planner.object_names:
            self._planner.remove_object(name)
        return self._planner

    @functools.cached_property
    def _own_problems(self) -> dict[str, Problem]:
        opened = open_problems(self._files.directory, self._files.name)
        return {problem.name: problem for problem in self._unpacked.enter_context(opened)}

    def _on_this_machine(self, problem: Problem) -> Problem:
        """A worker on another machine unpacks the problems itself."""
        return problem if problem.request.is_file() else self._own_problems[problem.name]

    def set_up(self, problem: Problem) -> tuple[srmp.PlannerInterface, srmp.MoveItProblem]:
        """The problem's scene, and its start and goals for the robot (whose name is that of the files)."""
        problem = self._on_this_machine(problem)
        request = srmp.load_moveit_request(str(problem.request))
        planner = self._planner_for(request.group_name)
        planner.load_moveit_scene(str(problem.scene))
        joint_names = planner.get_joint_names(self._files.name)
        missing = [joint for joint in joint_names if joint not in request.start_joints]
        if missing:
            raise srmp.InvalidArgument(f"{problem.request}: the start has no position for joint '{missing[0]}'.")
        # The requests also place joints that these URDFs hold fixed (fingers, wheels): those are left out.
        moveit_problem = planner.apply_moveit_request(self._files.name, request)
        require_unconstrained(moveit_problem, problem.request)
        return planner, moveit_problem

    def run(self, problem: Problem) -> dict[str, Any]:
        """One row of the result file. Only problems that cannot even be set up raise."""
        planner, moveit_problem = self.set_up(problem)
        trajectory, reason = None, ""
        try:
            trajectory = planner.plan(self._files.name, moveit_problem.start, moveit_problem.goals)
            status = "solved"
        except srmp.PlanningError as error:
            status, reason = status_name(error.status), str(error)
        return self._row(problem, planner, status, reason, trajectory)

    def _row(
        self,
        problem: Problem,
        planner: srmp.PlannerInterface,
        status: str,
        reason: str,
        trajectory: srmp.Trajectory | None,
    ) -> dict[str, Any]:
        stats = planner.get_planning_stats()
        row: dict[str, Any] = {"problem": problem.name, "status": status, "reason": reason}
        row.update((key, stats[key]) for key in STATISTICS)
        row["joint_names"] = planner.get_joint_names(self._files.name)
        if trajectory is None:
            row.update(dict.fromkeys(("path", *COSTS, "bound", "certificate", *PROFILES)))
            return row
        row["path"] = trajectory.waypoints
        row["straight_cost_rad"] = straight_length(planner, self._files.name, trajectory.waypoints)
        row["path_cost_rad"] = stats["path_cost_rad"]
        row["ee_cost_m"] = end_effector_length(planner, self._files.name, trajectory.waypoints)
        row["bound"] = stats["bound"]
        row["certificate"] = certificate_row(trajectory.certificate)
        row.update((name, getattr(trajectory, name)) for name in PROFILES)
        return row


def certificate_row(certificate: srmp.Certificate | None) -> dict[str, Any] | None:
    """The part of a certificate that results hold; None without one."""
    if certificate is None:
        return None
    kept = ("holds", "proved_free", "clearance", "clearance_proved", "deviation", "goal_error")
    return {name: getattr(certificate, name) for name in kept}


def difference(planner: srmp.PlannerInterface, robot: str, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """b - a, of configurations or rows of them; continuous joints the short way round."""
    motion = b - a
    continuous = np.isinf(planner.get_joint_limits(robot)).all(axis=1)
    motion[..., continuous] = (motion[..., continuous] + np.pi) % (2 * np.pi) - np.pi
    return motion


def straight_length(planner: srmp.PlannerInterface, robot: str, path: np.ndarray) -> float:
    """Length [rad] of the straight motion from the path's start to its end, continuous joints the short way round."""
    return float(np.linalg.norm(difference(planner, robot, path[0], path[-1])))


def end_effector_length(planner: srmp.PlannerInterface, robot: str, path: np.ndarray) -> float:
    """How far the end effector travels along the waypoints [m]."""
    return srmp.Trajectory(planner.get_joint_names(robot), path).end_effector_length(planner, robot)


def run(
    data: str | Path,
    robot: str,
    *,
    scenarios: Sequence[str] = (),
    problems: str = "",
    planner_id: str = "auto",
    options: Mapping[str, str] | None = None,
    geometry: str = "urdf",
    time_limit: float = 10.0,
    execution: Execution | None = None,
    progress: Progress[Problem] | None = None,
    steps: Steps | None = None,
) -> dict[str, Any]:
    """Runs the chosen problems and returns {"header": …, "rows": […]}; runner.run_rows says how.

    Ctrl-C ends it early: header["complete"] is then False, and the rows are those that were finished.
    """
    execution = execution or Execution()
    files = robot_files(data, robot, geometry)
    numbers = parse_numbers(problems) if problems else None
    settings = (files, planner_id, options or {}, time_limit)
    described = {
        "data": str(data),
        "robot": robot,
        "scenarios": [],
        "problems": problems or "all",
        "planner": planner_id,
        "planner_options": dict(options or {}),
        "geometry": geometry,
        "time_limit": time_limit,
    }
    with open_problems(files.directory, robot, scenarios, numbers) as chosen:
        described["scenarios"] = sorted({problem.scenario for problem in chosen})
        runner = Runner(*settings, steps)
        if execution.distributed:
            runner.set_up(chosen[0])  # the sphere covers are computed once, before the workers begin
        rows, complete = run_rows(
            chosen,
            functools.partial(Runner, *settings),
            request=journal_request("MotionBenchMaker", described),
            solver=runner,
            execution=execution,
            progress=progress,
        )
    return {"header": run_header("MotionBenchMaker", complete, described, execution), "rows": rows}


def journal_request(benchmark: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """What the journal of a run is of: rows of other options or versions do not belong beside each other."""
    return {"benchmark": benchmark, **options, "versions": versions()}


def run_header(
    benchmark: str, complete: bool, options: Mapping[str, Any], execution: Execution, **more: Any
) -> dict[str, Any]:
    """The header of a run: header(), and whether it is complete, when it ended, the cores, workers and options."""
    created = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
    about = {"complete": complete, "created": created, "cores": os.cpu_count()}
    if execution.distributed:
        about.update(workers=execution.workers, ray=execution.ray)
    return header(benchmark, **about, options=options, **more)


def status_name(status: Any) -> str:
    """ "timed_out" for Status.timed_out."""
    return getattr(status, "name", None) or str(status)


def header(benchmark: str, **more: Any) -> dict[str, Any]:
    """The header of a result file: what was measured, by which versions, on which CPU, and `more`."""
    return {"benchmark": benchmark, "versions": versions(), "cpu": cpu_name(), **more}


def versions() -> dict[str, str]:
    """The versions of srmp, Python and the libraries that decide speed."""
    found = {"srmp": srmp.__version__, "python": platform.python_version()}
    for name in ("numpy", "libpinocchio", "libcoal"):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def cpu_name() -> str:
    """The name of the CPU, as far as the system tells it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


# --- statistics -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ScenarioStatistics:
    """Times [s] and costs are over the solved problems, NaN when there is none; invalid problems are not failures."""

    scenario: str
    solved: int
    valid: int
    total: int
    time_median: float
    time_mean: float
    time_p95: float
    time_max: float
    mean_cost_rad: float
    mean_straight_cost_rad: float
    mean_ee_cost_m: float
    after_median: float
    """Time for timing and certificate."""
    proved: int
    """Trajectories whose certificate holds and proves all of the motion free."""


def statistics(rows: Sequence[Mapping[str, Any]]) -> list[ScenarioStatistics]:
    """One entry a scenario in the order of the rows, then one over all with scenario "all"."""
    scenarios = dict.fromkeys(row["problem"].rpartition("/")[0] for row in rows)
    groups = [(name, [row for row in rows if row["problem"].rpartition("/")[0] == name]) for name in scenarios]
    return [_statistics(name, group) for name, group in [*groups, ("all", list(rows))]]


def _statistics(name: str, rows: Sequence[Mapping[str, Any]]) -> ScenarioStatistics:
    solved = [row for row in rows if row["status"] == "solved"]
    valid = [row for row in rows if row["status"] not in ("start_invalid", "goal_invalid")]
    times = np.array([row["plan_time_s"] for row in solved]) if solved else np.array([math.nan])
    costs = [row["path_cost_rad"] for row in solved] or [math.nan]
    straight = [row.get("straight_cost_rad", math.nan) for row in solved] or [math.nan]
    lengths = [row["ee_cost_m"] for row in solved] or [math.nan]
    after = [row.get("total_time_s", math.nan) - row["plan_time_s"] for row in solved] or [math.nan]
    return ScenarioStatistics(
        scenario=name,
        solved=len(solved),
        valid=len(valid),
        total=len(rows),
        time_median=float(np.median(times)),
        time_mean=float(np.mean(times)),
        time_p95=float(np.percentile(times, 95)),
        time_max=float(np.max(times)),
        mean_cost_rad=float(np.mean(costs)),
        mean_straight_cost_rad=float(np.mean(straight)),
        mean_ee_cost_m=float(np.mean(lengths)),
        after_median=float(np.median(after)),
        proved=sum(bool(c and c["holds"] and c["proved_free"]) for c in (row.get("certificate") for row in solved)),
    )


COLUMNS = (
    *("scenario", "solved/valid/total", "median", "mean", "p95", "max", "cost [rad]", "straight", "end effector [m]"),
    *("timing + proof", "proved"),
)


def cells(entry: ScenarioStatistics) -> list[str]:
    """What stands under COLUMNS."""
    times = (entry.time_median, entry.time_mean, entry.time_p95, entry.time_max)
    return [
        entry.scenario,
        f"{entry.solved}/{entry.valid}/{entry.total}",
        *("–" if math.isnan(time) else format_seconds(time) for time in times),
        "–" if math.isnan(entry.mean_cost_rad) else f"{entry.mean_cost_rad:.2f}",
        "–" if math.isnan(entry.mean_straight_cost_rad) else f"{entry.mean_straight_cost_rad:.2f}",
        "–" if math.isnan(entry.mean_ee_cost_m) else f"{entry.mean_ee_cost_m:.2f}",
        "–" if math.isnan(entry.after_median) else format_seconds(entry.after_median),
        str(entry.proved),
    ]


def format_statistics(rows: Sequence[Mapping[str, Any]]) -> str:
    """The table that `srmp bench mbm` prints: times until the path is ready, joint-space and end-effector length."""
    return format_table(COLUMNS, [cells(entry) for entry in statistics(rows)], rule_before_last=True)
