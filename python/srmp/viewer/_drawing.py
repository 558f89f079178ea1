"""A whole drawing of a planner's world: its scene, a motion, or why there is none. Every renderer draws this."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srmp._html_tables import certificate_table
from srmp._verify import summary
from srmp.viewer._failure import Failure, find_failure
from srmp.viewer._motion import Motion, sample_motion, trajectories_of
from srmp.viewer._plots import Plot, plots_of
from srmp.viewer._scene import CONTACT, Body, Scene, read_scene
from srmp.viewer._shapes import Colour, Segments

if TYPE_CHECKING:
    from srmp import MultiTrajectory, PlannerInterface, Trajectory


CAMERA = {"yaw": float(np.radians(-148)), "pitch": float(np.radians(24))}
"""Where one looks from at first: from behind and from the right of a robot that faces x."""
_SEE_THROUGH = 0.4  # opacity


@dataclass(frozen=True, eq=False)
class Drawing:
    """What is drawn; poses are those of Scene.frames."""

    scene: Scene
    motion: Motion | None
    failure: Failure | None  # of the last plan
    paths: dict[str, NDArray[np.float64]]  # (n, 3) [m] of end effectors, by robot
    plots: list[Plot] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # sentences on the motion
    segments: list[Segments] = field(default_factory=list)  # of a search
    panels: list[tuple[str, str]] = field(default_factory=list)  # titles and HTML: certificates, constraint trees

    @property
    def poses(self) -> NDArray[np.float64]:
        """(n, frames, 7): along the motion, else where the robots are shown."""
        if self.motion is not None:
            return self.motion.poses
        return (self.scene.poses if self.failure is None else self.failure.poses)[None]


def make_drawing(
    planner: PlannerInterface,
    trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory] | None = None,
    *,
    kinds: Sequence[str] | None = None,
    plots: bool = True,
    clearances: bool = True,
) -> Drawing:
    """The planner's scene with a motion (default: that of its last plan) or with the reason why that plan failed.

    plots, clearances: with what changes along the motion, and with how near it comes to anything, which takes longest.

    Raises InvalidArgument for a trajectory that is none of the robots', and as read_scene does.
    """
    chosen = trajectories_of(planner, trajectory)
    scene = read_scene(planner, kinds)
    if not chosen:
        return Drawing(scene, None, None if trajectory is not None else find_failure(planner), {})
    motion = sample_motion(planner, chosen)
    paths = {
        robot: motion.poses[:, scene.frames.index(f"{robot}/{planner.get_end_effector(robot)}"), :3] for robot in chosen
    }
    drawn = plots_of(planner, motion, clearances) if plots else []
    return Drawing(scene, motion, None, paths, drawn, _notes(chosen), panels=_certificates(chosen) if plots else [])


def appearance(drawing: Drawing, body: Body) -> tuple[Colour, float]:
    """The colour and the opacity of a body: where a plan failed, one looks through all but the links at fault."""
    if drawing.failure is None:
        return body.colour, 1.0
    if any(body.label in touch.bodies for touch in drawing.failure.touches):
        return CONTACT, 1.0 if body.frame else _SEE_THROUGH
    return body.colour, _SEE_THROUGH


def _notes(trajectories: Mapping[str, Trajectory]) -> list[str]:
    return [
        f"{robot}: {one.duration:.2f} s" + (f"; certificate: {summary(one.certificate)}" if one.certificate else "")
        for robot, one in trajectories.items()
    ]


def _certificates(trajectories: Mapping[str, Trajectory]) -> list[tuple[str, str]]:
    """What each certificate claims, and where it is tightest."""
    return [
        (f"certificate of '{robot}'", certificate_table(one.certificate))
        for robot, one in trajectories.items()
        if one.certificate
    ]


def bounds(drawing: Drawing) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lower and the upper corner (3,) of all that is drawn, without floors: large, thin and flat."""
    poses = drawing.poses
    picked = poses[np.unique(np.linspace(0, len(poses) - 1, 7).astype(int))]
    corners = []
    for body in drawing.scene.bodies:
        for row in picked if body.frame else picked[:1]:
            vertices = drawing.scene.placed(body, row).vertices
            lower, upper = vertices.min(axis=0), vertices.max(axis=0)
            if body.frame or not is_floor(lower, upper):
                corners += [lower, upper]
    if not corners:
        return np.full(3, -0.5), np.full(3, 0.5)
    return np.min(corners, axis=0), np.max(corners, axis=0)


def is_floor(lower: NDArray[np.float32], upper: NDArray[np.float32]) -> bool:
    """Is a body with these corners so large and thin that a picture need not hold all of it?"""
    size = upper - lower
    return bool(min(size[0], size[1]) > 1.2 and size[2] < 0.2 * min(size[0], size[1]))
