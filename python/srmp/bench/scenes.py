"""Scenes of several robots: their models, where they stand, the objects around them, and problems in them."""

from __future__ import annotations

import dataclasses
import itertools
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

import srmp
from srmp.bench.mbm import GROUPS, robot_files

Configurations = dict[str, np.ndarray]
"""Robot name: (dof,) [rad]."""


# --- scenes ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    """A robot model. `tool_length`: from the end effector's link to the end of its tool, along the link's z [m]."""

    urdf: Path
    srdf: Path | None = None
    package_dirs: tuple[str, ...] = ()
    group: str = ""
    fixed_joints: Mapping[str, float] = field(default_factory=dict)
    _: dataclasses.KW_ONLY
    base_link: str
    """The link that stands on the table: it never moves, and may therefore touch the objects."""
    end_effector: str
    home: tuple[float, ...]
    tool_length: float
    reach: tuple[float, float]
    """How far from its base it reaches the table, tool down: minimum and maximum [m]."""


@dataclass(frozen=True)
class Robot:
    """A robot of a scene, its base on the floor: position [m], yaw [rad]."""

    name: str
    model: Model
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0

    def at(self, x: float, y: float, yaw: float = 0.0) -> Robot:
        """The same robot at another place: x, y [m], yaw [rad]."""
        return dataclasses.replace(self, position=(float(x), float(y), 0.0), yaw=float(yaw))

    @property
    def base(self) -> srmp.Pose:
        """The pose of its base in the world."""
        return srmp.Pose.from_rpy(self.position, [0, 0, self.yaw])


@dataclass(frozen=True)
class Shape:
    """A box with edge lengths `size`, or a cylinder along z whose `size` is radius and length [m]."""

    name: str
    kind: str
    size: tuple[float, ...]
    pose: srmp.Pose

    def add_to(self, planner: srmp.PlannerInterface) -> None:
        """Adds the shape to the planner's world."""
        if self.kind == "box":
            planner.add_box(self.name, self.size, self.pose)
        else:
            planner.add_cylinder(self.name, *self.size, self.pose)

    def to_dict(self) -> dict[str, Any]:
        """The shape as result files hold it."""
        return {"name": self.name, "type": self.kind, "size": self.size, "pose": list(self.pose)}


@dataclass(frozen=True)
class Held:
    """A shape (its pose that in the link) that moves with a robot's link."""

    shape: Shape
    robot: str
    link: str
    may_touch: tuple[str, ...]

    def add_to(self, planner: srmp.PlannerInterface) -> None:
        """Adds the shape to the planner's world, and attaches it."""
        self.shape.add_to(planner)
        planner.attach_object(self.shape.name, self.robot, self.link, list(self.may_touch), self.shape.pose)

    def to_dict(self) -> dict[str, Any]:
        """The attached shape as result files hold it."""
        return {**self.shape.to_dict(), "robot": self.robot, "link": self.link, "may_touch": self.may_touch}


@dataclass(frozen=True)
class World:
    """Robots, objects and attached objects of a scenario."""

    robots: tuple[Robot, ...]
    shapes: tuple[Shape, ...]
    held: tuple[Held, ...] = ()

    @property
    def models(self) -> list[Model]:
        """The robot models, each once."""
        return list({robot.model.urdf: robot.model for robot in self.robots}.values())

    def build(self) -> srmp.PlannerInterface:
        """A planner with this scene."""
        planner = srmp.PlannerInterface()
        for robot in self.robots:
            planner.add_articulation(
                urdf_path=str(robot.model.urdf),
                srdf_path=str(robot.model.srdf or ""),
                name=robot.name,
                end_effector=robot.model.end_effector,
                group=robot.model.group,
                fixed_joints=dict(robot.model.fixed_joints),
                package_dirs=list(robot.model.package_dirs),
                base_pose=robot.base,
            )
        for item in (*self.shapes, *self.held):
            item.add_to(planner)
        for robot, shape in itertools.product(self.robots, self.shapes):
            planner.set_allowed_collision(f"{robot.name}/{robot.model.base_link}", shape.name)
        return planner

    def to_dict(self, planner: srmp.PlannerInterface) -> dict[str, Any]:
        """All that is needed to build it again elsewhere; poses: x, y, z [m], quaternion x, y, z, w.

        planner: as built; knows which links always touch where no SRDF says it.
        """
        robots = {
            robot.name: {
                "urdf": robot.model.urdf.resolve(),
                "srdf": robot.model.srdf and robot.model.srdf.resolve(),
                "package_dirs": [Path(directory).resolve() for directory in robot.model.package_dirs],
                "allowed": planner.get_always_colliding(robot.name),
                "fixed_joints": robot.model.fixed_joints,
                "base_link": robot.model.base_link,
                "base": list(robot.base),
            }
            for robot in self.robots
        }
        return {
            "robots": robots,
            "objects": [shape.to_dict() for shape in self.shapes],
            "held": [held.to_dict() for held in self.held],
        }


