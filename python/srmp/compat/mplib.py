"""MPLib's planner interface, implemented with this planner: `from srmp.compat.mplib import Planner, Pose`.

The calls of MPLib 0.2.1 (https://github.com/haosulab/MPlib), and those of 0.1 that ManiSkill's solvers make. Lengths in
m, angles in rad, times in s; quaternions are [w, x, y, z] here, and nowhere else in srmp. docs/compat-mplib.md says
what differs.
"""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import srmp
from srmp._errors import checked
from srmp.compat._names import nearest, refuses_unknown, require_positive
from srmp.compat._pose import Array, Pose, screw
from srmp.compat._world import Box, Capsule, CollisionObject, Cone, Cylinder, Sphere, World, WorldCollisionResult

__all__ = ["Box", "Capsule", "CollisionObject", "Cone", "Cylinder", "Planner", "Pose", "Sphere", "WorldCollisionResult"]

logger = logging.getLogger(__name__)
Result = dict[str, Any]


@dataclass
class _Options:
    """What plan_qpos and plan_pose take besides, with MPLib's defaults; the last five are of 0.1 or have no effect."""

    time_step: float = 0.1
    planning_time: float = 1.0
    fix_joint_limits: bool = True
    simplify: bool = True
    verbose: bool = False
    use_point_cloud: bool = True
    use_attach: bool = True
    constraint_function: Callable[..., Any] | None = None
    constraint_jacobian: Callable[..., Any] | None = None
    constraint_tolerance: float = 1e-3
    no_simplification: bool = False
    rrt_range: float = 0.1
    planner_name: str = "RRTConnect"


class _ScrewFailed(Exception):
    pass


