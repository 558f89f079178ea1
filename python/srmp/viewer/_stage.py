"""A scene in a viser server: nodes for frames and bodies, changed only where the scene has changed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp.viewer._failure import Touch
from srmp.viewer._scene import CONTACT, Body, Scene
from srmp.viewer._shapes import Colour, sphere

_MAX_TEXTS = 4  # of points in the scene; the panel has all


class Stage:
    """The nodes below `root`, of all bodies that `chosen` accepts; translucent below 1 `opacity`.

    One thread at a time may show and paint; others may place the frames at the same time.
    """

    def __init__(
        self, server: Any, root: str, opacity: float = 1.0, chosen: Callable[[Body], bool] = lambda body: True
    ) -> None:
        self.scene = Scene([], [], np.zeros((0, 7)))
        self.sent = 0  # bodies that were sent in all, for tests
        self._server, self._root, self._opacity, self._chosen = server, root, opacity, chosen
        self._lock = threading.RLock()
        self._bodies: dict[str, tuple[Body, Any]] = {}
        self._frames: dict[str, Any] = {}
        self._placed: dict[str, NDArray[np.float64]] = {}
        self._hidden: set[str] = set()
        self._faulty: set[str] = set()

    def show(self, scene: Scene) -> None:
        """Removes what is gone, adds what is new, and moves what is elsewhere."""
        with self._lock, self._server.atomic():
            self.scene = scene
            shown = {body.name: body for body in scene.bodies if self._chosen(body)}
            for name in [name for name, (body, _) in self._bodies.items() if not _same(body, shown.get(name))]:
                self._bodies.pop(name)[1].remove()
            self._show_frames({body.frame for body in shown.values() if body.frame})
            for name, body in shown.items():
                if name not in self._bodies:
                    self._bodies[name] = (body, self._added(body))
                elif not np.array_equal(self._bodies[name][0].pose, body.pose):
                    handle = self._bodies[name][1]
                    handle.position, handle.wxyz = _position_and_wxyz(body.pose)
                    self._bodies[name] = (body, handle)
            self.place(scene.poses)

    def place(self, poses: NDArray[np.float64]) -> None:
        """Moves the frames to `poses` (frames, 7), in the order of Scene.frames."""
        with self._lock, self._server.atomic():
            for frame, pose in zip(self.scene.frames, poses, strict=True):
                if frame in self._frames and not np.array_equal(pose, self._placed.get(frame)):
                    self._frames[frame].position = pose[:3]
                    self._frames[frame].wxyz = pose[[6, 3, 4, 5]]
                    self._placed[frame] = pose

    def paint(self, faulty: Iterable[str]) -> None:
        """Bodies with these labels red, all others in their own colours."""
        with self._lock, self._server.atomic():
            before, self._faulty = self._faulty, set(faulty)
            for body, handle in self._bodies.values():
                if body.label in before | self._faulty:
                    handle.color = _rgb(self._colour(body))

    def switch(self, kind: str, visible: bool) -> None:
        """Shows or hides all bodies of a kind."""
        with self._lock:
            (self._hidden.discard if visible else self._hidden.add)(kind)
            for body, handle in self._bodies.values():
                if body.kind == kind:
                    handle.visible = visible

    def clear(self) -> None:
        """Removes all nodes."""
        self.show(Scene([], [], np.zeros((0, 7))))

    def _show_frames(self, frames: set[str]) -> None:
        for frame in set(self._frames) - frames:
            self._frames.pop(frame).remove()
            self._placed.pop(frame, None)
        for frame in sorted(frames - set(self._frames)):
            self._frames[frame] = self._server.scene.add_frame(self._node("frames", frame), show_axes=False)

    def _added(self, body: Body) -> Any:
        self.sent += 1
        position, wxyz = _position_and_wxyz(body.pose)
        parent = self._node("frames", body.frame) if body.frame else f"{self._root}/world"
        return self._server.scene.add_mesh_simple(
            f"{parent}/{_safe(body.name)}",
            vertices=body.mesh.vertices,
            faces=body.mesh.triangles.astype(np.uint32),
            color=_rgb(self._colour(body)),
            opacity=self._opacity if self._opacity < 1 else None,
            flat_shading=True,
            side="double",
            position=position,
            wxyz=wxyz,
            visible=body.kind not in self._hidden,
        )

    def _colour(self, body: Body) -> Colour:
        return CONTACT if body.label in self._faulty else body.colour

    def _node(self, group: str, name: str) -> str:
        return f"{self._root}/{group}/{_safe(name)}"


class Marks:
    """Red points with texts, where bodies touch and where joints leave their limits."""

    def __init__(self, server: Any) -> None:
        self.texts: list[str] = []
        self._server = server
        self._handles: list[Any] = []

    def show(self, touches: Sequence[Touch]) -> None:
        """These in place of those before."""
        with self._server.atomic():
            for handle in self._handles:
                handle.remove()
            self._handles = []
            for k, touch in enumerate(touches):
                marker = sphere(0.012, 16)
                self._handles.append(
                    self._server.scene.add_mesh_simple(
                        f"/marks/point{k}", marker.vertices, marker.triangles, color=_rgb(CONTACT), position=touch.point
                    )
                )
                if k < _MAX_TEXTS:
                    place = touch.point + 0.04 * k * np.array([0, 0, 1])  # beside each other where the points are near
                    self._handles.append(self._server.scene.add_label(f"/marks/text{k}", touch.text, position=place))
            self.texts = [touch.text for touch in touches]


def _same(before: Body, now: Body | None) -> bool:
    return (
        now is not None
        and before.mesh is now.mesh
        and (before.frame, before.kind, before.colour)
        == (
            now.frame,
            now.kind,
            now.colour,
        )
    )


def _safe(name: str) -> str:
    """A slash would begin a node of its own."""
    return name.replace("/", "|")


def _rgb(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in colour)
    return red, green, blue


def _position_and_wxyz(pose: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    placed = srmp.Pose.from_matrix(pose)
    return np.asarray(placed.p), np.asarray(placed.q)[[3, 0, 1, 2]]
