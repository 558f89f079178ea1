"""A robot and the objects around it, with the interface of MPLib's ArticulatedModel and PlanningWorld."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike

import srmp
from srmp._urdf import UrdfJoint, chain_links, joints_of
from srmp.compat._names import nearest, refuses_unknown, require_known
from srmp.compat._pose import Array, Pose, to_pose


# What update_attached_object and add_object take; MPLib's own (mplib.collision_detection.fcl) will do too.
class Box(NamedTuple):
    """Edge lengths `side` (3,) [m]."""

    side: ArrayLike


class Sphere(NamedTuple):
    """[m]"""

    radius: float


class Capsule(NamedTuple):
    """A cylinder of length `lz` along z with half spheres on its ends [m]."""

    radius: float
    lz: float


class Cylinder(NamedTuple):
    """Of length `lz` along z [m]."""

    radius: float
    lz: float


class Cone(NamedTuple):
    """Its apex at lz/2 on z, its base at -lz/2 [m]."""

    radius: float
    lz: float


class CollisionObject(NamedTuple):
    """A geometry and its pose in the world."""

    collision_geometry: Any
    pose: Any


class WorldCollisionResult(NamedTuple):
    """Two bodies in contact."""

    collision_type: str
    """self, self_attached, attached_attached, self_sceneobject or attached_sceneobject."""
    object_name1: str
    object_name2: str
    link_name1: str
    link_name2: str
    distance: float
    """[m], negative: how deep the two overlap."""


@dataclass(frozen=True)
class _Body:
    """An object that this module made, so that it can be replaced, removed for one plan and put back."""

    add: Callable[..., None]  # of name and pose
    pose: srmp.Pose  # in the world, or in the link that holds it
    link: str | None = None
    is_cloud: bool = False


@refuses_unknown
class World:
    """One robot and what is around it; `srmp` is the srmp.PlannerInterface that knows them."""

    def __init__(
        self,
        urdf: Path,
        move_group: str,
        srdf: str | Path | None,
        new_package_keyword: str,
        user_link_names: Sequence[str],
        user_joint_names: Sequence[str],
    ) -> None:
        self.srmp = srmp.PlannerInterface()
        self._bodies: dict[str, _Body] = {}
        tree, joints = _read_urdf(urdf, new_package_keyword)
        self._joints = _depth_first(joints)
        chain = set(chain_links(self._joints, move_group))
        movable = {joint.name: joint for joint in self._joints if joint.moves}
        self._planned = {name for name, joint in movable.items() if joint.child in chain and not joint.mimics}
        self._driven: set[str] = set()
        while more := {n for n, j in movable.items() if j.mimics in self._planned | self._driven} - self._driven:
            self._driven |= more
        changed = _as_mplib_reads(tree, self._planned, self._driven) or bool(new_package_keyword)

        links = list(dict.fromkeys(link for joint in self._joints for link in (joint.parent, joint.child)))
        self.user_link_names = list(user_link_names) or links
        self.user_joint_names = list(user_joint_names) or list(movable)
        require_known("user_link_names", self.user_link_names, links)
        require_known("user_joint_names", self.user_joint_names, movable)
        require_known("move_group", [move_group], self.user_link_names)
        if missing := sorted(set(movable) - set(self.user_joint_names)):
            raise srmp.InvalidArgument(f"user_joint_names lacks {missing}; every movable joint must be there")
        group = [name for name in self.user_joint_names if name in self._planned]
        if not srdf:
            srdf = beside if (beside := urdf.with_suffix(".srdf")).is_file() else None
        self.srmp.add_articulation(
            urdf_path="" if changed else str(urdf),
            urdf_text=ElementTree.tostring(tree, encoding="unicode") if changed else "",
            urdf_directory=str(urdf.parent) if changed else "",
            srdf_text=_collision_rules(Path(srdf), links) if srdf else "",
            end_effector=move_group,
            joint_names=group,
        )
        self._name = self.srmp.robot_names[0]
        self.move_group = move_group
        self.link_name_2_idx = {name: i for i, name in enumerate(self.user_link_names)}
        self.joint_name_2_idx = {name: i for i, name in enumerate(self.user_joint_names)}
        self.move_group_link_id = self.link_name_2_idx[move_group]
        self.move_group_joint_indices = [self.joint_name_2_idx[name] for name in group]
        self.joint_limits = np.array([[movable[n].lower, movable[n].upper] for n in self.user_joint_names])
        self._base = srmp.Pose()
        self._qpos = np.clip(np.zeros(len(movable)), *self.joint_limits.T)

    # --- the robot

    robot = property(lambda self: self, doc="MPLib's ArticulatedModel: this Planner, which has its commonest calls.")

    def get_name(self) -> str:
        """The URDF's."""
        return self._name

    def get_qpos(self) -> Array:
        """All joints, as last told by set_qpos or current_qpos."""
        return self._qpos.copy()

    def set_qpos(self, qpos: ArrayLike, full: bool = False) -> None:
        """Where the robot stands, on the limit where qpos is beyond it. full: qpos must hold all joints."""
        if full and np.size(qpos) != len(self._qpos):
            raise srmp.InvalidArgument(f"qpos has {np.size(qpos)} numbers; with full=True it has {len(self._qpos)}")
        self._stand(qpos)

    def get_base_pose(self) -> Pose:
        """Of the root link, in the world."""
        return Pose(self._base)

    def set_base_pose(self, pose: Any) -> None:
        """Place the root link in the world."""
        self.srmp.set_base_pose(self._name, to_pose(pose))
        self._base = to_pose(pose)

    def pad_move_group_qpos(self, qpos: ArrayLike) -> Array:
        """qpos with all joints, where it has those of the move group alone."""
        try:
            numbers = np.asarray(qpos, dtype=float)
        except (TypeError, ValueError):
            raise srmp.InvalidArgument(f"qpos must be numbers, but is {qpos!r}") from None
        if numbers.shape == self._qpos.shape:
            return numbers.copy()
        if numbers.shape != (len(self.move_group_joint_indices),):
            raise srmp.InvalidArgument(
                f"qpos has the shape {numbers.shape}; it must be {len(self._qpos)} numbers, of all joints "
                f"({', '.join(self.user_joint_names)}), or {len(self.move_group_joint_indices)}, of the move group"
            )
        result = self._qpos.copy()
        result[self.move_group_joint_indices] = numbers
        return result

    # --- collisions; state: default get_qpos()

    def check_for_self_collision(self, state: ArrayLike | None = None) -> list[WorldCollisionResult]:
        """Contacts of the robot and what it holds among themselves."""
        return [c for c in self.check_for_collision(state) if not c.collision_type.endswith("sceneobject")]

    def check_for_env_collision(self, state: ArrayLike | None = None) -> list[WorldCollisionResult]:
        """Contacts of the robot and what it holds with everything else."""
        return [c for c in self.check_for_collision(state) if c.collision_type.endswith("sceneobject")]

    def check_for_collision(self, state: ArrayLike | None = None) -> list[WorldCollisionResult]:
        """Both, deepest first."""
        with self._standing(state) as q:
            return [self._collision(contact) for contact in self.srmp.contacts(self._name, q)]

    def distance_to_collision(self, state: ArrayLike | None = None) -> float:
        """Of the nearest pair [m]; negative: how deep it overlaps."""
        with self._standing(state) as q:
            return self.srmp.distance_to_collision(self._name, q)

    # --- the world

    planning_world = property(
        lambda self: self, doc="MPLib's PlanningWorld: this Planner, which has its commonest calls."
    )

    def get_object_names(self) -> list[str]:
        """Sorted; attached ones and clouds too."""
        return self.srmp.object_names

    def update_point_cloud(self, points: ArrayLike, resolution: float = 1e-3, name: str = "scene_pcd") -> None:
        """Add a cloud (n, 3) [m], or replace the one of that name; every point fills a voxel of `resolution` [m]."""
        add = functools.partial(self.srmp.add_point_cloud, points=np.array(points), resolution=resolution)
        self._put(name, _Body(add, srmp.Pose(), is_cloud=True))

    def remove_point_cloud(self, name: str = "scene_pcd") -> bool:
        """False if there is none."""
        return self.remove_object(name)

    def add_object(self, name: str, collision_object: Any) -> None:
        """Add a CollisionObject, or replace the object of that name."""
        if hasattr(collision_object, "get_collision_geometry"):  # MPLib's
            collision_object = CollisionObject(collision_object.get_collision_geometry(), collision_object.pose)
        self._put(name, _Body(self._shape(collision_object.collision_geometry), to_pose(collision_object.pose)))

    def remove_object(self, name: str) -> bool:
        """Attached or not; False if there is none."""
        self._bodies.pop(name, None)
        if there := name in self.srmp.object_names:
            self.srmp.remove_object(name)
        return there

    def attach_object(self, name: str, art_name: str | None = None, link_id: int | str = -1, pose: Any = None) -> None:
        """Attach what add_object added, as update_attached_object does; pose: default as it lies now."""
        link = self._link(art_name, link_id)
        if name not in self._bodies:
            raise srmp.InvalidArgument(f"there is no object '{name}'{nearest(name, self._bodies)}")
        holder = self.srmp.compute_fk(self._name, self._qpos[self.move_group_joint_indices], link=link)
        in_link = holder.inverse() @ self.srmp.get_object_pose(name) if pose is None else to_pose(pose)
        self._put(name, replace(self._bodies[name], pose=in_link, link=link))

    def detach_object(self, name: str = "attached_geom", also_remove: bool = False) -> bool:
        """Leave it where the robot at get_qpos() holds it, or also_remove it; False if it is not attached."""
        if not self._is_held(name):
            return False
        if also_remove:
            return self.remove_object(name)
        self.srmp.detach_object(name)
        self._bodies[name] = replace(self._bodies[name], pose=self.srmp.get_object_pose(name), link=None)
        return True

    def update_attached_object(
        self,
        collision_geometry: Any,
        pose: Any,
        name: str = "attached_geom",
        art_name: str | None = None,
        link_id: int | str = -1,
    ) -> None:
        """Attach a geometry to a link (default: the move group's), at `pose` in the link's frame, or replace what has
        that name.

        It may touch the gripper: links that no planned joint moves against that link. link_id: a number in
        user_link_names, or a name.
        """
        link = self._link(art_name, link_id)
        self._put(name, _Body(self._shape(collision_geometry), to_pose(pose), link))

    def update_attached_sphere(
        self, radius: float, pose: Any, art_name: str | None = None, link_id: int | str = -1
    ) -> None:
        """Attach a sphere named "<robot>_<link number>_sphere", as update_attached_object."""
        self._attach("sphere", functools.partial(self.srmp.add_sphere, radius=radius), pose, art_name, link_id)

    def update_attached_box(
        self, size: ArrayLike, pose: Any, art_name: str | None = None, link_id: int | str = -1
    ) -> None:
        """Attach a box with edge lengths `size` (3,) [m], named "<robot>_<link number>_box"; see attach_object."""
        self._attach("box", functools.partial(self.srmp.add_box, size=size), pose, art_name, link_id)

    def update_attached_mesh(
        self, mesh_path: str | Path, pose: Any, art_name: str | None = None, link_id: int | str = -1
    ) -> None:
        """Attach a mesh file's surface named "<robot>_<link number>_mesh"; see attach_object."""
        self._attach("mesh", functools.partial(self.srmp.add_mesh, path=str(mesh_path)), pose, art_name, link_id)

    # --- beneath: where the robot stands

    def _stand(self, qpos: ArrayLike, tolerance: float = math.inf) -> Array:
        """Sets the robot to qpos, inside limits. Returns the planned joints, moved by `tolerance` at most for that."""
        given = self.pad_move_group_qpos(qpos)
        inside = np.clip(given, *self.joint_limits.T)
        positions = dict(zip(self.user_joint_names, inside.tolist(), strict=True))
        self.srmp.set_joint_positions(self._name, {n: q for n, q in positions.items() if n not in self._driven})
        self._qpos = inside
        return np.where(np.abs(given - inside) <= tolerance, inside, given)[self.move_group_joint_indices]

    @contextlib.contextmanager
    def _standing(self, state: ArrayLike | None) -> Iterator[Array]:
        """The robot at `state` during one query; yields its planned joints."""
        before = self._qpos
        try:
            yield self._stand(before if state is None else state, tolerance=0)
        finally:
            self._stand(before)

    def _in_world(self, pose: Any, wrt_world: bool) -> srmp.Pose:
        return to_pose(pose) if wrt_world else self._base @ to_pose(pose)

    # --- beneath: objects

    def _put(self, name: str, body: _Body) -> None:
        """Replaces the object of this name, which stays if the new one is refused."""
        old = self._bodies.get(name)
        if old is not None:
            self.srmp.remove_object(name)
        try:
            self._make(name, body)
        except Exception:
            if old is not None:
                self._make(name, old)
            raise
        self._bodies[name] = body

    def _make(self, name: str, body: _Body) -> None:
        body.add(name=name, pose=body.pose)
        if body.link is not None:
            self.srmp.attach_object(name, self._name, body.link, self._gripper(body.link), body.pose)

    @contextlib.contextmanager
    def _without(self, use_point_cloud: bool, use_attach: bool) -> Iterator[None]:
        """Removes clouds, or what is attached, for one plan."""
        removed = {
            name: body
            for name, body in self._bodies.items()
            if (body.is_cloud and not use_point_cloud) or (body.link is not None and not use_attach)
        }
        for name in removed:
            self.srmp.remove_object(name)
        try:
            yield
        finally:
            for name, body in removed.items():
                self._make(name, body)

    def _attach(self, kind: str, add: Callable[..., None], pose: Any, art_name: str | None, link_id: int | str) -> None:
        link = self._link(art_name, link_id)
        self._put(f"{self._name}_{self.link_name_2_idx[link]}_{kind}", _Body(add, to_pose(pose), link))

    def _link(self, art_name: str | None, link_id: int | str) -> str:
        if art_name not in (None, self._name):
            raise srmp.InvalidArgument(f"art_name is {art_name!r}; the only robot is '{self._name}'")
        if isinstance(link_id, str):
            require_known("link_id", [link_id], self.user_link_names)
            return link_id
        if not -1 <= link_id < len(self.user_link_names):
            raise srmp.InvalidArgument(f"link_id is {link_id}; it must be in 0..{len(self.user_link_names) - 1}, or -1")
        return self.move_group if link_id == -1 else self.user_link_names[link_id]

    def _gripper(self, link: str) -> list[str]:
        """Links that no planned joint moves against `link`: no plan can change their contact with what it holds."""
        gripper = {link}
        still = [(j.parent, j.child) for j in self._joints if j.name not in self._planned | self._driven]
        while more := {b for pair in still for a, b in (pair, pair[::-1]) if a in gripper} - gripper:
            gripper |= more
        return sorted(gripper)

    def _shape(self, geometry: Any) -> Callable[..., None]:
        """What adds a geometry, ours or MPLib's."""
        kind = type(geometry).__name__
        if kind == "Box":
            return functools.partial(self.srmp.add_box, size=geometry.side)
        if kind == "Sphere":
            return functools.partial(self.srmp.add_sphere, radius=geometry.radius)
        round_ = {"Capsule": self.srmp.add_capsule, "Cylinder": self.srmp.add_cylinder, "Cone": self.srmp.add_cone}
        if kind in round_:
            return functools.partial(round_[kind], radius=geometry.radius, length=geometry.lz)
        raise srmp.NotSupported(
            f"a geometry must be a Box, Sphere, Capsule, Cylinder or Cone, but is {geometry!r}; update_attached_mesh "
            "attaches meshes, Planner.srmp.add_mesh adds them"
        )

    def _collision(self, contact: srmp.Contact) -> WorldCollisionResult:
        links = self.srmp.get_link_names(self._name)
        roles = ("self", "attached", "sceneobject")

        def role(body: str) -> int:
            return 0 if body in links else 1 if body == contact.body_a or self._is_held(body) else 2

        pair = sorted((contact.body_a, contact.body_b), key=role)
        kind = "_".join(roles[role(body)] for body in pair)
        owners = [self._name if body in links else body for body in pair]
        return WorldCollisionResult("self" if kind == "self_self" else kind, *owners, *pair, contact.distance)

    def _is_held(self, name: str) -> bool:
        return name in self._bodies and self._bodies[name].link is not None


