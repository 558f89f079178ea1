"""Scenarios of several robots in one scene: read from a file, or generated.

A file says where the robots stand, boxes, held cylinders and named states of all robots together; each ordered pair
of two states is a problem. A generator places N robots and draws problems by inverse kinematics: the same scenario,
robots, seed and number give the same problem.
"""

from __future__ import annotations

import functools
import itertools
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp._names import did_you_mean
from srmp.bench.scenes import (
    MODELS,
    OF_DATA,
    Configurations,
    Held,
    Model,
    Problem,
    Robot,
    Scenario,
    Shape,
    World,
    find_model,
)

Target = Callable[[np.random.Generator], srmp.Pose]
"""Draws the target of a robot's tool: its end at the position, z the direction in which it points."""

DOWN = srmp.Pose.from_rpy([0, 0, 0], [np.pi, 0, 0])
FORWARD = srmp.Pose.from_rpy([0, 0, 0], [np.pi, -np.pi / 2, 0])
TRIES = 200
CLEARANCE = 0.01  # of starts and goals [m]


# --- files ------------------------------------------------------------------------------------------------------------


class FileScenario:
    """Named states of all robots; its problems are the ordered pairs of two of them, numbered from 1."""

    endless = False

    def __init__(self, path: str | Path, data: str | Path | None = None, geometry: str = "urdf") -> None:
        self._path = Path(path)
        content = self._read()
        self.name = str(content.get("name", self._path.stem))
        panda = find_model("panda", data, geometry)
        try:
            self._load(content, panda)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            what = f"there is no {error}" if isinstance(error, KeyError) else str(error)
            raise srmp.FileError(f"{self._path} is not a scenario of several robots: {what}.") from error
        self._pairs = list(itertools.permutations(self._states, 2))
        self.numbers = range(1, len(self._pairs) + 1)

    def _read(self) -> Mapping[str, Any]:
        try:
            content = json.loads(self._path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise srmp.FileError(f"{self._path} cannot be read: {error}.") from error
        if not isinstance(content, dict):
            raise srmp.FileError(f"{self._path} is not a scenario of several robots: it is not a JSON object.")
        return content

    def _load(self, content: Mapping[str, Any], panda: Model) -> None:
        robots = tuple(
            Robot(f"panda_{k}", panda, _numbers(base["position"], 3, f"bases[{k}].position"), float(base["yaw"]))
            for k, base in enumerate(content["bases"])
        )
        shapes = tuple(
            Shape(
                str(box["name"]),
                "box",
                _numbers(box["size"], 3, f"the size of {box['name']}"),
                srmp.Pose(p=_numbers(box["position"], 3, f"the position of {box['name']}")),
            )
            for box in content["boxes"]
        )
        held = tuple(_held(k, item, robots) for k, item in enumerate(content.get("attached_cylinders", [])))
        self.world = World(robots, shapes, held)
        self._states: dict[str, Configurations] = {}
        for state, rows in content["states"].items():
            if len(rows) != len(robots):
                raise ValueError(f"state '{state}' has {len(rows)} configurations for {len(robots)} robots")
            self._states[state] = {
                robot.name: np.array(_numbers(row, len(panda.home), f"state '{state}'"))
                for robot, row in zip(robots, rows, strict=True)
            }

    def problem(self, number: int) -> Problem:
        """From one named state to another."""
        start, goal = self._pairs[number - 1]
        return Problem(number, self._states[start], self._states[goal], {"from": start, "to": goal})


_AXES = {"x": [0, np.pi / 2, 0], "y": [-np.pi / 2, 0, 0], "z": [0, 0, 0]}  # roll, pitch, yaw that bring z there


def _held(number: int, item: Mapping[str, Any], robots: Sequence[Robot]) -> Held:
    where = f"attached_cylinders[{number}]"
    axis, index = str(item["axis"]), item["robot"]
    if axis.removesuffix(" of the link") not in _AXES:
        raise ValueError(f"the axis of {where} is '{axis}', not x, y or z of the link")
    if not isinstance(index, int) or not 0 <= index < len(robots):
        raise ValueError(f"{where} is held by robot {index}; there are robots 0 to {len(robots) - 1}")
    pose = srmp.Pose.from_rpy(_numbers(item["position"], 3, f"{where}.position"), _AXES[axis[0]])
    shape = Shape(f"held_{number}", "cylinder", (float(item["radius"]), float(item["length"])), pose)
    return Held(shape, robots[index].name, str(item["link"]), tuple(item["may_touch"]))


def _numbers(values: Sequence[Any], count: int, what: str) -> tuple[float, ...]:
    numbers = tuple(float(value) for value in values)
    if len(numbers) != count or not np.all(np.isfinite(numbers)):
        raise ValueError(f"{what} must be {count} numbers")
    return numbers


# --- generators -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Layout:
    """The scene of a generated scenario, and where its targets are drawn."""

    world: World
    targets: Callable[[np.random.Generator], Sequence[Target]]
    """Draws the targets of all robots' tools together: one Target for each robot."""


@dataclass(frozen=True)
class Kind:
    """A generator: the default and allowed numbers of robots, repetitions of each problem with goals moved a little."""

    make: Callable[[Sequence[Robot]], Layout]
    """Places the robots."""
    robots: int
    allowed: range
    repetitions: int = 1
    problems: int = 50
    mixed: bool = False
    """Whether the robots are of all MODELS, one after the other, instead of Pandas alone."""


class GeneratedScenario:
    """All starts together are collision-free, and so are all goals, by PlannerInterface.is_state_colliding.

    With repetitions, problem k is repetition (k - 1) % n of base problem (k - 1) // n: repetition 0 as drawn, the goals
    of the others moved by up to 2 degrees in one joint of each robot, as in Shaoul et al. 2024.
    """

    endless = True

    def __init__(
        self,
        name: str,
        robots: int | None = None,
        seed: int = 0,
        data: str | Path | None = None,
        repetitions: int | None = None,
        geometry: str = "urdf",
    ) -> None:
        """repetitions: of each base problem, instead of those of its kind. geometry: as in find_model."""
        kind = KINDS[name]
        robots = kind.robots if robots is None else robots
        if robots not in kind.allowed:
            allowed = f"{kind.allowed[0]} to {kind.allowed[-1]}"
            raise srmp.InvalidArgument(f"robots {robots}: '{name}' takes {allowed}.")
        if seed < 0:
            raise srmp.InvalidArgument(f"seed {seed} is below 0.")
        self.name = name
        self.numbers = range(1, kind.problems + 1)
        self._repetitions, self._seed = repetitions or kind.repetitions, seed
        names = (tuple(MODELS) if data is None else OF_DATA) if kind.mixed else ("panda",)
        models = {model: find_model(model, data, geometry) for model in names[:robots]}
        layout = kind.make([Robot(f"{n}_{k}", models[n]) for k, n in zip(range(robots), itertools.cycle(names))])
        self.world, self._targets = layout.world, layout.targets
        self._base = functools.lru_cache(maxsize=1)(self._draw)

    @functools.cached_property
    def _planner(self) -> srmp.PlannerInterface:
        return self.world.build()

    def problem(self, number: int) -> Problem:
        """The problem of this number; the same number gives the same problem."""
        base, repetition = divmod(number - 1, self._repetitions)
        starts, goals = self._base(base)
        about = {} if self._repetitions == 1 else {"base": base, "repetition": repetition}
        if repetition:
            goals = self._moved(goals, self._random(base, repetition))
        return Problem(number, starts, goals, about)

    def _random(self, *numbers: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, zlib.crc32(self.name.encode()), *numbers])

    def _draw(self, base: int) -> tuple[Configurations, Configurations]:
        random = self._random(base)
        return self._together(random, base), self._together(random, base)

    def _together(self, random: np.random.Generator, base: int) -> Configurations:
        for _ in range(TRIES):
            if (found := self._place_all(random)) is not None:
                return found
        raise srmp.Error(f"no problem {base} of '{self.name}' was found in {TRIES} tries.")

    def _place_all(self, random: np.random.Generator) -> Configurations | None:
        """Places robot after robot, free of those that are placed already and of the others at home."""
        for robot in self.world.robots:
            self._planner.set_qpos(robot.name, robot.model.home)
        placed: Configurations = {}
        for robot, target in zip(self.world.robots, self._targets(random), strict=True):
            q = self._place(robot, target, random)
            if q is None:
                return None
            placed[robot.name] = q
        return placed

    def _place(self, robot: Robot, target: Target, random: np.random.Generator) -> np.ndarray | None:
        to_link = srmp.Pose(p=[0, 0, -robot.model.tool_length])
        for _ in range(10):
            pose = target(random) @ to_link
            for q in self._planner.compute_ik(robot.name, pose, robot.model.home, max_solutions=2, seeds=8):
                if self._stands_free(robot.name, q):
                    return np.array(q)
        return None

    def _stands_free(self, name: str, q: np.ndarray) -> bool:
        """Leaves the robot there if it is, CLEARANCE away from everything."""
        # Of what moves: arms stand close to their tables.
        if self._planner.collision_checker(name, mode="coal").clearance([q])[0] < CLEARANCE:
            return False
        self._planner.set_qpos(name, q)
        return True

    def _moved(self, goals: Configurations, random: np.random.Generator) -> Configurations:
        for name, q in goals.items():
            self._planner.set_qpos(name, q)
        return {name: self._moved_one(name, q, random) for name, q in goals.items()}

    def _moved_one(self, name: str, q: np.ndarray, random: np.random.Generator) -> np.ndarray:
        limits = self._planner.get_joint_limits(name)
        for _ in range(TRIES):
            moved, joint = q.copy(), int(random.integers(len(q)))
            moved[joint] += np.deg2rad(random.uniform(-2, 2))
            if limits[joint, 0] <= moved[joint] <= limits[joint, 1] and self._stands_free(name, moved):
                return moved
        return q


