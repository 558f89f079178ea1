"""What `srmp view FILE` shows: the scene, and the trajectory, of a file of any kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from srmp import _srmp

if TYPE_CHECKING:
    import srmp

    RobotWorld = Callable[[str, str | None], srmp.PlannerInterface]  # of a URDF and a MoveIt scene


def open_file(
    file: str, scene: str | None, urdf: str | None, package_dirs: Sequence[str], robot_world: RobotWorld
) -> tuple[srmp.PlannerInterface, srmp.Trajectory | None]:
    """The world of a file, and a trajectory that is not its own last result.

    Raises FileError for a file that is none of those that can be seen, and where a robot or scene is missing.
    """
    suffix = Path(file).suffix.lower()
    if suffix in (".urdf", ".xml"):
        if urdf:
            raise _srmp.InvalidArgument(f"--urdf gives a robot, but {file} is one itself")
        return robot_world(file, scene), None
    if suffix in (".yaml", ".yml"):
        if not urdf:
            raise _srmp.FileError(f"{file}: a MoveIt scene needs its robot too: --urdf")
        return robot_world(urdf, file), None
    if not scene and not urdf:
        return _world(file, package_dirs), None
    trajectory = _srmp.Trajectory.load(file)
    if urdf:
        return robot_world(urdf, scene), trajectory
    assert scene is not None
    return _srmp.PlannerInterface.load(scene, package_dirs=list(package_dirs)), trajectory


def _world(file: str, package_dirs: Sequence[str]) -> srmp.PlannerInterface:
    try:
        return _srmp.PlannerInterface.load(file, package_dirs=list(package_dirs))
    except _srmp.FileError as error:
        try:
            _srmp.Trajectory.load(file)
        except _srmp.FileError:
            raise error from None
        raise _srmp.FileError(f"{file} is a trajectory; say with --scene or --urdf what its robot is") from error
