"""The page with the results of the experiments."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import srmp
from srmp._files import write_json, write_text
from srmp.bench.paper.contestants import BENCHMARK, EXPERIMENTS, SRMP, Experiment
from srmp.bench.paper.statements import Statement, statements
from srmp.bench.paper.statements import markdown as statement_table
from srmp.bench.paper.tables import Entry, as_json, tables
from srmp.bench.paper.tables import markdown as entry_table

NO_FIGURES = 'There are no figures: matplotlib is not installed (pip install ".[bench]").'

_SETUP = {
    "a": """One Panda picks and places in bins (`binpick`) and moves from shelf to shelf (`shelves`): {problems}, each
with {repetitions}, for which one joint of the goal is moved by up to 2 degrees. The time limit is {time_limit:g} s.""",
    "b": """Four Pandas around bins (`binpick`) and three before a shelf (`shelves`) move at the same time: {problems},
each with {repetitions}, for which one joint of each goal is moved by up to 2 degrees. OMPL's planners plan in the
composite space of all robots. The time limit is {time_limit:g} s. Lengths are summed over the robots.""",
    "c": """MotionBenchMaker's problems {numbers} of each scenario, for the Panda, the UR5 and the Fetch. The time limit
is {time_limit:g} s. Boxes span the quartiles, whiskers 90 % of the problems; percentages say how many were solved.""",
}

_METHOD = """## How it is measured

- **Length** is the distance that the end effector travels, the paper's cost. **Variation** is its coefficient of
  variation (standard deviation by mean) over the repetitions of a base problem, averaged over base problems.
  **× shortest** compares with the shortest path that any planner found for the problem. Means are over the problems
  that the planner solved.
- **Time** ends when the path is ready: shortcut, in our planners, or simplified by OMPL's `PathSimplifier`, which takes
  the time that is left and at least one pass. Our planners have their default options, OMPL's their default
  parameters. `ARA*` and `AMRA*` improve their path for nine tenths of the time limit, unless it can be no better;
  RRT* does until the limit.
- **OMPL** plans on the same robot, scene and collision checker as our planners: motions are proved free between
  samples, so that only the planner differs. **OMPL, plain Coal** uses Pinocchio and Coal
  [as one writes it](benchmarks.md#plain-coal), and samples motions as MoveIt does by default (half a percent of the
  space's extent). AORRTC is that of the `ompl` wheel where it is installed; its checks go through Python, which makes
  each some microseconds slower.
- **Every path is checked again** by code that plans nothing: start, goal and joint limits are compared, and Coal's
  distances prove the motion between waypoints free. Motions of several robots from our planners are verified on their
  common clock. A path with a fault is *faulty* and does not count as solved.
- OMPL's planners take random numbers from a seed that depends on the problem (the wheel's from one of its own). Our
  planners need none. What PRM and the anytime planners find within their time depends on the machine.
- A statement about OMPL's planners is compared with those on the same collision checker, and, unless it names them,
  without the anytime planners.
