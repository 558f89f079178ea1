"""Do planner and simulator see the same world?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, PlannerInterface, Pose
from srmp.sim.contacts import ContactNames, Pair
from srmp.sim.robots import Robot
from srmp.sim.simulator import Probe
from srmp.sim.world import SAME_POSE, SimulatedWorld, world_of


@dataclass
class Difference:
    """A pair of bodies that touch in one of the worlds only."""

    pair: Pair
    seen_by: str  # "planner" or the simulator's kind
    states: int = 0  # in how many
    depth: float = 0.0  # [m] deepest overlap
    first_state: dict[str, NDArray[np.float64]] = field(default_factory=dict)  # of each robot
    reason: str = ""  # why it may be; "" = unexplained

    def __str__(self) -> str:
        where = f"{self.pair[0]} and {self.pair[1]}: seen by {self.seen_by} alone in {self.states} states"
        return f"{where}, up to {1000 * self.depth:.3g} mm deep: {self.reason or 'NOT EXPLAINED'}"


@dataclass
class ParityReport:
    """What check_parity found. True where there is nothing that is not explained."""

    kind: str
    samples: int
    margin: float  # [m]
    collisions: dict[str, int]  # states in collision, by "planner" and the simulator's kind
    link_error_m: float  # largest
    link_error_rad: float
    worst_link: str
    differences: list[Difference]
    not_compared: dict[Pair, str]  # pairs that one of the two is told to ignore, and which
    robot_differences: list[str]

    @property
    def unexplained(self) -> list[Difference]:
        """The differences without a known reason."""
        return [difference for difference in self.differences if not difference.reason]

    @property
    def links_agree(self) -> bool:
        """Whether all link poses agree, to 1e-5 m and 1e-5 rad."""
        return max(self.link_error_m, self.link_error_rad) <= SAME_POSE

    def __bool__(self) -> bool:
        return self.links_agree and not self.unexplained

    def __str__(self) -> str:
        counts = ", ".join(f"{count} by {who}" for who, count in self.collisions.items())
        lines = [
            f"{self.samples} states: link poses differ by at most {self.link_error_m:.2g} m and "
            f"{self.link_error_rad:.2g} rad ({self.worst_link})"
            + ("" if self.links_agree else f", more than {SAME_POSE}: NOT THE SAME KINEMATICS"),
            f"in collision: {counts}; {len(self.differences)} pairs differ, {len(self.unexplained)} unexplained",
            *(f"  {difference}" for difference in self.differences),
            *(f"  not compared, {why}: {a} and {b}" for (a, b), why in sorted(self.not_compared.items())),
            *(f"  {sentence}" for sentence in self.robot_differences),
        ]
        return "\n".join(lines)


def check_parity(
    planner: PlannerInterface,
    sim: Any = None,
    samples: int = 1000,
    seed: int = 0,
    margin: float | None = None,
) -> ParityReport:
    """Puts the robots into random states in both worlds, and compares link poses and collision states.

    planner: one whose scene was read by read_sim, from `sim`; it is refreshed first. samples, seed: how many states,
    drawn evenly between the joint limits. margin: [m], default the simulator's own: touches no deeper than that are no
    disagreement. The simulator is left as it was.

    A pair that differs may be explained: shapes of the URDF that are not those of the simulator (the difference is gone
    with the simulator's own), a contact of which the other side is told to ignore one, or shapes that the simulator
    itself tests roughly. What a robot holds is not compared, as the simulator's robots are put without it.
    Raises InvalidArgument when nothing was read, no robot, or another scene, and for numbers that are not as said.
    """
    world = world_of(planner)
    if sim is not None and not world.simulator.is_of(sim):
        raise InvalidArgument("this is not the scene that the planner has read; give the one that read_sim was given")
    if not isinstance(samples, Integral) or samples < 1:
        raise InvalidArgument(f"samples is {samples!r}; a whole number of states, at least 1, is needed")
    if not isinstance(seed, Integral) or seed < 0:
        raise InvalidArgument(f"seed is {seed!r}; it is to be a whole number, 0 or more")
    if margin is not None and not (isinstance(margin, Real) and math.isfinite(margin) and margin >= 0):
        raise InvalidArgument(f"margin is {margin!r}; it is to be 0 m or more, or None for the simulator's own")
    if not world.robots:
        raise InvalidArgument(
            "no robot was read, so there is nothing to compare; name some in read_sim's articulations"
        )
    world.refresh()
    return _Comparison(world, world.simulator.margin if margin is None else margin).run(samples, seed)


class _Comparison:
    def __init__(self, world: SimulatedWorld, margin: float) -> None:
        self.world = world
        self.planner = world.planner
        self.kind = world.simulator.kind
        self.margin = margin
        self.names = ContactNames(world)
        self.differences: dict[tuple[Pair, str], Difference] = {}
        self.not_compared: dict[Pair, str] = {}
        self.errors: tuple[float, float, str] = (0.0, 0.0, "")
        self.counts = {"planner": 0, self.kind: 0}

    def run(self, samples: int, seed: int) -> ParityReport:
        random = np.random.default_rng(seed)
        robots = list(self.world.robots.values())
        before = {robot.name: self.planner.get_qpos(robot.name) for robot in robots}
        try:
            with self.world.simulator.probe() as probe:
                for _ in range(samples):
                    state = {robot.name: self._random_state(robot, random) for robot in robots}
                    self._compare(probe, state)
        finally:
            for name, q in before.items():
                self.planner.set_qpos(name, q)
        self._explain()
        return ParityReport(
            kind=self.kind,
            samples=samples,
            margin=self.margin,
            collisions=self.counts,
            link_error_m=self.errors[0],
            link_error_rad=self.errors[1],
            worst_link=self.errors[2],
            differences=sorted(self.differences.values(), key=lambda each: each.pair),
            not_compared=self.not_compared,
            robot_differences=self.world.differences,
        )

    def _random_state(self, robot: Robot, random: np.random.Generator) -> NDArray[np.float64]:
        limits = self.planner.get_joint_limits(robot.name)[:, :2]
        return random.uniform(np.maximum(limits[:, 0], -np.pi), np.minimum(limits[:, 1], np.pi))

    def _compare(self, probe: Probe, state: Mapping[str, NDArray[np.float64]]) -> None:
        for name, q in state.items():
            robot = self.world.robots[name]
            self.planner.set_qpos(name, q)
            joints = [robot.joints[joint] for joint in self.planner.get_joint_names(name)]
            probe.put(robot.articulation, dict(zip(joints, q.tolist(), strict=True)))
        for name, q in state.items():
            self._compare_links(probe, self.world.robots[name], q)
        ours, theirs = self._planner_pairs(state), self._simulator_pairs(probe)
        self.counts["planner"] += bool(ours)
        self.counts[self.kind] += bool(theirs)
        for pairs, others, who in ((ours, theirs, "planner"), (theirs, ours, self.kind)):
            for pair, depth in pairs.items():
                if pair not in others and depth > self.margin:
                    self._note(pair, who, depth, state)

    def _compare_links(self, probe: Probe, robot: Robot, q: NDArray[np.float64]) -> None:
        poses = probe.link_poses(robot.articulation)
        for ours, theirs in robot.links.items():
            metres, radians = _distance(self.planner.compute_fk(robot.name, q, ours), poses[theirs])
            if max(metres, radians) > max(self.errors[:2]):
                self.errors = (metres, radians, f"{robot.name}/{ours}")

    def _planner_pairs(self, state: Mapping[str, NDArray[np.float64]]) -> dict[Pair, float]:
        pairs: dict[Pair, float] = {}
        for name, q in state.items():
            for contact in self.planner.contacts(name, q):
                pair = self.names.pair(*(self._full_name(body, name) for body in (contact.body_a, contact.body_b)))
                pairs[pair] = max(pairs.get(pair, 0.0), -contact.distance)
        return pairs

    def _full_name(self, body: str, robot: str) -> str:
        return f"{robot}/{body}" if body in self.planner.get_link_names(robot) else body

    def _simulator_pairs(self, probe: Probe) -> dict[Pair, float]:
        """Those that the planner does not allow."""
        pairs = self.names.of_robots(probe.touching())
        ignored = [pair for pair in pairs if self.names.told_to_ignore(pair)]
        for pair in ignored:
            self.not_compared[pair] = "the planner allows it"
            del pairs[pair]
        return pairs

    def _note(self, pair: Pair, who: str, depth: float, state: Mapping[str, NDArray[np.float64]]) -> None:
        if any(self.world.is_held(body) for body in pair):
            self.not_compared[pair] = f"a robot holds one, which moves with it in the planner only, not in {self.kind}"
            return
        if not all(self.world.is_of_simulator(body) for body in pair):
            self.not_compared[pair] = f"{self.kind} does not have one of the two"
            return
        if who == "planner" and not self.world.may_touch_in_simulator(*pair):
            self.not_compared[pair] = f"{self.kind} lets them through each other"
            return
        reason = self.world.why_differ(*pair, who)
        new = Difference(pair, who, first_state=dict(state), reason=reason)
        difference = self.differences.setdefault((pair, who), new)
        difference.states += 1
        difference.depth = max(difference.depth, depth)

    def _explain(self) -> None:
        """Robots from URDFs: is the difference gone with the simulator's own shapes?"""
        from_urdf = {name for name, robot in self.world.robots.items() if not robot.from_simulator}
        if not any(self.world.split(body)[0] in from_urdf for d in self.differences.values() for body in d.pair):
            return
        twin = self.world.with_own_models()
        for difference in self.differences.values():
            if not any(self.world.split(body)[0] in from_urdf for body in difference.pair):
                continue
            comparison = _Comparison(twin, self.margin)
            with twin.simulator.probe() as probe:
                comparison._compare(probe, difference.first_state)
            if (difference.pair, difference.seen_by) not in comparison.differences:
                links = [body for body in difference.pair if self.world.split(body)[0] in from_urdf]
                difference.reason = f"the URDF's shapes of {' and '.join(links)} are not those of {self.kind}"


def _distance(a: Pose, b: Pose) -> tuple[float, float]:
    between = a.inverse() @ b
    vector, w = np.asarray(between.q[:3]), abs(float(between.q[3]))
    return float(np.linalg.norm(between.p)), 2 * float(np.arctan2(np.linalg.norm(vector), w))
