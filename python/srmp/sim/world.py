"""A simulator's scene in a planner's world: read, kept up to date, grasped from and released into."""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from srmp import Error, InvalidArgument, MultiTrajectory, PlannerInterface, Pose, Trajectory
from srmp._names import did_you_mean
from srmp.sim.execution import Execution, by_robot, play
from srmp.sim.robots import Robot, match_robot, only_end, require_known, short_names
from srmp.sim.shapes import Shape, add_object, object_pose, placed_pose, require_readable, same_shape
from srmp.sim.simulator import Articulation, Body, Geometry, Simulator
from srmp.sim.urdf import to_urdf

logger = logging.getLogger("srmp.sim")

SAME_POSE = 1e-5  # [m] and [rad]: frames closer than that are one frame
LIMIT_TOLERANCE = 0.02  # [rad or m] by which a simulated joint, whose stop is soft, may be past its limit

# What `articulations` may say of a robot: these, and what add_articulation is told.
_OWN_KEYS = ("articulation", "self_collisions")
_DESCRIPTION_KEYS = (
    *("urdf_path", "urdf_text", "urdf_directory", "srdf_path", "srdf_text", "end_effector", "group", "joint_names"),
    *("fixed_joints", "package_dirs"),
)


@dataclass
class _Object:
    """An object of the planner."""

    body: str
    shape: Shape
    pose: Pose  # of the shape in the world, as last read
    key: Hashable
    put: Pose = field(default_factory=Pose)  # where the planner's object was put


