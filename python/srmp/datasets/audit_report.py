"""What an audit found, as text and as a page with figures."""

from __future__ import annotations

import base64
import html
import io
import math
from pathlib import Path

import numpy as np

from srmp._files import write_text
from srmp._table import format_table
from srmp.datasets.audit import FIGURES, STATUSES, Audit

_LISTED = 50


def summary(audit: Audit) -> str:
    """A table of scenes by status, figures, and the faults."""
    columns, rows = _statuses(audit)
    lines = [format_table(columns, rows)] if rows else []
    for name, unit in FIGURES.items():
        values = [value for value in audit.figures[name] if math.isfinite(value)]
        if values:
            low, middle, high = np.percentile(values, [5, 50, 95])
            lines.append(
                f"{name}{f' [{unit}]' if unit else ''}: median {middle:.3g}, 5 % to 95 %: {low:.3g} to {high:.3g}"
            )
    lines += [str(fault) for fault in audit.faults[:_LISTED]]
    if (count := len(audit.faults) + audit.more_faults) > _LISTED:
        lines.append(f"… and {count - _LISTED} more")
    end = "no faults" if not count else "1 fault" if count == 1 else f"{count} faults"
    lines.append(f"{audit.records} records, collisions of {audit.checked} checked: {end}")
    return "\n".join(lines)


def _statuses(audit: Audit) -> tuple[list[str], list[list[str]]]:
    seen = [status for status in STATUSES if any(counts[status] for counts in audit.statuses.values())]
    rows = []
    for scene, counts in sorted(audit.statuses.items()):
        total = sum(counts.values())
        rows.append([scene, str(total), f"{counts['solved'] / total:.1%}", *(str(counts[status]) for status in seen)])
    return ["scene", "records", "success", *seen], rows


def write(audit: Audit, path: str | Path) -> None:
    """Writes a page (HTML) with the table, histograms (with matplotlib) and the faults. Raises FileError."""
    columns, rows = _statuses(audit)
    head = "".join(f"<th>{html.escape(column)}</th>" for column in columns)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    faults = "".join(f"<li>{html.escape(str(fault))}</li>" for fault in audit.faults)
    more = f"<p>… and {audit.more_faults} more</p>" if audit.more_faults else ""
    summary = "No faults were found." if audit.passed else f"{len(audit.faults) + audit.more_faults} faults were found."
    write_text(
        path,
        f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Audit of {html.escape(audit.directory.name)}</title>
<style>body{{font-family:sans-serif;margin:2em;max-width:70em}}td,th{{padding:.2em .8em;text-align:right}}
td:first-child,th:first-child{{text-align:left}}img{{max-width:100%}}</style></head>
<body><h1>Audit of {html.escape(audit.directory.name)}</h1>
<p>{audit.records} records were read; the collisions of {audit.checked} motions were checked. {summary}</p>
<table><tr>{head}</tr>{body}</table>
{_figure(audit)}
<h2>Faults</h2><ul>{faults or "<li>none</li>"}</ul>{more}
</body></html>
""",
    )


def _figure(audit: Audit) -> str:
    """Histograms and success by scene as an image in the page; a sentence where matplotlib is missing."""
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        return "<p>There are no figures: matplotlib is not installed.</p>"
    figure = Figure(figsize=(11, 6), layout="constrained")
    axes = figure.subplots(2, 3).flatten()
    for ax, (name, unit) in zip(axes, FIGURES.items(), strict=False):
        values = np.array([value for value in audit.figures[name] if math.isfinite(value)])
        whole = len(values) and np.all(values == np.round(values))  # a bar for each number, where they are few
        ax.hist(values, bins=np.arange(values.min() - 0.5, values.max() + 1) if whole else 40, color="tab:blue")
        ax.locator_params(axis="x", nbins=6)
        ax.set_xlabel(f"{name} [{unit}]" if unit else name)
        ax.set_ylabel("motions")
    scenes = sorted(audit.statuses)
    success = [audit.statuses[scene]["solved"] / sum(audit.statuses[scene].values()) for scene in scenes]
    axes[4].barh(scenes, success, color="tab:green")
    axes[4].set_xlim(0, 1)
    axes[4].set_xlabel("success")
    axes[5].axis("off")
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110)
    image = base64.b64encode(out.getvalue()).decode()
    about = "Histograms of lengths, durations, clearances; success by scene"
    return f'<p><img alt="{about}" src="data:image/png;base64,{image}"></p>'
