"""PyBullet (>= 3.2). `sim` is a client's number, a BulletClient, or the module `pybullet` itself for client 0."""

from __future__ import annotations

import contextlib
import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, NotSupported, Pose
from srmp.sim import shapes
from srmp.sim.pybullet_meshes import find_file, grid_surface, read_obj, read_stl
from srmp.sim.pybullet_shapes import (
    ENDLESS,
    HULL_MARGIN,
    MESH,
    bounding_reach,
    hull,
    inner_point,
    is_surface,
    primitive,
)
from srmp.sim.shapes import Shape
from srmp.sim.simulator import (
    Articulation,
    Body,
    Geometry,
    Joint,
    Positions,
    Probe,
    Simulator,
    Touch,
    import_simulator,
)

OVERLAP = 1e-3  # [m] as deep as two shapes have to be in each other before a missing contact means a filter
MIN_STATES, MAX_STATES = 200, 2000  # random ones in which filters among a body's own links are looked for
UNLIMITED = 1e5  # [N or Nm] the force of motors whose joints have no limit
FAR = 1e3  # [m] above everything: where a body is measured alone
RAYS = 16000  # in one query
SAMPLES = 200  # triangles by which meshes are compared
BOX_TOLERANCE = 5e-3  # [m] by which Bullet makes bounding boxes larger

REVOLUTE, PRISMATIC, FIXED = 0, 1, 4  # JOINT_… of pybullet
MULTI_BODY = 2  # body type of getDynamicsInfo
UNREADABLE = {(1,): "a body with useMaximalCoordinates", (3,): "a soft body"}  # by body type
NO_FILE = b"unknown_file"

Link = tuple[int, int]  # unique id of the body, and number of the link, -1 for the base


class _Client:
    """pybullet's functions for one client."""

    def __init__(self, module: ModuleType, number: int) -> None:
        self.module, self.number = module, number

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.module, name)
        return functools.partial(self._call, value) if callable(value) else value

    def _call(self, function: Any, *args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, physicsClientId=self.number, **kwargs)
        except self.module.error:
            self.require_connection()
            raise

    def require_connection(self) -> None:
        """Raises InvalidArgument where there is none."""
        if not self.module.isConnected(physicsClientId=self.number):
            raise InvalidArgument(f"PyBullet's client {self.number} is not connected; give what connect() returned")


@dataclass(frozen=True)
class _Shapes:
    """The shapes of a link as read, and by what it is seen that they are still those."""

    data: tuple[Any, ...]  # what getCollisionShapeData says; empty for height fields, of which it knows nothing
    corners: dict[int, Any]  # of hulls that no file is known of, by their place in data
    geometries: tuple[Geometry, ...]
    reach: NDArray[np.float64]  # (3,) half the size of their bounding box in the inertial frame; inf = has none