@dataclass(frozen=True)
class Problem:
    """One problem of a scenario: starts and goals of all robots."""

    number: int
    starts: Configurations
    goals: Configurations
    about: Mapping[str, Any]
    """Further entries of its row in the result file."""


class Scenario(Protocol):
    """A scene, and numbered problems in it."""

    name: str
    world: World
    numbers: range
    """The numbers of its problems; of generators, which have endlessly many, of those that are run by default."""
    endless: bool

    def problem(self, number: int) -> Problem:
        """The problem of this number; the same number gives the same problem."""


# --- robots -----------------------------------------------------------------------------------------------------------


def example_robot_data() -> Path | None:
    """robots/ of the example-robot-data package, where pip put it."""
    for path in sys.path:
        directory = Path(path) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if directory.is_dir():
            return directory
    return None


# Files as example-robot-data has them.
MODELS = {
    "panda": Model(
        Path("panda_description/urdf/panda.urdf"),
        Path("panda_description/srdf/panda.srdf"),
        group="arm",
        fixed_joints={"panda_finger_joint1": 0.04},
        base_link="panda_link0",
        end_effector="panda_hand",
        home=(0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
        tool_length=0.1034,
        reach=(0.35, 0.7),
    ),
    "ur5": Model(
        Path("ur_description/urdf/ur5_robot.urdf"),
        base_link="base_link",
        end_effector="tool0",
        home=(0.0, -1.8, 1.9, -1.67, -1.57, 0.0),
        tool_length=0.2,
        reach=(0.35, 0.65),
    ),
    "xarm7": Model(
        Path("xarm_description/urdf/xarm7.urdf"),
        base_link="link_base",
        end_effector="link_eef",
        home=(0.0, -0.6, 0.0, 0.9, 0.0, 1.5, 0.0),
        tool_length=0.1,
        reach=(0.3, 0.55),
    ),
    "ur10": Model(
        Path("ur_description/urdf/ur10_robot.urdf"),
        base_link="base_link",
        end_effector="tool0",
        home=(0.0, -1.8, 2.1, -1.87, -1.57, 0.0),
        tool_length=0.1,
        reach=(0.45, 0.9),
    ),
}
OF_DATA = ("panda", "ur5")
"""Those that MotionBenchMaker's directory has too."""


def find_model(name: str, data: str | Path | None, geometry: str = "urdf") -> Model:
    """The robot of MotionBenchMaker's directory `data`, else that of example-robot-data.

    geometry: "urdf", or "spheres" for MotionBenchMaker's spherized robot.
    """
    if geometry != "urdf" and data is None:
        raise srmp.InvalidArgument(
            f"geometry '{geometry}': only MotionBenchMaker's robots have it; say where they are (--data)."
        )
    if data is not None:
        files = robot_files(data, name, geometry)
        return dataclasses.replace(
            MODELS[name],
            urdf=files.urdf,
            srdf=files.srdf,
            package_dirs=(str(files.directory),),
            group=GROUPS[name],
            fixed_joints={},  # its fingers are fixed in the URDF
        )
    directory = example_robot_data()
    if directory is None:
        raise srmp.FileError(
            f"There is no {name}: say where MotionBenchMaker's robots are (--data), or pip install example-robot-data."
        )
    model = MODELS[name]
    srdf = directory / model.srdf if model.srdf else None
    return dataclasses.replace(model, urdf=directory / model.urdf, srdf=srdf, package_dirs=(str(directory.parents[1]),))
