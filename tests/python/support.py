"""What several test modules share, beside the fixtures of conftest.py."""

import time

import numpy as np
import pytest

import srmp
from srmp import GoalConstraint, GoalType
from srmp.robots._packages import PACKAGES

ERD = PACKAGES["example-robot-data"]()  # where the package's robots are; None where it is not installed
needs_example_robot_data = pytest.mark.skipif(ERD is None, reason="needs pip install example-robot-data")


def eventually(condition, seconds=20):
    """Waits until the condition is true, and fails when it is not after so many seconds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def refuses(call, sentence, kind=srmp.InvalidArgument):
    """The call is refused by one sentence, which matches."""
    with pytest.raises(kind, match=sentence) as error:
        call()
    assert "\n" not in str(error.value)


# Of the package's own arm: its hand 0.43 m in front of the base, fingers down.
READY = np.array([0, 0, 0, np.pi / 2, 0, np.pi / 2, 0])


def turned(angle):
    """Ready, turned about the vertical axis."""
    return READY + np.array([angle, 0, 0, 0, 0, 0, 0])


def joints(*targets):
    return GoalConstraint(GoalType.JOINTS, list(targets))


def arms(poses):
    """A planner with the package's own arm at each of these poses, by name."""
    planner = srmp.PlannerInterface()
    for name, pose in poses.items():
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_path=srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=pose,
        )
    return planner


def recheck_scenario(bases, objects=(), held=()):
    """The same arms for srmp.recheck: where they stand as [x, y, z, qx, qy, qz, qw], by name."""
    robots = {
        name: {
            "urdf": srmp.data_path("arm7.urdf"),
            "srdf": srmp.data_path("arm7.srdf"),
            "package_dirs": [],
            "base": base,
            "fixed_joints": {},
        }
        for name, base in bases.items()
    }
    return {"robots": robots, "held": list(held), "objects": list(objects)}


# Of the trajectories that conftest.py makes by hand: cubic, jumpy and untimed.
NAMES = ["a", "b"]
TIMES = np.array([0.5, 0.75, 1.5, 2.0, 3.0])


def analytic(t):
    """Joint a: t^3 - 2 t, joint b: 1 + 3 t^2. Position, velocity, acceleration, jerk: (k, 2) each."""
    t = np.asarray(t, dtype=float)
    columns = [
        (t**3 - 2 * t, 1 + 3 * t**2),
        (3 * t**2 - 2, 6 * t),
        (6 * t, 6 + 0 * t),
        (6 + 0 * t, 0 * t),
    ]
    return [np.stack(pair, axis=-1) for pair in columns]