def _box(name: str, size: Sequence[float], centre: Sequence[float]) -> Shape:
    return Shape(name, "box", tuple(size), srmp.Pose(p=centre))


def _floor(half: float) -> Shape:
    return _box("floor", (2 * half, 2 * half, 0.02), (0, 0, -0.01))


def _spin(random: np.random.Generator) -> srmp.Pose:
    """About the direction in which the tool points: half a turn, as grippers of two fingers need no more."""
    return srmp.Pose.from_rpy([0, 0, 0], [0, 0, random.uniform(-np.pi / 2, np.pi / 2)])


def _uniform(random: np.random.Generator, *intervals: tuple[float, float]) -> list[float]:
    return [random.uniform(*interval) for interval in intervals]


def _around(robot: Robot, azimuth: tuple[float, float], height: tuple[float, float]) -> Target:
    """Tool down, within the robot's reach, at an angle from its front [rad] and a height above its base [m]."""

    def draw(random: np.random.Generator) -> srmp.Pose:
        r, angle, z = _uniform(random, robot.model.reach, azimuth, height)
        return robot.base @ srmp.Pose(p=[r * np.cos(angle), r * np.sin(angle), z]) @ DOWN @ _spin(random)

    return draw


def _always(targets: Sequence[Target]) -> Callable[[np.random.Generator], Sequence[Target]]:
    return lambda random: targets


