"""The viewer in the browser, on viser."""

from __future__ import annotations

import atexit
import contextlib
import html
import io
import queue
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import srmp
from srmp._errors import checked
from srmp.viewer._drawing import Drawing, make_drawing
from srmp.viewer._failure import Failure, touches_together
from srmp.viewer._html import FIELD_OF_VIEW, view
from srmp.viewer._motion import Motion, trajectories_of
from srmp.viewer._panel import Panel
from srmp.viewer._scene import ROBOT_KINDS, copied, frame_poses, read_scene
from srmp.viewer._search import searched, sentence
from srmp.viewer._stage import Marks, Stage
from srmp.viewer._tree import drawn_tree, said, trees_of

if TYPE_CHECKING:
    from srmp import MultiTrajectory, PlannerInterface, Pose, Trajectory

_FOLLOW_PERIOD = 0.2  # [s] between two looks at the planner that is watched
_MAX_DELAY = 1.0  # [s] between two changes that are taken over while others follow
_FRAME_PERIOD = 1 / 30  # [s] of a motion that plays
_GOAL_OPACITY = 0.4
_PATH_COLOUR, _WORSE_COLOUR = (11, 122, 117), (170, 175, 182)
_MAX_CANDIDATES = 8  # configurations of a goal, of which the first without contacts is shown