class SimulatedWorld:
    """The scene that PlannerInterface.read_sim read, and the connection to its simulator.

    An object is named as its body, or "body/shape" where the body has several; of "world" bodies, as the shape.
    """

    def __init__(self, planner: PlannerInterface, simulator: Simulator, exclude: Sequence[str] = ()) -> None:
        self.planner = planner
        self.simulator = simulator
        self.exclude = frozenset(require_names("exclude", exclude))
        self.robots: dict[str, Robot] = {}
        self._objects: dict[str, _Object] = {}
        self._held: dict[str, tuple[str, str, list[str]]] = {}  # object: robot, link, touch links
        self._filters: Hashable = object()  # of the simulator, as last applied; at first, none were
        self._allowed: set[tuple[str, str]] = set()  # by these filters
        self._self_filtered: list[Robot] = []  # robots whose links they are applied to

    @property
    def differences(self) -> list[str]:
        """The differences between URDFs and simulator about the robots, as sentences."""
        return [sentence for robot in self.robots.values() for sentence in robot.differences]

    # --- reading

    def read(self, articulations: Mapping[str, Mapping[str, Any]]) -> None:
        """Adds robots and objects, all or none."""
        found = self._articulations()
        added: list[str] = []
        try:
            for name, description in articulations.items():
                self._add_robot(name, description, found, added)
            states, seen = self._joint_states(), self._read_objects(found)
            self._update(states, seen, found)
        except BaseException:
            for name in self._objects:
                self.planner.remove_object(name)
            for name in added:
                self.planner.remove_articulation(name)
            raise

    def require_excluded(self) -> None:
        """Raises InvalidArgument for a name in `exclude` that nothing has."""
        bodies = self.simulator.bodies()
        bodies += [link for articulation in self.simulator.articulations() for link in articulation.links]
        known = {body.name for body in bodies} | set(_named(bodies))
        for name in sorted(self.exclude):
            require_known("object in exclude:", name, dict.fromkeys(sorted(known)))

    def refresh(self, sim: Any = None) -> None:
        """Moves what moved, robots too, adds what is new, and removes what is gone; held objects move with their link.

        What the planner's user moved or removed of it is put back. sim: the scene in its new form, where the simulator
        makes another (a MuJoCo model that was compiled again). Raises InvalidArgument for a robot that is gone, has
        other joints or stands outside its limits, for numbers that are not finite, a name that an object of the user
        has, and an object that the user attached instead of grasp; then nothing was moved.
        """
        before = self.simulator
        if sim is not None and not before.is_of(sim):
            self.simulator = type(before)(sim)  # type: ignore[call-arg]
        try:
            found = self._articulations()
            for robot in self.robots.values():
                require_known("articulation", robot.articulation, found)
            states, seen = self._joint_states(), self._read_objects(found)
            self._require_ours(seen)
        except BaseException:
            self.simulator = before
            raise
        self._update(states, seen, found)

    def _update(
        self,
        states: Mapping[str, Mapping[str, float]],
        seen: Mapping[str, _Object],
        found: Mapping[str, Articulation],
    ) -> None:
        """Brings robots and objects up to date; filters of what is new, and of all where they changed."""
        new, filters = self._update_objects(seen, self._update_robots(states)), self.simulator.filters()
        if filters == self._filters:
            return self._apply_filters(new, found)
        for robot in self._self_filtered:
            self._filter_self(robot, found[robot.articulation])
        self._apply_filters(self._objects, found)
        self._filters = filters

    def _add_robot(
        self, name: str, description: Mapping[str, Any], found: Mapping[str, Articulation], added: list[str]
    ) -> None:
        if not isinstance(name, str) or not name:
            raise InvalidArgument(
                f"articulations has a robot called {name!r}; robots are called by strings that are not empty"
            )
        if not isinstance(description, Mapping):
            raise InvalidArgument(
                f"articulations['{name}'] is {description!r}; it is to be a dict such as {{'urdf_path': …}}, or empty"
            )
        for key in description:
            if key not in _OWN_KEYS + _DESCRIPTION_KEYS:
                raise InvalidArgument(
                    f"articulations['{name}'] has '{key}'; known: {', '.join(_OWN_KEYS + _DESCRIPTION_KEYS)}"
                    + did_you_mean(key, _OWN_KEYS + _DESCRIPTION_KEYS, before="; ")
                )
        where = self.simulator.name_of(description.get("articulation", name))
        articulation = require_known("articulation", where, found)
        for robot in self.robots.values():
            if robot.articulation == where:
                raise InvalidArgument(
                    f"robots '{robot.name}' and '{name}' are both articulation '{where}'; read it once"
                )
        options = {key: value for key, value in description.items() if key in _DESCRIPTION_KEYS}
        own = not ("urdf_path" in options or "urdf_text" in options)
        if own:
            links = short_names(link.name for link in articulation.links)
            joints = short_names(joint.name for joint in articulation.joints)
            options["urdf_text"] = to_urdf(articulation, links, joints)
            if "end_effector" not in options:
                options["end_effector"] = only_end(name, articulation, links)
        try:
            self.planner.add_articulation(name=name, **options)
        except TypeError as error:
            said = ", ".join(f"{key}={value!r}" for key, value in options.items() if key in description)
            raise InvalidArgument(
                f"articulations['{name}'] has a value of a wrong type among {said}; see what add_articulation takes"
            ) from error
        added.append(name)
        robot = match_robot(self.planner, name, articulation, list(self.simulator.link_poses(where)), own)
        self.robots[name] = robot
        self._compare_limits(robot, articulation)
        for sentence in robot.differences:
            logger.info(sentence)
        if description.get("self_collisions", own and self.simulator.self_collision(articulation.name)):
            self._self_filtered.append(robot)

    def _compare_limits(self, robot: Robot, articulation: Articulation) -> None:
        joints = {joint.name: joint for joint in articulation.joints}
        limits = self.planner.get_joint_limits(robot.name)
        for name, (lower, upper, _) in zip(self.planner.get_joint_names(robot.name), limits, strict=True):
            joint = joints[robot.joints[name]]
            theirs = (-np.inf, np.inf) if joint.kind == "continuous" else (joint.lower, joint.upper)
            if not np.allclose([lower, upper], theirs, atol=1e-4):
                robot.differences.append(
                    f"joint '{name}' of robot '{robot.name}' has limits [{lower:.6g}, {upper:.6g}] in the URDF and "
                    f"[{theirs[0]:.6g}, {theirs[1]:.6g}] in {self.simulator.kind}; the URDF's are kept"
                )

    def _filter_self(self, robot: Robot, articulation: Articulation) -> None:
        """Pairs of links that the simulator lets through each other."""
        names = {theirs: ours for ours, theirs in robot.links.items()}
        for i, a in enumerate(articulation.links):
            for b in articulation.links[:i]:
                if a.geometries and b.geometries:
                    pair = f"{robot.name}/{names[a.name]}", f"{robot.name}/{names[b.name]}"
                    self._filter(*pair, self._may_collide(a.geometries, b.geometries))

    def _filter(self, a: str, b: str, may_collide: bool) -> None:
        """Allows contact of the two where the simulator does not count it, and not any more where it does again."""
        if may_collide == ((a, b) in self._allowed):
            self.planner.set_allowed_collision(a, b, allowed=not may_collide)
            (self._allowed.discard if may_collide else self._allowed.add)((a, b))

    def _joint_states(self) -> dict[str, dict[str, float]]:
        """Of all robots, by the planner's names, as they stand in the simulator."""
        return {robot.name: self._joint_state(robot) for robot in self.robots.values()}

    def _joint_state(self, robot: Robot) -> dict[str, float]:
        positions = self.simulator.joint_positions(robot.articulation)
        self._require_same(robot, "joint", robot.joints, positions)
        self._require_same(robot, "link", robot.links | robot.merged, self.simulator.link_poses(robot.articulation))
        limits = self.planner.get_all_joint_limits(robot.name)
        within = {}
        for ours, theirs in robot.joints.items():
            lower, upper = limits[ours]
            value = positions[theirs]
            within[ours] = float(np.clip(value, lower, upper))
            if not abs(within[ours] - value) <= LIMIT_TOLERANCE:  # NaN neither
                raise InvalidArgument(
                    f"joint '{theirs}' stands at {value:.4g} in {self.simulator.kind}, outside the limits "
                    f"[{lower:.4g}, {upper:.4g}] of joint '{ours}' of robot '{robot.name}'"
                )
        return within

    def _require_same(self, robot: Robot, what: str, names: Mapping[str, str], there: Mapping[str, Any]) -> None:
        gone = [theirs for theirs in names.values() if theirs not in there]
        if gone:
            raise InvalidArgument(
                f"{what} '{gone[0]}' of robot '{robot.name}' is no longer in {self.simulator.kind}; "
                "call reset() of the planner, and read_sim again"
            )

    def _articulations(self) -> dict[str, Articulation]:
        return {articulation.name: articulation for articulation in self.simulator.articulations()}

    def _update_robots(self, states: Mapping[str, Mapping[str, float]]) -> NDArray[np.float64]:
        """Returns the middle of the robots' bases, (3,) [m]."""
        bases = [np.zeros(3)] if not states else []
        for name, state in states.items():
            self.planner.set_joint_positions(name, dict(state))
            base = self._base_pose(self.robots[name])
            self.planner.set_base_pose(name, base)
            bases.append(base.p)
        return np.mean(bases, axis=0)

    def _base_pose(self, robot: Robot) -> Pose:
        """By the matched link nearest to the root, the root itself if the simulator has it."""
        poses = self.simulator.link_poses(robot.articulation)
        q = self.planner.get_qpos(robot.name)
        here = self.planner.compute_fk(robot.name, q, self.planner.get_link_names(robot.name)[0])
        link = next(name for name in self.planner.get_link_names(robot.name) if name in robot.links)
        in_base = here.inverse() @ self.planner.compute_fk(robot.name, q, link)
        return poses[robot.links[link]] @ in_base.inverse()

    # --- objects

    def _read_objects(self, found: Mapping[str, Articulation]) -> dict[str, _Object]:
        """Shapes of bodies, and of links of articulations that are not robots, by names that no other has."""
        robots = {robot.articulation for robot in self.robots.values()}
        bodies = self.simulator.bodies()
        bodies += [link for name, other in found.items() if name not in robots for link in other.links]
        seen = {
            name: _Object(body.name, geometry.shape, body.pose @ geometry.pose, geometry.key)
            for name, (body, geometry) in _named(bodies).items()
            if not self.exclude & {name, body.name}
        }
        for name, item in seen.items():
            with _naming(name):
                require_readable(item.shape)
        return seen

    def _require_ours(self, seen: Mapping[str, _Object]) -> None:
        """Raises InvalidArgument for what refresh must not touch: see there."""
        present = set(self.planner.object_names)
        for name in seen:
            if name in present and name not in self._objects:
                raise InvalidArgument(
                    f"{self.simulator.kind} has a new object '{name}', and the planner has one of that name already; "
                    "remove that, or give it another name"
                )
            if name in present and name not in self._held:
                try:
                    self.planner.set_object_pose(name, self.planner.get_object_pose(name))
                except InvalidArgument as error:
                    raise InvalidArgument(
                        f"object '{name}' of {self.simulator.kind} was attached without grasp(); detach it, and call "
                        "grasp instead of attach_object"
                    ) from error

    def _update_objects(self, seen: Mapping[str, _Object], centre: NDArray[np.float64]) -> dict[str, _Object]:
        """Brings the planner's objects up to date, planes around `centre`; returns those that are new."""
        present = set(self.planner.object_names)
        for name in [name for name, old in self._objects.items() if not _still_there(old, seen.get(name))]:
            if name in present:
                self.planner.remove_object(name)
                present.remove(name)
        self._allowed = {pair for pair in self._allowed if pair[1] not in self._objects or pair[1] in present}
        self._objects = {name: old for name, old in self._objects.items() if name in present}
        self._held = {name: holder for name, holder in self._held.items() if name in present}
        new = {}
        for name, item in seen.items():
            old = self._objects.get(name)
            item.pose = object_pose(item.shape, item.pose, centre)
            if old is None:
                with _naming(name):
                    add_object(self.planner, name, item.shape, item.pose)
                new[name] = item
            elif name in self._held:
                self._place_in_hand(name, placed_pose(item.shape, item.pose))
            elif not (_same_pose(old.pose, item.pose) and _same_pose(old.put, self.planner.get_object_pose(name))):
                self.planner.set_object_pose(name, placed_pose(item.shape, item.pose))
            item.put = self.planner.get_object_pose(name)
            self._objects[name] = item
        return new

    def _apply_filters(self, objects: Mapping[str, _Object], found: Mapping[str, Articulation]) -> None:
        """Filters the contacts of these objects with robots, and of robots among each other, as the simulator does."""
        links = {robot.name: _link_geometries(robot, found) for robot in self.robots.values()}
        for robot, of_links in links.items():
            for link, geometries in of_links.items():
                for name, item in objects.items():
                    may_collide = any(self.simulator.may_collide(geometry.key, item.key) for geometry in geometries)
                    self._filter(f"{robot}/{link}", name, may_collide)
        for i, (robot, of_links) in enumerate(links.items()):
            for other, of_other in list(links.items())[:i]:
                for link, geometries in of_links.items():
                    for other_link, others in of_other.items():
                        pair = f"{robot}/{link}", f"{other}/{other_link}"
                        self._filter(*pair, self._may_collide(geometries, others))

    def _may_collide(self, a: Sequence[Geometry], b: Sequence[Geometry]) -> bool:
        return any(self.simulator.may_collide(x.key, y.key) for x in a for y in b)

    def names_of_keys(self) -> dict[Hashable, list[str]]:
        """The planner's names of each of the simulator's geometries: objects, and links as "robot/link"."""
        names: dict[Hashable, list[str]] = {}
        for name, item in self._objects.items():
            names.setdefault(item.key, []).append(name)
        found = self._articulations()
        for robot in self.robots.values():
            for link, geometries in _link_geometries(robot, found).items():
                for key in {geometry.key for geometry in geometries}:
                    names.setdefault(key, []).append(f"{robot.name}/{link}")
        return names

    def objects_of(self, body: Any) -> list[str]:
        """The planner's objects that were made of a body of the simulator."""
        body = body if isinstance(body, str) else self.simulator.name_of(body)
        names = [name for name, item in self._objects.items() if body in (item.body, name)]
        if not names:
            bodies = sorted({item.body for item in self._objects.values()})
            raise InvalidArgument(
                f"{self.simulator.kind} has no body {body!r} among those that were read"
                + (did_you_mean(body, bodies, before="; ") or f"; there are {', '.join(bodies) or 'none'}")
            )
        return names

    def is_of_robot(self, name: str) -> bool:
        """Returns whether this is a link of a robot, or an object that a robot holds."""
        return name in self._held or (name not in self._objects and self.split(name)[0] in self.robots)

    def is_held(self, name: str) -> bool:
        """Returns whether a robot holds this object."""
        return name in self._held

    def is_of_simulator(self, name: str) -> bool:
        """Returns whether this object, or the robot of this link, was read, not added by the planner's user."""
        return name in self._objects or bool(self.split(name)[0])

    def split(self, name: str) -> tuple[str, str]:
        """The robot of this world and the link that "robot/link" names; ("", name) if it is none."""
        robots = [robot for robot in self.robots if name.startswith(f"{robot}/")]
        robot = max(robots, key=len, default="")
        return robot, name.removeprefix(f"{robot}/") if robot else name

    def may_touch_in_simulator(self, a: str, b: str) -> bool:
        """Returns whether the simulator counts contact of these two, objects or links as "robot/link"."""
        return any(self.simulator.may_collide(x, y) for x in self._keys_of(a) for y in self._keys_of(b))

    def why_differ(self, a: str, b: str, seen_by: str) -> str:
        """Why `seen_by`, "planner" or the simulator's kind, may alone report that these two touch; "" = not known."""
        pairs = [(x, y) for x in self._keys_of(a) for y in self._keys_of(b)]
        if seen_by == "planner" and not all(self.simulator.may_collide(x, y) for x, y in pairs):
            return f"{self.simulator.kind} counts contact of some of their shapes only, the planner of all"
        reasons = (self.simulator.may_differ(x, y, seen_by) for x, y in pairs)
        return next(filter(None, reasons), "")

    def _keys_of(self, name: str) -> list[Hashable]:
        if name in self._objects:
            return [self._objects[name].key]
        robot, link = self.split(name)
        if not robot:
            return []  # something that the user added beside the simulator's
        return [geometry.key for geometry in _link_geometries(self.robots[robot], self._articulations()).get(link, ())]

    def with_own_models(self) -> SimulatedWorld:
        """The same scene read again into a planner of its own, with the simulator's models of all robots."""
        world = SimulatedWorld(PlannerInterface(), self.simulator, tuple(self.exclude))
        world.read(
            {
                robot.name: {
                    "articulation": robot.articulation,
                    "joint_names": self.planner.get_joint_names(robot.name),
                    "end_effector": self._last_moved_link(robot),
                }
                for robot in self.robots.values()
            }
        )
        return world

    def _last_moved_link(self, robot: Robot) -> str:
        """The end effector, or, where the simulator does not have it, the link that moves with the last joint."""
        end = self.planner.get_end_effector(robot.name)
        if end in robot.links:
            return end
        q = self.planner.get_qpos(robot.name)
        moved = [link for link in robot.links if np.any(self.planner.compute_jacobian(robot.name, q, link)[3:, -1])]
        return moved[0]

    # --- held bodies

    def grasp(self, body: Any, robot: str, link: str = "", touch_links: Sequence[str] | None = None) -> None:
        """Attaches the body to the robot, at its pose in the simulator.

        `link`: that it moves with; default the end effector. `touch_links`: links it may touch beside that; default
        those that it touches now in the simulator. Everything else is refreshed too. Raises InvalidArgument for
        unknown names and for a body that is held already.
        """
        require_known("robot", robot, self.robots)
        link = link or self.planner.get_end_effector(robot)
        if not isinstance(link, str):
            raise InvalidArgument(f"link is {link!r}; it is to be the name of a link")
        names = self.objects_of(body)
        for name in names:
            if name in self._held:
                raise InvalidArgument(
                    f"'{body}' is attached to robot '{self._held[name][0]}' already; release it first"
                )
        touched = None if touch_links is None else require_names("touch_links", touch_links)
        self.refresh()
        names = self.objects_of(body)
        touched = self._touched_links(names, robot) if touched is None else touched
        for name in names:
            self.planner.attach_object(name, robot, link, touched)
            self._held[name] = (robot, link, touched)

    def release(self, body: Any) -> None:
        """Detaches the body: an object of the world again, where it is in the simulator.

        Raises InvalidArgument when it is not held.
        """
        names = self.objects_of(body)
        for name in names:
            if name not in self._held:
                raise InvalidArgument(f"'{body}' is not held; grasp it first")
        for name in names:
            self._detach(name)
            del self._held[name]
        self.refresh()

    # --- motion

    def execute(
        self,
        trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory],
        robot: str | None = None,
        *,
        real_time: bool = False,
        settle_time: float = 0.5,
        on_step: Callable[[float], bool | None] | None = None,
    ) -> Execution:
        """Plays a trajectory, or those of several robots on one clock, with the simulator's own controllers.

        robot: that a single trajectory is of, where joint names do not say it. real_time: no faster than the clock.
        settle_time: [s] in which the last row stays the target. on_step: called after every step with the time [s];
        False stops. Afterwards the planner's world is refreshed, and the controllers hold what they last held.

        Raises InvalidArgument for unknown robots and joints, a trajectory without times, or one that starts more than
        0.05 rad (or m) from where the robot is; Error when the simulation diverges. After an error, on_step's too, the
        planner's world is refreshed where that is possible.
        """
        if not (isinstance(settle_time, Real) and math.isfinite(settle_time) and settle_time >= 0):
            raise InvalidArgument(f"settle_time is {settle_time!r}; it must be 0 s or more")
        if on_step is not None and not callable(on_step):
            raise InvalidArgument(f"on_step is {on_step!r}; it is to be a function that takes the time, or None")
        return play(self, by_robot(self, trajectory, robot), real_time, settle_time, on_step)

    def _touched_links(self, objects: Sequence[str], robot: str) -> list[str]:
        names = self.names_of_keys()
        links = set()
        with self.simulator.probe() as probe:
            for touch in probe.touching():
                a, b = names.get(touch.a, []), names.get(touch.b, [])
                for mine, other in ((a, b), (b, a)):
                    if set(mine) & set(objects):
                        links |= {link for owner, link in map(self.split, other) if owner == robot}
        return sorted(links)

    def _place_in_hand(self, name: str, pose: Pose) -> None:
        robot, link, touch_links = self._held[name]
        held = self._detach(name)
        self.planner.set_object_pose(name, pose)
        if held:
            self.planner.attach_object(name, robot, link, touch_links)
        else:
            del self._held[name]

    def _detach(self, name: str) -> bool:
        """False if the planner's user has detached it before."""
        try:
            self.planner.detach_object(name)
        except InvalidArgument:
            return False
        return True