class PyBullet(Simulator):
    """An articulation is a body with a joint that moves; all other bodies are objects, their links with them.

    Bodies are called as their URDF says, or by addUserData(body, "name", "…"), or "body<id>"; where a name is taken,
    "name_<id>". Links of articulations are "body/link".
    """

    kind = "pybullet"
    margin = 1.5e-3  # Bullet rounds the edges of boxes and cylinders by 1 mm, and meshes of triangles by as much

    def __init__(self, sim: Any) -> None:
        self.p = _Client(import_simulator("pybullet", "pybullet"), _client_number(sim))
        self.p.require_connection()
        self._names: dict[int, tuple[str, str]] = {}  # what the body says of itself, and what it is called
        self._shapes: dict[Link, _Shapes] = {}
        self._filters: dict[tuple[Link, Link], bool] = {}
        self._filtered: dict[int, tuple[set[frozenset[int]], bool]] = {}

    def is_of(self, sim: Any) -> bool:
        return _client_number(sim) == self.p.number

    # --- the scene

    def _bodies(self) -> dict[str, int]:
        """Names of all bodies."""
        ids = [self.p.getBodyUniqueId(k) for k in range(self.p.getNumBodies())]
        said = {body: self._said_name(body) for body in ids}
        self._names = {body: name for body, name in self._names.items() if said.get(body) == name[0]}
        taken = {name for _, name in self._names.values()}
        for body in ids:
            if body not in self._names:
                name = said[body] or f"body{body}"
                name = f"{name}_{body}" if name in taken else name
                self._names[body] = (said[body], name)
                taken.add(name)
        return {self._names[body][1]: body for body in ids}

    def _said_name(self, body: int) -> str:
        entry = self.p.getUserDataId(body, "name")
        return (self.p.getUserData(entry) if entry >= 0 else self.p.getBodyInfo(body)[1]).decode()

    def name_of(self, handle: Any) -> str:
        if isinstance(handle, str):
            return handle
        for name, body in self._bodies().items():
            if not isinstance(handle, bool) and handle == body:
                return name
        raise InvalidArgument(f"PyBullet's client {self.p.number} has no body {handle!r}")

    def _joint_infos(self, body: int) -> list[tuple[Any, ...]]:
        return [self.p.getJointInfo(body, joint) for joint in range(self.p.getNumJoints(body))]

    def _moves(self, body: int) -> bool:
        return any(info[2] != FIXED for info in self._joint_infos(body))

    def _articulated(self) -> dict[str, int]:
        return {name: body for name, body in self._bodies().items() if self._moves(body)}

    def articulations(self) -> list[Articulation]:
        return [self._articulation(name, body) for name, body in self._articulated().items()]

    def _articulation(self, name: str, body: int) -> Articulation:
        infos, links = self._joint_infos(body), self._link_names(name, body)
        names, poses = _unique([info[1].decode() for info in infos], "joint"), self._poses(body)
        order = _parents_first([info[16] for info in infos])
        return Articulation(
            name,
            tuple(Body(links[link], poses[link], self._geometries(body, link, poses[link])) for link in (-1, *order)),
            tuple(self._joint(body, infos[link], names[link], links) for link in order),
        )

    def _link_names(self, name: str, body: int) -> dict[int, str]:
        names = [self.p.getBodyInfo(body)[0].decode(), *(info[12].decode() for info in self._joint_infos(body))]
        return {link: f"{name}/{each}" for link, each in enumerate(_unique(names, "link"), -1)}

    def _joint(self, body: int, info: tuple[Any, ...], name: str, links: dict[int, str]) -> Joint:
        """PyBullet's joint frames are between the links' inertial frames."""
        parent, child = self._inertial(body, info[16]), self._inertial(body, info[0])
        turned = Pose(q=info[15]).inverse() @ Pose(q=child.q).inverse()
        origin = parent @ Pose(p=info[14]) @ turned
        kind = {REVOLUTE: "revolute", PRISMATIC: "prismatic", FIXED: "fixed"}.get(info[2], "unreadable")
        lower, upper, velocity = float(info[8]), float(info[9]), float(info[11])
        if lower > upper:
            kind, lower, upper = "continuous" if kind == "revolute" else kind, -np.inf, np.inf
        axis = np.array([1.0, 0, 0]) if kind in ("fixed", "unreadable") else Pose(q=child.q) @ np.array(info[13])
        velocity_limit = velocity if velocity > 0 else None
        return Joint(name, kind, links[info[16]], links[info[0]], origin, axis, lower, upper, velocity_limit)

    def _inertial(self, body: int, link: int) -> Pose:
        """The link's inertial frame, in the link's."""
        dynamics = self.p.getDynamicsInfo(body, link)
        return Pose(p=dynamics[3], q=dynamics[4]) if dynamics[10] == MULTI_BODY else Pose()

    def _poses(self, body: int) -> dict[int, Pose]:
        position, rotation = self.p.getBasePositionAndOrientation(body)
        poses = {-1: Pose(p=position, q=rotation) @ self._inertial(body, -1).inverse()}
        if count := self.p.getNumJoints(body):
            states = self.p.getLinkStates(body, list(range(count)), computeForwardKinematics=1)
            poses |= {link: Pose(p=state[4], q=state[5]) for link, state in enumerate(states)}
        return poses

    def bodies(self) -> list[Body]:
        found = [self._rigid_body(name, body) for name, body in self._bodies().items() if not self._moves(body)]
        return [body for body in found if body.geometries]

    def _rigid_body(self, name: str, body: int) -> Body:
        """All its links in one."""
        poses = self._poses(body)
        inside = {link: poses[-1].inverse() @ pose for link, pose in poses.items()}
        geometries = [
            Geometry(each.name, each.shape, inside[link] @ each.pose, each.key)
            for link in poses
            for each in self._geometries(body, link, poses[link])
        ]
        return Body(name, poses[-1], tuple(geometries))

    def joint_positions(self, articulation: str) -> dict[str, float]:
        body, joints = self._joints_of(articulation)
        states = self.p.getJointStates(body, list(joints.values())) if joints else []
        return {name: float(state[0]) for name, state in zip(joints, states, strict=True)}

    def _joints_of(self, articulation: str) -> tuple[int, dict[str, int]]:
        body = self._bodies()[articulation]
        infos = self._joint_infos(body)
        names = _unique([info[1].decode() for info in infos], "joint")
        return body, {names[info[0]]: info[0] for info in infos if info[2] in (REVOLUTE, PRISMATIC)}

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        body = self._bodies()[articulation]
        names = self._link_names(articulation, body)
        return {names[link]: pose for link, pose in self._poses(body).items()}

    # --- shapes

    def _geometries(self, body: int, link: int, pose: Pose) -> tuple[Geometry, ...]:
        """Kept from the last time if they are the same: PyBullet gives a removed body's number to the next one."""
        known = self._shapes.get((body, link))
        if known is None or not self._still(body, link, pose, known):
            known = self._shapes[body, link] = self._read_shapes(body, link, pose)
            self._filters = {pair: may for pair, may in self._filters.items() if body not in (pair[0][0], pair[1][0])}
            self._filtered.pop(body, None)
        return known.geometries

    def _still(self, body: int, link: int, pose: Pose, known: _Shapes) -> bool:
        if not self._fills_its_box(body, link, pose, known.reach):
            return False
        if known.geometries and not known.data:  # a height field; to read its data again would print a warning
            shape = known.geometries[0].shape
            return isinstance(shape, shapes.Mesh) and self._has_triangles(body, pose @ known.geometries[0].pose, shape)
        return self._data(body, link) == known.data and all(
            self._corners(body, link, k) == corners for k, corners in known.corners.items()
        )

    def _data(self, body: int, link: int) -> tuple[Any, ...]:
        """(type, dimensions, file, position, orientation) of each shape, in the inertial frame."""
        kind = self.p.getDynamicsInfo(body, link)[10]
        if kind != MULTI_BODY:
            return (kind,)
        return tuple(tuple(entry[2:7]) for entry in self.p.getCollisionShapeData(body, link))

    def _read_shapes(self, body: int, link: int, pose: Pose) -> _Shapes:
        data = self._data(body, link)
        corners: dict[int, Any] = {}
        inertial = self._inertial(body, link)
        key = (body, link)
        if data in UNREADABLE:
            return _Shapes(data, {}, (Geometry("", shapes.Unreadable(UNREADABLE[data]), Pose(), key),), ENDLESS)
        found: list[tuple[Shape, Pose]] = []  # in the inertial frame
        for k, (kind, dimensions, file, position, rotation) in enumerate(data):
            if kind != MESH:
                found.append(primitive(kind, dimensions, Pose(p=position, q=rotation)))
            elif file == NO_FILE and (points := self._corners(body, link, k)):
                corners[k] = points
                found.append((hull(np.array(points)), Pose()))
            else:
                found += self._mesh(body, link, k, data)
        if not data and np.any(self._half_box(body, link) > BOX_TOLERANCE):
            found.append((self._height_field(body, link), Pose()))
        reach = bounding_reach(found)
        if not self._fills_its_box(body, link, pose, reach):
            found, reach = [(shapes.Unreadable("a shape that PyBullet does not describe as it is"), Pose())], ENDLESS
        names = [""] if len(found) == 1 else [str(k) for k in range(len(found))]
        geometries = [Geometry(name, shape, inertial @ at, key) for name, (shape, at) in zip(names, found, strict=True)]
        return _Shapes(data, corners, tuple(geometries), reach)

    def _half_box(self, body: int, link: int) -> NDArray[np.float64]:
        lower, upper = np.array(self.p.getAABB(body, link))
        return (upper - lower) / 2

    def _fills_its_box(self, body: int, link: int, pose: Pose, reach: NDArray[np.float64]) -> bool:
        """Is the link's bounding box about that of shapes that reach so far?

        Bullet's box is larger where it turns boxes in boxes, and smaller for spheres, which it does not turn.
        """
        if np.any(np.isinf(reach)):
            return True
        box = self._half_box(body, link)
        turned = np.abs((pose @ self._inertial(body, link)).matrix()[:3, :3]) @ reach
        tolerance = BOX_TOLERANCE + max(self.p.getDynamicsInfo(body, link)[11], 0.0)
        return bool(np.all(box > turned / 3**0.5 - tolerance) and np.all(box < 1.2 * turned + 3 * tolerance))

    def _corners(self, body: int, link: int, k: int = -1) -> Any:
        """Of the hulls of the link's k-th shape, or of all, in the inertial frame; () for other shapes."""
        which = {} if k < 0 else {"collisionShapeIndex": k}
        return self.p.getMeshData(body, link, **which)[1] or ()

    def _mesh(self, body: int, link: int, k: int, data: tuple[Any, ...]) -> list[tuple[Shape, Pose]]:
        """Bullet takes the hull of each object of an OBJ file, of other files one hull, unless told `concave`."""
        _, scale, name, position, rotation = data[k]
        seen = name == NO_FILE  # made by createCollisionShape of triangles: at best the file is that of what is seen
        if seen:
            name, scale = self._seen_mesh(body, link)
        pose, path = Pose(p=position, q=rotation), find_file(name.decode())
        if path is None or path.suffix.lower() not in (".obj", ".stl"):
            points = () if seen else self._corners(body, link, k)
            if points:
                return [(hull(np.array(points)), Pose())]
            what = f"the file '{name.decode()}' of a mesh" if name else "a mesh of triangles without a file"
            return [(shapes.Unreadable(what), Pose())]
        vertices, objects = (read_obj if path.suffix.lower() == ".obj" else read_stl)(path)
        vertices = vertices * np.array(scale)
        triangles = np.concatenate(objects)
        mesh = shapes.Mesh(vertices, triangles)
        if seen:
            with self._alone(body, link) as frame:
                same = self._has_triangles(body, frame @ pose, mesh)
            return [(mesh if same else shapes.Unreadable("a mesh of triangles without a file"), pose)]
        corners = np.array(self._corners(body, link)).reshape(-1, 3)
        outermost = pose @ vertices[triangles.ravel()[np.argmax(vertices[triangles.ravel()] @ [1.0, 0.1, 0.01])]]
        if len(corners) and np.linalg.norm(corners - outermost, axis=1).min() < HULL_MARGIN:
            return [(hull(vertices[np.unique(each)]), pose) for each in objects]
        return [(mesh, pose)]

    def _seen_mesh(self, body: int, link: int) -> tuple[bytes, Any]:
        """File and scale of the mesh that the link is drawn as, if it is one."""
        seen = [entry for entry in self.p.getVisualShapeData(body) if entry[1] == link and entry[2] == MESH]
        return (seen[0][4], seen[0][3]) if len(seen) == 1 else (b"", (1.0, 1.0, 1.0))

    def _has_triangles(self, body: int, pose: Pose, mesh: shapes.Mesh) -> bool:
        """Do short rays through the triangles all hit? `pose` of the mesh, in the world."""
        assert mesh.triangles is not None
        few = np.random.default_rng(0).integers(len(mesh.triangles), size=SAMPLES)
        a, b, c = (mesh.vertices[mesh.triangles[few, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        sizes = np.linalg.norm(normals, axis=1, keepdims=True)
        steps = 1e-4 * normals / np.maximum(sizes, 1e-12)
        ends = [[pose @ p for p in ((a + b + c) / 3 + side * steps)[sizes[:, 0] > 1e-12]] for side in (1, -1)]
        hit = {hit[0] for hit in self.p.rayTestBatch(*ends)}
        return body in hit and -1 not in hit

    @contextlib.contextmanager
    def _alone(self, body: int, link: int = -1) -> Iterator[Pose]:
        """The body is far above all others, its base not turned. Gives the link's inertial frame."""
        with self.probe():
            self.p.resetBasePositionAndOrientation(body, [0, 0, FAR], [0, 0, 0, 1])
            yield self._poses(body)[link] @ self._inertial(body, link)

    def _hits(self, body: int, starts: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) how far along the rays the body is, 0 to 1; NaN for those that miss."""
        found: list[float] = []
        for first in range(0, len(starts), RAYS):
            several = slice(first, first + RAYS)
            hits = self.p.rayTestBatch(starts[several].tolist(), ends[several].tolist())
            found += [hit[2] if hit[0] == body else np.nan for hit in hits]
        return np.array(found)

    def _height_field(self, body: int, link: int) -> Shape:
        """PyBullet tells nothing of a height field, but its rays do: its surface, in the inertial frame."""
        with self._alone(body, link) as frame:
            lower, upper = np.array(self.p.getAABB(body, link))

            def heights(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
                """At fractions of the sides."""
                inside = np.clip(np.stack([x, y], axis=-1), 1e-9, 1 - 1e-9)
                starts = np.append(inside * (upper - lower)[:2] + lower[:2], np.full((len(x), 1), upper[2] + 1), axis=1)
                down = np.array([0.0, 0.0, upper[2] - lower[2] + 2])
                return starts[:, 2] - self._hits(body, starts, starts - down) * down[2]

            found = grid_surface(heights, float(upper[2] - lower[2]))
            if found is None:
                return shapes.Unreadable("a shape that PyBullet does not describe")
            surface, triangles = found
            corners = np.append(lower[:2] + surface[:, :2] * (upper - lower)[:2], surface[:, 2:], axis=1)
            return shapes.Mesh(corners - frame.p, triangles)

    # --- contacts

    def may_collide(self, a: Any, b: Any) -> bool:
        """PyBullet has no query for its filters, so the two are moved into each other to see if they touch."""
        if a[0] == b[0]:
            through, ghost = self._filtered_links(a[0])
            return not ghost and frozenset((a[1], b[1])) not in through
        pair = (min(a, b), max(a, b))
        if pair not in self._filters:
            self._filters[pair] = self._touch_when_moved(*pair)
        return self._filters[pair]

    def self_collision(self, articulation: str) -> bool:
        return not self._filtered_links(self._bodies()[articulation])[1]

    def _filtered_links(self, body: int) -> tuple[set[frozenset[int]], bool]:
        """Pairs of its links that were seen in each other without a contact, in random states, and if all are so.

        Neighbours tell nothing of the others: Bullet lets them through each other anyway. Limits of joints that turn
        are not kept, to see more pairs.
        """
        if body not in self._filtered:
            infos = self._joint_infos(body)
            scalar = [info for info in infos if info[2] in (REVOLUTE, PRISMATIC)]
            joints = {info[0]: info[8:10] if info[2] == PRISMATIC else (-np.pi, np.pi) for info in scalar}
            neighbours = {frozenset((info[0], info[16])) for info in infos}
            through: set[frozenset[int]] = set()
            touched: set[frozenset[int]] = set()
            random = np.random.default_rng(0)
            with self.probe():
                for state in range(MAX_STATES):
                    if state >= MIN_STATES and (through | touched) - neighbours:
                        break
                    for joint, limits in joints.items():
                        self.p.resetJointState(body, joint, random.uniform(*limits))
                    self.p.performCollisionDetection()
                    deep = {
                        frozenset(hit[3:5]) for hit in self.p.getClosestPoints(body, body, 0.0) if hit[8] < -OVERLAP
                    }
                    counted = {frozenset(hit[3:5]) for hit in self.p.getContactPoints(body, body)}
                    touched |= deep & counted
                    through |= {pair for pair in deep - counted if len(pair) == 2}
            through -= touched
            self._filtered[body] = through, bool(through - neighbours) and not touched
        return self._filtered[body]

    def _touch_when_moved(self, a: Link, b: Link) -> bool:
        """Surfaces never touch each other in Bullet. True where nothing could be seen."""
        points = [self._within(each) for each in (a, b)]
        if all(is_surface for shapes_of in points for _, is_surface in shapes_of):
            return False
        with self.probe():
            position, rotation = (np.array(each) for each in self.p.getBasePositionAndOrientation(b[0]))
            for (here, _), (there, _) in itertools.product(*points):
                self.p.resetBasePositionAndOrientation(b[0], position + here - there, rotation)
                if self._depth(a, b) >= OVERLAP:
                    self.p.performCollisionDetection()
                    return bool(self.p.getContactPoints(a[0], b[0], a[1], b[1]))
        return True

    def _within(self, link: Link) -> list[tuple[NDArray[np.float64], bool]]:
        """For each shape of the link a point in it, in the world, and if it is a surface."""
        pose = self._poses(link[0])[link[1]]
        return [
            (pose @ each.pose @ inner_point(each.shape), is_surface(each.shape))
            for each in self._geometries(*link, pose)
        ]

    @contextlib.contextmanager
    def probe(self) -> Iterator[Probe]:
        state = self.p.saveState()
        try:
            yield _Probe(self)
        finally:
            self.p.restoreState(state)
            self.p.performCollisionDetection()  # forgets the contacts that were not there before
            self.p.restoreState(state)
            self.p.removeState(state)

    def touching(self) -> list[Touch]:
        """Contact points say which pairs count; their depths are queried anew.

        The points are kept from step to step, so they may be of a state before, or hide a deeper one of a mesh.
        """
        pairs = dict.fromkeys(((hit[1], hit[3]), (hit[2], hit[4])) for hit in self.p.getContactPoints() or ())
        depths = {(a, b): self._depth(a, b) for a, b in pairs}
        return [Touch(a, b, depth) for (a, b), depth in depths.items() if depth > 0]

    def _depth(self, a: Link, b: Link) -> float:
        """[m] whether filtered or not."""
        return max((-float(hit[8]) for hit in self.p.getClosestPoints(a[0], b[0], 0.0, a[1], b[1])), default=0.0)

    # --- motion

    @property
    def time_step(self) -> float:
        return float(self.p.getPhysicsEngineParameters()["fixedTimeStep"])

    def hold(self, articulation: str) -> None:
        """Nothing to do: all joints have motors that hold what they were told, or their place."""
        if self.p.getPhysicsEngineParameters()["useRealTimeSimulation"]:
            raise NotSupported("PyBullet steps by itself; setRealTimeSimulation(0) lets trajectories be executed")

    def command(self, articulation: str, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        """Position control that takes away the whole error in a step, as far as the joints' forces allow."""
        body, joints = self._joints_of(articulation)
        indices = [joints[name] for name in positions]
        forces = [self.p.getJointInfo(body, index)[10] for index in indices]
        self.p.setJointMotorControlArray(
            body,
            indices,
            self.p.POSITION_CONTROL,
            targetPositions=list(positions.values()),
            targetVelocities=[0.0] * len(indices),
            positionGains=[1.0] * len(indices),
            velocityGains=[1.0] * len(indices),
            forces=[force if force > 0 else UNLIMITED for force in forces],
        )

    def step(self) -> None:
        self.p.stepSimulation()


class _Probe(Probe):
    """The world itself, which is put back afterwards."""

    def __init__(self, simulator: PyBullet) -> None:
        self.simulator = simulator

    def put(self, articulation: str, positions: Positions) -> None:
        body, joints = self.simulator._joints_of(articulation)
        for name, value in positions.items():
            self.simulator.p.resetJointState(body, joints[name], value)

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        return self.simulator.link_poses(articulation)

    def touching(self) -> list[Touch]:
        self.simulator.p.performCollisionDetection()
        return self.simulator.touching()


def _client_number(sim: Any) -> int:
    number = getattr(sim, "_client", sim)
    if isinstance(sim, ModuleType) and sim.__name__ == "pybullet":
        number = 0
    if isinstance(number, bool) or not isinstance(number, int):
        raise InvalidArgument(
            f"a PyBullet scene is a client's number, a BulletClient or the module pybullet, not {type(sim).__name__}"
        )
    return number


def _unique(names: list[str], otherwise: str) -> list[str]:
    """Names that are empty, or were there before, become `otherwise` with their place."""
    return [name if name and name not in names[:k] else f"{otherwise}{k}" for k, name in enumerate(names)]


def _parents_first(parents: list[int]) -> list[int]:
    order = [-1]
    for link in order:
        order += [child for child, parent in enumerate(parents) if parent == link]
    return order[1:]
