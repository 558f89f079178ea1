"""Planner options with types: `planner.make_planner("panda", srmp.WAStar(weight=10))`.

Each class holds the options of one planner, with the library's defaults; units and ranges stand in brackets.

docs/generate_options.py writes this file from the registry of options in the library: change the registry, not the
file.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, TypeVar

__all__ = [
    "CBS",
    "ECBS",
    "WPASE",
    "XECBS",
    "AMRAStar",
    "ARAStar",
    "AStar",
    "Auto",
    "MHAStar",
    "Prioritised",
    "RRTConnect",
    "WAStar",
]
_Class = TypeVar("_Class")


@dataclasses.dataclass(kw_only=True)
class _Options:
    """Options that every planner has."""

    planner_id: ClassVar[str]

    time_limit: float = 5.0
    """All phases of a plan together take at most this time [s, > 0]."""
    heuristic: str = "joint_euclidean"
    """This heuristic guides the search: joint_euclidean, joint_proximal, joint_distal, joint_sum, bfs, bfs(0.1) for
    cells of 0.1 m, or the name of a user's heuristic."""
    resolution: float = 15.0
    """A lattice has this step in revolute joints [degrees, > 0 and <= 360]."""
    prismatic_resolution: float = 0.05
    """A lattice has this step in prismatic joints [m, > 0 and <= 1000]."""
    mprim_path: str = ""
    """This YAML file defines the motion primitives; an empty path selects the built-in ones."""
    direction: str = "auto"
    """The search begins at the start (forward), at the goals (backward), or at the end with less clearance (auto)
    [auto | forward | backward]."""
    bfs_resolution: float = 0.05
    """The grid of the bfs heuristic has cells of this size [m, > 0 and <= 1000]."""
    bfs_radius: float = 0.05
    """The grid of the bfs heuristic inflates obstacles by this radius [m, >= 0 and <= 1000]."""
    ik_solutions: int = 16
    """Each target of a pose or position goal becomes at most this many valid configurations: of those that inverse
    kinematics finds, the nearest to the start [> 0]."""
    ik_goal_connection: bool = True
    """A search from the start may also end by inverse kinematics from a state near a pose or position target."""
    recover_start: bool = False
    """A start in collision is recovered first, by a motion on which no pair penetrates deeper and no other pair comes
    into contact."""
    shortcut: bool = True
    """The path is shortened before it is timed."""
    sample_period: float = 0.02
    """The returned trajectory has a sample after each such period [s, > 0]."""
    sample_rate: float = 0.0
    """The returned trajectory has this many samples a second, at even times and nowhere else, in place of a
    `sample_period`; 0 leaves samples at the corners of the path too [Hz, >= 0]."""
    velocity_scaling: float = 1.0
    """The trajectory may use this fraction of the velocity limits [> 0 and <= 1]."""
    acceleration_scaling: float = 1.0
    """The trajectory may use this fraction of the acceleration and jerk limits [> 0 and <= 1]."""
    timing: str = "toppra"
    """The trajectory is time-optimal with rounded corners (toppra), jerk-limited with a stop at each corner (ruckig),
    or a path without times (none) [toppra | ruckig | none]."""
    blend_deviation: float = 0.005
    """No point of the robot leaves the checked path by more than this distance at a rounded corner
    [m, >= 0 and <= 1000]."""
    clearance: float = 0.0
    """The path keeps this clearance from everything, and the robot's links from each other; a pair that is closer at
    the start or at the goal does not come closer on the way from or to there [m, >= 0 and <= 1000]."""
    preferred_clearance: float = 0.0
    """Shortening the path and rounding its corners give away no clearance below this that the searched path had
    [m, >= 0 and <= 1000]."""
    certify: bool = True
    """Code that is independent of the planner verifies the trajectory and attaches a certificate."""

    def __new__(cls: type[_Class], *args: Any, **options: Any) -> _Class:
        """Raises WrongType, with the nearest name, for an option that the planner does not have."""
        from srmp._wrong_types import require_options

        require_options(cls, args, options)
        return super().__new__(cls)  # type: ignore[misc]

    def to_dict(self) -> dict[str, Any]:
        """The dictionary with the same options. Raises WrongType where an attribute was set to what is no option."""
        from srmp._wrong_types import require_options

        options = dataclasses.asdict(self)
        require_options(type(self), (), options)
        for robot, own in options.pop("robots", {}).items():
            options |= {f"{key}_{robot}": value for key, value in own.items()}
        return {"planner_id": self.planner_id, **options}


