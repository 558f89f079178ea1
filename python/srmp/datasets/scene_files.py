"""Objects of scene files, and starts and goals of request files, for variations of given scenes."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import srmp
from srmp._moveit import require_unconstrained
from srmp.datasets.scene import SceneObject


def read_objects(path: Path) -> list[SceneObject]:
    """The objects of a MoveIt scene (YAML) or of a scene or problem file of the library. Raises FileError.

    Raises NotSupported for point clouds and files of meshes: a data set holds its scenes itself.
    """
    if not path.is_file():
        raise srmp.FileError(f"the scene {path} does not exist.")
    if path.suffix in (".yaml", ".yml"):
        with tempfile.TemporaryDirectory(prefix="srmp-") as directory:
            planner = srmp.PlannerInterface()
            copy = _without_robots(path, Path(directory))
            try:
                planner.load_moveit_scene(str(copy))
            except srmp.FileError as error:  # its lines are not those of the file
                raise srmp.FileError(re.sub(rf"{re.escape(str(copy))}(:\d+)?", str(path), str(error))) from error
            planner.save_scene(Path(directory) / "scene.json")
            content = json.loads((Path(directory) / "scene.json").read_text(encoding="utf-8"))
    else:
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise srmp.FileError(f"{path} is not a scene file: {error}.") from error
    try:
        return [_object(item) for item in content["scene"]["objects"]]
    except KeyError as error:
        raise srmp.FileError(f"{path} is not a scene file: it has no {error}.") from error
    except (TypeError, ValueError) as error:
        raise srmp.FileError(f"{path} is not a scene file: {error}.") from error


def _without_robots(path: Path, directory: Path) -> Path:
    """The file without what it says of robots, which are not in this world."""
    import yaml

    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise srmp.FileError(f"{path} is not YAML: {' '.join(str(error).split())}.") from error
    if not isinstance(content, dict) or "world" not in content:
        raise srmp.FileError(f"{path} is not a MoveIt scene: it has no 'world'.")
    copy = directory / "objects.yaml"
    copy.write_text(yaml.safe_dump({"world": content["world"]}), encoding="utf-8")
    return copy


_SIZES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "cone": ("radius", "length"),
}


def _object(item: Mapping[str, Any]) -> SceneObject:
    shape = item["shape"]
    kind = shape["kind"]
    if kind not in _SIZES:
        raise srmp.NotSupported(f"object '{item['name']}' is a {kind}, which variations of a scene cannot have yet.")
    size = [x for key in _SIZES[kind] for x in (shape[key] if key == "size" else [shape[key]])]
    return SceneObject(item["name"], kind, tuple(map(float, size)), tuple(map(float, item["pose"])))


def read_request(planner: srmp.PlannerInterface, robot: str, path: Path) -> tuple[tuple[float, ...], srmp.Pose]:
    """The start of a MoveIt request, and the pose of the end effector at its first goal."""
    request = srmp.load_moveit_request(str(path))
    problem = planner.apply_moveit_request(robot, request)
    require_unconstrained(problem, path)
    goal = problem.goals[0]
    target = goal.targets[0]
    pose = planner.compute_fk(robot, target) if goal.type == srmp.GoalType.JOINTS else srmp.Pose(target[:3], target[3:])
    return tuple(float(x) for x in problem.start), pose
