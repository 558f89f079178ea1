"""Speed of collision checks, by robot, scenario and instruction set, against plain Coal in the same run.

    python bench/micro/checks.py --data DIR --out results.json     builds bench_checks, measures, prints the table
    python bench/micro/checks.py --table results.json              prints the table of an earlier run

DIR holds MotionBenchMaker's robots and problems, as for `srmp bench mbm`. Motions start at random free configurations
and move every joint by up to --size. *Plain Coal* is plain_coal.hpp: samples so close that no point of the robot moves
more than --step between two, the end first, Pinocchio's kinematics for each, Coal for each pair whose boxes overlap,
until the first contact; with boxes compared pair by pair and with Coal's own broad phase, and the faster of the two
counts. The checker proves its motions free between samples too. CPU time of one thread, best of --repeats, competitors
in turns. Instruction sets are forced one after the other. Lanes hold parts of a motion (motions) or 16 unrelated
configurations (free, random).
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import re
import statistics
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

import srmp
from srmp._files import write_json
from srmp.bench import mbm

REPOSITORY = Path(__file__).resolve().parents[2]
MODELS = [("panda", "spheres"), ("panda", "urdf"), ("ur5", "urdf"), ("fetch", "urdf")]
BACKENDS = ("portable", "avx2", "avx512")


def build(program: str) -> Path:
    """bench_checks or another program of bench/micro, built from this checkout; takes minutes the first time."""
    directory = REPOSITORY / "build" / "bench"
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path}
    print(f"building {program} in {directory}", file=sys.stderr)
    for command in (
        ["cmake", "-S", REPOSITORY, "-B", directory, "-DSRMP_BUILD_BENCH=ON", "-DCMAKE_BUILD_TYPE=Release"],
        ["cmake", "--build", directory, "--target", program, "--parallel", str(os.cpu_count() or 1)],
    ):
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            sys.exit(f"{done.stdout}\n{command[1]} failed; it needs what pyproject.toml's dependency group build lists")
    return directory / "bench" / "micro" / program


def label(robot: str, geometry: str) -> str:
    return f"{robot}, {'spheres' if geometry == 'spheres' else 'meshes'}"


def run_or_print(
    parser: argparse.ArgumentParser,
    run: Callable[[argparse.Namespace], dict[str, Any]],
    table: Callable[[dict[str, Any]], str],
) -> None:
    """Adds --data, --out and --table; measures, or reads an earlier run's results, and prints the table of them."""
    parser.add_argument("--data", type=Path, help="MotionBenchMaker's robots and problems")
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    parser.add_argument(
        "--table", type=Path, metavar="RESULTS", help="print the table of these results, measure nothing"
    )
    options = parser.parse_args()
    if options.table:
        print(table(json.loads(options.table.read_text())))
        return
    if not options.data:
        parser.error("--data is missing")
    results = run(options)
    if options.out:
        write_json(options.out, results)
    print(table(results))


def rows_of(
    program: Path, data: Path, robot: str, geometry: str, numbers: str, settings: Sequence[object]
) -> Iterator[dict[str, Any]]:
    """What the program prints of the scenes of these problems."""
    files = mbm.robot_files(data, robot, geometry)
    srmp.cover(str(files.urdf), package_dirs=[str(files.directory)])  # its time is not measured here
    with mbm.open_problems(files.directory, robot, numbers=mbm.parse_numbers(numbers)) as problems:
        names = {str(problem.scene): problem.name for problem in problems}
        command = [str(program), str(files.urdf), str(files.srdf), mbm.GROUPS[robot], *map(str, settings), *names]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            for line in tqdm(process.stdout, f"{robot} {geometry}", disable=None):
                row = json.loads(line)
                yield {"robot": robot, "geometry": geometry, "problem": names[row.pop("scene")], **row}
        if process.returncode:
            sys.exit(f"{program} failed")


def run(options: argparse.Namespace) -> dict[str, Any]:
    program = options.program or build("bench_checks")
    settings = (options.motions, options.size, options.step, options.repeats)
    rows = [row for model in MODELS for row in rows_of(program, options.data, *model, options.problems, settings)]
    header = mbm.header(
        "collision checks",
        created=datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        options={key: getattr(options, key) for key in ("motions", "size", "step", "repeats", "problems")},
    )
    return {"header": header, "rows": rows, "summary": summary(rows)}


