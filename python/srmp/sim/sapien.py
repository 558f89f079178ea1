"""SAPIEN (sapien >= 3.0), with physics on the CPU. `sim` is a sapien.Scene."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Collection, Hashable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srmp import InvalidArgument, Pose
from srmp.sim import shapes
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

STIFFNESS, DAMPING = 3e5, 1100.0  # [1/s^2], [1/s]: of joints without a drive; 550 rad/s, as PhysX's joints rub
NO_LIMIT = 100.0  # [rad/s or m/s] what PhysX lets a joint do when nobody says a speed
CYLINDER_CORNERS = 32  # SAPIEN's cylinders are prisms, with their corners on the circle
TINY_STEP = 1e-6  # [s] of the probe: contacts are found, and hardly anything moves
# The probe's world is larger by this factor. PhysX's search for contacts is made for things of some metres: around an
# arm it misses six contacts in a thousand, up to centimetres deep; in the larger world, two in ten thousand.
GROWTH = 30.0
ALONG_X = Pose.from_rpy([0, 0, 0], [0, np.pi / 2, 0])  # turns z into x, along which PhysX has its shapes


@dataclasses.dataclass(frozen=True)
class _Known:
    """A collision shape of the scene."""

    component: Any  # of which body or link
    shape: shapes.Shape
    pose: Pose  # in the body


class Sapien(Simulator):
    """An articulation is called by its own name, else as its root link; its links are "articulation/link".

    What has no name, or one that was taken before, gets a number. Keys are the collision shapes themselves.
    """

    kind = "sapien"
    margin = 5e-4  # of 20 000 contacts of convex shapes 5 were decided otherwise, at most 0.25 mm deep

    def __init__(self, sim: Any) -> None:
        self.sapien = import_simulator("sapien", "sapien")
        self.px = self.sapien.physx
        self.scene = self._checked(sim)
        self.system = sim.physx_system
        self._known: dict[Any, _Known] = {}
        self._names: dict[Any, str] = {}  # of entities, and of articulations by their root
        self._found: dict[str, Any] = {}  # articulations
        self._controls: dict[str, _Control] = {}

    def _checked(self, sim: Any) -> Any:
        if not isinstance(sim, self.sapien.pysapien.Scene):
            raise InvalidArgument(f"a SAPIEN scene is a sapien.Scene, not {type(sim).__name__}")
        try:
            system = sim.physx_system
        except RuntimeError:
            system = None
        if not isinstance(system, self.px.PhysxCpuSystem):
            raise InvalidArgument(
                "a SAPIEN scene needs physics on the CPU: sapien.Scene([sapien.physx.PhysxCpuSystem(), …])"
            )
        return sim

    def is_of(self, sim: Any) -> bool:
        return self._checked(sim) is self.scene

    # --- the scene

    def _components(self) -> list[Any]:
        """Bodies of no articulation."""
        return [*self.system.rigid_static_components, *self.system.rigid_dynamic_components]

    def _read(self) -> dict[str, Any]:
        """Articulations by name; learns what is new of names and shapes, and forgets what is gone."""
        links = self.system.articulation_link_components
        roots = [link for link in links if link.is_root]
        components = self._components() + links
        present = {component.entity for component in components} | {root.articulation for root in roots}
        self._names = {owner: name for owner, name in self._names.items() if owner in present}
        for root in roots:
            self._name(root.articulation, root.articulation.name or root.name or root.entity.name or "articulation")
        for root in roots:
            prefix = self._names[root.articulation]
            for number, link in enumerate(root.articulation.links):
                self._name(link.entity, f"{prefix}/{link.name or link.entity.name or f'link{number}'}")
        for component in self._components():
            self._name(component.entity, component.entity.name or f"body{component.entity.per_scene_id}")
        self._known = {
            shape: self._known.get(shape) or _Known(component, *self._shape(shape))
            for component in components
            for shape in component.collision_shapes
        }
        self._found = {self._names[root.articulation]: root.articulation for root in roots}
        self._controls = {
            name: control for name, control in self._controls.items() if self._found.get(name) is control.articulation
        }
        return self._found

    def _name(self, owner: Any, preferred: str) -> None:
        if owner not in self._names:
            taken, name, number = set(self._names.values()), preferred, 2
            while name in taken:
                name, number = f"{preferred}_{number}", number + 1
            self._names[owner] = name

    def articulations(self) -> list[Articulation]:
        return [self._articulation(name, found) for name, found in self._read().items()]

    def _articulation(self, name: str, found: Any) -> Articulation:
        links, joints = [self._body(found.root)], []
        for joint, joint_name in _named_joints(found):
            chain = self._chain(joint, joint_name)
            links += [Body(link.child, Pose(), ()) for link in chain[:-1]] + [self._body(joint.child_link)]
            joints += chain
        return Articulation(name, tuple(links), tuple(joints))

    def name_of(self, handle: Any) -> str:
        if isinstance(handle, self.px.PhysxArticulation):
            for name, articulation in self._read().items():
                if articulation is handle:
                    return name
            raise InvalidArgument(f"articulation '{handle.name}' is not in this SAPIEN scene")
        return super().name_of(handle)

    def bodies(self) -> list[Body]:
        self._read()
        return [self._body(component) for component in self._components() if component.collision_shapes]

    def _body(self, component: Any) -> Body:
        geometries = [
            Geometry("", self._known[shape].shape, self._known[shape].pose, shape)
            for shape in component.collision_shapes
        ]
        return Body(self._names[component.entity], _pose(component.entity.pose), tuple(geometries))

    def _shape(self, shape: Any) -> tuple[shapes.Shape, Pose]:
        """As PhysX has it, and its pose in the body."""
        px, pose = self.px, _pose(shape.local_pose)
        match shape:
            case px.PhysxCollisionShapeBox():
                return shapes.Box(2 * _doubles(shape.half_size)), pose
            case px.PhysxCollisionShapeSphere():
                return shapes.Sphere(float(shape.radius)), pose
            case px.PhysxCollisionShapeCapsule():
                return shapes.Capsule(float(shape.radius), 2 * float(shape.half_length)), pose @ ALONG_X
            case px.PhysxCollisionShapeCylinder():
                return shapes.Mesh(_prism(float(shape.radius), float(shape.half_length)), None), pose
            case px.PhysxCollisionShapePlane():
                return shapes.Plane(), pose @ ALONG_X
            case px.PhysxCollisionShapeConvexMesh():
                return shapes.Mesh(_doubles(shape.vertices) * _doubles(shape.scale), None), pose
            case px.PhysxCollisionShapeTriangleMesh():
                vertices = _doubles(shape.vertices) * _doubles(shape.scale)
                return shapes.Mesh(vertices, np.array(shape.triangles, dtype=np.int64)), pose
        return shapes.Unreadable(f"a {type(shape).__name__}"), pose

    def _chain(self, joint: Any, name: str) -> list[Joint]:
        """From the parent to the child, with a link between where the child's origin is not on the axis."""
        parent, child = (self._names[link.entity] for link in (joint.parent_link, joint.child_link))
        in_child = _pose(joint.pose_in_child)
        kind = joint.type.removesuffix("_unwrapped")
        lower, upper = joint.limits[0].tolist() if joint.dof == 1 else (0.0, 0.0)
        if kind == "revolute" and np.isinf([lower, upper]).all():
            kind = "continuous"
        speed = float(joint.max_velocity)
        moving = Joint(
            name,
            kind,
            parent,
            child,
            origin=_pose(joint.pose_in_parent) @ in_child.inverse(),
            axis=in_child.matrix()[:3, 0],
            lower=float(lower),
            upper=float(upper),
            velocity=speed if 0 < speed < NO_LIMIT else None,
        )
        if kind not in ("revolute", "continuous") or not np.any(in_child.p):
            return [moving]
        between, to_axis = f"{child}:{name}", Pose(p=in_child.p)
        on_axis = dataclasses.replace(moving, child=between, origin=moving.origin @ to_axis)
        return [on_axis, Joint(f"{name}:fixed", "fixed", between, child, to_axis.inverse(), np.array([1.0, 0, 0]))]

    def joint_positions(self, articulation: str) -> dict[str, float]:
        found = self._found[articulation]
        return dict(zip(_active_names(found), found.qpos.tolist(), strict=True))

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        links = self._found[articulation].links
        return {self._names[link.entity]: _pose(link.entity.pose) for link in links}

    # --- contacts

    def may_collide(self, a: Any, b: Any) -> bool:
        if a not in self._known or b not in self._known:
            return False
        one, two = self._known[a].component, self._known[b].component
        return (
            one is not two
            and not (self._is_fixed(one) and self._is_fixed(two))
            and not (_parent(one) is two or _parent(two) is one)
            and not (self._is_jointed(one, two) or self._is_jointed(two, one))
            and not (self._is_flat(a) and self._is_flat(b))
            and _groups_meet(a.collision_groups, b.collision_groups)
        )

    def filters(self) -> Hashable:
        return tuple(tuple(shape.collision_groups) for shape in self._known)

    def _is_fixed(self, component: Any) -> bool:
        """PhysX finds no contacts among those that nothing can push."""
        if isinstance(component, self.px.PhysxArticulationLinkComponent):
            return bool(component.is_root and component.joint.type == "fixed")
        return isinstance(component, self.px.PhysxRigidStaticComponent) or component.kinematic

    def _is_jointed(self, child: Any, parent: Any) -> bool:
        """Drives and the like let their two bodies through each other."""
        joints = (each for each in child.entity.components if isinstance(each, self.px.PhysxJointComponent))
        return any(joint.parent is parent for joint in joints)

    def _is_flat(self, shape: Any) -> bool:
        """On the CPU there are no contacts among planes and triangle meshes."""
        return isinstance(shape, self.px.PhysxCollisionShapePlane | self.px.PhysxCollisionShapeTriangleMesh)

    def may_differ(self, a: Any, b: Any, seen_by: str) -> str:
        mesh = self.px.PhysxCollisionShapeTriangleMesh
        known = seen_by == "planner" and (isinstance(a, mesh) or isinstance(b, mesh))
        return "PhysX does not find every contact with a triangle mesh" if known else ""

    @contextlib.contextmanager
    def probe(self) -> Iterator[Probe]:
        yield _Probe(self)

    def touching(self) -> list[Touch]:
        return _touches(self.system)

    # --- motion

    @property
    def time_step(self) -> float:
        return float(self.system.timestep)

    def hold(self, articulation: str) -> None:
        found, before = self._read()[articulation], self._controls.get(articulation)
        self._controls[articulation] = _Control(self.system, found, before.own if before else {})

    def command(self, articulation: str, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        self._controls[articulation].aim(positions, velocities, accelerations)

    def step(self) -> None:
        for control in self._controls.values():
            control.apply()
        self.system.step()


class _Probe(Probe):
    """Two scenes of copies: PhysX has two algorithms for contacts (PCM and SAT), and each misses some."""

    def __init__(self, simulator: Sapien) -> None:
        self.simulator = simulator
        self.copies = [_Copy(simulator, pcm) for pcm in (True, False)]

    def put(self, articulation: str, positions: Positions) -> None:
        for copy in self.copies:
            copy.put(articulation, positions)

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        names = [self.simulator._names[link.entity] for link in self.simulator._found[articulation].links]
        return dict(zip(names, self.copies[0].link_poses(articulation), strict=True))

    def touching(self) -> list[Touch]:
        return [touch for copy in self.copies for touch in copy.touching()]


class _Copy:
    """A scene of its own, GROWTH times as large, with triangle meshes that have two sides (PhysX's have one)."""

    def __init__(self, simulator: Sapien, pcm: bool) -> None:
        self.sapien, self.px = simulator.sapien, simulator.px
        self.material = self.px.PhysxMaterial(0.0, 0.0, 0.0)
        self.originals: dict[Any, Any] = {}  # shapes, by their copies
        self.system = self._system(pcm)
        self.scene = self.sapien.Scene([self.system])
        self.articulations = {name: self._copy_articulation(each) for name, each in simulator._read().items()}
        self.positions = {name: each.qpos for name, each in self.articulations.items()}
        self.roots = {name: each.root_pose for name, each in self.articulations.items()}
        for component in simulator._components():
            self._copy_body(component)

    def _system(self, pcm: bool) -> Any:
        before = self.px.get_scene_config()
        try:
            self.px.set_scene_config(enable_pcm=pcm)
            system = self.px.PhysxCpuSystem()
        finally:
            self.px.set_scene_config(before)
        system.timestep = TINY_STEP
        return system

    def _copy_body(self, original: Any) -> None:
        copy = type(original)()
        if isinstance(original, self.px.PhysxRigidDynamicComponent):
            copy.kinematic = original.kinematic
            copy.disable_gravity = True
            copy.set_locked_motion_axes([True] * 6)
        self._add(original, copy)

    def _copy_articulation(self, original: Any) -> Any:
        copies: dict[Any, Any] = {}
        for link in original.links:
            copy = copies[link] = self.px.PhysxArticulationLinkComponent(copies.get(link.parent))
            theirs, ours = link.joint, copy.joint
            ours.type, ours.name = theirs.type, theirs.name
            if link.parent is not None:
                ours.pose_in_parent, ours.pose_in_child = map(
                    self._grown, (theirs.pose_in_parent, theirs.pose_in_child)
                )
            if theirs.dof:
                ours.limits = theirs.limits * _unit(theirs)
        for link, copy in copies.items():
            self._add(link, copy)
            copy.disable_gravity = True
            copy.mass, copy.inertia = 1.0, [1.0, 1.0, 1.0]
            copy.max_depenetration_velocity = 1e-3
        articulation = copies[original.root].articulation
        articulation.qpos = original.qpos * _units(original)
        return articulation

    def _add(self, original: Any, copy: Any) -> None:
        for shape in original.collision_shapes:
            grown = self._copy_shape(shape)
            grown.local_pose = self._grown(shape.local_pose)
            grown.set_collision_groups(shape.collision_groups)
            copy.attach(grown)
            self.originals[grown] = shape
        entity = self.sapien.Entity()
        entity.add_component(copy)
        entity.pose = self._grown(original.entity.pose)
        self.scene.add_entity(entity)

    def _grown(self, pose: Any) -> Any:
        return self.sapien.Pose(GROWTH * pose.p, pose.q)

    def _copy_shape(self, shape: Any) -> Any:
        px, material = self.px, self.material
        match shape:
            case px.PhysxCollisionShapeBox():
                return px.PhysxCollisionShapeBox(GROWTH * shape.half_size, material)
            case px.PhysxCollisionShapeSphere():
                return px.PhysxCollisionShapeSphere(GROWTH * shape.radius, material)
            case px.PhysxCollisionShapeCapsule() | px.PhysxCollisionShapeCylinder():
                return type(shape)(GROWTH * shape.radius, GROWTH * shape.half_length, material)
            case px.PhysxCollisionShapeConvexMesh():
                return px.PhysxCollisionShapeConvexMesh(shape.vertices, GROWTH * shape.scale, material)
            case px.PhysxCollisionShapeTriangleMesh():
                both_sides = np.concatenate([shape.triangles, shape.triangles[:, ::-1]])
                return px.PhysxCollisionShapeTriangleMesh(shape.vertices, both_sides, GROWTH * shape.scale, material)
        return type(shape)(material)

    def put(self, articulation: str, positions: Positions) -> None:
        for number, (joint, name) in enumerate(_active(self.articulations[articulation])):
            if name in positions:
                self.positions[articulation][number] = positions[name] * _unit(joint)

    def _place(self, name: str) -> Any:
        articulation = self.articulations[name]
        articulation.root_pose = self.roots[name]
        articulation.qpos = self.positions[name]
        return articulation

    def link_poses(self, articulation: str) -> list[Pose]:
        poses = [_pose(link.entity.pose) for link in self._place(articulation).links]
        return [Pose(p=pose.p / GROWTH, q=pose.q) for pose in poses]

    def touching(self) -> list[Touch]:
        for name in self.articulations:
            articulation = self._place(name)
            articulation.root_linear_velocity = articulation.root_angular_velocity = np.zeros(3)
            articulation.qvel = np.zeros(articulation.dof)
        self.system.step()
        touches = _touches(self.system)
        return [Touch(self.originals[a], self.originals[b], depth / GROWTH) for a, b, depth in touches]


class _Control:
    """Drives get the target and its velocity; gravity and the motion's own inertia are fed forward.

    Joints without a drive get one; those with one keep it, and their target until they are told another.
    """

    def __init__(self, system: Any, articulation: Any, own_before: Collection[Any]) -> None:
        self.system, self.articulation = system, articulation
        self.names, self.joints = _active_names(articulation), articulation.active_joints
        self.accelerations = np.zeros(len(self.joints))
        self.masses = _Masses(articulation, _doubles(system.config.gravity))
        self.own = {joint for joint in self.joints if joint.stiffness == 0 or joint in own_before}
        self.led = set(self.own)  # joints whose force is ours to set
        for joint, position in zip(self.joints, articulation.qpos.tolist(), strict=True):
            if joint in self.own:
                joint.set_drive_properties(STIFFNESS, DAMPING, joint.force_limit, "acceleration")
                joint.set_drive_target(position)
                joint.set_drive_velocity_target(0.0)

    def _lead(self) -> float:
        """[s] by which joints would be ahead: TGS cuts a step into parts, and each pulls to the target of its end."""
        parts = self.articulation.solver_position_iterations if self.system.config.enable_tgs else 1
        return float(self.system.timestep * (1 - 1 / parts) / 2)

    def aim(self, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        lead = self._lead()
        for number, (name, joint) in enumerate(zip(self.names, self.joints, strict=True)):
            if name in positions:
                joint.set_drive_target(positions[name] - lead * velocities[name])
                joint.set_drive_velocity_target(velocities[name])
                self.accelerations[number] = accelerations[name]
                self.led.add(joint)

    def apply(self) -> None:
        forces = self.masses.forces(self.accelerations) + self.articulation.compute_passive_force(gravity=False)
        led = [joint in self.led for joint in self.joints]
        self.articulation.qf = np.where(led, forces, self.articulation.qf)


class _Masses:
    """Of an articulation's links. (compute_passive_force has no inertia, and does not heed disable_gravity.)"""

    def __init__(self, articulation: Any, gravity: NDArray[np.float64]) -> None:
        self.joints, self.links = articulation.active_joints, articulation.links
        self.turns = np.array([joint.type != "prismatic" for joint in self.joints], dtype=bool)[:, None]
        self.mass = np.array([link.mass for link in self.links])[:, None]
        self.inertia = np.array([np.diag(link.inertia) for link in self.links], dtype=np.float64)
        self.pull = np.array([(not link.disable_gravity) * gravity for link in self.links])
        self.moves = np.zeros((len(self.links), len(self.joints), 1))  # which links does a joint move
        for number, joint in enumerate(self.joints):
            for link in self._below(joint.child_link):
                self.moves[self.links.index(link), number] = 1.0

    def _below(self, link: Any) -> list[Any]:
        return [link] + [each for child in link.children for each in self._below(child)]

    def forces(self, accelerations: NDArray[np.float64]) -> NDArray[np.float64]:
        """[Nm or N] that hold the joints against gravity and accelerate them so, from rest."""
        frames = [_pose(joint.global_pose).matrix() for joint in self.joints]
        axes, anchors = (np.array([frame[:3, k] for frame in frames]).reshape(-1, 3) for k in (0, 3))
        bodies = [_pose(link.entity.pose * link.cmass_local_pose).matrix() for link in self.links]
        centres, turned = (np.array([body[:3, k] for body in bodies]) for k in (3, slice(0, 3)))
        sweep = np.cross(axes, centres[:, None] - anchors)  # (links, joints, 3)
        linear = self.moves * np.where(self.turns, sweep, axes)
        angular = self.moves * self.turns * axes
        push = self.mass * (np.einsum("ljk,j->lk", linear, accelerations) - self.pull)
        inertia = turned @ self.inertia @ turned.transpose(0, 2, 1)
        spin = np.einsum("lik,ljk,j->li", inertia, angular, accelerations)
        return np.einsum("ljk,lk->j", linear, push) + np.einsum("ljk,lk->j", angular, spin)


def _touches(system: Any) -> list[Touch]:
    """Those nearer than the contact offset are there too, with separations above 0."""
    found = (
        (contact.shapes, min((p.separation for p in contact.points), default=0.0)) for contact in system.get_contacts()
    )
    return [Touch(a, b, -float(separation)) for (a, b), separation in found if separation < 0]


def _groups_meet(a: list[int], b: list[int]) -> bool:
    """SAPIEN's filter: set_collision_groups says what the four integers are."""
    if a[3] >> 16 != b[3] >> 16 or (a[2] & b[2] and a[3] & 0xFFFF == b[3] & 0xFFFF):
        return False
    return bool(a[0] & b[1] or a[1] & b[0])


def _parent(component: Any) -> Any:
    """Of a link; itself where there is none, which no other component is."""
    parent = getattr(component, "parent", None)
    return component if parent is None else parent


def _named_joints(articulation: Any) -> Iterable[tuple[Any, str]]:
    """All but the root's, each with a name that no other has."""
    taken: set[str] = set()
    for number, joint in enumerate(articulation.joints):
        if joint.parent_link is None:
            continue
        name = joint.name or f"joint{number}"
        if name in taken:
            name = f"{name}_{number}"
        taken.add(name)
        yield joint, name


def _active(articulation: Any) -> list[tuple[Any, str]]:
    """Movable joints with their names, in the order of qpos."""
    return [(joint, name) for joint, name in _named_joints(articulation) if joint.dof]


def _active_names(articulation: Any) -> list[str]:
    return [name for _, name in _active(articulation)]


def _unit(joint: Any) -> float:
    """What a radian or metre of this joint is in the grown world."""
    return GROWTH if joint.type == "prismatic" else 1.0


def _units(articulation: Any) -> NDArray[np.float64]:
    return np.array([_unit(joint) for joint, _ in _active(articulation)])


def _prism(radius: float, half_length: float) -> NDArray[np.float64]:
    """Corners of SAPIEN's cylinder, which lies along x."""
    angles = 2 * np.pi / CYLINDER_CORNERS * np.arange(CYLINDER_CORNERS)
    circle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([np.insert(circle, 0, x, axis=1) for x in (-half_length, half_length)])


def _doubles(values: Any) -> NDArray[np.float64]:
    return np.array(values, dtype=np.float64)


def _pose(pose: Any) -> Pose:
    q = _doubles(pose.q)
    return Pose.from_wxyz(_doubles(pose.p), q / np.linalg.norm(q))
