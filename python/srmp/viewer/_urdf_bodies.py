"""The visual and collision geometries of a URDF, each with its link, pose and colour."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp._urdf import origin_matrix
from srmp.viewer._shapes import Colour, Mesh, box, capsule, cylinder, load_mesh_file, sphere


@dataclass(frozen=True)
class UrdfBody:
    """One geometry of a link, or one part of its mesh file."""

    link: str
    mesh: Mesh
    pose: NDArray[np.float64]  # (4, 4), in the link's frame
    colour: Colour | None  # None: the URDF does not say one


def read_bodies(urdf: str, kind: str, urdf_directory: str, package_dirs: Sequence[str]) -> list[UrdfBody]:
    """All geometries of a kind, "visual" or "collision", of the URDF's text.

    Raises FileError for a mesh file that is missing or broken, and MeshesUnreadable where no package reads it.
    """
    root = ElementTree.fromstring(urdf)
    materials = {material.get("name", ""): _colour(material) for material in root.findall("material")}
    bodies = []
    for link in root.findall("link"):
        for element in link.findall(kind):
            geometry, material = element.find("geometry"), element.find("material")
            if geometry is None or not len(geometry):
                continue
            colour = None
            if material is not None:
                colour = _colour(material) or materials.get(material.get("name", ""))
            pose = origin_matrix(element.find("origin"))
            for mesh, own in _parts(geometry[0], urdf_directory, package_dirs):
                bodies.append(UrdfBody(link.get("name", ""), mesh, pose, colour or own))
    return bodies


def _parts(
    shape: ElementTree.Element, urdf_directory: str, package_dirs: Sequence[str]
) -> Iterator[tuple[Mesh, Colour | None]]:
    def number(name: str) -> float:
        return float(shape.get(name, "0"))

    match shape.tag:
        case "box":
            yield box(_numbers(shape.get("size", "0 0 0"))), None
        case "cylinder":
            yield cylinder(number("radius"), number("length")), None
        case "capsule":
            yield capsule(number("radius"), number("length")), None
        case "sphere":
            yield sphere(number("radius")), None
        case "mesh":
            path = find_mesh(shape.get("filename", ""), urdf_directory, package_dirs)
            scale = np.diag([*_numbers(shape.get("scale", "1 1 1")), 1.0])
            for mesh, colour in load_mesh_file(path):
                yield (mesh if np.array_equal(scale, np.eye(4)) else mesh.moved(scale)), colour


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def _colour(material: ElementTree.Element) -> Colour | None:
    colour = material.find("color")
    if colour is None:
        return None
    red, green, blue, *_ = _numbers(colour.get("rgba", "0.7 0.7 0.7 1"))
    return red, green, blue


def find_mesh(filename: str, urdf_directory: str, package_dirs: Sequence[str]) -> str:
    """The path of a URDF's mesh file, found where the library finds it; raises FileError with all places tried."""
    tried = list(dict.fromkeys(str(place) for place in _candidates(filename, urdf_directory, package_dirs)))
    for place in tried:
        if Path(place).is_file():
            return place
    raise srmp.FileError(f"mesh '{filename}' was not found; tried {', '.join(tried) or 'nothing'}")


def _candidates(filename: str, urdf_directory: str, package_dirs: Sequence[str]) -> Iterator[Path]:
    if filename.startswith("package://"):
        package, _, inner = filename.removeprefix("package://").partition("/")
        for directory in _package_directories(urdf_directory, package_dirs):
            yield directory / package / inner
            if directory.name == package:
                yield directory / inner
    elif filename.startswith("file://"):
        yield Path(filename.removeprefix("file://"))
    elif Path(filename).is_absolute():
        yield Path(filename)
    else:
        for name in (urdf_directory, *package_dirs):
            if name:
                yield Path(name) / filename


def _package_directories(urdf_directory: str, package_dirs: Sequence[str]) -> Iterator[Path]:
    if urdf_directory:
        own = Path(os.path.abspath(urdf_directory))  # noqa: PTH100  (resolve would follow links, as the library does not)
        yield from (own, *own.parents)
    yield from (Path(os.path.abspath(name)) for name in package_dirs)  # noqa: PTH100
    for variable, below in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")):
        yield from (Path(entry) / below for entry in os.environ.get(variable, "").split(":") if entry)
