"""Planner options with types: `planner.make_planner("panda", srmp.WAStar(weight=10))`.

Each class is a planner of the paper's dictionary; its fields are that planner's options, with the library's defaults.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

__all__ = ["CBS", "ECBS", "WPASE", "XECBS", "ARAStar", "AStar", "Auto", "MHAStar", "Prioritised", "WAStar"]


@dataclasses.dataclass(kw_only=True)
class _Options:
    """Options that every planner has."""

    planner_id: ClassVar[str]

    time_limit: float = 5.0
    """[s] over all phases of a plan, > 0."""
    heuristic: str = "joint_euclidean"
    """joint_euclidean | joint_base | joint_hand | joint_sum | bfs | bfs(0.1), in cells of 0.1 m | one of your own."""
    resolution: float = 15.0
    """Lattice step of revolute joints [degrees], > 0."""
    prismatic_resolution: float = 0.05
    """Lattice step of prismatic joints [m], > 0."""
    mprim_path: str = ""
    """Motion primitives (YAML); "" = built in: joints alone, in pairs, and all at once towards the other end."""
    direction: str = "auto"
    """Search from: forward = the start | backward = the goals | auto = the end with less clearance."""
    bfs_resolution: float = 0.05
    """Cell of the bfs heuristic's grid [m], > 0."""
    bfs_radius: float = 0.05
    """Obstacles are inflated by this in that grid [m], >= 0."""
    ik_solutions: int = 16
    """Configurations tried for a pose or position goal, > 0."""
    ik_goal_connection: bool = True
    """A search from the start may also end by inverse kinematics from a state near a pose or position target."""
    recover_start: bool = False
    """Leave a start in collision: on the way out no pair gets deeper and no other comes into contact."""
    shortcut: bool = True
    """Shorten the path before timing it."""
    sample_period: float = 0.02
    """Of the returned trajectory [s], > 0."""
    velocity_scaling: float = 1.0
    """Share of the velocity limits that may be used, in (0, 1]."""
    acceleration_scaling: float = 1.0
    """Share of the acceleration and jerk limits, in (0, 1]."""
    timing: str = "toppra"
    """toppra: time-optimal, corners rounded | ruckig: jerk-limited, a stop at each corner | none: no times."""
    blend_deviation: float = 0.005
    """No point of the robot leaves the checked path by more at a corner [m], >= 0."""
    certify: bool = True
    """Prove the trajectory by other code (Trajectory.certificate)."""

    def to_dict(self) -> dict[str, Any]:
        """The paper's dictionary."""
        options = dataclasses.asdict(self)
        for robot, own in options.pop("robots", {}).items():
            options |= {f"{key}_{robot}": value for key, value in own.items()}
        return {"planner_id": self.planner_id, **options}


@dataclasses.dataclass(kw_only=True)
class AStar(_Options):
    """A* (Hart, Nilsson, Raphael 1968): the shortest path on the lattice."""

    planner_id: ClassVar[str] = "Astar"


@dataclasses.dataclass(kw_only=True)
class WAStar(_Options):
    """Weighted A* with lazy edges (Pohl 1970; Cohen, Phillips, Likhachev 2014): cost <= weight * optimal."""

    planner_id: ClassVar[str] = "wAstar"
    weight: float = 50.0
    """>= 1."""


@dataclasses.dataclass(kw_only=True)
class ARAStar(_Options):
    """ARA* (Likhachev, Gordon, Thrun 2003): anytime; a first path quickly, then better ones until the time limit."""

    planner_id: ClassVar[str] = "ARAstar"
    weight: float = 50.0
    """First weight, >= 1."""
    weight_delta: float = 10.0
    """Taken off after every round, > 0."""
    final_weight: float = 1.0
    """Stop at this bound, >= 1."""


