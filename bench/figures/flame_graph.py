"""Draws where the CPU time of plans goes, as a flame graph.

    python bench/figures/flame_graph.py --data DIR flame.svg

Plans the first problem of each of MotionBenchMaker's scenarios, with `auto` and the Panda's meshes, again and again
under Linux's `perf`, which has to be installed (Debian: linux-perf), and draws its samples. From the bottom to the top
are the callers; a box is as wide as its part of the time. Below 0.4 % nothing is drawn.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from srmp.bench import mbm

WIDTH, ROW, SMALLEST = 1200, 17, 0.004
COLORS = {"batch": "#e07b39", "coal": "#c0504d", "toppra": "#7f9f7f", "trajectory": "#8aa9c9"}  # by what the name has


@dataclass
class Frame:
    samples: int = 0
    called: dict[str, Frame] = field(default_factory=dict)

    def add(self, stack: list[str]) -> None:
        frame = self
        frame.samples += 1
        for name in stack:
            frame = frame.called.setdefault(name, Frame())
            frame.samples += 1

    def depth(self) -> int:
        return 1 + max((each.depth() for each in self.called.values()), default=0)


def plan_for(seconds: float, data: Path) -> None:
    """What perf watches."""
    files = mbm.robot_files(data, "panda", "urdf")
    runner = mbm.Runner(files, "auto", {}, 10.0)
    with mbm.open_problems(files.directory, "panda", numbers=[1]) as problems:
        for problem in problems:
            planner, own = runner.set_up(problem)
            planner.prepare()
            planner.plan("panda", own.start, own.goals)
            end = time.process_time() + seconds / len(problems)
            while time.process_time() < end:
                planner.plan("panda", own.start, own.goals)


def short(name: str) -> str:
    """A function's name without its arguments, template arguments and our namespaces."""
    name = re.sub(r"\(anonymous namespace\)::", "", name.split("+0x")[0])
    while (simpler := re.sub(r"<[^<>]*>|\([^()]*\)", "", name)) != name:
        name = simpler
    name = re.sub(r"\b(srmp|detail)::", "", name.strip())
    return name.removesuffix(" const").split(" ")[-1] or "?"


def samples_of(script: str) -> Frame:
    """The stacks in perf's output below PlannerInterface::plan."""
    root = Frame()
    for block in script.split("\n\n"):
        stack = [short(" ".join(line.split()[1:-1])) for line in block.splitlines()[1:] if line.startswith("\t")]
        stack.reverse()
        if "PlannerInterface::plan" in stack:
            root.add(stack[stack.index("PlannerInterface::plan") :])
    return root


def boxes(frame: Frame, name: str, left: float, depth: int, total: int, rows: int) -> list[str]:
    share = frame.samples / total
    if share < SMALLEST:
        return []
    width, top = share * WIDTH, (rows - 1 - depth) * ROW
    color = next((color for part, color in COLORS.items() if part in name), "#d8c690")
    label = name if len(name) * 6.2 < width - 6 else name[: max(0, int((width - 6) / 6.2))]
    parts = [
        f"<g><title>{escape(name)}: {share:.1%}</title>"
        f'<rect x="{left:.1f}" y="{top}" width="{max(width - 0.5, 0.5):.1f}" height="{ROW - 1}" fill="{color}"/>'
        f'<text x="{left + 3:.1f}" y="{top + 12}">{escape(label)}</text></g>'
    ]
    for called, child in sorted(frame.called.items()):
        parts += boxes(child, called, left, depth + 1, total, rows)
        left += child.samples / total * WIDTH
    return parts


def drawn(root: Frame) -> str:
    rows = root.depth()
    parts = boxes(root, f"all: {root.samples} samples", 0.0, 0, root.samples, rows)
    top = min(int(y) for part in parts for y in re.findall(r'<rect x="[^"]*" y="(\d+)"', part))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 {top} {WIDTH} {rows * ROW - top}" '
        f'font-family="monospace" font-size="10.5"><rect y="{top}" width="{WIDTH}" height="{rows * ROW}" fill="white"/>'
        + "\n".join(parts)
        + "</svg>\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=re.sub(r"\n.*", "", __doc__ or "", flags=re.S))
    parser.add_argument("figure", type=Path, help="SVG file")
    parser.add_argument("--data", type=Path, required=True, help="MotionBenchMaker's robots and problems")
    parser.add_argument("--seconds", type=float, default=10.0, help="of planning (default: %(default)s)")
    parser.add_argument("--watched", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.watched:
        plan_for(options.seconds, options.data)
        return
    if not shutil.which("perf"):
        sys.exit("perf is not installed; it counts where the time goes (Debian: apt install linux-perf)")
    with tempfile.TemporaryDirectory() as directory:
        record = ["perf", "record", "-q", "-F", "999", "--call-graph", "dwarf,16384", "-o", f"{directory}/data"]
        again = [sys.executable, __file__, *sys.argv[1:], "--watched"]
        subprocess.run([*record, *again], check=True)
        script = ["perf", "script", "-i", f"{directory}/data", "--no-inline", "-F", "comm,ip,sym,dso"]
        found = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    root = samples_of(found)
    if not root.samples:
        sys.exit("perf has no sample below PlannerInterface::plan")
    options.figure.write_text(drawn(root))
    print(f"{options.figure}: {root.samples} samples")


if __name__ == "__main__":
    main()
