"""plan_multi(..., obstacles=): arms planned around motions that others are committed to."""

from math import pi

import numpy as np
import pytest
from support import arms, recheck_scenario

import srmp

NAN = float("nan")


@pytest.fixture
def two():
    """Two of the package's arms across a table, 0.6 m apart: their hands conflict half-way."""
    planner = arms({"left": srmp.Pose(), "right": srmp.Pose.from_rpy([0.6, 0, 0], [0, 0, pi])})
    planner.add_box("table", size=[3, 3, 0.1], pose=srmp.Pose(p=[0.3, 0, -0.051]))
    planner.make_planner(["left"], {"planner_id": "xECBS", "time_limit": 20})
    return planner


def turned(angle):
    """The hand in front of the arm, which is turned about its base."""
    return np.array([angle, 0, 0, pi / 2, 0, pi / 2, 0])


def goal(q):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


def sweep(planner, duration=3.0, first=-0.9, last=0.9):
    """Smooth: at rest at both ends."""
    rows = np.array([turned(first), turned(last)])
    return srmp.Trajectory(planner.get_joint_names("right"), rows, [0, duration], np.zeros((2, 7)))


def plan(planner, obstacle, start=-0.9, end=0.9):
    return planner.plan_multi({"left": turned(start)}, {"left": goal(turned(end))}, obstacles={"right": obstacle})


def via(planner, times, angles):
    """At rest at each of the angles of the other arm's base."""
    rows = np.array([turned(angle) for angle in angles])
    return srmp.Trajectory(planner.get_joint_names("right"), rows, times, np.zeros((len(times), 7)))


def wait(trajectory):
    moved = np.flatnonzero((trajectory.positions != trajectory.positions[0]).any(axis=1))
    return trajectory.times[moved[0] - 1]


BASES = {"left": [0, 0, 0, 0, 0, 0, 1], "right": [0.6, 0, 0, 0, 0, 1, 0]}
WAITS = pytest.mark.parametrize(("duration", "way"), [(0.8, (-0.9, 0.9)), (0.8, (0.9, -0.9)), (2.0, (0.9, -0.9))])


@WAITS
def test_it_waits_until_the_other_has_passed(two, duration, way):
    obstacle = sweep(two, duration)
    trajectory = plan(two, obstacle, *way)["left"]
    assert trajectory.times[0] == 0
    assert 0 < wait(trajectory) <= duration
    assert not trajectory.velocities[:2].any()
    certificate = trajectory.certificate
    assert certificate.holds
    assert certificate.proved_free
    assert certificate.clearance_proved > 0
    np.testing.assert_allclose(trajectory.positions[-1], turned(way[1]), atol=1e-9)
    stats = two.get_planning_stats()
    assert stats["makespan_s"] == trajectory.duration
    assert stats["flow_time_s"] == pytest.approx(trajectory.duration)


@pytest.mark.parametrize("duration", [0.8, 2.0, 5.0])
@pytest.mark.parametrize("way", [(-0.9, 0.9), (0.9, -0.9)], ids=["against", "with"])
def test_the_arms_keep_apart_all_the_time(two, duration, way):
    """At each instant the other arm is set there, and the scene is queried, which knows nothing of plans and times."""
    obstacle = sweep(two, duration)
    trajectory = plan(two, obstacle, *way)["left"]
    two.remove_object("table")  # stands below, 1 mm under the bases
    least = np.inf
    for time in np.arange(0, max(duration, trajectory.duration) + 0.02, 0.02):
        two.set_qpos("right", obstacle.sample(time))
        q = trajectory.sample(time)
        assert not two.is_state_colliding("left", q)
        least = min(least, two.distance_to_collision("left", q))
    assert least > 0
    assert trajectory.certificate.clearance_proved <= least + 1e-9


def tables(motions):
    return {
        name: {
            "joint_names": motion.joint_names,
            "times": motion.times,
            "positions": motion.positions,
            "velocities": motion.velocities,
        }
        for name, motion in motions.items()
    }


def contacts_at_1_khz(suite, motions):
    """By Pinocchio and Coal alone."""
    recheck = suite("recheck_multi")
    world = recheck.World(recheck_scenario(BASES))
    found = (world.touching(q) for q in recheck.motion(world, tables(motions), 1000.0)[1])
    return [pair for pair in found if pair]


