"""The demonstration: the package's own arm takes its end effector out of one compartment of a shelf and into another.

Shows all steps of a request (robot, scene, goal, planner, trajectory) and is short enough to copy from.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._files import write_json
from srmp._table import format_seconds
from srmp.result import plan_result

# name: (edge lengths, centre) [m]; the shelf is open towards the arm
BOXES = {
    "floor": ((1.8, 1.8, 0.02), (0.25, 0.0, -0.012)),
    "board_low": ((0.30, 0.86, 0.02), (0.60, 0.0, 0.05)),
    "board_middle": ((0.30, 0.86, 0.02), (0.60, 0.0, 0.40)),
    "board_top": ((0.30, 0.86, 0.02), (0.60, 0.0, 0.75)),
    "side_left": ((0.30, 0.02, 0.76), (0.60, 0.44, 0.38)),
    "side_right": ((0.30, 0.02, 0.76), (0.60, -0.44, 0.38)),
    "divider": ((0.30, 0.02, 0.68), (0.60, 0.0, 0.40)),
    "back": ((0.02, 0.90, 0.76), (0.76, 0.0, 0.38)),
}
# name: (radius, length, centre) [m]
CYLINDERS = {
    "can": (0.025, 0.12, (0.60, -0.20, 0.471)),
    "jar": (0.045, 0.16, (0.66, 0.22, 0.491)),
}
START = srmp.Pose.from_rpy([0.58, 0.20, 0.20], [0.0, np.pi / 2, 0.0])  # end effector in the lower left compartment
GOAL = srmp.Pose.from_rpy([0.60, -0.20, 0.48], [0.0, np.pi / 2, 0.0])  # fingers around the can, upper right
ROBOT = "arm7"


def make_world() -> srmp.PlannerInterface:
    """The arm in front of the shelf."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name=ROBOT,
        end_effector="arm7_hand",
    )
    for name, (size, centre) in BOXES.items():
        planner.add_box(name, size, srmp.Pose(p=centre))
    for name, (radius, length, centre) in CYLINDERS.items():
        planner.add_cylinder(name, radius, length, srmp.Pose(p=centre))
    return planner


def start_configuration(planner: srmp.PlannerInterface) -> np.ndarray:
    """The collision-free configuration with the end effector at START that is nearest to the arm's zero position."""
    for q in planner.compute_ik(ROBOT, START):
        if not planner.is_state_colliding(ROBOT, q):
            return q
    raise srmp.Error("The end effector does not reach into the lower compartment.")


@dataclass
class DemoResult:
    """The planned demonstration: planner, trajectory and statistics."""

    planner: srmp.PlannerInterface
    trajectory: srmp.Trajectory
    statistics: Mapping[str, Any]

    def summary(self) -> str:
        """One line: time, expansions, waypoints, length and duration."""
        t, s = self.trajectory, self.statistics
        return (
            f"solved in {format_seconds(s['plan_time_s'])} with {s['expansions']} expansions: "
            f"{len(t.waypoints)} waypoints, {s['path_cost_rad']:.2f} rad, a motion of {t.times[-1]:.2f} s"
        )

    def write(self, path: str | Path) -> None:
        """The plan with the scene that it belongs to."""
        result = plan_result(self.statistics, self.trajectory.joint_names, self.trajectory)
        result["scene"] = {
            "boxes": {name: {"size": size, "position": centre} for name, (size, centre) in BOXES.items()},
            "cylinders": {
                name: {"radius": radius, "length": length, "position": centre}
                for name, (radius, length, centre) in CYLINDERS.items()
            },
        }
        write_json(path, result)

    def draw(self, path: str | Path) -> None:
        """Draws the motion. Needs matplotlib."""
        self.planner.plot(path, self.trajectory, title=f"srmp demo: {self.summary()}")


def run(options: Mapping[str, Any] | None = None) -> DemoResult:
    """Plans the demonstration; `options` as for PlannerInterface.make_planner. Raises PlanningError like plan."""
    planner = make_world()
    planner.make_planner([ROBOT], {"planner_id": "auto", "time_limit": 10, **(options or {})})
    goal = srmp.GoalConstraint(srmp.GoalType.POSE, GOAL)
    trajectory = planner.plan(ROBOT, start_configuration(planner), goal)
    return DemoResult(planner, trajectory, planner.get_planning_stats())
