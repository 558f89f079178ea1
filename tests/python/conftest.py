import importlib
import os
import sys
from pathlib import Path

import numpy as np
import pytest

import srmp

sys.path.append(str(Path(__file__).parent))  # modules that tests share
pytest.register_assert_rewrite("clearance_worlds", "moveit_messages", "mplib_arm", "sim_checks", "support")

from support import NAMES, TIMES, analytic  # noqa: E402


def pytest_collection_modifyitems(items):
    """Genesis last: its first scene compiles for minutes."""
    items.sort(key=lambda item: "genesis" in item.nodeid)


def _mbm_data():
    """MotionBenchMaker's robots and problems, where SRMP_MBM_DIR says; None where it does not."""
    directory = os.environ.get("SRMP_MBM_DIR", "")
    return Path(directory) if directory and Path(directory, "panda", "panda.urdf").exists() else None


@pytest.fixture(scope="session")
def mbm_data():
    """MotionBenchMaker's data itself, for what is said of its robots and problems."""
    if (directory := _mbm_data()) is None:
        pytest.skip("set SRMP_MBM_DIR to a directory with MotionBenchMaker robots and problems to run this test")
    return directory


@pytest.fixture(scope="session", params=["own arm", "data"])
def mbm_dir(request, tmp_path_factory):
    """A directory as MotionBenchMaker's, with a Panda and its problems: the data, and a stand-in for any checkout."""
    if request.param == "data":
        return request.getfixturevalue("mbm_data")
    import stand_in

    return stand_in.write(tmp_path_factory.mktemp("mbm"))


@pytest.fixture(scope="session")
def stand_in_dir(tmp_path_factory):
    """The stand-in alone: for what is the same with any robot."""
    import stand_in

    return stand_in.write(tmp_path_factory.mktemp("mbm"))


@pytest.fixture(scope="session")
def suite():
    """Imports a program of bench/suites, which verifies results with Pinocchio's and Coal's Python packages."""
    sys.path.append(str(Path(__file__).parents[2] / "bench" / "suites"))

    def load(name):
        for package in ("pinocchio", "coal", "yaml"):
            pytest.importorskip(package, reason=f"the re-check needs {package}: pip install '.[test]'")
        return importlib.import_module(name)

    return load


@pytest.fixture(scope="session")
def sim_checks():
    """What every simulator has to show."""
    return importlib.import_module("sim_checks")


@pytest.fixture
def arm_alone():
    """The package's own arm in an empty scene, without a planner."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="arm",
        end_effector="arm7_hand",
    )
    return planner


@pytest.fixture
def arm(arm_alone):
    """The package's own arm on a table, with a box beside it and a quick planner."""
    planner = arm_alone
    planner.add_box("table", size=[2, 2, 0.1], pose=srmp.Pose(p=[0, 0, -0.051]))
    planner.add_box("post", size=[0.1, 0.1, 0.8], pose=srmp.Pose(p=[0.3, 0, 0.4]))
    planner.make_planner("arm", {"planner_id": "wAstar", "time_limit": 10})
    return planner


@pytest.fixture
def ready(arm):
    """A free configuration of the arm, off to one side."""
    return np.array(arm.get_group_states("arm")["ready"]) + np.array([0.9, 0, 0, 0, 0, 0, 0])


@pytest.fixture
def cubic():
    """Rows of a motion that is known at every time."""
    position, velocity, acceleration, _ = analytic(TIMES)
    return srmp.Trajectory(NAMES, position, TIMES, velocity, acceleration)


@pytest.fixture
def jumpy():
    """Rows that nothing but their positions and velocities ties together."""
    return srmp.Trajectory(
        NAMES,
        [[0, 0], [0.3, -0.2], [0.1, 0.4], [-0.5, 0.2]],
        [0, 0.4, 0.5, 1.5],
        [[0, 0], [0.5, 0.1], [-0.7, 0.3], [-0.2, -0.1]],
        waypoints=[[0, 0], [-0.5, 0.2]],
    )


@pytest.fixture
def untimed():
    """A path without times."""
    return srmp.Trajectory(NAMES, [[0, 0], [1, 1], [2, 0]])


@pytest.fixture(params=["cubic", "jumpy", pytest.param("untimed", id="path"), "planned"])
def any_trajectory(request, arm, ready):
    """Each of the three above, and one by a planner."""
    if request.param == "planned":
        return arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.1))
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="session")
def small_data_set(tmp_path_factory):
    """What generate() returns of data_sets.spec_of(); the files are there, and stay as they are."""
    from data_sets import spec_of

    from srmp.datasets.generation import generate

    return generate(spec_of(), tmp_path_factory.mktemp("datasets") / "one", workers=1)


@pytest.fixture
def client():
    """A connection to a PyBullet of its own."""
    import pybullet

    number = pybullet.connect(pybullet.DIRECT)
    yield number
    if pybullet.isConnected(number):
        pybullet.disconnect(number)
