"""Plan times and costs beside aims, in one table, and beside another installed build in pairs.

    python bench/suites/speed.py --data DIR [--multi-data DIR] [--aims 1,2,3] [--problems 1-5] [--rounds 3]
        [--baseline PYTHON] [--vamp PYTHON] [--out speed.json]

DIR holds MotionBenchMaker's robots and problems; --multi-data is a directory with panda_two_rod.json, panda_four.json
and their robot in panda/. Aims: 1 one arm of spheres, until the path is ready; 2 exact meshes, also to poses; 3
certified and timed, from call to return, the first plan in a new and in a changed scene, beside a later one after other
work, and one object moved or added among 100; 4 cost over time; 5 many arms.

Times are CPU times of a process whose planner has one thread. Every case runs --rounds times in a process of its own;
with --baseline, the Python of an environment that holds another build, both take turns. A problem's time is its best of
all rounds; the last columns are the baseline's median and the median of the problems' ratios to it. Where the `ompl`
wheel is installed (pip install ompl), OMPL's RRTConnect and AORRTC are run on the same problems and collision checker,
as a yardstick; their checks go through Python. With --vamp, the Python of an environment that holds vamp
(github.com/KavrakiLab/vamp, with its Panda), so are VAMP's RRT-Connect with simplification and its AORRTC, which check
samples of motions against the same spheres, by VAMP's own measurement of time.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from report import result_of

import srmp
from srmp._table import format_table
from srmp.bench import mbm

SCENARIOS = ("bookshelf_small", "bookshelf_tall", "bookshelf_thin", "box", "cage", "table_pick", "table_under_pick")
SPHERES = {"table_under_pick": 0.5, "cage": 1.2}  # [ms] aims for AVX2; 0.35 for the others
ANYTIME = dict(zip(SCENARIOS, (4.23, 4.53, 4.33, 4.25, 5.87, 4.35, 4.54), strict=True))  # mean costs of AORRTC
TIMES = (0.001, 0.01, 0.03, 0.1)  # [s] of aim 4
PATH_ONLY = {"timing": "none", "certify": False}
LIMIT = 20.0  # [s] of a plan
YARDSTICK, VAMP = "yardstick", "vamp"  # the kinds of case that no other build runs
VAMP_ITERATIONS = (100, 300, 1000, 3000, 10000)  # of its AORRTC, which has no time limit
REPEATS = 5  # of a plan in one process

Measured = dict[str, dict[str, Any]]
"""Problem: seconds (None: not solved), cost [rad] and what else a kind of case measures."""


@dataclass(frozen=True)
class Case:
    """A row of the table."""

    aim: int
    name: str
    kind: str
    arguments: tuple[Any, ...]
    goal: str


def cases(aims: Sequence[int], multi_data: str | None, vamp: str | None) -> list[Case]:
    """Of the chosen aims, beside OMPL's planners where its wheel is installed and VAMP's by the Python `vamp`."""
    wheel = has_wheel()
    found = [
        Case(1, f"{scenario}, spheres", "path", ("panda", "spheres", scenario), f"{SPHERES.get(scenario, 0.35)} ms")
        for scenario in SCENARIOS
    ]
    found += [
        Case(1, f"{scenario}, OMPL's RRTConnect", YARDSTICK, ("RRT-Connect", scenario), "–")
        for scenario in SCENARIOS
        if wheel
    ]
    found += [
        Case(1, f"{scenario}, VAMP's RRT-Connect", VAMP, ("rrtc", scenario, vamp), "–")
        for scenario in SCENARIOS
        if vamp
    ]
    found += [
        Case(2, f"{scenario}, meshes", "path", ("panda", "urdf", scenario), "2 × spheres") for scenario in SCENARIOS
    ]
    found += [Case(2, f"{robot}, meshes", "path", (robot, "urdf", ""), goal) for robot, goal in OTHERS.items()]
    found += [
        Case(2, f"{scenario}, meshes, to poses", "to_pose", ("panda", "urdf", scenario), "–") for scenario in SCENARIOS
    ]
    found += [Case(2, f"{robot}, meshes, to poses", "to_pose", (robot, "urdf", ""), "–") for robot in OTHERS]
    found += [
        Case(3, f"{scenario}, certified", "certified", ("panda", "spheres", scenario), "1 ms") for scenario in SCENARIOS
    ]
    found += [
        Case(3, f"{scenario}, {name}", kind, ("panda", "urdf", scenario), goal)
        for scenario in SCENARIOS
        for name, kind, goal in (
            ("first plan", "first", "–"),
            ("first plan after all objects moved", "after_change", "0.2 ms more"),
            ("a later plan after other work", "after_other_work", "–"),
        )
    ]
    found += [Case(3, f"one of 100 boxes {change}", change, (), "0.05 ms") for change in ("moved", "added")]
    found += [
        Case(4, f"{scenario}, at {1e3 * TIMES[-1]:g} ms", "anytime", ("panda", "spheres", scenario), f"cost {cost}")
        for scenario, cost in ANYTIME.items()
    ]
    found += [
        Case(4, f"{scenario}, AORRTC at {1e3 * TIMES[-1]:g} ms", YARDSTICK, ("AORRTC", scenario), "–")
        for scenario in SCENARIOS
        if wheel
    ]
    found += [
        Case(4, f"{scenario}, VAMP's AORRTC at {1e3 * TIMES[-1]:g} ms", VAMP, ("aorrtc", scenario, vamp), "–")
        for scenario in SCENARIOS
        if vamp
    ]
    found += cases_of_arms(multi_data)
    return [case for case in found if case.aim in aims]


def cases_of_arms(multi_data: str | None) -> list[Case]:
    """To the configurations that the aims are about, and to poses."""
    of_files = {"two_rod": "8 ms", "four": "30 ms"} if multi_data else {}
    found = []
    for kind, to in (("arms", ""), ("arms_to_poses", ", to poses")):
        for name, goal in of_files.items():
            file = str(Path(multi_data or "", f"panda_{name}.json"))
            found.append(Case(5, name + to, kind, (file, None, multi_data), "–" if to else goal))
        for name, count, goal in GENERATED_TO_POSES if to else GENERATED:
            found.append(Case(5, f"{name} of {count}{to}", kind, (name, count, None), goal))
    return found


def has_wheel() -> bool:
    from srmp.bench import ompl_wheel  # which other builds may not have

    return ompl_wheel.module() is not None


OTHERS = {"ur5": "2 ms", "fetch": "10 ms"}
GENERATED = (
    ("binpick", 4, "mean 60 ms"),
    ("shelves", 3, "mean 60 ms"),
    ("grid", 64, "0.3 s"),
    ("grid", 128, "1 s"),
    ("ring", 16, "1 s"),
)
GENERATED_TO_POSES = (("binpick", 4, "–"), ("shelves", 3, "–"), ("grid", 16, "–"))


# --- measurements, in a process with one build ------------------------------------------------------------------------


def cpu(call: Callable[[], Any]) -> tuple[float | None, Any]:
    """CPU time and result; None for both where there is no plan."""
    begin = time.process_time()
    try:
        result = call()
    except srmp.PlanningError:
        return None, None
    return time.process_time() - begin, result


def best(call: Callable[[], Any], repeats: int = REPEATS) -> tuple[float | None, Any]:
    """Of the repeats after the first, which warms the caches."""
    _, result = cpu(call)
    if result is None:
        return None, None
    return min(seconds for seconds, _ in (cpu(call) for _ in range(repeats)) if seconds is not None), result


def more(seconds: float | None, than: float | None) -> dict[str, Any]:
    """By how much; None where there is no plan."""
    return {"seconds": None if seconds is None or than is None else seconds - than, "cost": None}


def over_problems(
    data: str,
    problems: str,
    robot: str,
    geometry: str,
    scenario: str,
    options: Mapping[str, Any],
    measure: Any,
    goals_of: Callable[[srmp.PlannerInterface, srmp.MoveItProblem], Any] = lambda _, own: own.goals,
) -> Measured:
    """measure(planner, plan) for each problem."""
    return {
        name: measure(planner, lambda: planner.plan(robot, own.start, goals))  # noqa: B023
        for name, planner, own in set_up(data, problems, robot, geometry, scenario, options)
        for goals in [goals_of(planner, own)]
    }


def set_up(
    data: str, problems: str, robot: str, geometry: str, scenario: str, options: Mapping[str, Any]
) -> Iterator[tuple[str, srmp.PlannerInterface, srmp.MoveItProblem]]:
    """The name of each problem, a planner in its scene, and its start and goals; good until the next one."""
    files = mbm.robot_files(data, robot, geometry)
    runner = mbm.Runner(files, "auto", dict(options), LIMIT)
    named = (scenario,) if scenario else ()
    with mbm.open_problems(files.directory, robot, named, mbm.parse_numbers(problems)) as chosen:
        for problem in chosen:
            yield problem.name, *runner.set_up(problem)


def cost(planner: srmp.PlannerInterface) -> float:
    return planner.get_planning_stats()["path_cost_rad"]


def time_and_cost(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
    seconds, _ = best(plan)
    return {"seconds": seconds, "cost": None if seconds is None else cost(planner)}


def path(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    return over_problems(data, problems, robot, geometry, scenario, PATH_ONLY, time_and_cost)


def to_pose(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    """Of the end effector, where the problem's goal has it: with inverse kinematics."""

    def pose(planner: srmp.PlannerInterface, own: srmp.MoveItProblem) -> srmp.GoalConstraint:
        return srmp.GoalConstraint(srmp.GoalType.POSE, planner.compute_fk(robot, own.goals[0].targets[0]))

    return over_problems(data, problems, robot, geometry, scenario, PATH_ONLY, time_and_cost, pose)


