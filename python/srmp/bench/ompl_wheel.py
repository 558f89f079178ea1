"""OMPL's planners of the `ompl` wheel (pip install ompl), with our collision checker.

The planners are OMPL's own C++ code; states and motions are checked through Python, which adds some microseconds to
each check. Their random numbers cannot be seeded for each plan.
"""

from __future__ import annotations

import functools
import importlib.metadata
import time
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

import srmp

PLANNERS = {"RRT-Connect": "RRTConnect", "RRT*": "RRTstar", "AORRTC": "AORRTC"}
"""Their names in tables, and in OMPL."""
_ANYTIME = ("RRT*", "AORRTC")


@functools.cache
def module() -> ModuleType | None:
    """The wheel's package, which is quiet from now on; None where it is not installed."""
    try:
        import ompl
        from ompl import base, geometric, util  # noqa: F401
    except ImportError:
        return None
    util.setLogLevel(util.LOG_NONE)
    return ompl


def version() -> str | None:
    """Of the wheel; None where it is not installed."""
    return importlib.metadata.version("ompl") if module() else None


def has(name: str) -> bool:
    """Whether the planner of this name can be run here."""
    ompl = module()
    return ompl is not None and name in PLANNERS and hasattr(ompl.geometric, PLANNERS[name])


def plan(
    planner: srmp.PlannerInterface,
    robot: str,
    start: npt.ArrayLike,
    goal: npt.ArrayLike,
    name: str,
    time_limit: float,
) -> dict[str, Any]:
    """{"status": "solved" or "timed_out", "plan_time_s", "waypoints": (n, dof) or None}.

    Planners that stop at their first path have it simplified, in the time that is left and with at least one pass; the
    others improve it until the time is over. Raises NotSupported for continuous joints.
    """
    ompl = module()
    assert ompl is not None
    ends = np.asarray(start, dtype=float), np.asarray(goal, dtype=float)
    information = _space_information(ompl, planner, robot)
    definition = ompl.base.ProblemDefinition(information)
    definition.setStartAndGoalStates(*(_state(information, q) for q in ends))
    if name in _ANYTIME:
        definition.setOptimizationObjective(ompl.base.PathLengthOptimizationObjective(information))
    search = getattr(ompl.geometric, PLANNERS[name])(information)
    search.setProblemDefinition(definition)
    search.setup()
    begin = time.perf_counter()
    search.solve(time_limit)
    solved = definition.hasExactSolution()
    path = definition.getSolutionPath() if solved else None
    if path is not None and name not in _ANYTIME:
        left = time_limit - (time.perf_counter() - begin)
        ompl.geometric.PathSimplifier(information).simplify(path, max(left, 1e-3))
    seconds = time.perf_counter() - begin
    if path is None:
        return {"status": "timed_out", "plan_time_s": seconds, "waypoints": None}
    dof = len(ends[0])
    rows = np.array([[path.getState(i)[j] for j in range(dof)] for i in range(path.getStateCount())])
    if len(rows) == 2:
        rows[0] = ends[0]  # AORRTC of OMPL 2.0.1 returns the goal twice where the straight line is free
    return {"status": "solved", "plan_time_s": seconds, "waypoints": rows}


def _space_information(ompl: ModuleType, planner: srmp.PlannerInterface, robot: str) -> Any:
    limits = planner.get_joint_limits(robot)[:, :2]
    if not np.isfinite(limits).all():
        raise srmp.NotSupported(f"robot '{robot}' has continuous joints, which are not planned by the ompl wheel here.")
    dof = len(limits)
    space, bounds = ompl.base.RealVectorStateSpace(dof), ompl.base.RealVectorBounds(dof)
    for j, (low, high) in enumerate(limits):
        bounds.setLow(j, float(low))
        bounds.setHigh(j, float(high))
    space.setBounds(bounds)
    information = ompl.base.SpaceInformation(space)
    checker = planner.collision_checker(robot)

    def row(state: Any) -> npt.NDArray[np.float64]:
        return np.array([[state[j] for j in range(dof)]])

    class Validity(ompl.base.StateValidityChecker):
        def isValid(self, state: Any) -> bool:
            return bool(checker.are_free(row(state))[0])

    class Motions(ompl.base.MotionValidator):
        def checkMotion(self, a: Any, b: Any, last: Any = None) -> bool:
            return bool(checker.motions_free(row(a), row(b))[0])

    information.setStateValidityChecker(Validity(information))
    information.setMotionValidator(Motions(information))
    information.setup()
    return information


def _state(information: Any, q: npt.NDArray[np.float64]) -> Any:
    state = information.allocState()
    for j, value in enumerate(q):
        state[j] = float(value)
    return state
