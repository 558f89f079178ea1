"""An arm as MPLib's users have it, and what every plan of srmp.compat.mplib has to be."""

import numpy as np
from support import READY

import srmp
from srmp.compat.mplib import Planner

TURN = np.array([0.9, 0, 0, 0, 0, 0, 0])
ANY = READY + TURN
DOWN = [0, 1, 0, 0]  # w, x, y, z: half a turn about x
P = [0.45, 0.25, 0.35]  # with Q, a pose of the hand within reach
Q = np.array([0.3, 0.9, 0.2, 0.1]) / np.linalg.norm([0.3, 0.9, 0.2, 0.1])  # w, x, y, z: all different


def arm_planner():
    return Planner(srmp.data_path("arm7.urdf"), "arm7_hand", srdf=srmp.data_path("arm7.srdf"))


def hand(planner, q):
    """The move group's pose, in the world."""
    return planner.srmp.compute_fk(planner.get_name(), q)


def assert_a_plan(planner, result, start, time_step):
    assert result["status"] == "Success"
    n, dof = len(result["time"]), len(planner.move_group_joint_indices)
    assert all(result[key].shape == (n, dof) for key in ("position", "velocity", "acceleration"))
    steps = np.diff(result["time"])
    assert np.ptp(steps) < 1e-9 and 0.5 * time_step < steps[0] <= time_step * (1 + 1e-12)
    assert result["time"][0] == 0 and result["time"][-1] == result["duration"]
    np.testing.assert_array_equal(result["position"][0], start)
    np.testing.assert_allclose(result["velocity"][[0, -1]], 0, atol=1e-9)
    assert (np.abs(result["velocity"]) <= np.asarray(planner.joint_vel_limits) + 1e-6).all()
    assert (np.abs(result["acceleration"]) <= np.asarray(planner.joint_acc_limits) + 1e-6).all()
    motion = planner.srmp.collision_checker(planner.get_name())
    assert motion.are_free(result["position"]).all()