@refuses_unknown
class Planner(World):
    """One robot in a world, with MPLib's interface; `srmp` is the srmp.PlannerInterface that plans.

    A configuration (qpos) has a number for every joint of user_joint_names, or for those of the move group alone; then
    the others stay where they were. A pose is whatever Pose takes. Plans are dictionaries: status ("Success", or why
    there is none) and, with success, time (n,), position, velocity and acceleration (n, joints of the move group), and
    duration; rows are evenly spread, at most time_step apart. The motion is proved free between rows too, and the same
    request has the same result. Raises srmp.InvalidArgument for wrong arguments, srmp.NotSupported for what cannot be
    done here, and srmp.WrongType, which is a TypeError too, for unknown keywords.
    """

    _options = tuple(field.name for field in fields(_Options))

    @checked
    def __init__(
        self,
        urdf: str | Path,
        move_group: str,
        srdf: str | Path | None = None,
        new_package_keyword: str = "",
        use_convex: bool = False,
        user_link_names: Sequence[str] = (),
        user_joint_names: Sequence[str] = (),
        joint_vel_limits: ArrayLike | None = None,
        joint_acc_limits: ArrayLike | None = None,
        objects: Sequence[Any] = (),
        verbose: bool = False,
    ) -> None:
        """As MPLib's.

        move_group: the link that goals refer to; the joints that move it are planned. srdf: default the URDF's name
        with .srdf, if there is such a file, else allowed collisions are sampled; only an SRDF's rules of collisions are
        read. new_package_keyword: stands in for "package://". user_joint_names: all movable joints, in the order of
        qpos; default as MPLib has them. user_link_names: what link_id counts; default all. joint_vel_limits,
        joint_acc_limits: of the move group's joints, in user_joint_names' order; default 1 (velocities: the URDF's
        where that is lower). verbose: log more.
        """
        self._warned: set[str] = set()
        if len(objects):
            raise srmp.NotSupported("objects cannot be given to Planner; add_object adds them one by one")
        if use_convex:
            self._warn("use_convex", "convex meshes are taken as solids and all others as their triangles, always")
        super().__init__(Path(urdf), move_group, srdf, new_package_keyword, user_link_names, user_joint_names)
        slow = np.minimum(1.0, self.srmp.get_joint_limits(self._name)[:, 2])
        self.joint_vel_limits = slow if joint_vel_limits is None else np.asarray(joint_vel_limits)
        self.joint_acc_limits = np.ones(len(slow)) if joint_acc_limits is None else np.asarray(joint_acc_limits)
        self.srmp.set_motion_limits(self._name, self.joint_vel_limits, self.joint_acc_limits)
        self._log(verbose, "%s: plans %s of %s", self._name, self.move_group_joint_indices, self.user_joint_names)

    def __getattr__(self, name: str) -> Any:
        hint = nearest(name, [entry for entry in dir(type(self)) if not entry.startswith("_")])
        raise AttributeError(f"srmp.compat.mplib.Planner has no '{name}'{hint}; Planner.srmp has all that srmp can do")

    # --- plans

    def plan_qpos(
        self,
        goal_qposes: Iterable[ArrayLike],
        current_qpos: ArrayLike,
        *,
        fixed_joint_indices: Sequence[int] | None = None,
        **options: Any,
    ) -> Result:
        """To any one of a list of configurations.

        options: time_step=0.1 [s] between rows at most; planning_time=1 [s]; fix_joint_limits=True: begin at the limit
        where current_qpos is beyond it; simplify=True: shorten the path; verbose=False: log more;
        use_point_cloud=True, use_attach=True: False leaves clouds, or what is attached, out of this plan.
        """
        self._refuse_held("fixed_joint_indices", fixed_joint_indices)
        goals = [self.pad_move_group_qpos(goal)[self.move_group_joint_indices] for goal in goal_qposes]
        return self._plan(srmp.GoalConstraint(srmp.GoalType.JOINTS, goals), current_qpos, _Options(**options))

    def plan_pose(
        self,
        goal_pose: Any,
        current_qpos: ArrayLike,
        mask: Sequence[bool] | None = None,
        *,
        wrt_world: bool = True,
        **options: Any,
    ) -> Result:
        """To a pose of the move group's link, in the world or (wrt_world=False) the base's frame.

        options: as in plan_qpos.
        """
        self._refuse_held("mask", None if mask is None else np.flatnonzero(mask).tolist())
        goal = srmp.GoalConstraint(srmp.GoalType.POSE, self._in_world(goal_pose, wrt_world))
        return self._plan(goal, current_qpos, _Options(**options))

    def plan_qpos_to_qpos(
        self,
        goal_qposes: Iterable[ArrayLike],
        current_qpos: ArrayLike,
        time_step: float = 0.1,
        *,
        fixed_joint_indices: Sequence[int] | None = None,
        **options: Any,
    ) -> Result:
        """plan_qpos, as MPLib 0.1 calls it."""
        options |= {"time_step": time_step, "fixed_joint_indices": fixed_joint_indices}
        return self.plan_qpos(goal_qposes, current_qpos, **options)

    def plan_qpos_to_pose(
        self,
        goal_pose: Any,
        current_qpos: ArrayLike,
        mask: Sequence[bool] | None = None,
        time_step: float = 0.1,
        *,
        wrt_world: bool = True,
        **options: Any,
    ) -> Result:
        """plan_pose, as MPLib 0.1 calls it."""
        options |= {"time_step": time_step, "wrt_world": wrt_world}
        return self.plan_pose(goal_pose, current_qpos, mask, **options)

    def plan_screw(
        self,
        goal_pose: Any,
        current_qpos: ArrayLike,
        qpos_step: float = 0.1,
        time_step: float = 0.1,
        use_point_cloud: bool = True,
        use_attach: bool = True,
        wrt_world: bool = True,
        verbose: bool = False,
    ) -> Result:
        """Along the screw motion that leads to the pose: without a rotation, a straight line. Leaves it by 1 mm at
        most, measured half-way between waypoints.

        qpos_step: joint-space length [rad or m] between two waypoints at most. The others as in plan_pose.
        """
        require_positive(qpos_step=qpos_step, time_step=time_step)
        goal = self._in_world(goal_pose, wrt_world)
        with self._without(use_point_cloud, use_attach):
            start = self._stand(current_qpos, tolerance=1e-3)
            try:
                trajectory = self._in_time(self._follow_screw(start, goal, qpos_step), start)
            except _ScrewFailed as failure:
                self._log(verbose, "no plan: %s", failure)
                return {"status": f"Screw plan failed. {failure}"}
        return self._success(trajectory, time_step, verbose)

    def IK(
        self,
        goal_pose: Any,
        start_qpos: ArrayLike,
        mask: Sequence[bool] | None = None,
        *,
        n_init_qpos: int = 20,
        threshold: float = 1e-3,
        return_closest: bool = False,
        verbose: bool = False,
    ) -> tuple[str, list[Array] | Array | None]:
        """("Success", free configurations that bring the move group's link to goal_pose in the base's frame), or (why
        there are none, None).

        The nearest to start_qpos first; return_closest: that one alone. n_init_qpos: starts of the search. threshold:
        the largest Pose.distance that is accepted.
        """
        self._refuse_held("mask", None if mask is None else np.flatnonzero(mask).tolist())
        target, start = self._in_world(goal_pose, wrt_world=False), self._stand(start_qpos)
        found = self.srmp.compute_ik(self._name, target, reference=start, seeds=n_init_qpos)
        near = [q for q in found if Pose(self.srmp.compute_fk(self._name, q)).distance(target) < threshold]
        free = [q for q in near if not self.srmp.is_state_colliding(self._name, q)]
        self._log(verbose, "IK: %d configurations, %d of them free", len(near), len(free))
        if not near:
            return f"IK Failed! No configuration within limits brings '{self.move_group}' there.", None
        if not free:
            return f"IK Failed! In the nearest configuration {self.srmp.contacts(self._name, near[0])[0]}.", None
        full = [self.pad_move_group_qpos(q) for q in free]
        return "Success", full[0] if return_closest else full

    # --- beneath: plans

    def _plan(self, goal: srmp.GoalConstraint, current_qpos: ArrayLike, options: _Options) -> Result:
        require_positive(time_step=options.time_step, planning_time=options.planning_time)
        if options.constraint_function or options.constraint_jacobian or options.constraint_tolerance != 1e-3:
            raise srmp.NotSupported(
                "constraint_function, constraint_jacobian, constraint_tolerance: functions cannot be proved to hold "
                "between samples; Planner.srmp.plan takes constraints, a list of srmp.PathConstraint"
            )
        if options.rrt_range != 0.1:
            self._warn("rrt_range", "a search on a lattice takes its place, with steps of its own")
        if options.planner_name != "RRTConnect":
            self._warn("planner_name", "the planner is 'auto' always; Planner.srmp has the others")
        shortcut = options.simplify and not options.no_simplification
        self.srmp.make_planner(
            self._name, {"planner_id": "auto", "time_limit": options.planning_time, "shortcut": shortcut}
        )
        with self._without(options.use_point_cloud, options.use_attach):
            start = self._stand(current_qpos, math.inf if options.fix_joint_limits else 0)
            try:
                trajectory = self.srmp.plan(self._name, start, goal)
            except srmp.PlanningError as error:
                self._log(options.verbose, "no plan: %s", error)
                return {"status": f"{error.status.name}: {error}"}
        return self._success(trajectory, options.time_step, options.verbose)

    def _success(self, trajectory: srmp.Trajectory, time_step: float, verbose: bool) -> Result:
        self._log(verbose, "a plan of %g s", trajectory.duration)
        time = np.linspace(0, trajectory.duration, 1 + math.ceil(trajectory.duration / time_step))
        position, velocity, acceleration, _ = trajectory.state(time)
        rows = {"time": time, "position": position, "velocity": velocity, "acceleration": acceleration}
        return {"status": "Success", **rows, "duration": trajectory.duration}

    def _follow_screw(self, start: Array, goal: srmp.Pose, qpos_step: float) -> list[Array]:
        """Configurations along the screw: the straight motions between them leave it by less than half a millimetre."""
        pose_at = screw(self.srmp.compute_fk(self._name, start), goal)
        path, along, step = [start], 0.0, 1.0
        while along < 1:
            step = min(step, 1 - along)
            here, there = path[-1], pose_at(along + step)
            found = self.srmp.compute_ik(self._name, there, reference=here, max_solutions=1, seeds=1)
            if len(found) and np.linalg.norm(found[0] - here) <= qpos_step:
                off = Pose(self.srmp.compute_fk(self._name, (here + found[0]) / 2)).distance(pose_at(along + step / 2))
                if off < 5e-4:
                    path.append(found[0])
                    along, step = along + step, 2 * step
                    continue
            step /= 2
            if step < 1e-5:
                raise _ScrewFailed(
                    f"After {100 * along:.0f} % of the screw motion no configuration within limits is less than "
                    f"{qpos_step:g} rad further on; the "
                    f"joints are at {np.round(here, 3).tolist()}."
                )
        return path

    def _in_time(self, path: list[Array], start: Array) -> srmp.Trajectory:
        """With corners rounded by half a millimetre at most, and a certificate that holds."""
        checker = self.srmp.collision_checker(self._name)
        trajectory = srmp.time_parameterize(
            path,
            self.srmp.get_joint_names(self._name),
            self.srmp.motion_limits(self._name),
            blend_deviation=5e-4,
            reach=checker.reach,
            is_free=lambda a, b: bool(checker.motions_free(a[None], b[None])[0]),
        )
        certificate = self.srmp.verify(self._name, trajectory, start=start)
        if not certificate.holds:
            raise _ScrewFailed("; ".join(fault.text for fault in certificate.faults) + ".")
        return trajectory

    # --- beneath: messages

    def _refuse_held(self, argument: str, joints: Sequence[int] | None) -> None:
        for index in () if joints is None else joints:
            if not -len(self._qpos) <= index < len(self._qpos):
                raise srmp.InvalidArgument(f"{argument} names joint {index}; there are {len(self._qpos)}")
            if (name := self.user_joint_names[index]) in self._planned:
                raise srmp.NotSupported(
                    f"{argument} holds '{name}', which is planned; a Planner with a URDF where it is fixed can do that"
                )

    def _warn(self, argument: str, sentence: str) -> None:
        """Warns once for each Planner, at the line of the user."""
        if argument not in self._warned:
            warnings.warn(f"{argument} has no effect: {sentence}", stacklevel=5)
        self._warned.add(argument)

    def _log(self, verbose: bool, message: str, *values: Any) -> None:
        logger.log(logging.INFO if verbose else logging.DEBUG, message, *values)