def certified(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    def measure(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
        seconds, result = best(plan)
        return {
            "seconds": seconds,
            "cost": None if seconds is None else cost(planner),
            "proved": seconds is not None and bool(result.certificate.proved_free),
        }

    return over_problems(data, problems, robot, geometry, scenario, {}, measure)


def first(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    """What the first plan of a new planner in a new scene costs more than a later one."""

    def measure(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
        once, _ = cpu(plan)
        later, _ = best(plan)
        return more(once, later)

    return over_problems(data, problems, robot, geometry, scenario, PATH_ONLY, measure)


def after_change(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    """What the first plan costs more than a later one after each of the scene's objects was moved, by a nanometre."""

    def measure(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
        before, _ = best(plan)
        for name in planner.object_names:
            pose = planner.get_object_pose(name)
            planner.set_object_pose(name, srmp.Pose(p=pose.p + 1e-9, q=pose.q))
        once, _ = cpu(plan)
        later, _ = best(plan)
        return more(once, None if before is None or later is None else min(before, later))

    return over_problems(data, problems, robot, geometry, scenario, PATH_ONLY, measure)


def after_other_work(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    """What a plan costs more after work that has nothing to do with it, which empties the processor's caches, as a
    change of the scene does.
    """

    def measure(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
        later, _ = best(plan)
        sorted(str(number) for number in range(20000))
        once, _ = cpu(plan)
        return more(once, later)

    return over_problems(data, problems, robot, geometry, scenario, PATH_ONLY, measure)


def with_box(kind: str, change: Callable[[srmp.PlannerInterface, srmp.Pose], None]) -> Measured:
    """What a plan costs more among 100 boxes after a change of box0, which is to stand at the pose."""
    planner, random = srmp.PlannerInterface(), np.random.default_rng(0)
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        end_effector="arm7_hand",
        name="arm",
    )
    for k in range(100):
        planner.add_box(f"box{k}", [0.05] * 3, srmp.Pose(p=[*random.uniform(1.0, 2.0, 2), random.uniform(0, 1)]))
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": LIMIT, **PATH_ONLY})
    start = np.array(planner.get_group_states("arm")["ready"])
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, start + 0.5 * np.eye(7)[0])
    still, _ = best(lambda: planner.plan("arm", start, goal), 50)

    def with_change() -> Any:
        change(planner, srmp.Pose(p=[*random.uniform(1.0, 2.0, 2), 0.5]))
        return planner.plan("arm", start, goal)

    after, _ = best(with_change, 50)
    return {kind: more(after, still)}


def moved(data: str, problems: str) -> Measured:
    return with_box("moved", lambda planner, pose: planner.set_object_pose("box0", pose))


def added(data: str, problems: str) -> Measured:
    def change(planner: srmp.PlannerInterface, pose: srmp.Pose) -> None:
        planner.remove_object("box0")
        planner.add_box("box0", [0.05] * 3, pose)

    return with_box("added", change)


def anytime(data: str, problems: str, robot: str, geometry: str, scenario: str) -> Measured:
    """Costs at TIMES, by the planner's own clock; `seconds` is when the first path was there."""

    def measure(planner: srmp.PlannerInterface, plan: Callable[[], Any]) -> dict[str, Any]:
        _, result = cpu(plan)
        if result is None:
            return {"seconds": None, "cost": None}
        known = [(each["time_s"], each["cost_rad"]) for each in planner.get_planning_stats()["solutions"]]
        at = costs_at_times(known)
        return {"seconds": known[0][0], "cost": at[f"{TIMES[-1]:g}"], "costs": at}

    options = {**PATH_ONLY, "improve_time": TIMES[-1]}
    return over_problems(data, problems, robot, geometry, scenario, options, measure)


def costs_at_times(known: Sequence[tuple[float, float]]) -> dict[str, float | None]:
    """The least cost known at each of TIMES; `known`: (seconds, cost)."""
    return {f"{t:g}": min((cost for seconds, cost in known if seconds <= t), default=None) for t in TIMES}


def yardstick(data: str, problems: str, name: str, scenario: str) -> Measured:
    """A planner of OMPL's, on our checker: the median time and mean cost of its REPEATS plans, which are random."""
    from srmp.bench import ompl_wheel

    limit = TIMES[-1] if name == "AORRTC" else LIMIT
    found: Measured = {}
    for problem, planner, own in set_up(data, problems, "panda", "spheres", scenario, {}):
        goal = own.goals[0].targets[0]
        results = [ompl_wheel.plan(planner, "panda", own.start, goal, name, limit) for _ in range(REPEATS)]
        solved = [r for r in results if r["status"] == "solved"]
        lengths = [float(np.linalg.norm(np.diff(r["waypoints"], axis=0), axis=1).sum()) for r in solved]
        seconds = float(np.median([r["plan_time_s"] for r in results])) if len(solved) == REPEATS else None
        found[problem] = {"seconds": seconds, "cost": float(np.mean(lengths)) if lengths else None}
    return found


def vamp(data: str, problems: str, name: str, scenario: str, python: str) -> Measured:
    """A planner of VAMP's; AORRTC's costs at TIMES are those of the runs that had ended by then."""
    task: dict[str, Any] = {"planner": name, "iterations": VAMP_ITERATIONS, "repeats": REPEATS, "problems": {}}
    for problem, planner, own in set_up(data, problems, "panda", "spheres", scenario, {}):
        ends = {"start": [*own.start], "goals": [[*q] for q in own.goals[0].targets]}
        task["problems"][problem] = ends | primitives(planner) | {"cylinders_as_boxes": scenario == "box"}
    program = str(Path(__file__).with_name("vamp_planners.py"))
    found: Measured = {}
    for problem, runs in result_of(f"VAMP by {python}", [python, program], json.dumps(task)).items():
        known = [(run["seconds"], run["cost"]) for run in runs if run["seconds"] is not None]
        at = costs_at_times(known)
        cheapest = at[f"{TIMES[-1]:g}"] if name == "aorrtc" else min((cost for _, cost in known), default=None)
        found[problem] = {"seconds": min((s for s, _ in known), default=None), "cost": cheapest, "costs": at}
    return found


def primitives(planner: srmp.PlannerInterface) -> dict[str, list[Any]]:
    """Boxes (centre, roll-pitch-yaw, half extents) and cylinders (centre, roll-pitch-yaw, radius, length)."""
    found: dict[str, list[Any]] = {"boxes": [], "cylinders": []}
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory, "scene.json")
        planner.save_scene(str(file))
        objects = json.loads(file.read_text())["scene"]["objects"]
    for shape, pose in ((each["shape"], each["pose"]) for each in objects):
        # Rounded, because VAMP has a quicker check for boxes that stand upright exactly.
        place = [pose[:3], [round(angle, 9) for angle in srmp.Pose.from_xyzw(pose[:3], pose[3:]).rpy()]]
        if shape["kind"] == "box":
            found["boxes"].append([*place, [size / 2 for size in shape["size"]]])
        elif shape["kind"] == "cylinder":
            found["cylinders"].append([*place, shape["radius"], shape["length"]])
        else:
            raise srmp.NotSupported(f"VAMP's column is for boxes and cylinders; this scene has a {shape['kind']}.")
    return found


def arms_to_poses(data: str, problems: str, scenario: str, robots: int | None, own_data: str | None) -> Measured:
    """Of the end effectors, where the problems' goals have them."""
    return arms(data, problems, scenario, robots, own_data, to_poses=True)


def arms(
    data: str, problems: str, scenario: str, robots: int | None, own_data: str | None, to_poses: bool = False
) -> Measured:
    from srmp.bench.scenarios import find

    found = find(scenario, robots, 0, own_data or data)
    planner = found.world.build()
    planner.prepare()
    names = [robot.name for robot in found.world.robots]
    planner.make_planner(names, {"planner_id": "auto", "time_limit": LIMIT, **PATH_ONLY})
    result: Measured = {}
    for number in sorted(mbm.parse_numbers(problems)):
        if number not in found.numbers:
            continue
        problem = found.problem(number)
        goals = {
            name: srmp.GoalConstraint(srmp.GoalType.POSE, planner.compute_fk(name, q))
            if to_poses
            else srmp.GoalConstraint(srmp.GoalType.JOINTS, q)
            for name, q in problem.goals.items()
        }
        seconds, _ = best(lambda: planner.plan_multi(problem.starts, goals), 1)  # noqa: B023
        result[f"{number:04d}"] = {"seconds": seconds, "cost": None if seconds is None else cost(planner)}
    return result


KINDS = {
    function.__name__: function
    for function in (
        path,
        to_pose,
        certified,
        first,
        after_change,
        after_other_work,
        moved,
        added,
        anytime,
        yardstick,
        vamp,
        arms,
        arms_to_poses,
    )
}


# --- rounds and pairs -------------------------------------------------------------------------------------------------


def run_in_process(python: str, case: Case, data: str, problems: str) -> Measured:
    """One round of a case by the build of this Python."""
    task = json.dumps([case.kind, data, problems, *case.arguments])
    return result_of(f"'{case.name}' by {python}", [python, __file__, "--here", task])


def merge(rounds: Sequence[Measured]) -> Measured:
    """Each problem with its best time; solved only where every round solved it."""
    merged: Measured = {}
    for problem, row in rounds[0].items():
        times = [measured[problem]["seconds"] for measured in rounds]
        merged[problem] = {**row, "seconds": None if None in times else min(times)}
    return merged


def run(
    data: str,
    multi_data: str | None,
    aims: str,
    problems: str,
    rounds: int,
    baseline: str | None,
    vamp: str | None = None,
) -> dict[str, Any]:
    """One row a case: what was measured by this build, and by the baseline."""
    if not data:
        raise srmp.InvalidArgument("data: say where MotionBenchMaker's robots and problems are.")
    try:
        numbers = [int(aim) for aim in aims.split(",")]
    except ValueError:
        numbers = [0]
    if not all(1 <= aim <= 5 for aim in numbers):
        raise srmp.InvalidArgument(f"aims '{aims}': they are 1 to 5, separated by commas.")
    builds = {"own": sys.executable, **({"baseline": baseline} if baseline else {})}
    rows = []
    for case in cases(numbers, multi_data, vamp):
        chosen = ["own"] if case.kind in (YARDSTICK, VAMP) else list(builds)
        measured: dict[str, list[Measured]] = {build: [] for build in chosen}
        for number in range(rounds):
            for build in chosen if number % 2 else reversed(chosen):  # neither is always the first
                measured[build].append(run_in_process(builds[build], case, data, problems))
        rows.append(
            {"aim": case.aim, "name": case.name, "goal": case.goal} | {b: merge(r) for b, r in measured.items()}
        )
    options = {"aims": numbers, "problems": problems, "rounds": rounds, "baseline": baseline, "vamp": vamp}
    return {"header": mbm.header("speed", options=options), "rows": rows}


def table(result: dict[str, Any]) -> str:
    paired = any("baseline" in row for row in result["rows"])
    lines = []
    for row in result["rows"]:
        own, other = row["own"], row.get("baseline")
        seconds = [each["seconds"] for each in own.values() if each["seconds"] is not None]
        costs = [each["cost"] for each in own.values() if each["cost"] is not None]
        median, p95 = (in_ms(np.percentile(seconds, p)) if seconds else "–" for p in (50, 95))
        cells = [str(row["aim"]), row["name"], f"{len(seconds)}/{len(own)}", median, p95]
        cells += [f"{np.mean(costs):.2f}" if costs else "–", row["goal"]]
        lines.append([*cells, *(pair_cells(own, other or {}) if paired else [])])
    head = ["aim", "case", "solved", "median", "95 %", "cost", "goal", *(["baseline", "ratio"] if paired else [])]
    return format_table(head, lines)


def in_ms(seconds: float) -> str:
    return f"{1e3 * seconds:.2f} ms"


def pair_cells(own: Measured, other: Measured) -> list[str]:
    """The baseline's median, and the median ratio of the problems that both solve."""
    pairs = [(own[p]["seconds"], other[p]["seconds"]) for p in own if p in other]
    both = [(a, b) for a, b in pairs if a is not None and b]
    if not both:
        return ["–", "–"]
    return [in_ms(float(np.median([b for _, b in both]))), f"{np.median([a / b for a, b in both]):.2f}"]


def main() -> None:
    if len(sys.argv) == 3 and sys.argv[1] == "--here":
        kind, data, problems, *arguments = json.loads(sys.argv[2])
        print(json.dumps(KINDS[kind](data, problems, *arguments)))
        return
    from report import run_and_report

    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--data", required=True, help="the directory given to srmp bench mbm")
    parser.add_argument(
        "--multi-data", help="directory of panda_two_rod.json and panda_four.json; without it: left out"
    )
    parser.add_argument("--aims", default="1,2,3,4,5")
    parser.add_argument("--problems", default="1-5", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--baseline", help="Python of an environment with another build")
    parser.add_argument("--vamp", help="Python of an environment with vamp; without it: left out")
    run_and_report(parser, run, table)


if __name__ == "__main__":
    main()
