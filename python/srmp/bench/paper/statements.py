"""The paper's own statements on its experiments, and whether they hold here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from srmp.bench.paper.contestants import EXPERIMENTS, OMPL, SRMP, Contestant
from srmp.bench.paper.tables import INVALID, Entry, checked, number, rows_of, seconds, tables

REPRODUCED, EXCEEDED, NOT, UNKNOWN = "reproduced", "exceeded", "not", "not measured"
TIE = 1e-3  # lengths that differ by less, relatively, are equal
AT_LIMIT = 0.85  # of the time limit: the planner used it up; ours improve their paths for nine tenths of it


@dataclass(frozen=True)
class Statement:
    """What the paper says, what was measured here, and the finding, by a rule that `rule` states."""

    experiment: str
    paper: str
    ours: str
    rule: str
    finding: str


def statements(result: Mapping[str, Any]) -> list[Statement]:
    """Those of the experiments that were run."""
    measured = _Measured(result)
    letters = result["header"]["options"]["experiments"]
    return [make(measured) for letter in letters for make in _STATEMENTS[letter]]


class _Measured:
    """Rows and tables, by experiment."""

    def __init__(self, result: Mapping[str, Any]) -> None:
        self._rows = checked(result["rows"])
        self._entries = tables(result)
        self.time_limit: Mapping[str, float] = result["header"]["options"]["time_limit"]

    def entries(
        self, letter: str, matches: Callable[[Contestant], bool], scenario: str = ""
    ) -> Iterator[tuple[Contestant, Entry]]:
        """Those of planners that were run."""
        for contestant in EXPERIMENTS[letter].contestants:
            for entry in self._entries:
                of = (entry.experiment, entry.library, entry.planner) == (letter, contestant.library, contestant.name)
                if of and not entry.not_run and matches(contestant) and scenario in ("", entry.scenario):
                    yield contestant, entry

    def values(self, letter: str, matches: Callable[[Contestant], bool], field: str, scenario: str = "") -> list[float]:
        """A field of these entries, without NaN."""
        found = [getattr(entry, field) for _, entry in self.entries(letter, matches, scenario)]
        return [value for value in found if not math.isnan(value)]

    def scenarios(self, letter: str) -> list[str]:
        return list(dict.fromkeys(entry.scenario for entry in self._entries if entry.experiment == letter))

    def rows(self, letter: str, contestant: Contestant) -> list[Mapping[str, Any]]:
        """Of valid problems."""
        here = [row for row in self._rows if row["experiment"] == letter and row["status"] != INVALID]
        return rows_of(here, contestant)

    def ratios(self, letter: str, a: Contestant, b: Contestant, key: str) -> list[float]:
        """Of a's values to b's in the problems that both solved."""
        of_b = {row["instance"]: row[key] for row in self.rows(letter, b) if row["status"] == "solved"}
        return [
            row[key] / of_b[row["instance"]]
            for row in self.rows(letter, a)
            if row["status"] == "solved" and of_b.get(row["instance"])
        ]


# --- who --------------------------------------------------------------------------------------------------------------


def _search(contestant: Contestant) -> bool:
    return contestant.search and not contestant.anytime


def _sampling(contestant: Contestant) -> bool:
    return contestant.library == OMPL and not contestant.anytime


def _named(name: str, library: str) -> Callable[[Contestant], bool]:
    return lambda contestant: (contestant.name, contestant.library) == (name, library)


def _all(letter: str, matches: Callable[[Contestant], bool]) -> list[Contestant]:
    return [contestant for contestant in EXPERIMENTS[letter].contestants if matches(contestant)]


_PAIRS_C = (("wA*", "RRT-Connect"), ("MHA*", "BiEST"), ("ARA*", "RRT*"))


def _pairs(letter: str) -> list[tuple[Contestant, Contestant]]:
    """Ours and OMPL's that are compared."""
    if letter == "c":
        return [(_all("c", _named(a, SRMP))[0], _all("c", _named(b, OMPL))[0]) for a, b in _PAIRS_C]
    return [(ours, theirs) for ours in _all(letter, _search) for theirs in _all(letter, _sampling)]


# --- statements -------------------------------------------------------------------------------------------------------


def _finding(reproduced: bool, exceeded: bool = False) -> str:
    return EXCEEDED if exceeded else REPRODUCED if reproduced else NOT


