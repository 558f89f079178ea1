"""What the rows of the experiments say, planner by planner."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from srmp._table import format_seconds
from srmp.bench.paper.contestants import EXPERIMENTS, SRMP, Contestant, why_not_run
from srmp.bench.repeated import variation

INVALID = "invalid"


@dataclass(frozen=True)
class Entry:
    """A planner in a scenario; means are over the problems that it solved, NaN where there are none."""

    experiment: str
    scenario: str
    planner: str
    library: str
    not_run: str
    """Why it was not run; empty where it was."""
    solved: int = 0
    valid: int = 0
    faults: int = 0
    """Paths in which the re-check found a fault; they do not count as solved."""
    variation: float = math.nan
    """Of the end-effector path, over the repetitions of a problem."""
    length_mean_m: float = math.nan
    """Of the end-effector path, of all robots together."""
    length_ratio: float = math.nan
    """To the shortest that any planner found for the problem, mean."""
    time_mean_s: float = math.nan
    time_median_s: float = math.nan
    time_ratio: float = math.nan
    """To the shortest time in which any planner solved the problem, mean."""

    @property
    def success(self) -> float:
        """Fraction of the valid problems; NaN where there are none."""
        return self.solved / self.valid if self.valid else math.nan


def checked(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows in which paths that the re-check found faulty are no solutions, and invalid problems are so for everyone."""
    invalid = {row["instance"] for row in rows if row["status"] in ("start_invalid", "goal_invalid")}
    return [
        {**row, "status": INVALID if row["instance"] in invalid else "faulty" if row["fault"] else row["status"]}
        for row in rows
    ]


def tables(result: Mapping[str, Any]) -> list[Entry]:
    """One entry for each planner in each scenario of each experiment that was run."""
    rows = checked(result["rows"])
    named = result["header"]["options"]["planners"]
    entries = []
    for letter, scenario in dict.fromkeys((row["experiment"], row["scenario"]) for row in rows):
        here = [row for row in rows if row["experiment"] == letter and row["scenario"] == scenario]
        best = {key: _best(here, key) for key in ("ee_cost_m", "plan_time_s")}
        for contestant in EXPERIMENTS[letter].contestants:
            if contestant.among(named):
                entries.append(_entry(letter, scenario, contestant, here, best))
    return entries


def rows_of(rows: Sequence[Mapping[str, Any]], contestant: Contestant) -> list[Mapping[str, Any]]:
    """Those of the planner."""
    return [row for row in rows if (row["library"], row["planner"]) == (contestant.library, contestant.name)]


def _best(rows: Sequence[Mapping[str, Any]], key: str) -> dict[str, float]:
    """By problem, the least of the solved rows."""
    found: dict[str, float] = {}
    for row in rows:
        if row["status"] == "solved":
            found[row["instance"]] = min(found.get(row["instance"], math.inf), row[key])
    return found


def _entry(
    letter: str,
    scenario: str,
    contestant: Contestant,
    rows: Sequence[Mapping[str, Any]],
    best: Mapping[str, Mapping[str, float]],
) -> Entry:
    about = (letter, scenario, contestant.name, contestant.library)
    mine = rows_of(rows, contestant)
    if not mine:
        return Entry(*about, why_not_run(contestant) or "not run")
    solved = [row for row in mine if row["status"] == "solved"]
    counts = {
        "solved": len(solved),
        "valid": sum(row["status"] != INVALID for row in mine),
        "faults": sum(row["status"] == "faulty" for row in mine),
    }
    if not solved:
        return Entry(*about, "", **counts)
    lengths, times = ([row[key] for row in solved] for key in ("ee_cost_m", "plan_time_s"))
    return Entry(
        *about,
        "",
        **counts,
        variation=variation(mine),
        length_mean_m=float(np.mean(lengths)),
        length_ratio=_ratio(solved, best, "ee_cost_m"),
        time_mean_s=float(np.mean(times)),
        time_median_s=float(np.median(times)),
        time_ratio=_ratio(solved, best, "plan_time_s"),
    )


def _ratio(solved: Sequence[Mapping[str, Any]], best: Mapping[str, Mapping[str, float]], key: str) -> float:
    return float(np.mean([row[key] / max(best[key][row["instance"]], 1e-9) for row in solved]))


def as_json(entries: Sequence[Entry]) -> list[dict[str, Any]]:
    """As result files hold them."""
    return [asdict(entry) for entry in entries]


# --- Markdown ---------------------------------------------------------------------------------------------------------

_COLUMNS = ("planner", "of", "solved", "variation", "length [m]", "× shortest", "time, median", "time, mean")


def markdown(entries: Sequence[Entry]) -> str:
    """The table of a scenario."""
    letter = entries[0].experiment
    columns = [*_COLUMNS, *(["× shortest time"] if letter == "b" else [])]
    if letter == "c":
        columns.remove("variation")
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(_cells(entry, columns)) + " |" for entry in entries]
    return "\n".join(lines)


def _cells(entry: Entry, columns: Sequence[str]) -> list[str]:
    name = f"`{entry.planner}`" if entry.library == SRMP else entry.planner
    if entry.not_run:
        return [name, entry.library, entry.not_run, *["–"] * (len(columns) - 3)]
    faulty = f", {entry.faults} faulty" if entry.faults else ""
    cells = {
        "planner": name,
        "of": entry.library,
        "solved": f"{entry.solved}/{entry.valid}{faulty}",
        "variation": number(entry.variation, "{:.1%}"),
        "length [m]": number(entry.length_mean_m, "{:.2f}"),
        "× shortest": number(entry.length_ratio, "{:.2f}"),
        "time, median": seconds(entry.time_median_s),
        "time, mean": seconds(entry.time_mean_s),
        "× shortest time": number(entry.time_ratio, "{:.3g}"),
    }
    return [cells[column] for column in columns]


def number(value: float, form: str) -> str:
    """The number in this form; a dash where there is none."""
    return "–" if math.isnan(value) else form.format(value)


def seconds(value: float) -> str:
    """A time; a dash where there is none."""
    return "–" if math.isnan(value) else format_seconds(value)