def _grid(robots: Sequence[Robot]) -> Layout:
    """Rows and columns 1 m apart, tools anywhere around their robots: neighbours share workspace."""
    columns = int(np.ceil(np.sqrt(len(robots))))
    places = [divmod(k, columns) for k in range(len(robots))]
    middle = np.mean(places, axis=0)
    placed = [
        robot.at(column - middle[1], row - middle[0]) for robot, (row, column) in zip(robots, places, strict=True)
    ]
    aims = [_around(robot, (-np.pi, np.pi), (0.05, 0.5)) for robot in placed]
    return Layout(World(tuple(placed), (_floor(columns / 2 + 1),)), _always(aims))


def _circle(robots: Sequence[Robot], radius: float) -> tuple[Robot, ...]:
    """Evenly around the origin, facing it."""
    angles = [2 * np.pi * k / len(robots) for k in range(len(robots))]
    return tuple(
        robot.at(radius * np.cos(angle), radius * np.sin(angle), angle - np.pi)
        for robot, angle in zip(robots, angles, strict=True)
    )


def _ring(robots: Sequence[Robot]) -> Layout:
    """Around a table, at least 0.65 m apart, end effectors over the table."""
    radius = max(0.65, 0.325 / np.sin(np.pi / len(robots)))
    placed = _circle(robots, radius)
    table = Shape("table", "cylinder", (radius + 0.3, 0.05), srmp.Pose(p=[0, 0, -0.025]))
    return Layout(World(placed, (table,)), _always([_around(robot, (-1.0, 1.0), (0.03, 0.35)) for robot in placed]))


_BINS = [(x, y) for x in (-0.17, 0.17) for y in (-0.17, 0.17)]