def _range(values: Sequence[float], form: Callable[[float], str]) -> str:
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def _percent(value: float) -> str:
    return number(value, "{:.1%}")


def _variation(letter: str, paper: str) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        rule = "reproduced: our mean is below OMPL's in every scenario; exceeded: our largest is below OMPL's smallest"
        parts, mean, largest = [], [], []
        for scenario in measured.scenarios(letter):
            ours = measured.values(letter, _search, "variation", scenario)
            theirs = measured.values(letter, _sampling, "variation", scenario)
            if ours and theirs:
                parts.append(f"{scenario}: {_range(ours, _percent)}, OMPL {_range(theirs, _percent)}")
                mean.append(np.mean(ours) < np.mean(theirs))
                largest.append(max(ours) < min(theirs))
        if not parts:
            return Statement(letter, paper, "–", rule, UNKNOWN)
        return Statement(letter, paper, "; ".join(parts), rule, _finding(all(mean), all(largest)))

    return make


def _shorter(letter: str, paper: str, reproduced: float = 0.8) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        rule = (
            f"of the pairs of our and OMPL's path for a problem that differ by more than {TIE:.1%}, ours is shorter in "
            f"≥ {reproduced:.0%}: reproduced, ≥ 95%: exceeded"
        )
        ratios = [ratio for a, b in _pairs(letter) for ratio in measured.ratios(letter, a, b, "ee_cost_m")]
        different = [ratio for ratio in ratios if abs(ratio - 1) > TIE]
        if not different:
            return Statement(letter, paper, "–", rule, UNKNOWN)
        fraction = float(np.mean([ratio < 1 for ratio in different]))
        ours = f"shorter in {fraction:.1%} of {len(different)} pairs; median ratio {np.median(different):.2f}"
        return Statement(letter, paper, ours, rule, _finding(fraction >= reproduced, fraction >= 0.95))

    return make


def _times(letter: str, paper: str, field: str, word: str) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        rule = f"the mean over our planners' {word} times, by that over OMPL's: reproduced ≤ 3, exceeded ≤ 1"
        pairs = [(a, b) for a, b in _pairs(letter) if not a.anytime]
        ours = measured.values(letter, lambda c: c in [a for a, _ in pairs], field)
        theirs = measured.values(letter, lambda c: c in [b for _, b in pairs], field)
        if not ours or not theirs:
            return Statement(letter, paper, "–", rule, UNKNOWN)
        ratio = float(np.mean(ours) / np.mean(theirs))
        text = f"{seconds(float(np.mean(ours)))}, OMPL {seconds(float(np.mean(theirs)))}: ratio {ratio:.2g}"
        return Statement(letter, paper, text, rule, _finding(ratio <= 3, ratio <= 1))

    return make


def _ends_early(paper: str, name: str, library: str, early: bool) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        rule = f"ended before {AT_LIMIT:.0%} of the time limit: " + (
            "reproduced > 0%, exceeded ≥ 50%" if early else "reproduced 0%"
        )
        rows = [row for c in _all("a", _named(name, library)) for row in measured.rows("a", c)]
        if not rows:
            return Statement("a", paper, "–", rule, UNKNOWN)
        fraction = float(np.mean([row["plan_time_s"] < AT_LIMIT * measured.time_limit["a"] for row in rows]))
        finding = _finding(fraction > 0, fraction >= 0.5) if early else _finding(fraction == 0)
        return Statement("a", paper, f"{name} ended early in {fraction:.1%} of {len(rows)} plans", rule, finding)

    return make


def _success(letter: str, paper: str, reproduced: float) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        most = ", exceeded 100%" if reproduced < 1 else ""
        rule = f"solved by each search planner in each scenario: reproduced ≥ {reproduced:.0%}{most}"
        found = measured.values(letter, lambda c: c.search, "success")
        if not found:
            return Statement(letter, paper, "–", rule, UNKNOWN)
        finding = _finding(min(found) >= reproduced, reproduced < 1 and min(found) == 1)
        return Statement(letter, paper, _range(found, _percent), rule, finding)

    return make


