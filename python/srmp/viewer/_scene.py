"""What there is to be seen of a planner's scene: triangle meshes and where they are, for every way of drawing them."""

from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp._names import did_you_mean
from srmp.viewer._shapes import Colour, Mesh, MeshesUnreadable, of_object, spheres
from srmp.viewer._urdf_bodies import UrdfBody, read_bodies

if TYPE_CHECKING:
    from srmp import PlannerInterface

ROBOT_KINDS = ("visual", "collision", "spheres")
"""How robots can be drawn: the URDF's visual or collision geometry, or the spheres that cover the latter."""

_ROBOT_COLOURS: tuple[Colour, ...] = (
    (0.93, 0.55, 0.20),
    (0.25, 0.55, 0.80),
    (0.45, 0.70, 0.35),
    (0.75, 0.45, 0.70),
    (0.85, 0.75, 0.30),
    (0.35, 0.70, 0.70),
)
_BOARD: Colour = (0.80, 0.68, 0.52)  # boxes and meshes: furniture
_THING: Colour = (0.36, 0.56, 0.66)  # round objects
_HELD: Colour = (0.20, 0.62, 0.45)
_CLOUD: Colour = (0.55, 0.55, 0.60)
CONTACT: Colour = (0.86, 0.12, 0.12)


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh that moves with a frame."""

    name: str  # unique among the bodies of a scene
    kind: str  # one of ROBOT_KINDS, "object", "held" or "cloud"
    frame: str  # "robot/link", or "" for the world
    pose: NDArray[np.float64]  # (4, 4), in the frame
    mesh: Mesh
    colour: Colour

    @property
    def robot(self) -> str:
        """The robot that it belongs to or is held by; "" for objects in the world."""
        return self.frame.rpartition("/")[0]

    @property
    def label(self) -> str:
        """The name that contacts have for it: of a link 'robot/link', else the object's."""
        return self.frame if self.kind in ROBOT_KINDS else self.name


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, and where the frames are that they move with."""

    bodies: list[Body]
    frames: list[str]  # "robot/link"
    poses: NDArray[np.float64]  # (frames, 7): x, y, z [m], qx, qy, qz, qw, in the world

    def placed(self, body: Body, poses: NDArray[np.float64] | None = None) -> Mesh:
        """The body's mesh in the world, with the frames at `poses` (default: as they are)."""
        return body.mesh.moved(self.frame_matrix(body.frame, poses) @ body.pose)

    def frame_matrix(self, frame: str, poses: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """The homogeneous (4, 4) matrix of a frame in the world."""
        return matrix((self.poses if poses is None else poses)[self.frames.index(frame)]) if frame else np.eye(4)


def matrix(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """The homogeneous (4, 4) matrix of x, y, z, qx, qy, qz, qw."""
    return np.asarray(srmp.Pose(pose[:3], pose[3:]).matrix())


def read_scene(planner: PlannerInterface, kinds: Sequence[str] | None = None) -> Scene:
    """The scene of a planner as it stands.

    kinds: how robots are drawn, of ROBOT_KINDS; default: of each robot the first kind that it has and that can be read
    without further packages.

    Raises InvalidArgument for an unknown kind, FileError for a mesh that is missing or broken, and NotSupported for
    mesh files without the package that reads them.
    """
    for kind in kinds or ():
        if kind not in ROBOT_KINDS:
            known = ", ".join(f"'{name}'" for name in ROBOT_KINDS)
            raise srmp.InvalidArgument(f"robots are drawn as {known}, not '{kind}'{did_you_mean(kind, ROBOT_KINDS)}")
    content = scene_content(planner)
    bodies = [
        body
        for index, robot in enumerate(content["robots"])
        for body in _robot_bodies(robot, _ROBOT_COLOURS[index % len(_ROBOT_COLOURS)], kinds)
    ]
    bodies += [_object_body(item) for item in content["objects"]]
    frames = [f"{robot}/{link}" for robot in planner.robot_names for link in planner.get_link_names(robot)]
    return Scene(bodies, frames, frame_poses(planner))


def scene_content(planner: PlannerInterface) -> dict[str, Any]:
    """What planner.save_scene writes: robots, objects and allowed collisions (docs/files.md)."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "scene.srmp.json"
        planner.save_scene(path)
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["scene"]
    return content


def copied(planner: PlannerInterface) -> PlannerInterface:
    """With the same scene, planners and last result; without planners where these have heuristics in Python."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "problem.srmp.json"
        try:
            planner.save(path)
        except srmp.InvalidArgument:
            planner.save_scene(path)
        return srmp.PlannerInterface.load(path)


def frame_poses(
    planner: PlannerInterface, configurations: Mapping[str, NDArray[np.float64]] | None = None
) -> NDArray[np.float64]:
    """Poses (frames, 7) of all links of all robots, in the order of Scene.frames: at `configurations`, by robot name,
    and of robots not named where they stand."""
    configurations = configurations or {}
    return np.array(
        [
            list(planner.compute_fk(robot, q, link))
            for robot in planner.robot_names
            for q in [configurations[robot] if robot in configurations else planner.get_qpos(robot)]
            for link in planner.get_link_names(robot)
        ]
    ).reshape(-1, 7)


def _robot_bodies(robot: Mapping[str, Any], colour: Colour, kinds: Sequence[str] | None) -> list[Body]:
    if kinds is None:
        kinds = [_first_readable_kind(robot)]
    shades: dict[str, Colour] = {}
    bodies = []
    for kind in kinds:
        for number, part in enumerate(_parts(robot, kind)):
            dark = shades.setdefault(part.link, _shade(colour, 0.78 if len(shades) % 2 else 1.0))
            bodies.append(
                Body(
                    name=f"{robot['name']}/{part.link}/{kind}_{number}",
                    kind=kind,
                    frame=f"{robot['name']}/{part.link}",
                    pose=part.pose,
                    mesh=part.mesh,
                    colour=part.colour or dark,
                )
            )
    return bodies


def _shade(colour: Colour, factor: float) -> Colour:
    red, green, blue = colour
    return red * factor, green * factor, blue * factor


def _first_readable_kind(robot: Mapping[str, Any]) -> str:
    for kind in ("visual", "collision"):
        try:
            if _parts(robot, kind):
                return kind
        except (MeshesUnreadable, srmp.FileError):  # planning needs no visual meshes: they may be missing
            continue
    return "spheres"


def _parts(robot: Mapping[str, Any], kind: str) -> tuple[UrdfBody, ...]:
    arguments = (robot["urdf"], robot["urdf_directory"], tuple(robot["package_dirs"]))
    return _sphere_parts(*arguments) if kind == "spheres" else _urdf_parts(kind, *arguments)


@functools.lru_cache(maxsize=64)
def _urdf_parts(kind: str, urdf: str, urdf_directory: str, package_dirs: tuple[str, ...]) -> tuple[UrdfBody, ...]:
    return tuple(read_bodies(urdf, kind, urdf_directory, package_dirs))


@functools.lru_cache(maxsize=16)
def _sphere_parts(urdf: str, urdf_directory: str, package_dirs: tuple[str, ...]) -> tuple[UrdfBody, ...]:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "robot.urdf"
        path.write_text(urdf, encoding="utf-8")
        parents = [str(parent) for parent in (Path(urdf_directory), *Path(urdf_directory).parents)]
        cover = srmp.cover(str(path), package_dirs=[*(parents if urdf_directory else ()), *package_dirs])
    return tuple(
        UrdfBody(link.link, spheres(link.coarse), np.eye(4), None)
        for link in cover.links
        if len(np.asarray(link.coarse))
    )


def _object_body(item: Mapping[str, Any]) -> Body:
    held, kind = item.get("attached"), item["shape"]["kind"]
    colour = _BOARD if kind in ("box", "mesh") else _THING
    return Body(
        name=item["name"],
        kind="held" if held else "cloud" if kind == "point cloud" else "object",
        frame=f"{held['robot']}/{held['link']}" if held else "",
        pose=matrix(np.asarray(item["pose"], dtype=float)),
        mesh=_object_mesh(json.dumps(item["shape"])),
        colour=_HELD if held else _CLOUD if kind == "point cloud" else colour,
    )


@functools.lru_cache(maxsize=1024)
def _object_mesh(shape: str) -> Mesh:
    """The same Mesh for the same shape, so that drawings can keep what has not changed."""
    return of_object(json.loads(shape))


def coloured(body: Body, colour: Colour) -> Body:
    """The body in another colour."""
    return replace(body, colour=colour)
