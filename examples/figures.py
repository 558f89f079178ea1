"""Draws the motions of the examples with several robots: docs/two-arms-swap.png and docs/four-arms-over-bins.png.

    python examples/figures.py [DIRECTORY]

Needs matplotlib.
"""

import runpy
import sys
from pathlib import Path

import numpy as np

import srmp
from srmp._urdf import chain_links, read_joints
from srmp.plot import MotionDrawing, SceneDrawing, draw_motion

EXAMPLES = Path(__file__).parent
LINKS = chain_links(read_joints(srmp.data_path("arm7.urdf")), "arm7_hand")


def drawing(planner, name, motion, instants):
    """The robot at these instants [s]; it stays at the end of its own motion."""
    rows = [motion.sample(min(t, motion.duration)) for t in instants]
    chains = [np.array([planner.compute_fk(name, q, link).p for link in LINKS]) for q in rows]
    return MotionDrawing(chains, instants, motion.end_effector_path())


def draw(path, world, boxes, title):
    """Draws the motion that an example planned, with the boxes (size by name) of its scene."""
    planner, trajectory = world["planner"], world["trajectory"]
    instants = np.linspace(0.0, trajectory.duration, 6)
    scene = SceneDrawing(boxes=[(size, planner.get_object_pose(name).matrix()) for name, size in boxes.items()])
    motions = [drawing(planner, name, motion, instants) for name, motion in trajectory.items()]
    draw_motion(path, scene, motions, title=title)


if __name__ == "__main__":
    directory = Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLES.parent / "docs"
    draw(
        directory / "two-arms-swap.png",
        runpy.run_path(str(EXAMPLES / "05_two_arms_swap.py")),
        dict.fromkeys(("tray_a", "tray_b"), (0.2, 0.2, 0.1)),
        "Two robots swap places",
    )
    draw(
        directory / "four-arms-over-bins.png",
        runpy.run_path(str(EXAMPLES / "06_four_arms_over_bins.py")),
        {f"bin{i}": (0.16, 0.16, 0.14) for i in range(4)},
        "Four robots, each moving to the next bin",
    )