# --- statistics -------------------------------------------------------------------------------------------------------


def scenario_rates(rows: list[dict[str, Any]], backend: str) -> dict[str, float]:
    """Rates over the scenes of one scenario [1/s], and how many times faster than plain Coal the motions are."""

    def total(key: str, contender: str = backend) -> float:
        return sum(row["contenders"][contender][key] for row in rows)

    def plain(key: str) -> float:
        return min(total(key, "boxes"), total(key, "tree"))

    motions, free = sum(row["motions"] for row in rows), sum(row["free_motions"] for row in rows)
    return {
        "free_configurations": motions / total("free_states_s"),
        "random_configurations": motions / total("random_states_s"),
        "free_motions": free / total("free_s"),
        "motions": motions / total("all_s"),
        "coal_motions": motions / plain("all_s"),
        "times_coal": plain("all_s") / total("all_s"),
        "times_coal_free": plain("free_s") / total("free_s"),
    }


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """For each robot and instruction set: the rates of each scenario, their medians, and disagreements in all."""
    entries = []
    for robot, geometry in MODELS:
        chosen = [row for row in rows if (row["robot"], row["geometry"]) == (robot, geometry)]
        for backend in BACKENDS:
            if not all(backend in row["contenders"] for row in chosen) or not chosen:
                continue
            names = sorted({row["problem"].partition("/")[0] for row in chosen})
            scenarios = {
                name: scenario_rates([row for row in chosen if row["problem"].startswith(f"{name}/")], backend)
                for name in names
            }
            medians = {
                key: statistics.median(rates[key] for rates in scenarios.values()) for key in scenarios[names[0]]
            }
            wrong = sum(
                row["contenders"][backend][key]
                for row in chosen
                for key in ("free_not_certified", "certified_not_free")
            )
            entries.append(
                {
                    "robot": robot,
                    "geometry": geometry,
                    "backend": backend,
                    "median": medians,
                    "scenarios": scenarios,
                    "disagreements": wrong,
                }
            )
    return entries


def contradictions(rows: list[dict[str, Any]]) -> int:
    """Motions proved free in which one of plain Coal's samples touches something."""
    return sum(row["contenders"][plain]["certified_not_free"] for row in rows for plain in ("boxes", "tree"))


def table(results: dict[str, Any]) -> str:
    """Markdown; medians over the scenarios."""
    lines = [
        "| robot | instructions | configurations/s: free | random | motions/s: free | all | plain Coal |"
        " times faster (worst to best scenario) |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for entry in results["summary"]:
        median, ratios = entry["median"], [rates["times_coal"] for rates in entry["scenarios"].values()]
        cells = [
            label(entry["robot"], entry["geometry"]),
            entry["backend"],
            *(f"{median[key] / 1e6:.2f} M" for key in ("free_configurations", "random_configurations")),
            *(f"{median[key] / 1e3:.1f} k" for key in ("free_motions", "motions", "coal_motions")),
            f"{median['times_coal']:.1f} ({min(ratios):.1f} to {max(ratios):.1f})",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    header = results["header"]
    options = header["options"]
    lines += [
        "",
        f"{header['cpu']}, srmp {header['versions']['srmp']}, problems {options['problems']} of seven scenarios, "
        f"{options['motions']} motions each; {sum(e['disagreements'] for e in results['summary'])} results differ from "
        f"Coal's own proof, and plain Coal's samples hit something in {contradictions(results['rows'])} of the motions "
        "proved free.",
    ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("--problems", default="1-2", help="numbers in each scenario (default: %(default)s)")
    parser.add_argument("--motions", type=int, default=300, help="in each scene (default: %(default)s)")
    parser.add_argument("--size", type=float, default=0.13, help="of the fastest joint [rad] (default: %(default)s)")
    parser.add_argument("--step", type=float, default=0.01, help="of plain Coal's samples [m] (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3, help="the best counts (default: %(default)s)")
    parser.add_argument("--program", type=Path, help="bench_checks; default: built in build/bench")
    run_or_print(parser, run, table)


if __name__ == "__main__":
    main()
