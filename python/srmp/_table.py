"""Tables for terminals."""

from collections.abc import Sequence


def format_table(header: Sequence[str], rows: Sequence[Sequence[str]], rule_before_last: bool = False) -> str:
    """Columns as wide as needed: the first is left-aligned, the others are right-aligned."""
    widths = [max(len(row[k]) for row in [header, *rows]) for k in range(len(header))]

    def line(row: Sequence[str]) -> str:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        return "  ".join(cells).rstrip()

    rule = "  ".join("─" * width for width in widths)
    lines = [line(header), rule, *map(line, rows)]
    if rule_before_last and len(rows) > 1:
        lines.insert(-1, rule)
    return "\n".join(lines)


def format_seconds(seconds: float) -> str:
    """Three digits with the unit that fits: 0.42 ms, 12.3 ms, 1.23 s."""
    if seconds < 0.9995:
        milliseconds = seconds * 1e3
        digits = 2 if milliseconds < 10 else 1 if milliseconds < 100 else 0
        return f"{milliseconds:.{digits}f} ms"
    return f"{seconds:.2f} s"
