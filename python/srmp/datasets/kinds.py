"""The kinds of scenes that specs name, each a function of random numbers and its parameters.

Robots stand at the origin and face x; lengths are for a reach of 0.85 m (a Panda) and grow with `scale`. The functions
draw uniform numbers and call no sine or cosine of NumPy, whose last bits depend on the machine's instruction set.
"""

from __future__ import annotations

import fnmatch
import importlib
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import srmp
from srmp.datasets.scene import Scene, SceneObject, pose_of

Generator = np.random.Generator
HALF_TURN = np.pi


@dataclass(frozen=True)
class Parameter:
    """A parameter of a kind: its default, and the least and largest value."""

    default: float | int
    least: float = 0.0
    most: float = float("inf")


@dataclass(frozen=True)
class Kind:
    """A kind of scenes: the function that draws one, its parameters, where starts and goals come from by default."""

    make: Callable[..., Scene]
    parameters: Mapping[str, Parameter]
    start: str = "region"
    goal: str = "region"


# --- parts ------------------------------------------------------------------------------------------------------------

PRIMITIVES = ("box", "sphere", "cylinder", "capsule")  # a cone takes the library ten times as long to add
MESHES = ("convex", "bracket")


def _between(random: Generator, low: float, high: float) -> float:
    return float(random.uniform(low, high))


def _turned(random: Generator, position: Sequence[float], *, upright: bool = True) -> srmp.Pose:
    yaw = _between(random, -HALF_TURN, HALF_TURN)
    tilt = [0.0, 0.0] if upright else [_between(random, -HALF_TURN, HALF_TURN) for _ in range(2)]
    return srmp.Pose.from_rpy(position, [*tilt, yaw])


def _names(objects: int, meshes: int, *, end: str = "") -> list[tuple[str, tuple[str, ...]]]:
    """Names of objects, and the shapes that they may have."""
    primitives = [(f"object_{k}{end}", PRIMITIVES) for k in range(objects)]
    return primitives + [(f"mesh_{k}{end}", MESHES) for k in range(meshes)]


def _add_random(
    scene: Scene,
    random: Generator,
    name: str,
    shapes: Sequence[str],
    size: float,
    position: Sequence[float],
    *,
    upright: bool = True,
) -> None:
    """An object of one of the shapes, at most `size` wide and high [m], centred at the position."""
    shape = shapes[int(random.integers(len(shapes)))]
    half = size / 2
    pose = _turned(random, position, upright=upright)
    edges = random.uniform(0.4, 1.0, 3) * size
    if shape == "box":
        scene.box(name, edges, pose)
    elif shape == "sphere":
        scene.sphere(name, edges[0] / 2, pose)
    elif shape == "capsule":
        scene.capsule(name, edges[0] / 4, edges[1] / 2, pose)
    elif shape == "cylinder":
        scene.cylinder(name, edges[0] / 2, edges[1], pose)
    elif shape == "convex":
        scene.mesh(name, random.uniform(-half, half, (12, 3)), (), pose, convex=True)
    else:
        scene.mesh(name, *_bracket(edges, 0.25), pose)


