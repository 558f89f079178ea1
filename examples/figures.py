"""Draws the motions of the examples with several robots: docs/two-arms-swap.png and docs/four-arms-over-bins.png.

    python examples/figures.py [DIRECTORY]

Needs matplotlib.
"""

import runpy
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parent
FIGURES = {
    "two-arms-swap.png": ("05_two_arms_swap.py", "Two robots swap places"),
    "four-arms-over-bins.png": ("06_four_arms_over_bins.py", "Four robots, each moving to the next bin"),
}

if __name__ == "__main__":
    directory = Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLES.parent / "docs"
    for name, (example, title) in FIGURES.items():
        world = runpy.run_path(str(EXAMPLES / example))
        world["planner"].plot(directory / name, world["trajectory"], title=title)