@contextlib.contextmanager
def _naming(name: str) -> Iterator[None]:
    """Prefixes errors with the name of the object."""
    try:
        yield
    except Error as error:
        raise type(error)(f"object '{name}': {error}; exclude=['{name}'] leaves it out") from error


def require_names(argument: str, names: Any) -> list[str]:
    """The names; one alone may be a string. Raises InvalidArgument for anything else."""
    found = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else [names]
    if not all(isinstance(name, str) for name in found):
        raise InvalidArgument(f"{argument} is {names!r}; it is to be a list of names")
    return found


def require_planner(planner: Any) -> None:
    """Raises InvalidArgument unless this is a PlannerInterface."""
    if not isinstance(planner, PlannerInterface):
        raise InvalidArgument(f"planner is a {type(planner).__name__}; it is to be a PlannerInterface")


def world_of(planner: PlannerInterface) -> SimulatedWorld:
    """The simulated world of the planner. Raises InvalidArgument when there is none."""
    require_planner(planner)
    if not isinstance(planner.simulated_world, SimulatedWorld):
        raise InvalidArgument("the planner has read no simulator; call read_sim first")
    return planner.simulated_world


def _link_geometries(robot: Robot, found: Mapping[str, Articulation]) -> dict[str, tuple[Geometry, ...]]:
    """By the planner's link names; links without shapes are left out."""
    of = {link.name: link.geometries for link in found[robot.articulation].links}
    return {ours: of[theirs] for ours, theirs in (robot.links | robot.merged).items() if of[theirs]}


def _still_there(old: _Object, new: _Object | None) -> bool:
    return new is not None and same_shape(old.shape, new.shape)


def _same_pose(a: Pose, b: Pose) -> bool:
    return np.array_equal(a.p, b.p) and np.array_equal(a.q, b.q)


def _object_names(body: Body) -> Iterable[tuple[str, Geometry]]:
    single = len(body.geometries) == 1 and body.name not in ("", "world")
    for number, geometry in enumerate(body.geometries):
        name = geometry.name or str(number)
        if single:
            yield body.name, geometry
        elif geometry.name and body.name in ("", "world"):
            yield geometry.name, geometry
        else:
            yield f"{body.name}/{name}", geometry


def _named(bodies: Iterable[Body]) -> dict[str, tuple[Body, Geometry]]:
    """All shapes by the names of their objects; where one is taken already, it gets a number."""
    seen: dict[str, tuple[Body, Geometry]] = {}
    for body in bodies:
        for preferred, geometry in _object_names(body):
            name, number = preferred, 2
            while name in seen:
                name, number = f"{preferred}_{number}", number + 1
            seen[name] = body, geometry
    return seen