def _bracket(size: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """The surface of an L-shaped prism: vertices (12, 3) about its centre and triangles (20, 3)."""
    t = thickness
    outline = np.array([[0, 0], [1, 0], [1, t], [t, t], [t, 1], [0, 1]]) - 0.5
    bottom = np.column_stack([outline, np.full(6, -0.5)])
    top = np.column_stack([outline, np.full(6, 0.5)])
    sides = [face for i in range(6) for j in [(i + 1) % 6] for face in ((i, j, j + 6), (i, j + 6, i + 6))]
    ends = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    lids = [(a, c, b) for a, b, c in ends] + [(a + 6, b + 6, c + 6) for a, b, c in ends]
    return np.vstack([bottom, top]) * size, np.array(sides + lids)


def _floor(scene: Scene, scale: float) -> None:
    scene.box("floor", [3 * scale, 3 * scale, 0.02], [0, 0, -0.03])


# --- kinds ------------------------------------------------------------------------------------------------------------


def table(random: Generator, scale: float, objects: int, meshes: int) -> Scene:
    """A table of random height in front of the robot, with clutter of primitives and meshes on it."""
    scene, s = Scene(), scale
    _floor(scene, s)
    height, depth, width = (_between(random, *interval) * s for interval in ((0.0, 0.25), (0.4, 0.6), (0.8, 1.4)))
    near = 0.28 * s
    scene.box("table", [depth, width, 0.04], [near + depth / 2, 0, height - 0.02])
    for name, shapes in _names(objects, meshes):
        size = _between(random, 0.06, 0.2) * s
        x = near + _between(random, 0.1, 0.9) * depth
        y = _between(random, -0.45, 0.45) * width
        _add_random(scene, random, name, shapes, size, [x, y, height + size / 2])
    scene.region("above_table", [depth, 0.8 * width, 0.3 * s], [near + depth / 2, 0, height + 0.17 * s], "down")
    return scene


def shelf(random: Generator, scale: float, levels: int, objects: int, meshes: int) -> Scene:
    """A shelf with boards at random heights; tools reach into its compartments from the front."""
    scene, s = Scene(), scale
    _floor(scene, s)
    near, depth, width = (_between(random, *interval) * s for interval in ((0.45, 0.55), (0.25, 0.35), (0.7, 1.1)))
    heights = [_between(random, 0.05, 0.15) * s]
    for _ in range(levels):
        heights.append(heights[-1] + _between(random, 0.28, 0.38) * s)
    centre, t = near + depth / 2, 0.02
    for k, z in enumerate(heights):
        scene.box(f"board_{k}", [depth, width, t], [centre, 0, z])
    whole = heights[-1] - heights[0] + t
    middle = (heights[-1] + heights[0]) / 2
    scene.box("back", [t, width, whole], [near + depth + t / 2, 0, middle])
    for side, y in (("left", width / 2), ("right", -width / 2)):
        scene.box(f"side_{side}", [depth, t, whole], [centre, y, middle])
    for name, shapes in _names(objects, meshes):
        size = _between(random, 0.05, 0.12) * s
        board = heights[int(random.integers(levels))] + t / 2
        y = _between(random, -0.4, 0.4) * width
        _add_random(scene, random, name, shapes, size, [near + 0.75 * depth, y, board + size / 2])
    for k, (low, high) in enumerate(itertools.pairwise(heights)):
        size = [0.5 * depth, 0.7 * width, max(0.0, high - low - 0.2 * s)]
        scene.region(f"compartment_{k}", size, [near + 0.25 * depth, 0, (low + high) / 2], "forward")
    return scene


def bin(random: Generator, scale: float, bins: int, objects: int, meshes: int) -> Scene:
    """Bins that are open above, turned a little, with objects inside; tools reach into them from above."""
    scene, s = Scene(), scale
    _floor(scene, s)
    gap = 0.42 * s
    for k in range(bins):
        place = srmp.Pose.from_rpy(
            [_between(random, 0.42, 0.55) * s, (k - (bins - 1) / 2) * gap, 0.0], [0, 0, _between(random, -0.3, 0.3)]
        )
        length, width, height = (_between(random, *i) * s for i in ((0.28, 0.4), (0.28, 0.36), (0.1, 0.2)))
        _add_bin(scene, f"bin_{k}", place, length, width, height)
        for name, shapes in _names(objects, meshes, end=f"_in_bin_{k}"):
            size = _between(random, 0.03, 0.07) * s
            at = place @ [
                _between(random, -0.35, 0.35) * length,
                _between(random, -0.35, 0.35) * width,
                0.012 + size / 2,
            ]
            _add_random(scene, random, name, shapes, size, at)
        inside = place @ srmp.Pose(p=[0, 0, 0.08 * s + height / 2])
        scene.region(f"in_bin_{k}", [length - 0.12 * s, width - 0.12 * s, height], inside, "down")
    return scene


def _add_bin(scene: Scene, name: str, place: srmp.Pose, length: float, width: float, height: float) -> None:
    t = 0.01
    scene.box(f"{name}_bottom", [length, width, t], place @ srmp.Pose(p=[0, 0, t / 2]))
    for k, sign in enumerate((-1, 1)):
        scene.box(f"{name}_wall_{k}", [t, width, height], place @ srmp.Pose(p=[sign * length / 2, 0, height / 2]))
        scene.box(f"{name}_wall_{k + 2}", [length, t, height], place @ srmp.Pose(p=[0, sign * width / 2, height / 2]))


def cage(random: Generator, scale: float, bars: int) -> Scene:
    """A cage of bars on a stand; its front is open, and tools reach inside from outside."""
    scene, s = Scene(), scale
    _floor(scene, s)
    edge, t = _between(random, 0.34, 0.44) * s, 0.02 * s
    position = [_between(random, 0.5, 0.6) * s, _between(random, -0.15, 0.15) * s, _between(random, 0.25, 0.4) * s]
    place = srmp.Pose.from_rpy(position, [0, 0, _between(random, -0.25, 0.25)])
    half = edge / 2

    def bar(name: str, size: Sequence[float], centre: Sequence[float]) -> None:
        scene.box(name, size, place @ srmp.Pose(p=centre))

    scene.box(
        "stand", [0.1 * s, 0.1 * s, position[2] - half], [position[0], position[1], (position[2] - half) / 2 - 0.01]
    )
    for level, z in (("bottom", -half), ("top", half)):
        bar(f"{level}_plate", [edge, edge, t], [0, 0, z])
    for k in range(bars):
        along = -half + edge * (k + 0.5) / bars + _between(random, -0.1, 0.1) * edge / bars
        bar(f"left_{k}", [t, t, edge], [along, half, 0])
        bar(f"right_{k}", [t, t, edge], [along, -half, 0])
        bar(f"back_{k}", [t, t, edge], [half, along, 0])
    inside = place @ srmp.Pose(p=[-0.1 * edge, 0, 0])
    scene.region("inside", [0.4 * edge, 0.4 * edge, 0.3 * edge], inside, "forward")
    return scene


def clutter(random: Generator, scale: float, objects: int, meshes: int) -> Scene:
    """Primitives and meshes that hang around the robot; starts and goals are collision-free configurations."""
    scene, s = Scene(), scale
    _floor(scene, s)
    for name, shapes in _names(objects, meshes):
        size = _between(random, 0.08, 0.3) * s
        while True:  # not where the robot's base and its first links always are
            position = np.array([_between(random, *i) * s for i in ((-0.8, 0.9), (-0.9, 0.9), (0.1, 1.1))])
            if position[0] ** 2 + position[1] ** 2 > (0.25 * s + size) ** 2:
                break
        _add_random(scene, random, name, shapes, size, position, upright=False)
    scene.region("around", [1.2 * s, 1.4 * s, 0.7 * s], [0.1 * s, 0, 0.55 * s], "any")
    return scene


def variations(
    random: Generator,
    base: Sequence[Mapping[str, Any]],
    poses: Mapping[str, Sequence[float]],
    shift: float,
    turn: float,
    moved: Sequence[str],
    object_shift: float,
    object_turn: float,
) -> Scene:
    """The objects of a given scene, moved together, and some of them on their own, as in MotionBenchMaker.

    base: objects as dictionaries. poses: of tools, by name, that move with the scene: regions of one point. shift,
    turn: the most that all objects move along x and y [m] and turn about z [rad]; moved: patterns of names of those
    that also move on their own, by object_shift [m] and object_turn [rad] at most.
    """
    scene = Scene()
    centre = np.mean([item["pose"][:3] for item in base], axis=0) if base else np.zeros(3)
    centre[2] = 0.0
    offset = [_between(random, -shift, shift), _between(random, -shift, shift), 0.0]
    whole = srmp.Pose.from_rpy(centre + offset, [0, 0, _between(random, -turn, turn)]) @ srmp.Pose(p=-centre)
    for values in base:
        item = SceneObject.from_dict(values)
        pose = whole @ pose_of(item.pose)
        if any(fnmatch.fnmatchcase(item.name, pattern) for pattern in moved):
            step = [_between(random, -object_shift, object_shift) for _ in range(2)]
            pose = (
                srmp.Pose(p=[*step, 0])
                @ pose
                @ srmp.Pose.from_rpy([0, 0, 0], [0, 0, _between(random, -object_turn, object_turn)])
            )
        scene.objects.append(SceneObject(item.name, item.type, item.size, tuple(pose), item.vertices, item.triangles))
    for name, pose in poses.items():
        scene.region(name, [0, 0, 0], whole @ pose_of(pose), "exact")
    return scene


def function(random: Generator, function: str, parameters: Mapping[str, Any]) -> Scene:
    """A scene of the user's own function "module:name", called with the random numbers and the parameters."""
    module, _, name = function.partition(":")
    try:
        made = getattr(importlib.import_module(module), name)(random, **parameters)
    except srmp.Error as error:
        raise srmp.InvalidArgument(f"{function}: {error}") from error
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise srmp.InvalidArgument(f"{function} of the spec failed: {what}.") from error
    if not isinstance(made, Scene):
        raise srmp.InvalidArgument(f"{function} returned {made!r}; it must return a srmp.datasets.Scene.")
    return made


_SCALE = Parameter(1.0, 0.01, 100.0)


def _parameters(objects: int, meshes: int, **more: Parameter) -> dict[str, Parameter]:
    return {"scale": _SCALE, "objects": Parameter(objects, 0, 500), "meshes": Parameter(meshes, 0, 50), **more}


KINDS = {
    "table": Kind(table, _parameters(7, 1)),
    "shelf": Kind(shelf, _parameters(3, 0, levels=Parameter(2, 1, 10)), "configuration"),
    "bin": Kind(bin, _parameters(3, 0, bins=Parameter(2, 1, 8))),
    "cage": Kind(cage, {"scale": _SCALE, "bars": Parameter(3, 1, 20)}, "configuration"),
    "clutter": Kind(clutter, _parameters(10, 1), "configuration", "configuration"),
    "variations": Kind(variations, {}),
    "function": Kind(function, {}),
}