def _read_urdf(urdf: Path, new_package_keyword: str) -> tuple[ElementTree.Element, list[UrdfJoint]]:
    try:
        keyword = (new_package_keyword or "package://").encode()
        tree = ElementTree.fromstring(urdf.read_bytes().replace(b"package://", keyword))
        return tree, joints_of(tree)
    except (OSError, ValueError, ElementTree.ParseError):
        srmp.PlannerInterface().add_articulation(urdf_path=str(urdf))  # says where and what
        raise


def _as_mplib_reads(tree: ElementTree.Element, planned: set[str], driven: set[str]) -> bool:
    """Changes a URDF to what MPLib makes of it: mimics (fingers) are free, as in simulators, but for those of planned
    joints; the velocity limits of planned joints need not be there. Returns whether there was anything to change."""
    changed = False
    for joint in tree.findall("joint"):
        mimic, limit, name = joint.find("mimic"), joint.find("limit"), joint.get("name")
        if mimic is not None and name not in driven:
            joint.remove(mimic)
            changed = True
        if name in planned and (limit is None or float(limit.get("velocity", 0)) <= 0):
            limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
            limit.set("velocity", "1")
            changed = True
    return changed


def _collision_rules(srdf: Path, links: list[str]) -> str:
    """An SRDF's rules of collisions of these links. MPLib reads no more, so the rest may be another robot's."""
    try:
        tree = ElementTree.fromstring(srdf.read_bytes())
    except (OSError, ElementTree.ParseError) as error:
        raise srmp.FileError(f"SRDF file '{srdf}' cannot be read: {error}") from None
    for entry in list(tree):
        named = {entry.get(key) for key in ("link", "link1", "link2")} - {None}
        if not entry.tag.endswith("_collisions") or not named <= set(links):
            tree.remove(entry)
    return ElementTree.tostring(tree, encoding="unicode")


def _depth_first(joints: list[UrdfJoint]) -> list[UrdfJoint]:
    """The order of Pinocchio, and so MPLib's: each joint after its parents, siblings by name."""
    order: list[UrdfJoint] = []

    def visit(link: str) -> None:
        for joint in sorted((j for j in joints if j.parent == link), key=lambda j: j.name):
            order.append(joint)
            visit(joint.child)

    children = {joint.child for joint in joints}
    for root in dict.fromkeys(joint.parent for joint in joints if joint.parent not in children):
        visit(root)
    return order