def _ompl_fails(measured: _Measured) -> Statement:
    paper, rule = "OMPL's algorithms failed to solve at least 20% of the problems", "reproduced: each fails ≥ 20%"
    found = []
    for contestant in _all("b", _sampling):
        rows = measured.rows("b", contestant)
        if rows:
            found.append((contestant.name, float(np.mean([row["status"] != "solved" for row in rows]))))
    if not found:
        return Statement("b", paper, "–", rule, UNKNOWN)
    text = ", ".join(f"{name} fails {fraction:.0%}" for name, fraction in found)
    return Statement("b", paper, text, rule, _finding(all(fraction >= 0.2 for _, fraction in found)))


def _xecbs_time(scenario: str, paper_s: float) -> Callable[[_Measured], Statement]:
    def make(measured: _Measured) -> Statement:
        paper = f"xECBS plans for {paper_s:g} s on average in {scenario}"
        rule = f"mean time of solved problems: reproduced ≤ {1.25 * paper_s:.3g} s, exceeded ≤ {paper_s:g} s"
        (found,) = measured.values("b", _named("xECBS", SRMP), "time_mean_s", scenario) or [math.nan]
        if math.isnan(found):
            return Statement("b", paper, "–", rule, UNKNOWN)
        return Statement("b", paper, seconds(found), rule, _finding(found <= 1.25 * paper_s, found <= paper_s))

    return make


def _xecbs_slower(measured: _Measured) -> Statement:
    paper = (
        "xECBS takes longer than OMPL's algorithms (0.1 s in binpick, 0.14 s in shelves), which solve fewer problems"
    )
    rule = "mean times of solved problems: reproduced where xECBS is slower than an OMPL planner, exceeded where not"
    parts, slower = [], []
    for scenario in measured.scenarios("b"):
        ours = measured.values("b", _named("xECBS", SRMP), "time_mean_s", scenario)
        theirs = measured.values("b", _sampling, "time_mean_s", scenario)
        if ours and theirs:
            parts.append(f"{scenario}: {seconds(ours[0])}, OMPL {_range(theirs, seconds)}")
            slower.append(ours[0] > min(theirs))
    if not parts:
        return Statement("b", paper, "–", rule, UNKNOWN)
    return Statement("b", paper, "; ".join(parts), rule, _finding(any(slower), not any(slower)))


def _magnitudes(measured: _Measured) -> Statement:
    paper = "The cost of OMPL's paths is orders of magnitude higher"
    rule = "mean end-effector length of OMPL's paths by ours, in problems that both solved: reproduced ≥ 10"
    means = [
        (f"{b.name} by {a.name}", float(np.mean(ratios)))
        for a, b in _pairs("c")
        if (ratios := measured.ratios("c", b, a, "ee_cost_m"))
    ]
    if not means:
        return Statement("c", paper, "–", rule, UNKNOWN)
    text = ", ".join(f"{name} {mean:.2f}" for name, mean in means)
    return Statement("c", paper, text, rule, _finding(all(mean >= 10 for _, mean in means)))


_STATEMENTS: Mapping[str, Sequence[Callable[[_Measured], Statement]]] = {
    "a": (
        _variation("a", "SRMP's algorithms are significantly more consistent than OMPL's"),
        _shorter("a", "Solution costs from SRMP are almost always lower"),
        _times("a", "They are obtained with comparable planning times", "time_median_s", "median"),
        _ends_early("ARA* recovers the optimal path in some cases and ends early", "ARA*", SRMP, True),
        _ends_early("RRT* always runs until the time limit", "RRT*", OMPL, False),
    ),
    "b": (
        _shorter("b", "xECBS's paths are shorter than those of OMPL's algorithms"),
        _variation("b", "xECBS is more consistent, and more pronouncedly than with one arm"),
        _success("b", "xECBS solves almost all planning problems", 0.95),
        _ompl_fails,
        _xecbs_time("binpick", 1.5),
        _xecbs_time("shelves", 2.41),
        _xecbs_slower,
    ),
    "c": (
        _shorter("c", "The solution costs of SRMP are consistently lower than OMPL's"),
        _magnitudes,
        _times("c", "Average planning times are only slightly longer", "time_mean_s", "mean"),
        _success("c", "The success rate is perfect", 1.0),
    ),
}


def markdown(found: Sequence[Statement]) -> str:
    """A table of the statements of an experiment."""
    lines = ["| the paper | here | rule | finding |", "|---|---|---|---|"]
    lines += [f"| {s.paper} | {s.ours} | {s.rule} | **{s.finding}** |" for s in found]
    return "\n".join(lines)