class Viewer:
    """A planner's scene in the browser: robots, objects, motions, goals to drag, and why plans fail.

    It works on a copy of the planner's scene, which it renews when the scene changes; the planner is never used while
    it plans, and nothing that is done in the browser reaches it. Use it as a context manager, or close it.
    """

    @checked
    def __init__(
        self,
        planner: PlannerInterface,
        trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory] | None = None,
        *,
        kinds: Sequence[str] | None = None,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        """Serves the page at host:port; PlannerInterface.show explains the arguments, and what is raised."""
        viser = _import_viser()
        _require_address(host, port)
        chosen = trajectories_of(planner, trajectory) if trajectory is not None else None
        drawing = make_drawing(planner, chosen, kinds=kinds)
        self._watched, self._world = planner, copied(planner)
        self._kinds = tuple(kinds or dict.fromkeys(b.kind for b in drawing.scene.bodies if b.kind in ROBOT_KINDS))
        with _quiet():
            self._server = viser.ViserServer(host=host, port=port, label="srmp", verbose=False)
        self._host = host
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._closed = threading.Event()
        self._motion: Motion | None = None
        self._time, self._playing = 0.0, False
        self._goals: dict[str, NDArray[np.float64]] = {}  # configurations, by robot whose handle was moved
        self._dragged: dict[str, Pose] = {}
        self.goals: dict[str, Pose] = {}  #: poses of end effectors, by robot whose handle was moved
        self.trajectory: Mapping[str, Trajectory] = {}  #: what plays, by robot
        self._stage = Stage(self._server, "/scene")
        self._ghost = Stage(self._server, "/goals", _GOAL_OPACITY, lambda body: body.robot in self._goals)
        self._marks = Marks(self._server)
        self._path_nodes: list[str] = []
        self._search_nodes: list[Any] = []  # handles of what was searched
        self._nodes: list[srmp.ConstraintNode] = []  # of the constraint trees that are shown
        self._found: list[NDArray[np.float64]] = []  # paths (n, dof) of the plan that runs, each better than the last
        self._worse: list[NDArray[np.float64]] = []  # (n, 3) [m] the paths of end effectors along all but the best
        self._handles: dict[str, Any] = {}
        self._panel = Panel(self._server, self._kinds, self)
        self._set_camera(drawing)
        self._draw(drawing)
        for kind in self._kinds[1:]:
            self._stage.switch(kind, False)
            self._ghost.switch(kind, False)
        self._seen = _signature(planner)
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._work, self._follow, self._animate)]
        for thread in self._threads:
            thread.start()
        atexit.register(self.close)  # a thread must not outlive the library that it uses

    # --- for programs

    @property
    def url(self) -> str:
        """Where the page is."""
        host = "localhost" if self._host in ("0.0.0.0", "127.0.0.1") else self._host
        return f"http://{host}:{self._server.get_port()}"

    @property
    def status(self) -> str:
        """What the panel says: of the last plan, or of a goal that cannot be reached."""
        return self._panel.status

    def update(self) -> None:
        """Takes over the planner's scene and last result now, rather than within some tenths of a second.

        Raises Error while another thread plans with the planner.
        """
        self._seen = _signature(self._watched)
        self._adopt(copied(self._watched), wait=True)

    @checked
    def play(self, trajectory: Trajectory | MultiTrajectory | Mapping[str, Trajectory] | None = None) -> None:
        """Plays a trajectory of the scene's robots from its start; None: the one that is there.

        Raises InvalidArgument for a trajectory that is none of the robots'.
        """
        if trajectory is not None:
            chosen = trajectories_of(self._world, trajectory)
            self._run(lambda: self._draw(make_drawing(self._world, chosen, kinds=self._kinds)), wait=True)
        self._time, self._playing = 0.0, self._motion is not None

    @checked
    def show_search(self, trace: srmp.SearchTrace | None) -> None:
        """Draws what was searched, where the end effector is there; None: no longer. Stays until the next call.

        Of a constraint tree, the panel has the tree with a slider for its nodes, as show_conflict. Raises
        InvalidArgument where neither a lattice nor a constraint tree was searched, and UnknownRobot where the scene has
        not its robot.
        """
        segments = searched(self._world, trace) if trace is not None else []
        with self._server.atomic():
            while self._search_nodes:
                self._search_nodes.pop().remove()
            for k, one in enumerate(segments):
                colours = np.broadcast_to(np.round(255 * np.array(one.colour)).astype(np.uint8), one.points.shape)
                self._search_nodes.append(
                    self._server.scene.add_line_segments(f"/search/{k}", one.points.astype(np.float32), colours)
                )
        self._nodes = list(trace.constraint_nodes) if trace is not None else []
        self._panel.show_tree(*self._tree_at(0))
        self._panel.say(sentence(trace) if trace is not None else "")

    def show_conflict(self, node: int) -> None:
        """Places the robots where the step begins in which the first conflict of a node of a constraint tree is.

        Links that touch there are red; within the step, others may.

        node: 0 is the first that was opened. Raises InvalidArgument for a number that is none of a node.
        """
        if isinstance(node, bool) or not isinstance(node, int) or not 0 <= node < len(self._nodes):
            raise srmp.InvalidArgument(
                f"node must be a whole number from 0 to {len(self._nodes) - 1}, but is {node!r}"
                if self._nodes
                else "there is no constraint tree: show_search shows a SearchTrace that has one"
            )
        self._run(lambda: self._show_conflict(node), wait=True)

    @checked
    def set_goal(self, robot: str, pose: Pose) -> None:
        """Moves the handle of a robot's end effector to a pose in the world, as dragging it does.

        Raises InvalidArgument for an unknown robot, and for what is no pose.
        """
        if not isinstance(pose, srmp.Pose):
            raise srmp.InvalidArgument(f"pose must be a Pose, but is {pose!r}")
        self._world.get_end_effector(robot)  # refuses unknown robots
        self._handles[robot].position, self._handles[robot].wxyz = pose.p, np.asarray(pose.q)[[3, 0, 1, 2]]
        self._dragged[robot] = pose
        self._run(self._take_goals, wait=True)

    def plan(self) -> None:
        """Plans from where the robots stand to the goals of the handles, as the button does; returns when it has."""
        self._run(self._plan, wait=True)

    def wait(self) -> None:
        """Returns when the viewer is closed, or with Ctrl-C."""
        with contextlib.suppress(KeyboardInterrupt):
            while not self._closed.wait(0.2):
                pass

    def close(self) -> None:
        """Ends the server."""
        if not self._closed.is_set():
            self._closed.set()
            atexit.unregister(self.close)
            self._world._stop_plans(True)
            self._jobs.put(None)
            for thread in self._threads:
                thread.join()
            with _quiet():
                self._server.stop()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Viewer({self.url}{', closed' if self._closed.is_set() else ''})"

    # --- for the panel, whose callbacks come in threads of the server

    def on_plan(self) -> None:
        self._run(self._plan)

    def on_reset_goals(self) -> None:
        self._run(self._reset_goals)

    def on_stand_here(self) -> None:
        """The robots stand where they are shown: plans begin there."""
        self._run(self._stand_here)

    def on_play(self) -> None:
        if self._motion is None:
            return
        if not self._playing and self._time >= self._motion.duration:
            self._time = 0.0
        self._playing = not self._playing

    def on_seek(self, moment: float) -> None:
        self._playing = False
        self._show_time(moment)

    def on_switch(self, kind: str, visible: bool) -> None:
        self._run(lambda: self._switch(kind, visible))

    def on_node(self, place: int) -> None:
        self._run(lambda: self._show_conflict(place))

    # --- what the worker does, one job after the other

    def _run(self, job: Callable[[], None], wait: bool = False) -> None:
        done = threading.Event()

        def guarded() -> None:
            try:
                job()
            except srmp.Error as error:
                self._panel.say(str(error), failed=True)
            finally:
                done.set()

        self._jobs.put(guarded)
        while wait and not done.wait(0.05) and not self._closed.is_set():
            pass

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _draw(self, drawing: Drawing) -> None:
        self._stage.show(drawing.scene)
        self._motion, self.trajectory = drawing.motion, drawing.motion.trajectories if drawing.motion else {}
        for robot, rows in drawing.motion.configurations.items() if drawing.motion else ():
            self._world.set_qpos(robot, rows[0])  # plans begin where the motion does, until "Stand here"
        self._show_handles()
        self._time = 0.0
        self._panel.show_motion(drawing.motion, drawing.plots, drawing.notes)
        self._panel.show_panels(drawing.panels)
        self._show_paths(drawing)
        self._show_failure(drawing.failure)
        self._playing = drawing.motion is not None

    def _show_failure(self, failure: Failure | None) -> None:
        touches = failure.touches if failure else []
        self._marks.show(touches)
        self._stage.paint(label for touch in touches for label in touch.bodies)
        if failure:
            self._stage.place(failure.poses)
            self._panel.say(f"{failure.status}: {failure.reason}", failed=True)

    def _tree_at(self, place: int) -> tuple[str, int, int]:
        """The tree of a node as HTML, the node's place, and how many nodes there are."""
        if not self._nodes:
            return "", 0, 0
        node = self._nodes[place]
        (title, nodes), *_ = [tree for tree in trees_of(self._nodes) if tree[1][0].tree == node.tree]
        return (
            f"{title}<br>node {node.number}: {html.escape(said(node))}{drawn_tree(nodes, node)}",
            place,
            len(self._nodes),
        )

    def _show_conflict(self, place: int) -> None:
        if place >= len(self._nodes):
            return
        self._playing = False
        configurations = self._nodes[place].configurations
        touches = touches_together(self._world, configurations)
        self._stage.place(frame_poses(self._world, configurations))
        self._marks.show(touches)
        self._stage.paint(label for touch in touches for label in touch.bodies)
        self._panel.show_tree(*self._tree_at(place))

    def _show_paths(self, drawing: Drawing) -> None:
        """The paths of end effectors, and those of worse paths that the planner found before."""
        for name in self._path_nodes:
            self._server.scene.remove_by_name(name)
        worse = [(f"/paths/worse{k}", path, _WORSE_COLOUR) for k, path in enumerate(self._worse)]
        best = [(f"/paths/of {robot.replace('/', '|')}", path, _PATH_COLOUR) for robot, path in drawing.paths.items()]
        for name, path, colour in worse + best:
            segments = np.stack([path[:-1], path[1:]], axis=1).astype(np.float32)
            self._server.scene.add_line_segments(name, segments, colors=colour, thickness=0.004)
        self._path_nodes = [name for name, *_ in worse + best]
        self._worse = []

    def _show_handles(self) -> None:
        """A handle at the end effector of each robot; handles that were moved stay."""
        for robot in set(self._handles) - set(self._world.robot_names):
            self._handles.pop(robot).remove()
        for robot in self._world.robot_names:
            if robot not in self._handles:
                name = f"/handles/{robot.replace('/', '|')}"
                handle = self._server.scene.add_transform_controls(name, scale=0.22, line_width=3.0)
                handle.on_update(lambda event, robot=robot: self._on_drag(robot, event.target))
                self._handles[robot] = handle
            if robot not in self.goals:
                rows = self._motion.configurations.get(robot) if self._motion else None
                pose = self._world.compute_fk(robot, self._world.get_qpos(robot) if rows is None else rows[-1])
                self._handles[robot].position = pose.p
                self._handles[robot].wxyz = np.asarray(pose.q)[[3, 0, 1, 2]]

    def _on_drag(self, robot: str, handle: Any) -> None:
        waiting = bool(self._dragged)
        self._dragged[robot] = srmp.Pose.from_wxyz(handle.position, handle.wxyz)
        if not waiting:  # else the worker takes the newest pose when it comes to it
            self._run(self._take_goals)

    def _take_goals(self) -> None:
        dragged, self._dragged = self._dragged, {}
        for robot, pose in dragged.items():
            if robot not in self._world.robot_names:
                continue
            self.goals[robot] = pose
            near = self._goals.get(robot, self._world.get_qpos(robot))
            found = self._world.compute_ik(robot, pose, near, max_solutions=_MAX_CANDIDATES)
            if not len(found):
                self._panel.say(f"'{robot}' does not reach this goal", failed=True)
                continue
            free = (q for q in found if not self._world.is_state_colliding(robot, q))
            self._goals[robot] = next(free, found[0])
            self._panel.say(f"goal of '{robot}': {', '.join(f'{x:.3f}' for x in pose.p)} m")
        self._show_goals()

    def _show_goals(self) -> None:
        """The robots at their goals, translucent, with what touches there."""
        self._ghost.show(self._stage.scene)
        self._ghost.place(frame_poses(self._world, self._goals))
        touches = touches_together(self._world, self._goals)
        self._marks.show(touches)
        faulty = {label for touch in touches for label in touch.bodies}
        self._ghost.paint(faulty)
        self._stage.paint(label for label in faulty if "/" not in label)  # objects: robots stand elsewhere
        if touches:
            self._panel.say("; ".join(touch.text for touch in touches), failed=True)

    def _reset_goals(self) -> None:
        self.goals.clear()
        self._goals.clear()
        self._show_handles()
        self._show_goals()
        self._panel.say("")

    def _stand_here(self) -> None:
        if self._motion is not None:
            k = int(np.searchsorted(self._motion.times, self._time - 1e-9))
            for robot, rows in self._motion.configurations.items():
                self._world.set_qpos(robot, rows[min(k, len(rows) - 1)])
        self._draw(Drawing(read_scene(self._world, self._kinds), None, None, {}))

    def _plan(self) -> None:
        if not self.goals:
            return self._panel.say("drag the handle of an end effector first, which sets its goal", failed=True)
        self._panel.say("planning …")
        self._found = []
        self._marks.show([])
        starts = {name: self._world.get_qpos(name) for name in self._world.robot_names}
        robot = next(iter(self.goals))
        trajectory: Any = None
        with contextlib.suppress(srmp.PlanningError):  # the drawing shows why
            if len(starts) == 1:
                trajectory = self._world.plan(robot, starts[robot], self.goals[robot], self._show_better)
            else:
                trajectory = self._world.plan_multi(starts, dict(self.goals))
        for waypoints in self._found[:-1]:
            path = srmp.Trajectory(self._world.get_joint_names(robot), waypoints, np.arange(len(waypoints)))
            rows = path.sample(np.linspace(0, len(waypoints) - 1, 20 * len(waypoints)))
            self._worse.append(np.array([self._world.compute_fk(robot, q).p for q in rows]))
        self._draw(make_drawing(self._world, trajectory, kinds=self._kinds))
        if trajectory is not None:
            seconds = self._world.get_planning_stats()["plan_time_s"]
            self._panel.say(f"solved in {1e3 * seconds:.1f} ms; " + "; ".join(self._panel.notes))

    def _show_better(self, solution: dict[str, Any], waypoints: NDArray[np.float64]) -> None:
        """A path that is better than those before, while the planner still improves it."""
        self._found.append(np.array(waypoints))
        bound = f", at most {solution['bound']:.3g} times the optimum" if np.isfinite(solution["bound"]) else ""
        self._panel.say(f"planning … {solution['cost_rad']:.3f} rad after {solution['time_s']:.2f} s{bound}")

    def _switch(self, kind: str, visible: bool) -> None:
        if visible and kind not in self._kinds:
            scene = read_scene(self._world, [kind])  # refuses what cannot be read
            if not any(body.kind == kind for body in scene.bodies):
                raise srmp.InvalidArgument(f"the robots have no {kind} geometry")
            self._kinds = (*self._kinds, kind)
            self._stage.show(read_scene(self._world, self._kinds))
        self._stage.switch(kind, visible)
        self._ghost.switch(kind, visible)
        self._show_time(self._time)

    def _adopt(self, world: PlannerInterface, wait: bool = False) -> None:
        """Continues with another scene."""

        def adopt() -> None:
            self._world = world
            for robot in set(self.goals) - set(world.robot_names):
                self.goals.pop(robot)
                self._goals.pop(robot, None)
            self._draw(make_drawing(world, kinds=self._kinds))
            if self._goals:
                self._show_goals()

        self._run(adopt, wait)

    # --- threads

    def _follow(self) -> None:
        """Looks whether the planner's scene or result has changed; while it plans, it refuses, and is left alone.

        Changes that come one after the other are taken over together, or once a second.
        """
        before, adopted = self._seen, 0.0
        while not self._closed.wait(_FOLLOW_PERIOD):
            with contextlib.suppress(srmp.Error):
                seen = _signature(self._watched)
                at_rest, before = seen == before, seen
                if seen != self._seen and (at_rest or time.monotonic() > adopted + _MAX_DELAY):
                    world, self._seen = copied(self._watched), seen
                    adopted = time.monotonic()
                    self._adopt(world)

    def _animate(self) -> None:
        before = time.perf_counter()
        while not self._closed.wait(_FRAME_PERIOD):
            now = time.perf_counter()
            if self._playing:
                self._show_time(self._time + (now - before) * self._panel.speed)
            before = now

    def _show_time(self, moment: float) -> None:
        motion = self._motion
        if motion is None or len(motion.poses[0]) != len(self._stage.scene.frames):
            return
        self._time = min(max(moment, 0.0), motion.duration)
        if self._time >= motion.duration:
            self._playing = False
        k = int(np.searchsorted(motion.times, self._time - 1e-9))
        self._stage.place(motion.poses[min(k, len(motion.times) - 1)])
        self._panel.show_time(self._time)

    def _set_camera(self, drawing: Drawing) -> None:
        place = view(drawing)["camera"]
        flat = np.cos(place["pitch"])
        back = np.array([flat * np.cos(place["yaw"]), flat * np.sin(place["yaw"]), np.sin(place["pitch"])])
        target = np.array(place["target"])
        self._server.scene.set_up_direction("+z")
        self._server.initial_camera.position = target + place["distance"] * back
        self._server.initial_camera.look_at = target
        self._server.initial_camera.fov = FIELD_OF_VIEW


