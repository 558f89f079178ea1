"""A drawing as one HTML file, which plays in any browser without a server: player.html with the data in it."""

from __future__ import annotations

import base64
import html
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srmp.viewer._drawing import CAMERA, Drawing, appearance, bounds
from srmp.viewer._plots import Plot
from srmp.viewer._scene import CONTACT, ROBOT_KINDS, Body
from srmp.viewer._shapes import Mesh, spheres

_GRID = 65535  # corners are 16 bit numbers: to 1/65535 of a mesh's size
_PATH_COLOUR = [0.04, 0.48, 0.46, 1.0]
FIELD_OF_VIEW = 2 * float(np.arctan(1 / 2.4))  # [rad], as in player.html


def page(drawing: Drawing, title: str) -> str:
    """The text of the page. Where robots can be seen in several ways, the first is switched on at first."""
    data = json.dumps(_data(drawing, title), separators=(",", ":"))
    text = (Path(__file__).parent / "player.html").read_text(encoding="utf-8")
    packed = base64.b64encode(zlib.compress(data.encode(), 9)).decode()
    return text.replace("@TITLE@", html.escape(title)).replace("@DATA@", packed)


def _data(drawing: Drawing, title: str) -> dict[str, Any]:
    scene, motion, failure = drawing.scene, drawing.motion, drawing.failure
    meshes: dict[int, tuple[int, Mesh]] = {}  # by identity: bodies share them
    touches = failure.touches if failure else []
    bodies = [_body(drawing, body, meshes) for body in scene.bodies]
    if touches:
        marks = spheres([[*touch.point, 0.012] for touch in touches])
        bodies.append(_placed(_number(meshes, marks), -1, np.eye(4), [*CONTACT, 1.0], "contacts"))
    kinds = list(dict.fromkeys(body.kind for body in scene.bodies if body.kind in ROBOT_KINDS))
    notes = [(note, False) for note in drawing.notes]
    if failure:
        notes = [(f"{failure.status}: {failure.reason}", True)]
    return {
        "title": title,
        "notes": notes,
        "meshes": [_mesh(mesh) for _, mesh in meshes.values()],
        "bodies": bodies,
        "lines": [
            {"points": _rounded(path).ravel().tolist(), "colour": _PATH_COLOUR} for path in drawing.paths.values()
        ],
        "segments": [
            {"points": _packed(one.points.astype("<f4")), "colour": [*_rounded(one.colour, 3).tolist(), 1.0]}
            for one in drawing.segments
        ],
        "labels": [
            {"text": touch.text, "point": touch.point.tolist()} for touch in (failure.touches if failure else ())
        ],
        "frames": len(scene.frames),
        "times": _rounded(motion.times if motion else np.zeros(1)).tolist(),
        "poses": _packed(drawing.poses.astype("<f4")),
        "plots": [_plot(plot) for plot in drawing.plots],
        "panels": [{"title": title, "html": text} for title, text in drawing.panels],
        "switches": [(kind, kind in kinds[:1]) for kind in kinds] if len(kinds) > 1 else [],
        "view": view(drawing),
    }


def view(drawing: Drawing) -> dict[str, Any]:
    """Where the camera stands at first, and the grid on the floor."""
    lower, upper = bounds(drawing)
    size = float(np.linalg.norm(upper - lower))
    middle = ((lower + upper) / 2).tolist()
    return {
        "camera": {**CAMERA, "distance": 1.15 * size, "target": middle},
        "centre": middle[:2],
        "reach": 0.8 * size,
        "floor": float(min(lower[2], 0.0)) - 2e-3,
    }


def _body(drawing: Drawing, body: Body, meshes: dict[int, tuple[int, Mesh]]) -> dict[str, Any]:
    frame = drawing.scene.frames.index(body.frame) if body.frame else -1
    colour, opacity = appearance(drawing, body)
    return _placed(_number(meshes, body.mesh), frame, body.pose, [*colour, opacity], body.kind)


def _placed(mesh: int, frame: int, pose: NDArray[np.float64], colour: list[float], kind: str) -> dict[str, Any]:
    return {
        "mesh": mesh,
        "frame": frame,
        "pose": _rounded(pose.T).ravel().tolist(),  # column by column
        "colour": [round(part, 3) for part in colour],
        "kind": kind,
    }


def _number(meshes: dict[int, tuple[int, Mesh]], mesh: Mesh) -> int:
    return meshes.setdefault(id(mesh), (len(meshes), mesh))[0]


def _mesh(mesh: Mesh) -> dict[str, Any]:
    lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = np.maximum(upper - lower, 1e-9)
    return {
        "corners": _packed(np.round((mesh.vertices - lower) / size * _GRID).astype("<u2")),
        "indices": _packed(mesh.triangles.astype("<u4")),
        "origin": lower.astype(float).tolist(),
        "size": size.astype(float).tolist(),
    }


def _line(path: NDArray[np.float64]) -> dict[str, Any]:
    return {"points": _rounded(path).ravel().tolist(), "colour": _PATH_COLOUR}


def _plot(plot: Plot) -> dict[str, Any]:
    return {
        "title": plot.title,
        "times": _rounded(plot.times, 4).tolist(),
        "limit": plot.limit,
        "series": [
            {
                "name": series.name,
                "colour": series.colour,
                "values": [round(float(value), 4) if np.isfinite(value) else None for value in series.values],
            }
            for series in plot.series
        ],
    }


def _rounded(numbers: NDArray[np.float64], digits: int = 6) -> NDArray[np.float64]:
    return np.round(np.asarray(numbers, dtype=float), digits)


def _packed(numbers: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers).tobytes()).decode()