@WAITS
def test_pinocchio_and_coal_find_no_contact_at_1_khz(two, suite, duration, way):
    obstacle = sweep(two, duration)
    trajectory = plan(two, obstacle, *way)["left"]
    assert contacts_at_1_khz(suite, {"left": trajectory, "right": obstacle}) == []
    # Begun at once, they would collide.
    at_once = trajectory.slice(wait(trajectory), trajectory.times[-1])
    at_once = srmp.Trajectory(
        at_once.joint_names, at_once.positions, at_once.times - at_once.times[0], at_once.velocities
    )
    assert contacts_at_1_khz(suite, {"left": at_once, "right": obstacle})


def test_straight_motions_and_sudden_stops_are_obstacles_too(two):
    """No velocities: straight between rows."""
    rows = np.array([turned(angle) for angle in (-0.9, 0.3, -0.2, 0.9)])
    obstacle = srmp.Trajectory(two.get_joint_names("right"), rows, [0, 0.7, 1.1, 2.0])
    trajectory = plan(two, obstacle)["left"]
    assert trajectory.certificate.proved_free
    for time in np.arange(0, max(2.0, trajectory.duration), 0.02):
        two.set_qpos("right", obstacle.sample(time))
        assert not two.is_state_colliding("left", trajectory.sample(time))


def test_ten_thousand_straight_rows_are_proved_as_one_motion(two):
    """As a controller records them. Row by row it would not be over within the time limit, nor soon after."""
    times = np.linspace(0, 10, 10001)
    motion = srmp.Trajectory(two.get_joint_names("right"), [turned(0.3 * np.sin(t)) for t in times], times)
    certificate = plan(two, motion)["left"].certificate
    assert certificate.holds
    assert certificate.proved_free


@pytest.mark.parametrize("planner_id", ["CBS", "ECBS", "xECBS", "prioritised", "auto"])
@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
def test_every_planner_for_many_plans_for_one(two, planner_id, timing):
    two.make_planner("left", {"planner_id": planner_id, "timing": timing, "time_limit": 20})
    for start in (-0.9, 0.0):  # the second where the other arm passes
        trajectory = plan(two, sweep(two), start)["left"]
        assert trajectory.certificate.proved_free
        assert trajectory.certificate.holds
        np.testing.assert_allclose(trajectory.positions[[0, -1]], [turned(start), turned(0.9)], atol=1e-9)


@pytest.mark.parametrize("case", [(0.8, -0.9), (2.0, -0.9), (2.0, 0.0)], ids=["waits", "goes round", "makes way"])
def test_without_certificates_it_moves_the_same(two, case):
    duration, start = case
    certified = plan(two, sweep(two, duration), start)["left"]
    two.make_planner("left", {"planner_id": "xECBS", "time_limit": 20, "certify": False})
    bare = plan(two, sweep(two, duration), start)["left"]
    assert bare.certificate is None
    assert bare.times.tobytes() == certified.times.tobytes()
    assert bare.positions.tobytes() == certified.positions.tobytes()


@pytest.mark.parametrize("case", [(0.8, -0.9), (2.0, -0.9), (2.0, 0.0)], ids=["waits", "goes round", "makes way"])
def test_the_same_every_time(two, case):
    duration, start = case
    first, second = (plan(two, sweep(two, duration), start)["left"] for _ in range(2))
    assert first.times.tobytes() == second.times.tobytes()
    assert first.positions.tobytes() == second.positions.tobytes()
    assert first.velocities.tobytes() == second.velocities.tobytes()


MAKES_WAY = {  # times and angles of the other arm's base; where this one starts and ends; when it must be there
    "and goes on": ([0, 2], [-0.9, 0.9], (0.0, 0.9), 2.0),
    "and comes back": ([0, 2], [-0.9, 0.9], (0.0, 0.0), 2.5),
    "and is where the other will end": ([0, 2], [-0.9, 0.0], (0.0, 0.9), 2.0),
    "twice": ([0, 1, 3, 4, 6], [-1.5, -1.5, 1.5, 1.5, -1.5], (-0.3, 0.0), 6.5),
}


