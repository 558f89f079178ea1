"""Lists of robots: TOML files with a table for each robot, its files, groups, gripper and limits."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from srmp import FileError, NotSupported
from srmp._names import did_you_mean
from srmp.robots._packages import PACKAGES

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LIMITS = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Robot:
    """What is known of a robot; paths are relative to the directory of its package, or of the list without one."""

    name: str  #: as add_robot takes it
    listed_in: Path  #: the TOML file
    title: str = ""  #: what it is, in a few words
    package: str = ""  #: on PyPI, which has its files; "": they lie beside the list
    urdf: str = ""
    srdf: str = ""
    group: str = ""  #: of the SRDF, which is planned by default
    end_effector: str = ""  #: the link that goals refer to
    joint_names: tuple[str, ...] = ()  #: planned joints, where no group says them
    gripper: tuple[str, ...] = ()  #: joints of the gripper
    fixed_joints: Mapping[str, float] = field(default_factory=dict)  #: of joints that are not planned [rad or m]
    package_dirs: tuple[str, ...] = ()  #: where meshes are searched
    allowed_collisions: tuple[tuple[str, str], ...] = ()  #: links whose contact does not count
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  #: velocity, acceleration, jerk by joint
    refused: str = ""  #: why it cannot be planned; "" where it can

    @property
    def directory(self) -> Path | None:
        """To which the paths are relative; None when the package is not installed."""
        return PACKAGES[self.package]() if self.package else self.listed_in.parent

    @property
    def installed(self) -> bool:
        """Whether its URDF is on this machine."""
        directory = self.directory
        return directory is not None and (directory / self.urdf).is_file()

    @property
    def urdf_path(self) -> Path:
        """Raises NotSupported when the package is not installed."""
        return self._path(self.urdf)

    @property
    def srdf_path(self) -> Path | None:
        """Raises NotSupported when the package is not installed. None: the robot has no SRDF."""
        return self._path(self.srdf) if self.srdf else None

    def _path(self, path: str) -> Path:
        directory = self.directory
        if directory is None:
            raise NotSupported(
                f"robot '{self.name}' is in the package {self.package}, which is not installed: "
                f"pip install {self.package}"
            )
        return directory / path

    @property
    def groups(self) -> list[str]:
        """Names of the SRDF's planning groups; none where the robot is not installed."""
        if not self.installed or not (srdf := self.srdf_path) or not srdf.is_file():
            return []
        return [group.get("name", "") for group in ElementTree.parse(srdf).getroot().findall("group")]

    def arguments(self, **other: Any) -> dict[str, Any]:
        """Those of add_articulation, without the name; `other` counts more.

        Another group has an end effector of its own, and may plan joints that the list fixes: they are left out here,
        and add_robot sets those that are not planned.
        """
        own: dict[str, Any] = {
            "urdf_path": str(self.urdf_path),
            "srdf_path": str(self.srdf_path or ""),
            "group": self.group,
            "end_effector": self.end_effector,
            "joint_names": list(self.joint_names),
            "fixed_joints": dict(self.fixed_joints),
            "package_dirs": [str(self._path(path)) for path in self.package_dirs],
        }
        if other.get("group", self.group) != self.group or other.get("joint_names"):
            own |= {"end_effector": "", "joint_names": [], "group": "", "fixed_joints": {}}
        elif other.get("end_effector", self.end_effector) != self.end_effector:
            own |= {"joint_names": [], "group": ""}
        return own | other


# --- reading ----------------------------------------------------------------------------------------------------------


def read_list(path: str | os.PathLike[str]) -> list[Robot]:
    """The robots of a TOML file, or of all TOML files of a directory. Raises FileError."""
    try:
        where = Path(path).resolve()
        files = sorted(where.glob("*.toml")) if where.is_dir() else [where]
    except (OSError, ValueError, RuntimeError) as error:  # of a path that cannot be: too long, a loop of links
        reason = error.strerror if isinstance(error, OSError) else error
        raise FileError(f"cannot read the list of robots '{path}': {reason}") from error
    return [robot for file in files for robot in _read_file(file)]


def _read_file(path: Path) -> list[Robot]:
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"cannot read the list of robots '{path}': {error.strerror or error}") from error
    except ValueError as error:
        raise FileError(f"the list of robots '{path}' is not TOML: {error}") from error
    except RecursionError as error:
        raise FileError(f"the list of robots '{path}' has brackets nested too deeply") from error
    package = tables.pop("package", "")
    package_dirs = tables.pop("package_dirs", [])
    defaults = {"package": package, "package_dirs": package_dirs}
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise FileError(
                f"{path}: '{name}' must be a table, [{name}], with the robot of that name; before the tables stand "
                "package and package_dirs, for all robots of the file"
            )
    return [_robot(path, name, {**defaults, **table}) for name, table in tables.items()]


def _robot(path: Path, name: str, table: Mapping[str, Any]) -> Robot:
    robot = Robot(name, path)
    for key, value in table.items():
        if key not in _KEYS:
            raise FileError(
                f"{path}: robot '{name}' has the unknown key '{key}'"
                + (did_you_mean(key, _KEYS) or f"; known: {', '.join(_KEYS)}")
            )
        expected, fits = _KEYS[key]
        if not fits(value):
            raise FileError(f"{path}: {key} of robot '{name}' must be {expected}, but is {value!r}")
        robot = replace(robot, **{key: tuple(value) if isinstance(value, list) else value})
    if not robot.urdf:
        raise FileError(f"{path}: robot '{name}' needs urdf, the path of its URDF")
    if robot.package and robot.package not in PACKAGES:
        raise FileError(
            f"{path}: robot '{name}' is in the package '{robot.package}', of which nothing is known"
            + (did_you_mean(robot.package, PACKAGES) or f"; known: {', '.join(PACKAGES)}")
            + ". Without package, paths are relative to this file"
        )
    return robot


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _is_pairs(value: object) -> bool:
    return isinstance(value, list) and all(_is_texts(item) and len(item) == 2 for item in value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_numbers(value: object) -> bool:
    return isinstance(value, dict) and all(map(_is_number, value.values()))


def _is_limits(value: object) -> bool:
    return isinstance(value, dict) and all(_is_numbers(item) and set(item) <= set(LIMITS) for item in value.values())


_KEYS: dict[str, tuple[str, Callable[[object], bool]]] = {
    **dict.fromkeys(("title", "package", "urdf", "srdf", "group", "end_effector", "refused"), ("a string", _is_text)),
    **dict.fromkeys(("joint_names", "gripper", "package_dirs"), ("a list of strings", _is_texts)),
    "fixed_joints": ("a table of numbers by joint", _is_numbers),
    "allowed_collisions": ("a list of pairs of links", _is_pairs),
    "limits": (f"a table of tables by joint, with {', '.join(LIMITS)}", _is_limits),
}
