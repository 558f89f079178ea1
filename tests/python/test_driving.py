"""Robots that drive: a planar base is planned together with the arm."""

import numpy as np
import pytest

import srmp
from srmp.bench import mbm
from srmp.demo import BOXES

PLANAR = [[-3, -3], [3, 3]]
NAMES = ["base/x", "base/y", "base/theta"]


def rooms():
    """arm7, which drives, in two rooms."""
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7", planar_bounds=PLANAR)
    return add_rooms(planner)


def add_rooms(planner):
    """Two rooms, a wall with a door of 0.9 m between them, and the demonstration's shelf in the second one."""
    planner.add_box("wall left", [0.1, 2.55, 2], srmp.Pose(p=[0, 1.725, 1]))
    planner.add_box("wall right", [0.1, 2.55, 2], srmp.Pose(p=[0, -1.725, 1]))
    planner.add_box("lintel", [0.1, 0.9, 0.2], srmp.Pose(p=[0, 0, 1.9]))
    for name, (size, centre) in BOXES.items():
        if name != "floor":
            planner.add_box(name, size, srmp.Pose(p=np.add(centre, [1, 1, 0])))
    return planner


def start_of(planner):
    q = np.zeros(len(planner.get_joint_names("arm7")))
    q[:2], q[3:] = [-1.5, -1.0], planner.get_group_states("arm7")["ready"][3:]
    return q


@pytest.fixture(scope="module")
def driven():
    planner = rooms()
    goal = srmp.Pose.from_rpy([1.60, 0.80, 0.55], [0.0, np.pi / 2, 0.0])  # in the shelf
    return planner, planner.plan(start_of(planner), goal)


def require_drive(planner, robot, trajectory, reached):
    """It goes through the door, ends with the end effector at a point, and touches nothing."""
    assert trajectory.joint_names[:3] == NAMES
    assert trajectory.certificate.holds
    path = trajectory.positions
    assert path[0, 0] < -1 < 0.5 < path[-1, 0]
    in_door = path[np.abs(path[:, 0]) < 0.1]
    assert len(in_door) > 0
    assert np.abs(in_door[:, 1]).max() < 0.45
    np.testing.assert_allclose(planner.compute_fk(robot, path[-1]).p, reached, atol=1e-3)
    for t in np.arange(0, trajectory.duration, 0.01):
        assert not planner.is_state_colliding(robot, trajectory.sample(t))


def test_a_robot_drives_through_a_door_and_reaches_into_a_shelf(driven):
    require_drive(driven[0], "arm7", driven[1], [1.60, 0.80, 0.55])


@pytest.mark.filterwarnings("ignore::srmp.RobotWarning")
def test_fetch_drives_through_a_door_and_reaches_into_a_shelf(mbm_data):
    files = mbm.robot_files(mbm_data, "fetch", "urdf")
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=str(files.urdf),
        srdf_path=str(files.srdf),
        name="fetch",
        end_effector=mbm.END_EFFECTORS["fetch"],
        group=mbm.GROUPS["fetch"],
        package_dirs=[str(files.directory)],
        planar_bounds=PLANAR,
    )
    add_rooms(planner)
    tucked = [1.32, 1.40, -0.2, 1.72, 0.0, 1.66, 0.0]
    start = np.concatenate([[-1.5, -1.0, 0.0, 0.0], tucked])  # the fourth joint lifts the torso
    trajectory = planner.plan(start, srmp.Pose.from_rpy([1.60, 0.80, 0.55], [0.0, 0.0, 0.0]))
    require_drive(planner, "fetch", trajectory, [1.60, 0.80, 0.55])


def test_the_same_drive_every_time(driven):
    planner = rooms()
    again = planner.plan(start_of(planner), srmp.Pose.from_rpy([1.60, 0.80, 0.55], [0.0, np.pi / 2, 0.0]))
    assert again == driven[1]


def test_a_closed_door_has_a_reason(driven):
    planner = rooms()
    planner.add_box("door", [0.1, 0.9, 1.8], srmp.Pose(p=[0, 0, 0.9]))
    planner.make_planner("arm7", {"planner_id": "wAstar", "time_limit": 0.3})
    with pytest.raises(srmp.PlanningError) as error:
        planner.plan(start_of(planner), driven[1].positions[-1])
    assert error.value.status in (srmp.Status.timed_out, srmp.Status.exhausted)


def test_saved_scenes_keep_the_base(tmp_path):
    planner = rooms()
    planner.save_scene(tmp_path / "scene.json")
    other = srmp.PlannerInterface()
    other.load_scene(tmp_path / "scene.json")
    assert other.get_joint_names("arm7") == planner.get_joint_names("arm7")
    q = start_of(planner)
    assert other.compute_fk("arm7", q) == planner.compute_fk("arm7", q)


def test_motion_limits_of_the_base():
    planner = rooms()
    planner.set_motion_limits("arm7", velocity={"base/x": 0.2, "base/y": 0.2, "base/theta": 0.5})
    goal = start_of(planner)
    goal[:3] += [1.0, 0, 0.5]
    trajectory = planner.plan(start_of(planner), goal)
    assert np.abs(trajectory.velocities[:, :2]).max() <= 0.2
    assert trajectory.duration > 5


@pytest.mark.parametrize(
    ("bounds", "sentence"),
    [
        ([[0, 0], [0, 1]], r"planar_bounds: x is from 0 to 0 m; the lower bound must be below the upper one"),
        ([[0, 2], [1, 1]], r"planar_bounds: y is from 2 to 1 m; the lower bound"),
        ([[0, 0], [np.nan, 1]], r"planar_bounds: x is from 0 to NaN m; bounds must be finite numbers"),
        ([[0, 0], [1e4, 1]], r"planar_bounds: x is from 0 to 10000 m; at most 1000 m are allowed"),
        ([0, 1], "planar_bounds"),
        ([[0, 0], [1, 1], [2, 2]], "planar_bounds has 3 rows; it takes two"),
        ("wide", "planar_bounds"),
    ],
)
def test_wrong_bounds_are_refused(bounds, sentence):
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.add_robot("arm7", planar_bounds=bounds)
    assert planner.robot_names == []
