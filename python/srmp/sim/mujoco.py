"""MuJoCo (mujoco >= 3.1). `sim` is (MjModel, MjData), or an object with `model` and `data`."""

from __future__ import annotations

import contextlib
import copy
from collections import Counter
from collections.abc import Hashable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from srmp import InvalidArgument, NotSupported, Pose
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
    diverged,
    import_simulator,
)

STIFFNESS, DAMPING = 2500.0, 100.0  # [1/s^2], [1/s]: of joints without actuators; 50 rad/s, critically damped


class MuJoCo(Simulator):
    """An articulation is the tree under a body that is fixed to the world and has a moving child, or under a free body.

    It is called as its root body; "name" where all its bodies are "name/…", as MjSpec.attach makes them.
    """

    kind = "mujoco"
    margin = 1e-4

    def __init__(self, sim: Any) -> None:
        self.mj = import_simulator("mujoco", "mujoco")
        self.model, self.data = self._parts(sim)
        self._shapes: dict[int, tuple[Hashable, shapes.Shape]] = {}  # of each geom, and what it was made of
        self._controls: dict[str, _Control] = {}

    def _parts(self, sim: Any) -> tuple[Any, Any]:
        try:
            model, data = sim if isinstance(sim, tuple | list) else (sim.model, sim.data)
        except (AttributeError, ValueError):
            model = data = None
        if not (isinstance(model, self.mj.MjModel) and isinstance(data, self.mj.MjData)):
            raise InvalidArgument(f"a MuJoCo scene is a pair (MjModel, MjData), not {type(sim).__name__}")
        if (data.qpos.size, data.qvel.size, len(data.xpos)) != (model.nq, model.nv, model.nbody):
            raise InvalidArgument("this MjData is of another MjModel than this one; make it by MjData(model)")
        return model, data

    def is_of(self, sim: Any) -> bool:
        model, data = self._parts(sim)
        return model is self.model and data is self.data

    # --- the scene

    @cached_property
    def _roots(self) -> dict[str, int]:
        """Articulations: name to root body."""
        m = self.model
        moving = {int(m.jnt_bodyid[j]) for j in range(m.njnt) if m.jnt_type[j] != int(self.mj.mjtJoint.mjJNT_FREE)}
        roots = []

        def visit(body: int) -> None:
            inside = self._subtree(body)
            if not moving & set(inside):
                return
            children = [c for c in inside if m.body_parentid[c] == body and c != body]
            fixed = m.body_weldid[body] == 0
            if fixed and not any(m.body_weldid[c] != 0 and moving & set(self._subtree(c)) for c in children):
                for child in children:
                    visit(child)
            else:
                roots.append(body)

        for body in range(1, m.nbody):
            if m.body_parentid[body] == 0:
                visit(body)
        candidates = {root: self._articulation_names(root) for root in roots}
        taken = Counter(name for names in candidates.values() for name in names)
        return {
            next((name for name in names if taken[name] == 1), names[-1]): root for root, names in candidates.items()
        }

    def _articulation_names(self, root: int) -> list[str]:
        """Those that it may have, the best first: "a" and "a/b" if all its bodies are "a/b/…", and that of its root."""
        names = [self._body_name(body) for body in self._subtree(root)]
        parts = names[0].split("/")
        prefixes = ["/".join(parts[:k]) for k in range(1, len(parts))]
        shared = [prefix for prefix in prefixes if all(name.startswith(f"{prefix}/") for name in names)]
        return [*shared, names[0]]

    def _subtree(self, root: int) -> list[int]:
        inside = {root}
        for body in range(root + 1, self.model.nbody):  # parents have lower numbers
            if int(self.model.body_parentid[body]) in inside:
                inside.add(body)
        return sorted(inside)

    def _name(self, kind: str, index: int) -> str:
        return self.mj.mj_id2name(self.model, getattr(self.mj.mjtObj, f"mjOBJ_{kind}"), index) or ""

    def _body_name(self, body: int) -> str:
        return self._name("BODY", body) or f"body{body}"

    def _joint_name(self, joint: int) -> str:
        return self._name("JOINT", joint) or f"joint{joint}"

    def _update(self) -> None:
        """Brings the poses of bodies up to date with the positions of joints."""
        self.mj.mj_kinematics(self.model, self.data)
        lost = np.flatnonzero(~np.isfinite(np.hstack([self.data.xpos, self.data.xquat])).all(axis=1))
        if lost.size:
            raise InvalidArgument(
                f"the pose of body '{self._body_name(int(lost[0]))}' is not finite in mujoco: its simulation has "
                "diverged, or qpos was set so"
            )

    def articulations(self) -> list[Articulation]:
        self._update()
        result = []
        for name, root in self._roots.items():
            links, joints = [self._body(root)], []
            for body in self._subtree(root)[1:]:
                chain = self._chain(body)
                links += [Body(link.child, Pose(), ()) for link in chain[:-1]] + [self._body(body)]
                joints += chain
            result.append(Articulation(name, tuple(links), tuple(joints)))
        return result

    def name_of(self, handle: Any) -> str:
        if isinstance(handle, str) and handle not in self._roots:
            for name, root in self._roots.items():
                if handle == self._body_name(root):
                    return name
        return super().name_of(handle)

    def bodies(self) -> list[Body]:
        self._update()
        inside = {body for root in self._roots.values() for body in self._subtree(root)}
        found = [self._body(body) for body in range(self.model.nbody) if body not in inside]
        return [body for body in found if body.geometries]

    def _body(self, body: int) -> Body:
        first, count = self.model.body_geomadr[body], self.model.body_geomnum[body]
        geometries = [self._geometry(g) for g in range(first, first + count) if self._counts(g)]
        pose = Pose.from_wxyz(self.data.xpos[body], self.data.xquat[body])
        return Body(self._body_name(body), pose, tuple(geometries))

    def _counts(self, geom: int) -> bool:
        """Returns whether the geom collides, not only shows."""
        m = self.model
        return bool(m.geom_contype[geom] or m.geom_conaffinity[geom]) or any(geom in pair for pair in self._pairs)

    def _geometry(self, geom: int) -> Geometry:
        made_of = self._numbers(geom)
        if geom not in self._shapes or self._shapes[geom][0] != made_of:
            self._shapes[geom] = made_of, self._shape(geom)
        pose = Pose.from_wxyz(self.model.geom_pos[geom], self.model.geom_quat[geom])
        return Geometry(self._name("GEOM", geom), self._shapes[geom][1], pose, geom)

    def _numbers(self, geom: int) -> Hashable:
        """All of the model that is in the geom's shape, which may change in place, as domain randomisation does."""
        m, of = self.model, int(self.model.geom_dataid[geom])
        numbers = [m.geom_type[geom], m.geom_size[geom]]
        match self.mj.mjtGeom(m.geom_type[geom]).name:
            case "mjGEOM_MESH":
                numbers += [of, m.mesh_vert[m.mesh_vertadr[of] : m.mesh_vertadr[of] + m.mesh_vertnum[of]]]
            case "mjGEOM_HFIELD":
                first, count = m.hfield_adr[of], m.hfield_nrow[of] * m.hfield_ncol[of]
                numbers += [of, m.hfield_size[of], m.hfield_data[first : first + count]]
        return tuple(np.asarray(number).tobytes() for number in numbers)

    def _shape(self, geom: int) -> shapes.Shape:
        size = self.model.geom_size[geom].copy()
        kind = self.mj.mjtGeom(self.model.geom_type[geom])
        match kind.name:
            case "mjGEOM_PLANE":
                return shapes.Plane()
            case "mjGEOM_BOX":
                return shapes.Box(2 * size)
            case "mjGEOM_SPHERE":
                return shapes.Sphere(float(size[0]))
            case "mjGEOM_CYLINDER":
                return shapes.Cylinder(float(size[0]), float(2 * size[1]))
            case "mjGEOM_CAPSULE":
                return shapes.Capsule(float(size[0]), float(2 * size[1]))
            case "mjGEOM_ELLIPSOID":
                return shapes.Ellipsoid(size)
            case "mjGEOM_MESH":
                return shapes.Mesh(self._hull_vertices(int(self.model.geom_dataid[geom])), None)
            case "mjGEOM_HFIELD":
                return self._height_field(int(self.model.geom_dataid[geom]))
        return shapes.Unreadable(f"a geom of type {kind.name.removeprefix('mjGEOM_').lower()}")

    def _hull_vertices(self, mesh: int) -> np.ndarray:
        """MuJoCo lets meshes collide by their convex hulls, whose corners it has found already."""
        m = self.model
        first, graph = m.mesh_vertadr[mesh], m.mesh_graphadr[mesh]
        vertices = np.array(m.mesh_vert[first : first + m.mesh_vertnum[mesh]], dtype=float)
        if graph < 0:
            return vertices
        count = int(m.mesh_graph[graph])
        return vertices[m.mesh_graph[graph + 2 + count : graph + 2 + 2 * count]]

    def _height_field(self, field: int) -> shapes.HeightField:
        m = self.model
        rows, columns, first = int(m.hfield_nrow[field]), int(m.hfield_ncol[field]), m.hfield_adr[field]
        x, y, top, bottom = (float(value) for value in m.hfield_size[field])
        heights = np.array(m.hfield_data[first : first + rows * columns], dtype=float).reshape(rows, columns)
        return shapes.HeightField(top * heights, (2 * x / (columns - 1), 2 * y / (rows - 1)), -bottom)

    def _chain(self, body: int) -> list[Joint]:
        """From the parent to the body: a joint for each of its joints, with links between that have no shape."""
        m, free = self.model, self.mj.mjtJoint
        parent = self._body_name(int(m.body_parentid[body]))
        offset = Pose.from_wxyz(m.body_pos[body], m.body_quat[body])
        first, count = m.body_jntadr[body], m.body_jntnum[body]
        chain = []
        for j in range(first, first + count):
            kind = {free.mjJNT_HINGE: "revolute", free.mjJNT_SLIDE: "prismatic"}.get(
                free(int(m.jnt_type[j])), "unreadable"
            )
            anchor, axis = m.jnt_pos[j].copy(), m.jnt_axis[j].copy()
            if kind == "revolute" and not m.jnt_limited[j]:
                kind = "continuous"
            origin = offset @ Pose(p=anchor)
            if kind != "unreadable":
                origin = origin @ _moved(kind, axis, -float(m.qpos0[m.jnt_qposadr[j]]))
            limits = m.jnt_range[j] if m.jnt_limited[j] else (-np.inf, np.inf)
            child = f"{self._body_name(body)}:{self._joint_name(j)}"
            chain.append(
                Joint(self._joint_name(j), kind, parent, child, origin, axis, float(limits[0]), float(limits[1]))
            )
            parent, offset = child, Pose(p=-anchor)
        if chain and not np.any(offset.p):
            last = chain.pop()
            return [*chain, Joint(**(vars(last) | {"child": self._body_name(body)}))]
        name = f"{self._body_name(body)}:fixed"
        return [*chain, Joint(name, "fixed", parent, self._body_name(body), offset, np.array([1.0, 0, 0]))]

    def _joints_of(self, articulation: str) -> list[int]:
        inside = set(self._subtree(self._roots[articulation]))
        scalar = (int(self.mj.mjtJoint.mjJNT_HINGE), int(self.mj.mjtJoint.mjJNT_SLIDE))
        return [
            j for j in range(self.model.njnt) if self.model.jnt_bodyid[j] in inside and self.model.jnt_type[j] in scalar
        ]

    def joint_positions(self, articulation: str) -> dict[str, float]:
        qpos, address = self.data.qpos, self.model.jnt_qposadr
        return {self._joint_name(j): float(qpos[address[j]]) for j in self._joints_of(articulation)}

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        return self._link_poses(articulation, self.data)

    def _link_poses(self, articulation: str, data: Any) -> dict[str, Pose]:
        self.mj.mj_kinematics(self.model, data)
        bodies = self._subtree(self._roots[articulation])
        return {self._body_name(body): Pose.from_wxyz(data.xpos[body], data.xquat[body]) for body in bodies}

    # --- contacts

    @cached_property
    def _pairs(self) -> set[tuple[int, int]]:
        """Named one by one in the model: these count whatever the filters say."""
        return {tuple(sorted(pair)) for pair in zip(self.model.pair_geom1, self.model.pair_geom2, strict=True)}  # type: ignore[misc]

    @cached_property
    def _excluded(self) -> set[int]:
        return set(self.model.exclude_signature.tolist())

    def may_collide(self, a: Any, b: Any) -> bool:
        m, flags = self.model, self.model.opt.disableflags
        if flags & int(self.mj.mjtDisableBit.mjDSBL_CONTACT):
            return False
        if (min(a, b), max(a, b)) in self._pairs:
            return True
        if not (m.geom_contype[a] & m.geom_conaffinity[b] or m.geom_contype[b] & m.geom_conaffinity[a]):
            return False
        x, y = sorted((int(m.geom_bodyid[a]), int(m.geom_bodyid[b])))
        if (x << 16) + y in self._excluded or (y << 16) + x in self._excluded:
            return False
        u, v = int(m.body_weldid[x]), int(m.body_weldid[y])
        if u == v:
            return False
        of_parent = [int(m.body_weldid[m.body_parentid[w]]) for w in (u, v)]
        related = u != 0 and v != 0 and (of_parent[0] == v or of_parent[1] == u)
        return not related or bool(flags & int(self.mj.mjtDisableBit.mjDSBL_FILTERPARENT))

    def filters(self) -> Hashable:
        m = self.model
        return (m.opt.disableflags, m.geom_contype.tobytes(), m.geom_conaffinity.tobytes())

    @contextlib.contextmanager
    def probe(self) -> Iterator[Probe]:
        yield _Probe(self)

    def touching(self) -> list[Touch]:
        return self._touching(self.data)

    def _touching(self, data: Any) -> list[Touch]:
        contact = data.contact
        return [
            Touch(int(pair[0]), int(pair[1]), -float(distance))
            for pair, distance in zip(contact.geom, contact.dist, strict=True)
            if distance < 0 and min(pair) >= 0
        ]

    # --- motion

    @property
    def time_step(self) -> float:
        return float(self.model.opt.timestep)

    def hold(self, articulation: str) -> None:
        self._controls[articulation] = _Control(self, self._joints_of(articulation))

    def command(self, articulation: str, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        self._controls[articulation].aim(positions, velocities, accelerations)

    def step(self) -> None:
        before = self._resets()
        self.mj.mj_step1(self.model, self.data)
        for control in self._controls.values():
            control.apply()
        if self.model.opt.integrator == int(self.mj.mjtIntegrator.mjINT_RK4):  # does not come in halves
            self.mj.mj_step(self.model, self.data)
        else:
            self.mj.mj_step2(self.model, self.data)
        if self._resets() > before:
            raise diverged("MuJoCo found a state that is not finite or too large, and has reset it")

    def _resets(self) -> int:
        """How often the state was found bad; MuJoCo then resets it."""
        bad = (self.mj.mjtWarning.mjWARN_BADQPOS, self.mj.mjtWarning.mjWARN_BADQVEL, self.mj.mjtWarning.mjWARN_BADQACC)
        return sum(int(self.data.warning[int(each)].number) for each in bad)


class _Probe(Probe):
    """A copy of MjData."""

    def __init__(self, simulator: MuJoCo) -> None:
        self.simulator = simulator
        self.data = copy.copy(simulator.data)

    def put(self, articulation: str, positions: Positions) -> None:
        model = self.simulator.model
        for j in self.simulator._joints_of(articulation):
            name = self.simulator._joint_name(j)
            if name in positions:
                self.data.qpos[model.jnt_qposadr[j]] = positions[name]

    def link_poses(self, articulation: str) -> dict[str, Pose]:
        return self.simulator._link_poses(articulation, self.data)

    def touching(self) -> list[Touch]:
        mj, model = self.simulator.mj, self.simulator.model
        for update in (mj.mj_kinematics, mj.mj_comPos, mj.mj_collision):
            update(model, self.data)
        return self.simulator._touching(self.data)


class _Control:
    """Servos get the target, with what their damping will take, and gravity and inertia are fed forward beside them.

    Motors, and joints without actuators, get the torque that brings the joint to the target.
    """

    def __init__(self, simulator: MuJoCo, joints: list[int]) -> None:
        self.simulator = simulator
        m = simulator.model
        self.names = [simulator._joint_name(j) for j in joints]
        self.dofs = m.jnt_dofadr[joints]
        self.addresses = m.jnt_qposadr[joints]
        self.target = simulator.data.qpos[self.addresses].copy()
        self.velocity = np.zeros(len(joints))
        self.acceleration = np.zeros(len(joints))
        self.named = np.zeros(len(joints), dtype=bool)
        self.actuators = [[_Actuator(simulator, a) for a in _actuators_of(simulator, j)] for j in joints]
        self.servo = np.array([any(actuator.servo for actuator in of) for of in self.actuators], dtype=bool)
        self.others = np.array([bool(of) for of in self.actuators]) | np.array(
            [_has_tendon(simulator, j) for j in joints]
        )

    def aim(self, positions: Positions, velocities: Positions, accelerations: Positions) -> None:
        for i, name in enumerate(self.names):
            if name in positions:
                for actuator in self.actuators[i]:
                    actuator.require_known(name)
                self.target[i], self.velocity[i] = positions[name], velocities[name]
                self.acceleration[i] = accelerations[name]
                self.named[i] = True

    def apply(self) -> None:
        m, data, mj = self.simulator.model, self.simulator.data, self.simulator.mj
        ours = self.named | ~self.others  # the rest is held by what the user tells their actuators
        error, rate = self.target - data.qpos[self.addresses], self.velocity - data.qvel[self.dofs]
        pull = np.where(self.servo, 0.0, STIFFNESS * error + DAMPING * rate)
        required, force = np.zeros(m.nv), np.zeros(m.nv)
        required[self.dofs] = np.where(ours, self.acceleration + pull, 0.0)
        mj.mj_mulM(m, data, force, required)
        torque = (force + data.qfrc_bias - data.qfrc_passive)[self.dofs]
        for i in np.flatnonzero(ours):
            motors = [actuator for actuator in self.actuators[i] if not actuator.servo]
            for actuator in self.actuators[i]:
                if actuator.servo:
                    actuator.follow(self.target[i], self.velocity[i])
            for actuator in motors:
                actuator.push(torque[i] / len(motors))
            data.qfrc_applied[self.dofs[i]] = 0.0 if motors else torque[i]


class _Actuator:
    """A position servo or a motor on one joint."""

    def __init__(self, simulator: MuJoCo, index: int) -> None:
        m, mj = simulator.model, simulator.mj
        self.simulator, self.index = simulator, index
        self.gear = float(m.actuator_gear[index, 0])
        self.gain, self.bias = float(m.actuator_gainprm[index, 0]), m.actuator_biasprm[index]
        plain = m.actuator_gaintype[index] == int(mj.mjtGain.mjGAIN_FIXED) and self.gain > 0
        plain = plain and m.actuator_dyntype[index] == int(mj.mjtDyn.mjDYN_NONE)
        kind = m.actuator_biastype[index]
        self.servo = bool(plain and kind == int(mj.mjtBias.mjBIAS_AFFINE) and self.bias[1] == -self.gain)
        self.motor = bool(plain and kind == int(mj.mjtBias.mjBIAS_NONE))
        addresses = getattr(m, "actuator_ctrladr", None)  # since MuJoCo 4.0
        self.ctrl = index if addresses is None else int(addresses[index])

    def require_known(self, joint: str) -> None:
        if not (self.servo or self.motor):
            raise NotSupported(
                f"actuator '{self.simulator._name('ACTUATOR', self.index) or self.index}' of joint '{joint}' is "
                "neither a position servo nor a motor; give the joint one of those, or none"
            )

    def follow(self, position: float, velocity: float) -> None:
        lead = -self.bias[2] / self.gain * velocity  # what the servo's damping will hold back
        self.simulator.data.ctrl[self.ctrl] = self.gear * (position + lead)

    def push(self, torque: float) -> None:
        self.simulator.data.ctrl[self.ctrl] = torque / (self.gear * self.gain)


def _actuators_of(simulator: MuJoCo, joint: int) -> list[int]:
    m, mj = simulator.model, simulator.mj
    on_joint = (int(mj.mjtTrn.mjTRN_JOINT), int(mj.mjtTrn.mjTRN_JOINTINPARENT))
    return [a for a in range(m.nu) if m.actuator_trntype[a] in on_joint and m.actuator_trnid[a, 0] == joint]


def _has_tendon(simulator: MuJoCo, joint: int) -> bool:
    """Is the joint moved by an actuator on a tendon, as a gripper's fingers are?"""
    m, mj = simulator.model, simulator.mj
    on_tendon = m.actuator_trntype == int(mj.mjtTrn.mjTRN_TENDON)
    for tendon in m.actuator_trnid[on_tendon, 0]:
        for wrap in range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon]):
            if m.wrap_type[wrap] == int(mj.mjtWrap.mjWRAP_JOINT) and m.wrap_objid[wrap] == joint:
                return True
    return False


def _moved(kind: str, axis: np.ndarray, value: float) -> Pose:
    if kind == "prismatic":
        return Pose(p=value * axis)
    half = value / 2
    return Pose.from_wxyz([0, 0, 0], [np.cos(half), *(np.sin(half) * axis)])
