"""The figures of the experiments, drawn with matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from srmp.bench.paper.contestants import COAL, EXPERIMENTS, SRMP, Contestant
from srmp.bench.paper.tables import Entry, checked, rows_of, tables

_COLOURS = {SRMP: "#0b7a75", COAL: "#b9b2a7"}
_OTHER = "#c2955d"
_GREY = "#555555"


def draw(result: Mapping[str, Any], directory: Path) -> list[str]:
    """Writes experiments-a.svg and .png, and so on, of the experiments that have rows; returns the letters.

    Raises ModuleNotFoundError when matplotlib is not installed.
    """
    import matplotlib

    entries = [entry for entry in tables(result) if not entry.not_run]
    drawn = []
    with matplotlib.rc_context({"svg.hashsalt": "srmp", "font.size": 9, "svg.fonttype": "none"}):
        for letter in EXPERIMENTS:
            if here := [entry for entry in entries if entry.experiment == letter]:
                rows = [row for row in checked(result["rows"]) if row["experiment"] == letter]
                _save(_boxes(here, rows) if letter == "c" else _bars(here), directory / f"experiments-{letter}")
                drawn.append(letter)
    return drawn


def _save(figure: Any, path: Path) -> None:
    figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    figure.savefig(path.with_suffix(".png"), dpi=130)


def _figure(scenarios: Sequence[str], panels: int, names: int) -> tuple[Any, Any]:
    """A row of panels for each scenario."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    height = 1.0 + 0.24 * names
    figure = Figure(figsize=(3.9 * panels, height * len(scenarios) + 0.4), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)  # no window, no global state
    return figure, figure.subplots(len(scenarios), panels, squeeze=False)


def _label(planner: str, library: str) -> str:
    return {SRMP: planner, COAL: f"{planner} (Coal)"}.get(library, f"{planner} (OMPL)")


def _style(axes: Any, labels: Sequence[str] | None, title: str) -> None:
    axes.set_title(title, fontsize=9)
    axes.grid(axis="x", color="#e3e3e3", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(length=2)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_yticks(range(len(labels or ())), labels or ())
    axes.invert_yaxis()


# --- (a) and (b): bars ------------------------------------------------------------------------------------------------


def _bars(entries: Sequence[Entry]) -> Any:
    letter = entries[0].experiment
    scenarios = list(dict.fromkeys(entry.scenario for entry in entries))
    times = ("time_ratio", "planning time by the shortest") if letter == "b" else ("time_mean_s", "planning time [s]")
    panels = (
        ("variation", "coefficient of variation [%]", False),
        ("length_mean_m", "end-effector path [m], and problems solved", False),
        (*times, True),
    )
    figure, grid = _figure(scenarios, len(panels), len(entries) // len(scenarios))
    for line, scenario in zip(grid, scenarios, strict=True):
        here = [entry for entry in entries if entry.scenario == scenario]
        for axes, (field, title, logarithmic) in zip(line, panels, strict=True):
            _draw_bars(axes, here, field, f"{scenario}: {title}", logarithmic, axes is line[0])
    return figure


def _draw_bars(axes: Any, entries: Sequence[Entry], field: str, title: str, logarithmic: bool, labelled: bool) -> None:
    values = [getattr(entry, field) * (100 if field == "variation" else 1) for entry in entries]
    known = [value for value in values if not math.isnan(value)]
    _style(axes, [_label(e.planner, e.library) for e in entries] if labelled else [""] * len(entries), title)
    if not known:
        return
    if logarithmic:
        axes.set_xscale("log")
    for k, (entry, value) in enumerate(zip(entries, values, strict=True)):
        colour = _COLOURS.get(entry.library, _OTHER)
        text = "none solved" if math.isnan(entry.length_mean_m) else "–"
        if not math.isnan(value):
            if logarithmic:
                axes.plot([value], [k], marker="o", markersize=5, color=colour)
                axes.hlines(k, min(known) / 2, value, color=colour, linewidth=1.2)
            else:
                axes.barh(k, value, color=colour, height=0.68)
            text = f"{value:.3g}"
            if field == "length_mean_m":
                text = f"{value:.2f}  ({entry.success:.0%})"
        axes.annotate(
            text,
            (0 if math.isnan(value) and not logarithmic else min(known) / 2 if math.isnan(value) else value, k),
            xytext=(5, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=_GREY,
        )
    if logarithmic:
        axes.set_xlim(min(known) / 2, max(known) * 8)
    else:
        axes.set_xlim(0, max(max(known) * 1.35, 1e-6))


# --- (c): distributions -----------------------------------------------------------------------------------------------


def _boxes(entries: Sequence[Entry], rows: Sequence[Mapping[str, Any]]) -> Any:
    scenarios = list(dict.fromkeys(entry.scenario for entry in entries))
    contestants = [
        c
        for c in EXPERIMENTS["c"].contestants
        if any((entry.library, entry.planner) == (c.library, c.name) for entry in entries)
    ]
    panels = (("plan_time_s", "planning time [s], and problems solved"), ("ee_cost_m", "end-effector path [m]"))
    figure, grid = _figure(scenarios, len(panels), len(contestants))
    for line, scenario in zip(grid, scenarios, strict=True):
        here = [row for row in rows if row["scenario"] == scenario]
        for axes, (key, title) in zip(line, panels, strict=True):
            _draw_boxes(axes, contestants, here, key, f"{scenario}: {title}", axes is line[0])
    return figure


def _draw_boxes(
    axes: Any,
    contestants: Sequence[Contestant],
    rows: Sequence[Mapping[str, Any]],
    key: str,
    title: str,
    labelled: bool,
) -> None:
    solved = [[row for row in rows_of(rows, c) if row["status"] == "solved"] for c in contestants]
    values = [[row[key] for row in some] for some in solved]
    axes.set_xscale("log")
    boxes = axes.boxplot(
        values,
        positions=range(len(contestants)),
        orientation="horizontal",
        widths=0.6,
        patch_artist=True,
        whis=(5, 95),
        flierprops={"markersize": 2, "markeredgecolor": "#999999"},
        medianprops={"color": "black", "linewidth": 1},
        manage_ticks=False,
    )
    for patch, contestant in zip(boxes["boxes"], contestants, strict=True):
        patch.set_facecolor(_COLOURS.get(contestant.library, _OTHER))
        patch.set_linewidth(0.6)
    _style(axes, [_label(c.name, c.library) for c in contestants] if labelled else [""] * len(contestants), title)
    axes.set_ylim(len(contestants) - 0.5, -0.5)
    if labelled:
        for k, (contestant, some) in enumerate(zip(contestants, solved, strict=True)):
            valid = sum(row["status"] not in ("start_invalid", "goal_invalid") for row in rows_of(rows, contestant))
            text = f"{len(some) / valid:.0%}" if valid else "–"
            axes.annotate(
                text, (1.0, k), xycoords=("axes fraction", "data"), ha="right", va="center", fontsize=7, color=_GREY
            )
        low, high = axes.get_xlim()
        axes.set_xlim(low, high * 4)
