"""Checks that every simulator must pass, on a scene of its own."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import srmp
from srmp.sim import SimulatedWorld, check_parity


def panda(mbm_dir: Path) -> dict[str, Any]:
    """Its URDF and SRDF, as read_sim is told of them."""
    directory = mbm_dir / "panda"
    return {
        "urdf_path": str(directory / "panda.urdf"),
        "srdf_path": str(directory / "panda.srdf"),
        "end_effector": "panda_hand",
        "package_dirs": [str(directory)],
    }


def parity(planner: srmp.PlannerInterface, sim: object, samples: int = 1000) -> None:
    """Link poses equal, no unexplained difference, and enough collisions for that to mean something."""
    report = check_parity(planner, sim, samples=samples)
    print(report)
    assert report.links_agree, str(report)
    assert not report.unexplained, str(report)
    assert report.collisions["planner"] > samples // 20, str(report)


def random_free(planner: srmp.PlannerInterface, robot: str, random: np.random.Generator) -> np.ndarray:
    limits = planner.get_joint_limits(robot)[:, :2]
    while True:
        q = random.uniform(np.maximum(limits[:, 0], -np.pi) + 0.05, np.minimum(limits[:, 1], np.pi) - 0.05)
        if planner.distance_to_collision(robot, q) > 0.01:
            return q


def executes_random_plans(world: SimulatedWorld, robot: str, count: int = 10, seed: int = 0) -> None:
    """From where the robot is to random places: it gets there, and touches nothing that it may not.

    The clearance is for the simulator's controller, which follows a motion to a fraction of a millimetre.
    """
    planner, random = world.planner, np.random.default_rng(seed)
    planner.make_planner(robot, {"planner_id": "auto", "time_limit": 10, "clearance": 0.002})
    done = 0
    while done < count:
        world.refresh()
        goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, random_free(planner, robot, random))
        try:
            trajectory = planner.plan(robot, planner.get_qpos(robot), goal)
        except srmp.PlanningError as error:
            assert error.status in (srmp.Status.timed_out, srmp.Status.exhausted), error
            continue
        execution = world.execute(trajectory)
        assert execution.final_error <= 0.01, execution.final_error
        assert not execution.unexpected_contacts, [str(contact) for contact in execution.unexpected_contacts]
        done += 1


def avoids_what_moved(world: SimulatedWorld, robot: str, put: Callable[[srmp.Pose], object], size: float) -> None:
    """A box put into the way of a plan: after refresh() the plan is in collision, and the new plan is not.

    put: moves the box of edge `size`, in the simulator.
    """
    planner = world.planner
    planner.make_planner(robot, {"planner_id": "auto", "time_limit": 10})
    random = np.random.default_rng(5)
    while True:
        start, end = planner.get_qpos(robot), random_free(planner, robot, random)
        goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, end)
        first = planner.plan(robot, start, goal)
        middle = planner.compute_fk(robot, first.sample(first.duration / 2))
        reach = [np.linalg.norm(planner.compute_fk(robot, q).p - middle.p) for q in (start, end)]
        if min(reach) > size + 0.25:  # the hand does not touch the box at either end
            break
    put(srmp.Pose(p=middle.p))
    world.refresh()
    assert not planner.verify(robot, first).holds
    again = planner.plan(robot, start, goal)
    assert planner.verify(robot, again).holds
    execution = world.execute(again)
    assert execution.final_error <= 0.01
    assert not execution.unexpected_contacts, [str(contact) for contact in execution.unexpected_contacts]
