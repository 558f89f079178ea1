"""Robots of a spec, and their files as data sets carry them: URDF, SRDF and the meshes of collision geometry."""

from __future__ import annotations

import hashlib
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import srmp
from srmp.datasets.fields import Fields

MODELS = {"arm7": ("arm7.urdf", "arm7.srdf", "arm7_hand")}
"""Robots that come with the package: URDF, SRDF, end effector."""
_MAX_NAME = 60  # of a robot, which names a directory


@dataclass(frozen=True)
class RobotSpec:
    """A robot of a data set; its files are in robots/<name>/ there."""

    name: str
    end_effector: str
    group: str
    fixed_joints: Mapping[str, float]
    base: Sequence[float]
    """Pose of the root link: x, y, z [m], quaternion x, y, z, w."""
    tool_length: float
    """From the end effector's link to the end of its tool, along the link's z [m]."""

    def files_in(self, directory: Path) -> Path:
        """Where its files are in a data set's directory."""
        return directory / "robots" / self.name

    def add_to(self, planner: srmp.PlannerInterface, directory: Path) -> None:
        """Adds the robot to the planner's world; directory: of the data set."""
        files = self.files_in(directory)
        srdf = files / "robot.srdf"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", srmp.RobotWarning)
            planner.add_articulation(
                urdf_path=str(files / "robot.urdf"),
                srdf_path=str(srdf) if srdf.exists() else "",
                name=self.name,
                end_effector=self.end_effector,
                group=self.group,
                fixed_joints=dict(self.fixed_joints),
                base_pose=srmp.Pose(self.base[:3], self.base[3:]),
            )


@dataclass(frozen=True)
class Source:
    """Where a robot's files are on this machine."""

    urdf: Path
    srdf: Path | None
    package_dirs: tuple[Path, ...]

    def named_in(self, sentence: str, copies: Path) -> str:
        """The sentence with the names of these files in place of those of their copies in a directory."""
        return sentence.replace(f"{copies}/robot.urdf", str(self.urdf)).replace(f"{copies}/robot.srdf", str(self.srdf))


def read_robot(fields: Fields, directory: Path) -> tuple[RobotSpec, Source]:
    """A robot of the spec, and its files; relative paths begin at the directory. Raises InvalidArgument."""
    name = fields.text("name")
    if len(name) > _MAX_NAME or not name.replace("_", "").replace("-", "").isalnum():
        raise fields.refusal("name", name, f"made of at most {_MAX_NAME} letters, digits, - and _")
    if fields.has("model"):
        urdf, srdf, end_effector = MODELS[fields.text("model", choices=tuple(MODELS))]
        source = Source(Path(srmp.data_path(urdf)), Path(srmp.data_path(srdf)), ())
    else:
        end_effector = ""
        source = Source(
            fields.file("urdf", directory),
            fields.file("srdf", directory) if fields.has("srdf") else None,
            tuple(directory / path for path in fields.texts("package_dirs")),
        )
    end_effector = fields.text("end_effector", end_effector)
    group = fields.text("group", "")
    fixed = fields.mapping("fixed_joints")
    fixed = {joint: Fields(fixed, f"{fields.where}.fixed_joints").number(joint) for joint in fixed}
    base = fields.inner("base") or Fields({})
    position, rpy = base.numbers("position", 3, (0, 0, 0)), base.numbers("rpy", 3, (0, 0, 0))
    base.close()
    tool = fields.number("tool_length", 0.0, 0.0, 10.0)
    fields.close()
    return RobotSpec(name, end_effector, group, fixed, tuple(srmp.Pose.from_rpy(position, rpy)), tool), source


def pack(name: str, source: Source) -> dict[str, bytes]:
    """The robot's files by their path in a data set, with meshes beside the URDF; visuals are left out.

    Raises FileError where a file is missing or is not XML.
    """
    try:
        root = ElementTree.parse(source.urdf).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise srmp.FileError(f"{source.urdf} cannot be read as a URDF: {error}.") from error
    files = {}
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for mesh in link.iter("mesh"):
            path = _find_mesh(mesh.get("filename", ""), source)
            data = path.read_bytes()
            relative = f"meshes/{hashlib.sha256(data).hexdigest()[:12]}{path.suffix.lower()}"
            mesh.set("filename", f"package://{relative}")
            files[f"robots/{name}/{relative}"] = data
    files[f"robots/{name}/robot.urdf"] = ElementTree.tostring(root, encoding="utf-8")
    if source.srdf:
        files[f"robots/{name}/robot.srdf"] = source.srdf.read_bytes()
    return files


def _find_mesh(filename: str, source: Source) -> Path:
    """The places that the library tries too, but those of ROS's environment variables."""
    for path in _candidates(filename, source):
        if path.is_file():
            return path
    raise srmp.FileError(f"{source.urdf}: mesh '{filename}' was not found; give package_dirs.")


def _candidates(filename: str, source: Source) -> Iterator[Path]:
    directory = source.urdf.resolve().parent
    if filename.startswith("package://"):
        path = filename.removeprefix("package://")
        package, _, inner = path.partition("/")
        for place in (directory, *directory.parents, *source.package_dirs):
            yield place / path
            if place.name == package:
                yield place / inner
    else:
        for place in (directory, *source.package_dirs):
            yield place / filename.removeprefix("file://")