def _bin(name: str, x: float, y: float) -> list[Shape]:
    """0.3 m wide inside, 0.12 m high, open above."""
    sides = [(0.155, 0.0), (-0.155, 0.0), (0.0, 0.155), (0.0, -0.155)]
    walls = [
        _box(f"{name}_wall_{k}", (0.01, 0.32, 0.12) if dx else (0.32, 0.01, 0.12), (x + dx, y + dy, 0.06))
        for k, (dx, dy) in enumerate(sides)
    ]
    return [_box(f"{name}_floor", (0.3, 0.3, 0.01), (x, y, 0.005)), *walls]


def _binpick(robots: Sequence[Robot]) -> Layout:
    """Around four bins, each end effector in a bin of its own, drawn anew for start and goal."""
    shapes = [shape for k, place in enumerate(_BINS) for shape in _bin(f"bin_{k}", *place)]

    def into(x: float, y: float) -> Target:
        def draw(random: np.random.Generator) -> srmp.Pose:
            inside = _uniform(random, (x - 0.08, x + 0.08), (y - 0.08, y + 0.08), (0.03, 0.1))
            return srmp.Pose(p=inside) @ DOWN @ _spin(random)

        return draw

    bins = [into(*place) for place in _BINS]
    return Layout(
        World(_circle(robots, 0.55), (_floor(1.0), *shapes)),
        lambda random: [bins[k] for k in random.permutation(len(bins))[: len(robots)]],
    )


_SHELF = {  # edge lengths, centre [m]
    "board_0": ((0.3, 2.0, 0.02), (0.65, 0.0, 0.1)),
    "board_1": ((0.3, 2.0, 0.02), (0.65, 0.0, 0.45)),
    "board_2": ((0.3, 2.0, 0.02), (0.65, 0.0, 0.8)),
    "back": ((0.02, 2.0, 0.72), (0.81, 0.0, 0.45)),
    "side_left": ((0.3, 0.02, 0.72), (0.65, 1.01, 0.45)),
    "side_right": ((0.3, 0.02, 0.72), (0.65, -1.01, 0.45)),
}


def _shelves(robots: Sequence[Robot]) -> Layout:
    """Side by side 0.45 m apart before a shelf, end effectors level between two boards or above them."""
    placed = [robot.at(0.0, 0.45 * (k - (len(robots) - 1) / 2)) for k, robot in enumerate(robots)]

    def before(robot: Robot) -> Target:
        def draw(random: np.random.Generator) -> srmp.Pose:
            x, dy, dz, heading = _uniform(random, (0.55, 0.7), (-0.4, 0.4), (0.12, 0.24), (-0.35, 0.35))
            board = (0.1, 0.45, 0.8)[random.integers(3)]
            place = srmp.Pose.from_rpy([x, robot.position[1] + dy, board + dz], [0, 0, heading])
            return place @ FORWARD @ _spin(random)

        return draw

    shapes = [_box(name, *box) for name, box in _SHELF.items()]
    return Layout(World(tuple(placed), (_floor(1.5), *shapes)), _always([before(robot) for robot in placed]))


KINDS = {
    "ring": Kind(_ring, robots=4, allowed=range(2, 17)),
    "binpick": Kind(_binpick, robots=4, allowed=range(1, 5), repetitions=5, problems=75),
    "shelves": Kind(_shelves, robots=3, allowed=range(1, 5), repetitions=5, problems=75),
    "grid": Kind(_grid, robots=8, allowed=range(2, 129)),
    "mixed": Kind(_ring, robots=4, allowed=range(2, 17), mixed=True),
}


def find(
    scenario: str,
    robots: int | None = None,
    seed: int = 0,
    data: str | Path | None = None,
    geometry: str = "urdf",
) -> Scenario:
    """The scenario of that name, or in that file; geometry: of the robots, as in find_model."""
    if scenario in KINDS:
        return GeneratedScenario(scenario, robots, seed, data, geometry=geometry)
    if not Path(scenario).is_file():
        hint = did_you_mean(scenario, KINDS) or "."
        raise srmp.InvalidArgument(f"scenario '{scenario}' is neither a file nor one of {', '.join(KINDS)}{hint}")
    found = FileScenario(scenario, data, geometry)
    if robots not in (None, len(found.world.robots)):
        raise srmp.InvalidArgument(f"robots {robots}: {scenario} has {len(found.world.robots)}.")
    return found