"""


def write(result: Mapping[str, Any], directory: Path) -> list[str]:
    """Writes experiments.json, experiments.md and the figures; returns what was written, and what could not be."""
    directory.mkdir(parents=True, exist_ok=True)
    entries, found = tables(result), statements(result)
    said = []
    try:
        from srmp.bench.paper.figures import draw

        drawn = draw(result, directory)
        said += [f"wrote {directory / f'experiments-{letter}'}.svg and .png" for letter in drawn]
    except ModuleNotFoundError:
        drawn = []
        said.append(NO_FIGURES)
    write_text(directory / "experiments.md", page(result["header"], entries, found, result["rows"], drawn))
    write_json(
        directory / "experiments.json",
        {
            "header": result["header"],
            "seconds": durations(result["rows"]),
            "tables": as_json(entries),
            "statements": [asdict(statement) for statement in found],
            "rows": result["rows"],
        },
    )
    return [*said, f"wrote {directory / 'experiments.md'}", f"wrote {directory / 'experiments.json'}"]


def read(path: str | Path) -> dict[str, Any]:
    """The result in an experiments.json. Raises FileError where it is none."""
    try:
        result = json.loads(Path(path).read_text(encoding="utf-8"))
        if result["header"]["benchmark"] != BENCHMARK:
            raise ValueError("it is of another benchmark")
        return {"header": result["header"], "rows": result["rows"]}
    except (ValueError, KeyError, TypeError) as error:
        raise srmp.FileError(f"{path} holds no results of `srmp bench paper`: {error}.") from error


def durations(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """The time [s] that the rows of each experiment took: setting up, planning, checking."""
    found: dict[str, float] = {}
    for row in rows:
        found[row["experiment"]] = found.get(row["experiment"], 0.0) + row["row_time_s"]
    return found


def page(
    header: Mapping[str, Any],
    entries: Sequence[Entry],
    found: Sequence[Statement],
    rows: Sequence[Mapping[str, Any]],
    drawn: Sequence[str],
) -> str:
    """The page in Markdown."""
    options = header["options"]
    parts = [
        "# The paper's experiments",
        "This page is written by [`srmp bench paper`](cli.md#bench-paper). It repeats the experiments of the paper on\n"
        "SRMP with this library, beside what the paper says of them.",
        _how_it_was_run(header, rows),
        *header["notes"],
    ]
    if not header["complete"]:
        parts.append("**The run was interrupted: rows are missing.**")
    for letter in options["experiments"]:
        parts += _section(letter, options, entries, found, rows, drawn)
    return "\n\n".join([*parts, _METHOD])


def _section(
    letter: str,
    options: Mapping[str, Any],
    entries: Sequence[Entry],
    found: Sequence[Statement],
    rows: Sequence[Mapping[str, Any]],
    drawn: Sequence[str],
) -> list[str]:
    experiment = EXPERIMENTS[letter]
    here = [entry for entry in entries if entry.experiment == letter]
    parts = [f"## ({letter}) {experiment.title}"]
    if not here:
        return [*parts, "Not run."]
    from srmp.bench.mbm import parse_numbers

    parts.append(
        _SETUP[letter].format(
            numbers=options["problems"][letter],
            problems=_count(len(parse_numbers(options["problems"][letter])), "base problem"),
            repetitions=_count(options["repetitions"].get(letter, 1), "repetition"),
            time_limit=options["time_limit"][letter],
        )
    )
    parts.append(statement_table([statement for statement in found if statement.experiment == letter]))
    if letter in drawn:
        parts.append(f"![Experiment ({letter}): {experiment.title}](experiments-{letter}.svg)")
        parts.append(f"The figure as [PNG](experiments-{letter}.png).")
    for scenario in dict.fromkeys(entry.scenario for entry in here):
        parts += [f"### {scenario}", entry_table([entry for entry in here if entry.scenario == scenario])]
        parts += _found_by([row for row in rows if (row["experiment"], row["scenario"]) == (letter, scenario)])
    return parts


def _found_by(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Which members of portfolios found the paths."""
    lines = []
    for planner in ("xECBS", "auto"):
        found = Counter(row["found_by"] for row in rows if (row["library"], row["planner"]) == (SRMP, planner))
        del found[None]
        if found:
            by = ", ".join(f"{name} ({count})" for name, count in found.most_common())
            lines.append(f"Paths of `{planner}` were found by: {by}.")
    return lines


def _how_it_was_run(header: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> str:
    options = header["options"]
    smaller = [
        f"({e.letter}) {', '.join(differences)}"
        for e in EXPERIMENTS.values()
        if e.letter in options["experiments"] and (differences := _differences(e, options))
    ]
    if options["planners"]:
        smaller.append(f"only the planners {', '.join(options['planners'])}")
    took = ", ".join(f"({letter}) {_duration(seconds)}" for letter, seconds in durations(rows).items())
    by = "the workers of a Ray cluster" if header.get("ray") else _count(header.get("workers") or 1, "worker")
    text = (
        f"srmp {header['versions']['srmp']}"
        + (f", OMPL {header['ompl']}" if header["ompl"] else "")
        + (f" (AORRTC: {header['ompl_wheel']})" if header.get("ompl_wheel") else "")
        + f"; {header['cpu']}, {header['cores']} cores; seed {options['seed']}; {header['created'][:10]}.\n"
        + f"Setting up, planning and checking took {took or 'no time'}, by {by}."
    )
    return text + (f"\n\n**This is a smaller run than the paper's:** {'; '.join(smaller)}." if smaller else "")


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _differences(experiment: Experiment, options: Mapping[str, Any]) -> list[str]:
    """From the paper's size."""
    letter, differences = experiment.letter, []
    problems, limit = options["problems"][letter], options["time_limit"][letter]
    repetitions = options["repetitions"].get(letter, experiment.repetitions)
    if problems != experiment.problems:
        differences.append(f"problems {problems} instead of {experiment.problems}")
    if repetitions != experiment.repetitions:
        differences.append(f"{_count(repetitions, 'repetition')} instead of {experiment.repetitions}")
    if limit != experiment.time_limit:
        differences.append(f"{limit:g} s instead of {experiment.time_limit:g} s")
    return differences


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