@dataclasses.dataclass(kw_only=True)
class Auto(_Options):
    """The quickest: RRT-Connect and guided searches from both ends; anytime if requested.

    Literature: RRT-Connect with a deterministic sequence: Kuffner, LaValle 2000; beside it a portfolio of searches with
    several heuristics: Huberman, Lukose, Hogg 1997; Röger, Helmert 2010; Aine et al. 2016.

    Guarantee: cost <= `weight` * optimum of the lattice in which the path was found, or <= `weight` * length of the
    straight line; anytime if requested.
    """

    planner_id: ClassVar[str] = "auto"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """With many robots: `heuristic` and `mprim_path` of single robots, by name, in place of those for all."""
    weight: float = 50.0
    """The first path costs at most this factor times the optimum of its lattice, or the straight line [>= 1]."""
    improve_rounds: int = 0
    """After the first path, this many rounds search for better ones; the result is the same on every machine [>= 0]."""
    improve_time: float = 0.0
    """After the first path, the search for better ones takes this time within `time_limit`; 0 gives it the time that
    `improve_rounds` take [s, >= 0]."""
    final_weight: float = 1.0
    """The search for better paths ends early once this bound is proven; with 1 it uses all its rounds or time [>= 1].
    """
    max_expansions: int = 0
    """Without a first path after this many expanded states, the plan ends as timed_out, on every machine at the same
    place; 0 leaves that to `time_limit` [>= 0]."""
    max_group_expansions: int = 0
    """The same for each group of robots that are planned together, whose searches expand more [>= 0]."""
    num_threads: int = 1
    """At most this many threads plan parts for many robots at the same time; the result does not depend on it
    [> 0 and <= 1024]."""


@dataclasses.dataclass(kw_only=True)
class AStar(_Options):
    """A*: the shortest path in the lattice.

    Literature: A*: Hart, Nilsson, Raphael 1968.

    Guarantee: cost = optimum.
    """

    planner_id: ClassVar[str] = "Astar"


@dataclasses.dataclass(kw_only=True)
class WAStar(_Options):
    """Weighted A*: a path of at most weight times the least cost, quickly.

    Literature: weighted A*: Pohl 1970; lazy edges: Cohen, Phillips, Likhachev 2014.

    Guarantee: cost <= `weight` * optimum.
    """

    planner_id: ClassVar[str] = "wAstar"
    weight: float = 50.0
    """This weight inflates the heuristic [>= 1]."""
    multi_resolution: bool = True
    """Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by
    side, and the bound holds for the one in which the path was found; otherwise one lattice is."""


@dataclasses.dataclass(kw_only=True)
class ARAStar(_Options):
    """ARA*: a first path quickly, then better ones until the time limit.

    Literature: ARA*: Likhachev, Gordon, Thrun 2003.

    Guarantee: anytime; cost <= last proven bound * optimum.
    """

    planner_id: ClassVar[str] = "ARAstar"
    weight: float = 50.0
    """The first round inflates the heuristic by this weight [>= 1]."""
    weight_delta: float = 10.0
    """The weight decreases by this much after each round [> 0]."""
    final_weight: float = 1.0
    """The search ends once this bound is proven [>= 1]."""
    multi_resolution: bool = True
    """Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by
    side, and the bound holds for the one in which the path was found; otherwise one lattice is."""


@dataclasses.dataclass(kw_only=True)
class MHAStar(_Options):
    """MHA*: several heuristics share one search.

    Literature: MHA* with shared expansions: Aine, Swaminathan, Narayanan, Hwang, Likhachev 2016.

    Guarantee: cost <= `w1` * `w2` * optimum.
    """

    planner_id: ClassVar[str] = "MHAstar"
    inadmissible_heuristics: list[str] = dataclasses.field(
        default_factory=lambda: ["joint_proximal", "joint_distal", "joint_sum"]
    )
    """These heuristics guide searches beside the anchor search, which has the option `heuristic`."""
    w1: float = 20.0
    """This weight inflates every heuristic [>= 1]."""
    w2: float = 5.0
    """The keys of the inadmissible searches may exceed the anchor search's by this factor [>= 1]."""
    multi_resolution: bool = True
    """Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by
    side, and the bound holds for the one in which the path was found; otherwise one lattice is."""


@dataclasses.dataclass(kw_only=True)
class WPASE(_Options):
    """Parallel weighted search; the same path for every number of threads.

    Literature: ePA*SE: Mukherjee, Aine, Likhachev 2022; PA*SE: Phillips, Likhachev, Koenig 2014.

    Guarantee: cost <= `weight` * optimum.
    """

    planner_id: ClassVar[str] = "wPASE"
    weight: float = 50.0
    """This weight inflates the heuristic [>= 1]."""
    multi_resolution: bool = True
    """Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by
    side, and the bound holds for the one in which the path was found; otherwise one lattice is."""
    num_threads: int = 1
    """This many threads evaluate edges; the path does not depend on it. More pay where a check takes much longer than
    waking a thread, some 50 us [> 0 and <= 1024]."""
    batch_size: int = 4
    """This many edges are evaluated together; another size may find another path [> 0]."""


