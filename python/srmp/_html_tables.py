"""Tables in HTML, for notebooks, pages and the viewer."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from typing import Any

from srmp._verify import summary

GOOD, BAD = "#0b7a75", "#b3201e"


class Raw(str):
    """Text that is HTML already."""


def escaped(value: object) -> str:
    """As HTML."""
    return value if isinstance(value, Raw) else html.escape(str(value))


def table(rows: Iterable[tuple[str, Any]]) -> str:
    """Rows of a name and a value."""
    cells = "".join(
        f'<tr><th style="text-align: left">{escaped(name)}</th><td style="text-align: left">{escaped(value)}</td></tr>'
        for name, value in rows
    )
    return f"<table>{cells}</table>"


def certificate_table(certificate: Any) -> str:
    """Every claim of a Certificate, with where it is tightest."""
    colour = GOOD if certificate.holds else BAD
    rows: list[tuple[str, Any]] = [
        ("certificate", Raw(f'<b style="color: {colour}">{escaped(summary(certificate))}</b>'))
    ]
    rows += [
        (f"{fault.kind.name}", Raw(f'<span style="color: {BAD}">{escaped(fault.text)}</span>'))
        for fault in certificate.faults
    ]
    for name in ("position", "velocity", "acceleration", "jerk"):
        used = getattr(certificate, name)
        if not used.joint:
            rows.append((name, "no limit is used"))
        elif math.isfinite(used.fraction):
            where = f"{100 * used.fraction:.4g} % of the limit, {used.joint} at {used.time:.3f} s"
            rows.append((name, Raw(f"{_bar(used.fraction)} {escaped(where)}")))
        else:
            rows.append((name, f"unbounded, {used.joint} at {used.time:.3f} s"))
    if certificate.collisions_checked and math.isfinite(certificate.clearance):
        pair = f"{certificate.body_a} and {certificate.body_b} at {certificate.clearance_time:.3f} s"
        proved = f"proved at least {1e3 * certificate.clearance_proved:.3g} mm"
        rows.append(("clearance", f"{1e3 * certificate.clearance:.4g} mm, {pair}; {proved}"))
    if math.isfinite(certificate.deviation):
        rows.append(("deviation", f"{1e3 * certificate.deviation:.4g} mm from the checked path"))
    return table(rows)


def _bar(fraction: float) -> str:
    width, colour = round(80 * min(max(fraction, 0.0), 1.0)), BAD if fraction > 1 + 1e-6 else GOOD
    return (
        '<span style="display: inline-block; width: 80px; background: #e3e6ea">'
        f'<span style="display: block; width: {width}px; height: 0.7em; background: {colour}"></span></span>'
    )