@pytest.mark.parametrize("case", MAKES_WAY)
def test_it_leaves_a_start_that_is_swept(two, suite, case):
    times, angles, (start, end), latest = MAKES_WAY[case]
    obstacle = via(two, times, angles)
    resting = srmp.Trajectory(two.get_joint_names("left"), [turned(start)], [0], np.zeros((1, 7)))
    assert contacts_at_1_khz(suite, {"left": resting, "right": obstacle})
    trajectory = plan(two, obstacle, start, end)["left"]
    assert contacts_at_1_khz(suite, {"left": trajectory, "right": obstacle}) == []
    assert trajectory.certificate.holds
    assert trajectory.certificate.proved_free
    np.testing.assert_allclose(trajectory.positions[[0, -1]], [turned(start), turned(end)], atol=1e-9)
    assert trajectory.duration < latest
    stats = two.get_planning_stats()
    assert stats["status"] == srmp.Status.solved
    assert stats["makespan_s"] == stats["flow_time_s"] == trajectory.duration
    assert stats["bound"] == np.inf


def test_it_arrives_after_its_goal_was_swept(two, suite):
    obstacle = via(two, [0, 3, 5], [-1.5, -1.5, 1.5])
    trajectory = plan(two, obstacle, -0.9, 0.0)["left"]
    assert contacts_at_1_khz(suite, {"left": trajectory, "right": obstacle}) == []
    assert 4 < trajectory.duration < 5
    moved = two.get_planning_stats()["path_cost_rad"]
    assert moved == pytest.approx(np.linalg.norm(np.diff(trajectory.waypoints, axis=0), axis=1).sum())


def test_it_goes_round_one_that_is_long_in_the_way(two, suite):
    """Waiting, it would arrive after 15 s."""
    obstacle = via(two, [0, 1, 14, 15], [-0.9, 0, 0, -0.9])
    trajectory = plan(two, obstacle)["left"]
    assert contacts_at_1_khz(suite, {"left": trajectory, "right": obstacle}) == []
    assert trajectory.duration < 3
    assert trajectory.certificate.holds
    assert trajectory.certificate.proved_free


def test_a_robot_with_any_goal_makes_room(two, suite):
    obstacle = sweep(two, 2.0)
    goals = {"left": srmp.GoalConstraint.any()}
    trajectory = two.plan_multi({"left": turned(0)}, goals, obstacles={"right": obstacle})["left"]
    assert contacts_at_1_khz(suite, {"left": trajectory, "right": obstacle}) == []
    assert trajectory.certificate.proved_free
    assert (trajectory.positions[-1] != turned(0)).any()


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
def test_limits_hold_where_it_waits_on_the_way(two, timing):
    options = {"planner_id": "xECBS", "timing": timing, "velocity_scaling": 0.8, "acceleration_scaling": 0.5}
    two.make_planner("left", options | {"time_limit": 20})
    trajectory = plan(two, sweep(two, 4.0), 0.0, 0.0)["left"]
    certificate = trajectory.certificate
    assert certificate.holds
    limits = srmp.default_limits([2.2, 2.2, 2.4, 2.4, 3.0, 3.0, 3.0])
    for time in np.arange(0, trajectory.duration, 1e-3):
        _, velocity, acceleration, _ = trajectory.state(time)
        assert (abs(velocity) <= 0.8 * limits.velocity + 1e-9).all()
        assert (abs(acceleration) <= 0.5 * limits.acceleration + 1e-6).all()


def test_no_obstacles_no_wait(two):
    two.set_qpos("right", turned(-2.0))
    starts, goals = {"left": turned(-0.9)}, {"left": goal(turned(0.9))}
    trajectories = [two.plan_multi(starts, goals, obstacles=none)["left"] for none in (None, {})]
    trajectories.append(two.plan_multi(starts, goals, obstacles={"right": sweep(two, 2.0, -2.0, -2.1)})["left"])
    assert {trajectory.positions.tobytes() for trajectory in trajectories} == {trajectories[0].positions.tobytes()}
    assert wait(trajectories[0]) == 0
    assert two.get_qpos("right").tolist() == turned(-2.0).tolist()  # the scene is as it was


