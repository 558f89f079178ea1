"""What PyBullet does not tell of the meshes and height fields that it collides: read from their files, felt by rays."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Heights = Callable[[Floats, Floats], Floats]  # at fractions (n,), 0 to 1, of the sides along x and y

LARGEST_GRID = 512  # cells along a side of a height field
MAX_GRIDS = 2000  # that are tried
FLAT = 1e-6  # [m]: heights closer than that are the same


def find_file(file: str) -> Path | None:
    """Where it is; PyBullet does not tell its search path, but most scripts add that of pybullet_data."""
    directories = [Path()]
    with contextlib.suppress(ImportError):
        import pybullet_data

        directories.append(Path(pybullet_data.getDataPath()))
    return next((directory / file for directory in directories if (directory / file).is_file()), None)


def read_obj(path: Path) -> tuple[NDArray[np.float64], list[NDArray[np.int64]]]:
    """Vertices, and the triangles of each object or group with faces, as Bullet's reader takes them apart."""
    vertices: list[list[float]] = []
    objects: list[list[list[int]]] = [[]]
    for line in path.read_text(errors="replace").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) for x in rest[:3]])
        elif word in ("o", "g"):
            objects.append([])
        elif word == "f":
            numbers = [int(corner.split("/")[0]) for corner in rest]
            face = [number - 1 if number > 0 else len(vertices) + number for number in numbers]
            objects[-1] += [[face[0], face[k], face[k + 1]] for k in range(1, len(face) - 1)]
    return np.array(vertices), [np.array(each) for each in objects if each]


def read_stl(path: Path) -> tuple[NDArray[np.float64], list[NDArray[np.int64]]]:
    """A binary file, the only kind that Bullet reads."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(path.read_bytes()[84:], dtype=record)["corners"].astype(float).reshape(-1, 3)
    return corners, [np.arange(len(corners)).reshape(-1, 3)]


def grid_surface(heights: Heights, spread: float) -> tuple[Floats, NDArray[np.int64]] | None:
    """The grid of triangles whose height it is: corners (x and y as fractions, z) and triangles. None if there is none.

    spread: how much higher the highest corner is than the lowest. The grid is the coarsest that agrees everywhere.
    """
    few, many = (np.random.default_rng(seed).uniform(size=(2, count)) for seed, count in ((0, 300), (1, 20000)))
    at_few = heights(*few)
    if not np.all(np.isfinite(at_few)):
        return None
    columns = _cells(lambda x: np.append(heights(x, 0 * x), heights(x, 0 * x + 1)))
    rows = _cells(lambda y: np.append(heights(0 * y, y), heights(0 * y + 1, y)))
    sizes = itertools.product(range(columns, LARGEST_GRID + 1, columns), range(rows, LARGEST_GRID + 1, rows))
    for size in itertools.islice(sorted(sizes, key=lambda each: each[0] * each[1]), MAX_GRIDS):
        for rising in (True, False):
            if not np.allclose(_interpolated(heights, size, rising, few), at_few, atol=FLAT):
                continue
            x, y = (each.ravel() for each in np.meshgrid(*(np.linspace(0, 1, n + 1) for n in size)))
            z = heights(x, y)
            agrees = np.allclose(_interpolated(heights, size, rising, many), heights(*many), atol=FLAT)
            if agrees and abs(np.ptp(z) - spread) < FLAT:
                return np.stack([x, y, z], axis=1), _triangles(size, rising)
    return None


def _cells(profiles: Callable[[Floats], Floats]) -> int:
    """The fewest equal parts such that the two profiles are straight in each."""
    places = np.random.default_rng(2).uniform(size=64)
    true = profiles(places).reshape(2, -1)
    for count in range(1, LARGEST_GRID + 1):
        knots = np.linspace(0, 1, count + 1)
        guesses = [np.interp(places, knots, z) for z in profiles(knots).reshape(2, -1)]
        if np.allclose(guesses, true, atol=FLAT):
            return count
    return 1


def _interpolated(heights: Heights, size: tuple[int, int], rising: bool, places: Floats) -> Floats:
    """Heights (n,) at places (2, n), if it were a grid of so many cells, cut along the rising diagonal or the other."""
    scale = np.array(size)[:, None]
    cells = np.minimum(np.floor(places * scale), scale - 1)
    u, v = places * scale - cells
    a, b, c, d = (heights(*((cells + np.array(step)[:, None]) / scale)) for step in ((0, 0), (1, 0), (0, 1), (1, 1)))
    if rising:
        return np.where(u >= v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))
    return np.where(u + v <= 1, a + u * (b - a) + v * (c - a), d + (1 - u) * (c - d) + (1 - v) * (b - d))


def _triangles(size: tuple[int, int], rising: bool) -> NDArray[np.int64]:
    columns, rows = size
    number = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    cuts = [(a, b, d), (a, d, c)] if rising else [(a, b, c), (b, d, c)]
    return np.concatenate([np.stack([corner.ravel() for corner in cut], axis=1) for cut in cuts])