@dataclasses.dataclass(kw_only=True)
class AMRAStar(_Options):
    """AMRA*: several heuristics and resolutions share one search; better paths until the time limit.

    Literature: AMRA*: Saxena, Kusnur, Likhachev 2022; MRA*: Du, Islam, Likhachev 2020.

    Guarantee: anytime; first cost <= `w1` * `w2` * optimum of the finest lattice, then <= last proven bound * it.
    """

    planner_id: ClassVar[str] = "AMRAstar"
    w1: float = 20.0
    """In the first round, this weight inflates every heuristic [>= 1]."""
    w2: float = 5.0
    """In the first round, the keys of the inadmissible searches may exceed the anchor search's by this factor [>= 1].
    """
    final_weight: float = 1.0
    """The search ends once this bound is proven [>= 1]."""


@dataclasses.dataclass(kw_only=True)
class RRTConnect(_Options):
    """Two trees that grow towards each other, by the same samples every time: quick, not optimal.

    Literature: RRT-Connect: Kuffner, LaValle 2000.

    Guarantee: none; no path is shorter than the straight line, which bounds the cost.
    """

    planner_id: ClassVar[str] = "RRTConnect"


@dataclasses.dataclass(kw_only=True)
class CBS(_Options):
    """Many robots: the least sum of costs on their lattices.

    Literature: CBS: Sharon, Stern, Felner, Sturtevant 2015.

    Guarantee: sum of costs = optimum, without `independence_detection`.
    """

    planner_id: ClassVar[str] = "CBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """With many robots: `heuristic` and `mprim_path` of single robots, by name, in place of those for all."""
    independence_detection: bool = False
    """Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
    otherwise all robots that can reach each other are."""
    large_neighbourhood_search: bool = True
    """After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
    move as before."""
    num_threads: int = 1
    """At most this many threads plan parts for many robots at the same time; the result does not depend on it
    [> 0 and <= 1024]."""


@dataclasses.dataclass(kw_only=True)
class ECBS(_Options):
    """Many robots: sum of costs within a bound.

    Literature: ECBS: Barer, Sharon, Stern, Felner 2014.

    Guarantee: sum of costs <= product of its three factors * optimum, without `independence_detection`.
    """

    planner_id: ClassVar[str] = "ECBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """With many robots: `heuristic` and `mprim_path` of single robots, by name, in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """This weight inflates the heuristic of each robot's low-level search [>= 1]."""
    high_level_focal_suboptimality: float = 1.3
    """The focal list of the constraint tree holds the nodes within this factor of the lower bound [>= 1]."""
    low_level_focal_suboptimality: float = 1.3
    """The focal list of each robot's low-level search holds the states within this factor of its lower bound [>= 1]."""
    independence_detection: bool = False
    """Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
    otherwise all robots that can reach each other are."""
    multi_resolution: bool = True
    """Lattices of 6, 3, 1.5 and 0.75 times `resolution` (at most 90 degrees) are searched in turn, with budgets that
    grow, and the bound holds for those in which the paths were found; otherwise lattices of `resolution` are."""
    large_neighbourhood_search: bool = True
    """After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
    move as before."""
    num_threads: int = 1
    """At most this many threads plan parts for many robots at the same time; the result does not depend on it
    [> 0 and <= 1024]."""


@dataclasses.dataclass(kw_only=True)
class XECBS(_Options):
    """Many robots: ECBS that reuses its previous searches; quick.

    Literature: xECBS: Shaoul, Mishani, Likhachev, Li 2024.

    Guarantee: none beforehand; sum of costs <= `bound` of its statistics * optimum.
    """

    planner_id: ClassVar[str] = "xECBS"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """With many robots: `heuristic` and `mprim_path` of single robots, by name, in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """This weight inflates the heuristic of each robot's low-level search [>= 1]."""
    high_level_focal_suboptimality: float = 1.3
    """The focal list of the constraint tree holds the nodes within this factor of the lower bound [>= 1]."""
    low_level_focal_suboptimality: float = 1.3
    """The focal list of each robot's low-level search holds the states within this factor of its lower bound [>= 1]."""
    independence_detection: bool = True
    """Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
    otherwise all robots that can reach each other are."""
    large_neighbourhood_search: bool = True
    """After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
    move as before."""
    num_threads: int = 1
    """At most this many threads plan parts for many robots at the same time; the result does not depend on it
    [> 0 and <= 1024]."""


@dataclasses.dataclass(kw_only=True)
class Prioritised(_Options):
    """Many robots: robots of lower priority give way; quick, nothing is proven.

    Literature: priority-based search: Ma, Harabor, Stuckey, Li, Koenig 2019.

    Guarantee: none; it may find no path where there is one.
    """

    planner_id: ClassVar[str] = "prioritised"
    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)
    """With many robots: `heuristic` and `mprim_path` of single robots, by name, in place of those for all."""
    weight_low_level_heuristic: float = 50.0
    """This weight inflates the heuristic of each robot's low-level search [>= 1]."""
    independence_detection: bool = True
    """Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
    otherwise all robots that can reach each other are."""
    large_neighbourhood_search: bool = True
    """After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
    move as before."""
    num_threads: int = 1
    """At most this many threads plan parts for many robots at the same time; the result does not depend on it
    [> 0 and <= 1024]."""