def _import_viser() -> Any:
    try:
        import viser
    except ImportError as error:
        raise srmp.NotSupported("the viewer needs viser: pip install '.[viewer]' in the checkout") from error
    return viser


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without viser's banner: a library prints nothing."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def _require_address(host: object, port: object) -> None:
    if not isinstance(host, str) or not _is_of_this_machine(host):
        raise srmp.InvalidArgument(f"host must be the name of this machine or one of its addresses, but is {host!r}")
    if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port <= 65535:
        raise srmp.InvalidArgument(f"port must be a whole number from 0 to 65535, but is {port!r}")


def _is_of_this_machine(host: str) -> bool:
    """Whether one can serve there: viser would wait for ever for a server at another address."""
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM) if host else []
    except (OSError, ValueError, TypeError):  # there is no such name, or it is no text of a name
        return False
    for family, kind, _, _, address in found:  # a name may have an address of a family that is switched off
        with contextlib.suppress(OSError), socket.socket(family, kind) as listener:
            listener.bind(address)
            return True
    return False


def _signature(planner: PlannerInterface) -> tuple[Any, ...]:
    """Differs after every change of the scene that is seen, but for a new shape of an old name at an old pose."""
    statistics = planner.get_planning_stats()
    return (
        [(name, tuple(planner.get_object_pose(name))) for name in planner.object_names],
        [
            (name, planner.get_qpos(name).tolist(), [tuple(planner.compute_fk(name, planner.get_qpos(name), link))])
            for name in planner.robot_names
            for link in planner.get_link_names(name)
        ],
        planner.last_result is not None,
        (statistics["status"], statistics["reason"], statistics["total_time_s"], statistics["plan_time_s"]),
    )
