"""Runs the experiments: which problems, by whom, in which order."""

from __future__ import annotations

import contextlib
import functools
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import srmp
from srmp._names import did_you_mean
from srmp.bench import mbm, ompl_wheel
from srmp.bench.paper.contestants import (
    BENCHMARK,
    EXPERIMENTS,
    NO_OMPL,
    Contestant,
    Experiment,
    by_wheel,
    ompl_module,
    why_not_run,
)
from srmp.bench.paper.solve import Task, make_solver
from srmp.bench.runner import Execution, Progress, run_rows
from srmp.bench.scenarios import KINDS

SCENARIOS = ("binpick", "shelves")
ROBOTS = ("panda", "ur5", "fetch")


def run(
    *,
    experiments: str = "a,b,c",
    planners: Sequence[str] = (),
    problems: str | Sequence[str] = (),
    repetitions: int | None = None,
    time_limit: float | str | Sequence[str] = (),
    seed: int = 0,
    data: str | Path | None = None,
    execution: Execution | None = None,
    progress: Progress[Task] | None = None,
) -> dict[str, Any]:
    """Runs the experiments and returns {"header": …, "rows": […]}; runner.run_rows says how.

    planners: only those of these names or ids. problems: numbers of base problems, and in each of MotionBenchMaker's
    scenarios. time_limit: [s]. Both for all experiments, or for one as "a=1-5". What is not given is as in the paper.
    header["notes"] says what could not be run here, and why.

    Ctrl-C ends it early: header["complete"] is then False, and the rows are those that were finished.
    """
    execution = execution or Execution()
    chosen = _experiments(experiments)
    _require_known(planners, chosen)
    if repetitions is not None and repetitions < 1:
        raise srmp.InvalidArgument(f"repetitions {repetitions}: there must be at least 1.")
    numbers = _by_experiment("problems", problems, chosen)
    limits = {letter: _seconds(text) for letter, text in _by_experiment("time-limit", time_limit, chosen).items()}
    described = {
        "experiments": [experiment.letter for experiment in chosen],
        "planners": list(planners),
        "problems": {e.letter: numbers.get(e.letter, e.problems) for e in chosen},
        "repetitions": {e.letter: repetitions or e.repetitions for e in chosen if e.letter != "c"},
        "time_limit": {e.letter: limits.get(e.letter, e.time_limit) for e in chosen},
        "seed": seed,
        "data": data,
    }
    versions = _versions(chosen)
    begin = time.perf_counter()
    with contextlib.ExitStack() as stack:
        tasks = [
            task
            for experiment in chosen
            for task in _tasks(experiment, described, [c for c in experiment.contestants if _runs(c, planners)], stack)
        ]
        solver = functools.partial(make_solver, data, seed)
        request = {**mbm.journal_request(BENCHMARK, described), **versions}
        rows, complete = run_rows(tasks, solver, request=request, execution=execution, progress=progress)
    header = mbm.run_header(
        BENCHMARK,
        complete,
        described,
        execution,
        **{"ompl": None, **versions},
        notes=_notes(chosen, data),
        elapsed_s=time.perf_counter() - begin,
    )
    return {"header": header, "rows": rows}


def _versions(chosen: Sequence[Experiment]) -> dict[str, Any]:
    """Of OMPL, as far as it is here."""
    module = ompl_module()
    versions = {} if module is None else {"ompl": module.version}
    if any(by_wheel(contestant) for experiment in chosen for contestant in experiment.contestants):
        versions["ompl_wheel"] = ompl_wheel.version()
    return versions


def _experiments(letters: str) -> list[Experiment]:
    chosen = [letter.strip() for letter in letters.split(",")]
    for letter in chosen:
        if letter not in EXPERIMENTS:
            raise srmp.InvalidArgument(f"experiment '{letter}' is not one of {', '.join(EXPERIMENTS)}.")
    return [experiment for letter, experiment in EXPERIMENTS.items() if letter in chosen]


def _by_experiment(option: str, given: float | str | Sequence[str], chosen: Sequence[Experiment]) -> dict[str, str]:
    """By letter, of ["1-5", "c=1-3"]; what names an experiment wins."""
    letters = [experiment.letter for experiment in chosen]
    for_all: dict[str, str] = {}
    for_one: dict[str, str] = {}
    for value in [given] if isinstance(given, str | float | int) else given:
        letter, named, text = str(value).rpartition("=")
        if named and letter not in letters:
            raise srmp.InvalidArgument(f"{option} '{value}': '{letter}' is not one of {', '.join(letters)}.")
        if named:
            for_one[letter] = text
        else:
            for_all = dict.fromkeys(letters, text)
    return for_all | for_one


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds < math.inf:
        raise srmp.InvalidArgument(f"time-limit '{text}' must be seconds above 0.")
    return seconds


def _require_known(planners: Sequence[str], experiments: Sequence[Experiment]) -> None:
    contestants = [c for e in experiments for c in e.contestants]
    known = list(dict.fromkeys(c.name for c in contestants))
    for name in planners:
        if not any(c.among([name]) for c in contestants):
            hint = did_you_mean(name, known) or "."
            raise srmp.InvalidArgument(f"planner '{name}' is not one of {', '.join(known)}{hint}")


def _runs(contestant: Contestant, planners: Sequence[str]) -> bool:
    return not why_not_run(contestant) and contestant.among(planners)


def _notes(experiments: Sequence[Experiment], data: str | Path | None) -> list[str]:
    notes = []
    if ompl_module() is None:
        notes.append(NO_OMPL)
    if any(experiment.letter == "c" for experiment in experiments):
        if data is None:
            notes.append("MotionBenchMaker's problems were not run: --data DIR says where they are.")
        elif missing := [robot for robot in ROBOTS if not _has(data, robot)]:
            notes.append(f"MotionBenchMaker's problems for {', '.join(missing)} were not run: the data has none.")
    return notes


def _has(data: str | Path | None, robot: str) -> bool:
    return data is not None and (Path(data) / robot).is_dir()


def _tasks(
    experiment: Experiment, described: dict[str, Any], contestants: Sequence[Contestant], stack: contextlib.ExitStack
) -> list[Task]:
    """In the order of the problems; the files of problems exist until the stack is unwound."""
    letter = experiment.letter
    limit = described["time_limit"][letter]
    numbers = sorted(mbm.parse_numbers(described["problems"][letter]))
    if letter == "c":
        return [
            Task(letter, robot, contestant, limit, problem=problem)
            for robot in ROBOTS
            if _has(described["data"], robot)
            for problem in stack.enter_context(
                mbm.open_problems(Path(described["data"]) / robot, robot, (), set(numbers))
            )
            for contestant in contestants
        ]
    if numbers[0] == 0:
        raise srmp.InvalidArgument("problems are numbered from 1.")
    repetitions = described["repetitions"][letter]
    return [
        Task(letter, scenario, contestant, limit, number, 1 if letter == "a" else KINDS[scenario].robots, repetitions)
        for scenario in SCENARIOS
        for base in numbers
        for number in range(1 + (base - 1) * repetitions, 1 + base * repetitions)
        for contestant in contestants
    ]
