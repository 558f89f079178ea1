"""Genesis (genesis-world >= 1.4). `sim` is a gs.Scene that was built, of one environment."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator
from functools import cached_property
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

DAMPING = 100.0  # [1/s] of joints without gains, critically damped; less where the simulator's steps are long


class Genesis(Simulator):
    """An articulation is a kinematic tree with a revolute, prismatic or spherical joint, called as its entity.

    "entity/root link" where the entity has several such trees. Entities that were not named are called as their kind
    ("box", "box_2", …) or their robot. A geometry's key is its index in the scene.
    """

    kind = "genesis"
    margin = 1e-3

    def __init__(self, sim: Any) -> None:
        self.gs = import_simulator("genesis", "genesis-world")
        self.scene = self._checked(sim)
        self.solver = self.scene.rigid_solver
        self._shapes: dict[int, shapes.Shape] = {}
        self._controls: dict[str, _Control] = {}

    def _checked(self, sim: Any) -> Any:
        if not isinstance(sim, self.gs.Scene):
            raise InvalidArgument(f"a Genesis scene is a gs.Scene, not {type(sim).__name__}")
        if not sim.is_built:
            raise InvalidArgument("the Genesis scene is not built yet; call its build() first")
        if sim.n_envs > 1:
            raise InvalidArgument(
                f"the Genesis scene has {sim.n_envs} environments; build it with one: build(n_envs=1)"
            )
        return sim

    def is_of(self, sim: Any) -> bool:
        return self._checked(sim) is self.scene

    # --- names

    @cached_property
    def _entity_names(self) -> dict[int, str]:
        """By the entity's index: what the user called it, or its kind, as Genesis' own names are random."""
        names: dict[int, str] = {}
        for entity in self.scene.entities:
            kind = entity._get_morph_identifier()
            given = entity.name != f"{kind}_{entity.uid.short()}"
            names[entity.idx] = entity.name if given else _free_name(kind, names.values())
        return names

    @cached_property
    def _trees(self) -> dict[str, list[Any]]:
        """Articulations: name to links, the root first."""
        fixed_or_free = (self.gs.JOINT_TYPE.FIXED, self.gs.JOINT_TYPE.FREE)
        trees: dict[int, list[Any]] = {}
        for link in self.solver.links:
            trees.setdefault(link.root_idx, []).append(link)
        moving = [
            tree
            for tree in trees.values()
            if any(joint.type not in fixed_or_free for link in tree for joint in link.joints)
        ]
        of_entity = Counter(tree[0].entity.idx for tree in moving)
        result = {}
        for tree in moving:
            entity = tree[0].entity
            name = self._entity_names[entity.idx]
            result[name if of_entity[entity.idx] == 1 else f"{name}/{tree[0].name}"] = tree
        return result

    @cached_property
    def _link_names(self) -> dict[int, str]:
        """Of the links of articulations, by index."""
        names = {}
        for tree in self._trees.values():
            count = Counter(link.name for link in tree)
            taken: list[str] = []
            for link in tree:
                unique = link.name if count[link.name] == 1 else f"{self._entity_names[link.entity.idx]}/{link.name}"
                names[link.idx] = _free_name(unique, taken)
                taken.append(names[link.idx])
        return names

    @cached_property
    def _joints(self) -> dict[str, dict[str, Any]]:
        """By articulation: joints that move, free ones left out, by name."""
        fixed_or_free = (self.gs.JOINT_TYPE.FIXED, self.gs.JOINT_TYPE.FREE)
        result: dict[str, dict[str, Any]] = {}
        for articulation, tree in self._trees.items():
            joints = [joint for link in tree for joint in link.joints if joint.type not in fixed_or_free]
            count = Counter(joint.name for joint in joints)
            named: dict[str, Any] = {}
            for joint in joints:
                several = count[joint.name] > 1
                name = f"{self._entity_names[joint.entity.idx]}/{joint.name}" if several else joint.name
                named[_free_name(name, named)] = joint
            result[articulation] = named
        return result

    def name_of(self, handle: Any) -> str:
        if hasattr(handle, "base_link"):
            names = [name for name, tree in self._trees.items() if any(link.entity is handle for link in tree)]
            if len(names) == 1:
                return names[0]
            raise InvalidArgument(
                f"entity '{handle.name}' is {'several articulations' if names else 'no articulation'}; there are "
                f"{', '.join(self._trees) or 'none'}"
            )
        return super().name_of(handle)

    # --- the scene

    def articulations(self) -> list[Articulation]:
        poses = self._poses()
        result = []
        for name, tree in self._trees.items():
            joint_names = {joint.idx: given for given, joint in self._joints[name].items()}
            links, joints = self._root(tree[0], poses, joint_names)
            for link in tree[1:]:
                chain = self._chain(link, self._link_names[link.parent_idx], joint_names)
                links += [Body(joint.child, Pose(), ()) for joint in chain[:-1]] + [self._link(link, poses)]
                joints += chain
            result.append(Articulation(name, tuple(links), tuple(joints)))
        return result

    def _root(self, link: Any, poses: list[Pose], names: dict[int, str]) -> tuple[list[Body], list[Joint]]:
        """The first link, behind one that stands still where it has joints of its own."""
        if not any(joint.idx in names for joint in link.joints):
            return [self._link(link, poses)], []
        base = self._base_name(link)
        chain = self._chain(link, base, names)
        between = [Body(joint.child, Pose(), ()) for joint in chain[:-1]]
        return [Body(base, self._base_pose(link, poses), ()), *between, self._link(link, poses)], chain

    def _base_name(self, root: Any) -> str:
        return f"{self._link_names[root.idx]}:base"

    def _base_pose(self, root: Any, poses: list[Pose]) -> Pose:
        return Pose() if root.parent_idx < 0 else poses[root.parent_idx]

    def _link(self, link: Any, poses: list[Pose]) -> Body:
        return Body(self._link_names[link.idx], poses[link.idx], self._geometries(link))

    def _chain(self, link: Any, parent: str, names: dict[int, str]) -> list[Joint]:
        """From the parent to the link: a joint for each of its joints, with links between that have no shape."""
        kinds = {self.gs.JOINT_TYPE.REVOLUTE: "revolute", self.gs.JOINT_TYPE.PRISMATIC: "prismatic"}
        offset = Pose.from_wxyz(link.desc.pos, link.desc.quat)
        chain = []
        for joint in link.joints:
            if joint.idx not in names:
                continue
            kind = kinds.get(joint.type, "unreadable")
            anchor = np.asarray(joint.pos, dtype=float)
            revolute = kind == "revolute"
            axis = np.asarray(joint.desc.dofs_motion_ang[0] if revolute else joint.desc.dofs_motion_vel[0], dtype=float)
            lower, upper = self._limits(joint)
            if revolute and not (np.isfinite(lower) and np.isfinite(upper)):
                kind = "continuous"
            origin = offset @ Pose(p=anchor)
            if kind != "unreadable":
                origin = origin @ _moved(revolute, axis, -float(joint.init_qpos[0]))
            child = f"{self._link_names[link.idx]}:{names[joint.idx]}"
            chain.append(Joint(names[joint.idx], kind, parent, child, origin, axis, lower, upper))
            parent, offset = child, Pose(p=-anchor)
        own = self._link_names[link.idx]
        if chain and not np.any(offset.p):
            return [*chain[:-1], Joint(**(vars(chain[-1]) | {"child": own}))]
        return [*chain, Joint(f"{own}:fixed", "fixed", parent, own, offset, np.array([1.0, 0, 0]))]

    def _limits(self, joint: Any) -> tuple[float, float]:
        lower, upper = (self._row(each) for each in self.solver.get_dofs_limit(list(joint.dofs_idx)))
        return float(lower[0]), float(upper[0])

    def bodies(self) -> list[Body]:
        poses = self._poses()
        found: list[Body] = []
        inside = {link.idx for tree in self._trees.values() for link in tree}
        links = [link for link in self.solver.links if link.idx not in inside and link.geoms]
        count = Counter(link.entity.idx for link in self.solver.links if link.geoms)
        for link in links:
            name = self._entity_names[link.entity.idx]
            name = name if count[link.entity.idx] == 1 else f"{name}/{link.name}"
            name = _free_name(name, [body.name for body in found])
            found.append(Body(name, poses[link.idx], self._geometries(link)))
        return found + self._soft_bodies()

    def _soft_bodies(self) -> list[Body]:
        """What other solvers than those of rigid bodies move."""
        solid = (self.solver, self.scene.kinematic_solver)
        others = [entity for entity in self.scene.entities if getattr(entity, "solver", None) not in solid]
        result = []
        for entity in others:
            shape = shapes.Unreadable(f"an entity of material {type(entity.material).__name__}")
            name = self._entity_names[entity.idx]
            result.append(Body(name, Pose(), (Geometry("", shape, Pose(), f"entity {entity.idx}"),)))
        return result

    def _geometries(self, link: Any) -> tuple[Geometry, ...]:
        count = Counter(geom.metadata.get("name") for geom in link.geoms)
        result = []
        for geom in link.geoms:
            if geom.idx not in self._shapes:
                self._shapes[geom.idx] = self._shape(geom)
            name = geom.metadata.get("name") or ""
            pose = _pose(geom.init_pos, geom.init_quat) @ self._shape_pose(geom)
            result.append(Geometry(name if count[name] == 1 else "", self._shapes[geom.idx], pose, geom.idx))
        return tuple(result)

    def _shape(self, geom: Any) -> shapes.Shape:
        data = np.asarray(geom.data, dtype=float)
        match self.gs.GEOM_TYPE(geom.type).name:
            case "PLANE":
                return shapes.Plane()
            case "BOX":
                return shapes.Box(data[:3].copy())
            case "SPHERE":
                return shapes.Sphere(float(data[0]))
            case "CYLINDER":
                return shapes.Cylinder(float(data[0]), float(data[1]))
            case "CAPSULE":
                return shapes.Capsule(float(data[0]), float(data[1]))
            case "ELLIPSOID":
                return shapes.Ellipsoid(data[:3].copy())
            case "MESH":
                vertices = np.array(geom.init_verts, dtype=float)
                return shapes.Mesh(vertices, None if geom.is_convex else np.array(geom.init_faces, dtype=np.int64))
            case "TERRAIN":
                return self._terrain(geom)
        return shapes.Unreadable(f"a geom of type {self.gs.GEOM_TYPE(geom.type).name.lower()}")

    def _terrain(self, geom: Any) -> shapes.Shape:
        first = next(other for other in self.solver.geoms if other.type == self.gs.GEOM_TYPE.TERRAIN)
        if geom.entity is not first.entity:
            return shapes.Unreadable("a second terrain, which Genesis gives the heights of the first,")
        heights = np.asarray(geom.entity.terrain_hf, dtype=float)  # (along x, along y)
        spacing = float(geom.entity.terrain_scale[0])
        return shapes.HeightField(heights.T, (spacing, spacing), float(heights.min()) - 1.0, rising=False)

    def _shape_pose(self, geom: Any) -> Pose:
        """Of what _shape() says, in the geom's frame."""
        match self._shapes[geom.idx]:
            case shapes.Plane():
                return _turned_up(np.asarray(geom.data[:3], dtype=float))
            case shapes.HeightField(heights, spacing):
                rows, columns = heights.shape
                return Pose(p=[(columns - 1) / 2 * spacing[0], (rows - 1) / 2 * spacing[1], 0])
        return Pose()

    def joint_positions(self, articulation: str) -> dict[str, float]:
        positions = self._row(self.solver.get_qpos())
        return {
            name: float(positions[joint.q_start])
            for name, joint in self._joints[articulation].items()
            if joint.n_qs == 1
        }

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        poses, tree = self._poses(), self._trees[articulation]
        result = {self._link_names[link.idx]: poses[link.idx] for link in tree}
        if any(joint in tree[0].joints for joint in self._joints[articulation].values()):
            result[self._base_name(tree[0])] = self._base_pose(tree[0], poses)
        return result

    def _poses(self) -> list[Pose]:
        """Of all links."""
        self.solver.update_forward_pos()
        positions = _array(self.solver.get_links_pos()).reshape(-1, 3)
        rotations = _array(self.solver.get_links_quat()).reshape(-1, 4)
        return [_pose(p, q) for p, q in zip(positions, rotations, strict=True)]

    def _row(self, tensor: Any) -> NDArray[np.float64]:
        """Without the dimension of environments."""
        return _array(tensor).reshape(-1)

    # --- contacts

    @cached_property
    def _pairs(self) -> NDArray[np.bool_]:
        """Which geoms may touch: contype and conaffinity, neighbours, overlap at rest, welds."""
        above = np.asarray(self.solver.collider._collision_pair_idx) >= 0
        return above | above.T

    def may_collide(self, a: Hashable, b: Hashable) -> bool:
        if not (isinstance(a, int) and isinstance(b, int)):
            return True
        return bool(self.solver._enable_collision and self._pairs[a, b])

    def may_differ(self, a: Hashable, b: Hashable, seen_by: str) -> str:
        geoms = [self.solver.geoms[key] for key in (a, b) if isinstance(key, int)]
        kinds = {self.gs.GEOM_TYPE(geom.type).name for geom in geoms}
        if "TERRAIN" in kinds and seen_by == "planner":
            return "Genesis overlooks what is wholly beneath a terrain's lowest height"
        if "PLANE" in kinds and seen_by == "planner":
            return "Genesis overlooks what is wholly beneath a plane"
        if not all(geom.is_convex for geom in geoms) and "TERRAIN" not in kinds:
            return "Genesis tests a mesh that is not convex as a solid, and only corners against it"
        exact = self.gs.np_float is np.float64 and self.solver._options.use_gjk_collision
        if "CYLINDER" in kinds and not exact:
            return "Genesis errs at some cylinders, but not with init(precision='64') and use_gjk_collision=True"
        return ""

    def self_collision(self, articulation: str) -> bool:
        return bool(self.solver._enable_self_collision)

    @contextlib.contextmanager
    def probe(self) -> Iterator[Probe]:
        before = self.solver.__getstate__()
        try:
            yield _Probe(self)
        finally:
            self.solver.__setstate__(before)

    def touching(self) -> list[Touch]:
        contacts = self.solver.collider.get_contacts(as_tensor=True, to_torch=False)
        columns = (np.asarray(contacts[key]).reshape(-1).tolist() for key in ("geom_a", "geom_b", "penetration"))
        return [Touch(a, b, depth) for a, b, depth in zip(*columns, strict=True) if depth > 0 and min(a, b) >= 0]

    # --- motion

    @property
    def time_step(self) -> float:
        return float(self.scene.dt)

    def hold(self, articulation: str) -> None:
        joints = {name: joint for name, joint in self._joints[articulation].items() if joint.n_dofs == 1}
        self._controls[articulation] = _Control(self, joints)

    def command(self, articulation: str, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        self._controls[articulation].aim(positions, velocities, accelerations)

    def step(self) -> None:
        for control in self._controls.values():
            control.apply()
        self.scene.step()
        for control in self._controls.values():
            control.measure()


class _Probe(Probe):
    """The scene itself, put back afterwards."""

    def __init__(self, simulator: Genesis) -> None:
        self.simulator = simulator

    def put(self, articulation: str, positions: Positions) -> None:
        joints = self.simulator._joints[articulation]
        values = np.array(list(positions.values()))
        addresses = [joints[name].q_start for name in positions]
        self.simulator.solver.set_qpos(values[None] if self.simulator.scene.n_envs else values, addresses)

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        return self.simulator.link_poses(articulation)

    def touching(self) -> list[Touch]:
        solver = self.simulator.solver
        solver.update_forward_pos()
        solver.collider.reset()  # what it remembers of earlier contacts
        solver.collider.clear()
        solver.collider.detection()
        return self.simulator.touching()


class _Control:
    """Joints with gains get position and velocity targets, shifted by what gravity and the motion's inertia will take.

    Joints without gains get a torque. Joints that the user controls are left alone until a command names them.
    """

    def __init__(self, simulator: Genesis, joints: dict[str, Any]) -> None:
        self.simulator, self.solver = simulator, simulator.solver
        self.numbers = {name: i for i, name in enumerate(joints)}
        self.dofs = [joint.dof_start for joint in joints.values()]
        self.zero = np.array([float(joint.init_qpos[0]) for joint in joints.values()])  # Genesis counts from there
        self.target = self._of_dofs(self.solver.get_dofs_position())
        self.velocity = np.zeros(len(self.dofs))
        self.acceleration = np.zeros(len(self.dofs))
        self.mine = self._of_dofs(self.solver.dyn_state.dofs.ctrl_mode.to_numpy()) == simulator.gs.CTRL_MODE.FORCE
        self.mass, self.load = np.eye(len(self.dofs)), np.zeros(len(self.dofs))
        with simulator.probe():  # they are found by stepping only
            self.apply()
            self.solver.substep(0)
            self.measure()

    def _of_dofs(self, tensor: Any) -> NDArray[np.float64]:
        return self.simulator._row(tensor)[self.dofs]

    def aim(self, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        for name, value in positions.items():
            i = self.numbers[name]
            self.target[i] = value - self.zero[i]
            self.velocity[i], self.acceleration[i] = velocities[name], accelerations[name]
            self.mine[i] = True

    def apply(self) -> None:
        solver, step = self.solver, self.simulator.time_step
        now, speed = self._of_dofs(solver.get_dofs_position()), self._of_dofs(solver.get_dofs_velocity())
        due = self.target - step * self.velocity  # targets are of the end of the step; here and now, these
        due_speed = self.velocity - step * self.acceleration
        gain = self._of_dofs(solver.get_dofs_act_gain())
        offset, slope, _ = (self._of_dofs(bias) for bias in solver.get_dofs_act_bias())
        pushed = gain <= 0
        damping = min(DAMPING, 0.5 / step)
        pulled = np.where(pushed, damping**2 / 4 * (due - now) + damping * (due_speed - speed), 0.0)
        torque = self.mass @ (self.acceleration + pulled) + self.load
        driven = np.where(pushed, 1.0, gain)
        shifted = due + (torque - offset - (gain + slope) * now) / driven
        self._send(solver.control_dofs_position_velocity, self.mine & ~pushed, shifted, due_speed)
        self._send(solver.control_dofs_force, self.mine & pushed, torque)

    def measure(self) -> None:
        """Inertia and load of gravity, motion and friction, as the last step found them."""
        solver, state = self.solver, self.solver.dyn_state.dofs
        mass = _array(solver.get_mass_mat()).reshape(solver.n_dofs, solver.n_dofs)
        self.mass = mass[np.ix_(self.dofs, self.dofs)]
        self.load = self._of_dofs(state.qf_bias.to_numpy()) - self._of_dofs(state.qf_passive.to_numpy())

    def _send(self, control: Any, which: NDArray[np.bool_], *values: NDArray[np.float64]) -> None:
        if which.any():
            rows = [value[which][None] if self.simulator.scene.n_envs else value[which] for value in values]
            control(*rows, [dof for dof, mine in zip(self.dofs, which, strict=True) if mine])


def _array(tensor: Any) -> NDArray[np.float64]:
    return np.asarray(tensor.cpu() if hasattr(tensor, "cpu") else tensor, dtype=float)


def _pose(position: Any, wxyz: Any) -> Pose:
    quaternion = np.asarray(wxyz, dtype=float)
    return Pose.from_wxyz(np.asarray(position, dtype=float), quaternion / np.linalg.norm(quaternion))


def _free_name(name: str, taken: Iterable[str]) -> str:
    """The name, or "name_2", … where it is taken."""
    taken = set(taken)
    return next(each for each in (name, *(f"{name}_{k}" for k in range(2, len(taken) + 3))) if each not in taken)


def _moved(revolute: bool, axis: NDArray[np.float64], value: float) -> Pose:
    if not revolute:
        return Pose(p=value * axis)
    return Pose.from_wxyz([0, 0, 0], [np.cos(value / 2), *(np.sin(value / 2) * axis)])


def _turned_up(normal: NDArray[np.float64]) -> Pose:
    """A frame with z along the normal."""
    z = normal / np.linalg.norm(normal)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return Pose.from_matrix(matrix)
