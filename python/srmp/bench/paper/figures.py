"""The figures of the experiments, drawn with matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from srmp._table import format_seconds
from srmp.bench.paper.contestants import COAL, EXPERIMENTS, SRMP, Contestant
from srmp.bench.paper.tables import INVALID, Entry, checked, rows_of, tables

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
    figure.savefig(path.with_suffix(".png"), dpi=110)


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


def _style(axes: Any, labels: Sequence[str], title: str) -> None:
    axes.set_title(title, fontsize=9)
    axes.grid(axis="x", color="#e3e3e3", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(length=2)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)


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
    """Bars; on a logarithmic axis, where bars would mislead, points with a line."""
    values = [getattr(entry, field) * (100 if field == "variation" else 1) for entry in entries]
    known = [value for value in values if not math.isnan(value)]
    _style(axes, [_label(e.planner, e.library) for e in entries] if labelled else [""] * len(entries), title)
    if not known:
        axes.set_xticks([])
        return
    first = min(known) / 2 if logarithmic else 0.0
    if logarithmic:
        _logarithmic(axes, first, max(known) * 8)
    else:
        axes.set_xlim(0, max(max(known) * 1.35, 1e-6))
    for k, (entry, value) in enumerate(zip(entries, values, strict=True)):
        colour = _COLOURS.get(entry.library, _OTHER)
        if math.isnan(value):
            _write(axes, first, k, "–" if entry.solved else "none solved")
            continue
        if logarithmic:
            axes.plot([value], [k], marker="o", markersize=5, color=colour)
            axes.hlines(k, first, value, color=colour, linewidth=1.2)
        else:
            axes.barh(k, value, color=colour, height=0.68)
        _write(axes, value, k, _value(entry, field, value))


def _value(entry: Entry, field: str, value: float) -> str:
    if field == "length_mean_m":
        return f"{value:.2f}  ({entry.success:.0%})"
    return format_seconds(value) if field == "time_mean_s" else f"{value:.3g}"


def _write(axes: Any, x: float, y: float, text: str) -> None:
    axes.annotate(text, (x, y), xytext=(5, 0), textcoords="offset points", va="center", fontsize=7, color=_GREY)


def _logarithmic(axes: Any, low: float, high: float) -> None:
    """Labels at powers of ten only, or at 1, 2 and 5 where there are fewer than two."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axes.set_xscale("log")
    axes.set_xlim(low, high)
    if math.floor(math.log10(high)) - math.ceil(math.log10(low)) < 1:
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


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
    known = [value for some in values for value in some]
    _style(axes, [_label(c.name, c.library) for c in contestants] if labelled else [""] * len(contestants), title)
    if not known:
        axes.set_xticks([])
        return
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
    _logarithmic(axes, min(known) / 1.5, max(known) * (8 if labelled else 1.5))
    for k, (contestant, some) in enumerate(zip(contestants, solved, strict=True) if labelled else ()):
        valid = sum(row["status"] != INVALID for row in rows_of(rows, contestant))
        _write(axes, 2 * max(known), k, f"{len(some) / valid:.0%}" if valid else "–")