FAILURES = [
    ((2.0, -0.9, 0.0), (-0.9, 0.0), "goal_invalid", "right/arm7_"),
    ((2.0, 0.0, 0.9), (0.0, 0.9), "start_invalid", "'right' begins where 'left' starts: 'left/arm7_"),
    ((0.1, -0.9, 0.0), (0.0, 0.9), "start_invalid", "'right' ends where 'left' starts: 'left/arm7_"),
    (
        (0.4, -0.9, 0.9),
        (0.0, 0.9),
        "exhausted",
        "passes through where a robot waits.*'left/arm7_.*'right/arm7_.* touch at",
    ),
]


@pytest.mark.parametrize(("motion", "way", "status", "sentence"), FAILURES, ids=[row[2] for row in FAILURES])
def test_what_cannot_be_says_why(two, motion, way, status, sentence):
    with pytest.raises(srmp.PlanningError, match=sentence) as error:
        plan(two, sweep(two, *motion), *way)
    assert error.value.status == srmp.Status[status]
    assert two.get_planning_stats()["status"] == srmp.Status[status]
    stats = two.get_planning_stats()
    assert stats["reason"] == str(error.value)
    assert stats["robot_cost_rad"] == {"left": 0}
    assert {"tree_nodes", "makespan_s", "flow_time_s"} <= stats.keys()


def with_start(planner):
    planner.plan_multi({"left": turned(0)}, {"left": goal(turned(1))}, obstacles={"left": sweep(planner)})


def named(planner, names):
    return srmp.Trajectory(names, [turned(-0.9), turned(0.9)], [0, 1])


REFUSED = [
    (lambda p: p.plan_multi({"left": turned(0)}, {}, obstacles={"rihgt": sweep(p)}), "did you mean 'right'"),
    (with_start, "'left' has a start and is an obstacle too"),
    (lambda p: plan(p, named(p, list("abcdefg"))), "obstacle 'right': the joints are 'a'.* but those of robot 'right'"),
    (lambda p: plan(p, named(p, p.get_joint_names("right")[::-1])), "obstacle 'right': .*another order"),
    (
        lambda p: plan(p, srmp.Trajectory(p.get_joint_names("right"), [turned(-0.9)])),
        "obstacle 'right': the trajectory has no times",
    ),
    (lambda p: plan(p, sweep(p).slice(1, 2)), "obstacle 'right': the trajectory begins at 1 s"),
    (lambda p: plan(p, sweep(p, 1.0, -0.9, 9.0)), "obstacle 'right': arm7_joint1: the position is 9.* its limits are"),
    (
        lambda p: plan(p, srmp.Trajectory(p.get_joint_names("right"), [turned(-0.9), turned(9)], [0, 1])),
        r"arm7_joint1: the position is 9 at 1 s \(row 1, the last\); its limits",
    ),
    (lambda p: plan(p, sweep(p, 1.0, -0.9, NAN)), "trajectory: positions, row 1"),
    (lambda p: p.make_planner("left", {"timing": "none"}) or plan(p, sweep(p)), "timing is 'none'"),
    (lambda p: p.make_planner("left", srmp.WAStar()) or plan(p, sweep(p)), "'wAstar' plans for one robot"),
]


@pytest.mark.parametrize(("call", "sentence"), REFUSED)
def test_wrong_obstacles_are_refused(two, call, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence) as error:
        call(two)
    assert "\n" not in str(error.value)


def test_a_merged_motion_is_that_of_the_robots():
    """Straight without velocities, smooth with them; the two cannot be one."""
    rows = np.array([[0.0], [1.0], [0.0]])
    straight = srmp.Trajectory(["a"], rows, [0, 1, 2])
    smooth = srmp.Trajectory(["a"], rows, [0, 0.7, 2], np.zeros((3, 1)))
    for one in (straight, smooth):
        merged = srmp.MultiTrajectory({"x": one, "y": one.resample(0.5) if one is straight else one}).merged()
        for time in np.linspace(0, 2, 21):
            np.testing.assert_allclose(merged.sample(time), [one.sample(time)[0]] * 2, atol=1e-12)
    with pytest.raises(srmp.InvalidArgument, match="that of 'x' has none: one motion has them or not"):
        srmp.MultiTrajectory({"x": straight, "y": smooth}).merged()