@dataclasses.dataclass(kw_only=True)
class MHAStar(_Options):
    """MHA* (Aine et al. 2016) with shared expansions: cost <= w1 * w2 * optimal."""

    planner_id: ClassVar[str] = "MHAstar"
    inadmissible_heuristics: list[str] = dataclasses.field(
        default_factory=lambda: ["bfs", "joint_base", "joint_hand", "joint_sum"]
    )
    """Beside the anchor, which is `heuristic`."""
    w1: float = 20.0
    """Inflation of every heuristic, >= 1."""
    w2: float = 5.0
    """How far the others may run ahead of the anchor, >= 1."""


@dataclasses.dataclass(kw_only=True)
class WPASE(_Options):
    """Parallel weighted search on edges (ePA*SE; Mukherjee, Aine, Likhachev 2022): cost <= weight * optimal."""

    planner_id: ClassVar[str] = "wPASE"
    weight: float = 50.0
    """>= 1."""
    num_threads: int = 4
    """1 to 1024; the path does not depend on it."""
    batch_size: int = 16
    """Edges evaluated together, > 0; another batch may find another path."""


@dataclasses.dataclass(kw_only=True)
class Auto(_Options):
    """Guided searches in turns (Huberman, Lukose, Hogg 1997): two directions, four resolutions; anytime if asked."""

    planner_id: ClassVar[str] = "auto"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """For many robots: of single ones, by name, `heuristic` and `mprim_path` in place of those for all."""
    weight: float = 50.0
    """Of the first path, >= 1."""
    improve_rounds: int = 0
    """Of better paths after the first, >= 0: the same answer on every machine."""
    improve_time: float = 0.0
    """[s] for better paths, within the time limit; 0 = as long as the rounds take."""
    final_weight: float = 1.0
    """Stop improving once this bound is proven, >= 1; 1 = go on as long as asked."""
    num_threads: int = 1
    """For many robots: of parts that are planned at the same time, 1 to 1024; the same answer for every number."""


@dataclasses.dataclass(kw_only=True)
class CBS(_Options):
    """CBS (Sharon, Stern, Felner, Sturtevant 2015), many robots: the least sum of costs on their lattices."""

    planner_id: ClassVar[str] = "CBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """Of single robots, by name: `heuristic` and `mprim_path` in place of those for all."""
    num_threads: int = 1
    """Of parts that are planned at the same time, 1 to 1024; the same answer for every number."""


@dataclasses.dataclass(kw_only=True)
class ECBS(_Options):
    """ECBS (Barer, Sharon, Stern, Felner 2014), many robots: cost <= the product of its factors * optimal."""

    planner_id: ClassVar[str] = "ECBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """Of single robots, by name: `heuristic` and `mprim_path` in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """>= 1."""
    high_level_focal_suboptimality: float = 1.3
    """>= 1."""
    low_level_focal_suboptimality: float = 1.3
    """>= 1."""
    num_threads: int = 1
    """Of parts that are planned at the same time, 1 to 1024; the same answer for every number."""


@dataclasses.dataclass(kw_only=True)
class XECBS(_Options):
    """xECBS (Shaoul, Mishani, Likhachev, Li 2024), many robots: ECBS that begins with what it knows; the same bound."""

    planner_id: ClassVar[str] = "xECBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """Of single robots, by name: `heuristic` and `mprim_path` in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """>= 1."""
    high_level_focal_suboptimality: float = 1.3
    """>= 1."""
    low_level_focal_suboptimality: float = 1.3
    """>= 1."""
    improve_rounds: int = 0
    """Of better paths after the first, >= 0."""
    num_threads: int = 1
    """Of parts that are planned at the same time, 1 to 1024; the same answer for every number."""


@dataclasses.dataclass(kw_only=True)
class Prioritised(_Options):
    """Priority-based search (Ma, Harabor, Stuckey, Li, Koenig 2019), many robots: quick; nothing is proved."""

    planner_id: ClassVar[str] = "prioritised"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """Of single robots, by name: `heuristic` and `mprim_path` in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """>= 1."""
    num_threads: int = 1
    """Of parts that are planned at the same time, 1 to 1024; the same answer for every number."""
