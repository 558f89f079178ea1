"""How near the collision kernel is to what the machine could do at best, by robot, scenario and instruction set.

    python bench/micro/roof.py --data DIR --out roof.json     builds bench_roof, measures, prints the table
    python bench/micro/roof.py --table roof.json              prints the table of an earlier run

The kernel (spheres and distance fields, without Coal) checks blocks of 16 random configurations, and blocks of the 16
parts of random motions, that it proves free, so that it looks at all pairs. A copy of it that counts says how many
additions, multiplications, comparisons, square roots and gathers that takes; the roof is the time of as many
independent ones in one thread, with operands in registers, at the rates measured in the same run. CPU time, best of
--repeats. What the kernel takes longer for: loads and stores, branches, and operations that wait for each other.
"""

from __future__ import annotations

import argparse
import re
import statistics
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from checks import BACKENDS, MODELS, build, label, rows_of, run_or_print

from srmp.bench import mbm


def run(options: argparse.Namespace) -> dict[str, Any]:
    program = options.program or build("bench_roof")
    settings = (options.blocks, options.size, options.repeats)
    rows = [row for model in MODELS for row in rows_of(program, options.data, *model, options.problems, settings)]
    names = ("problems", "blocks", "size", "repeats")
    return {"header": mbm.header("roof", options={name: getattr(options, name) for name in names}), "rows": rows}


def cells(rows: Iterable[dict[str, Any]]) -> list[str]:
    """Medians over the scenarios: configurations a second, at the roof, and how much of it is reached."""
    rates, roofs = [], []
    for row in rows:
        configurations = 16 * row["blocks"]
        rates.append(configurations / row["seconds"])
        roofs.append(configurations / row["at_best_s"])
    share = statistics.median(rate / roof for rate, roof in zip(rates, roofs, strict=True))
    return [f"{statistics.median(rates) / 1e6:.2f} M", f"{statistics.median(roofs) / 1e6:.2f} M", f"{share:.0%}"]


def table(results: dict[str, Any]) -> str:
    lines = [
        "| robot | instructions | configurations/s | roof | reached | in motions: configurations/s | roof | reached |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for robot, geometry in MODELS:
        for backend in BACKENDS:
            own = [
                row
                for row in results["rows"]
                if (row["robot"], row["geometry"], row["backend"]) == (robot, geometry, backend) and row["blocks"]
            ]
            kinds = [[row for row in own if row["moving"] == moving] for moving in (False, True)]
            if not all(kinds):
                continue
            lines.append(f"| {' | '.join([label(robot, geometry), backend, *cells(kinds[0]), *cells(kinds[1])])} |")
    header = results["header"]
    lines += ["", f"{header['cpu']}, problems {header['options']['problems']} of seven scenarios."]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--problems", default="1", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument("--blocks", type=int, default=50, help="in each scene (default: %(default)s)")
    parser.add_argument("--size", type=float, default=0.13, help="of a motion [rad] (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=9, help="the best counts (default: %(default)s)")
    parser.add_argument("--program", type=Path, help="bench_roof; default: built in build/bench")
    run_or_print(parser, run, table)


if __name__ == "__main__":
    main()
