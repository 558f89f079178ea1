"""Limits of the speed of links: what docs/trajectories.md says of them, by Pinocchio alone, and every bad argument."""

import pickle

import numpy as np
import pytest

import srmp
from srmp import FaultKind, LinkSpeedLimit, MotionLimits, Pose

pin = pytest.importorskip("pinocchio", reason="speeds are checked by Pinocchio: pip install '.[test]'")

READY = [0.0, -0.5, 0.0, -1.8, 0.0, 1.2, 0.0]
GOAL = np.add(READY, [1.5, 0.2, 0, 0.4, 0, 0.3, 0])
POINT = [0.05, 0.02, 0.15]
LIMIT = 0.25


class Speeds:
    """Speed [m/s] of a point of a link and angular speed [rad/s], by Pinocchio."""

    def __init__(self, urdf, link, point=(0, 0, 0)):
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(link)
        self.point = np.array(point, dtype=float)

    def at(self, names, q, velocity):
        full, rates = pin.neutral(self.model), np.zeros(self.model.nv)
        for name, position, rate in zip(names, q, velocity, strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            full[joint.idx_q], rates[joint.idx_v] = position, rate
        pin.forwardKinematics(self.model, self.data, full, rates)
        placement = pin.updateFramePlacement(self.model, self.data, self.frame)
        twist = pin.getFrameVelocity(self.model, self.data, self.frame, pin.LOCAL_WORLD_ALIGNED)
        speed = twist.linear + np.cross(twist.angular, placement.rotation @ self.point)
        return np.linalg.norm(speed), np.linalg.norm(twist.angular)

    def fastest(self, motion):
        """Over samples of 1 ms."""
        times = np.append(np.arange(motion.times[0], motion.times[-1], 1e-3), motion.times[-1])
        positions, velocities, _, _ = motion.state(times)
        speeds = [self.at(motion.joint_names, q, v) for q, v in zip(positions, velocities, strict=True)]
        return np.max(speeds, axis=0)


@pytest.fixture
def urdf():
    return srmp.data_path("arm7.urdf")


def configurations(planner, robot, count, seed):
    limits, random = planner.get_joint_limits(robot), np.random.default_rng(seed)
    found = []
    while len(found) < count:
        q = random.uniform(limits[:, 0], limits[:, 1])
        if not planner.contacts(robot, q):
            found.append(q)
    return found


def plans(planner, robot, count, seed):
    starts, goals = configurations(planner, robot, count, seed), configurations(planner, robot, count, seed + 1)
    for k, (start, goal) in enumerate(zip(starts, goals, strict=True)):
        timing = "ruckig" if k % 3 == 2 else "toppra"
        planner.make_planner(robot, {"planner_id": "auto", "timing": timing, "sample_rate": 500 if k % 5 == 4 else 0})
        yield planner.plan(robot, start, goal)


@pytest.fixture(params=["arm7", "panda"])
def robot(request, tmp_path):
    """Planner, URDF and end effector of a robot."""
    planner = srmp.PlannerInterface()
    if request.param == "arm7":
        urdf, srdf, link = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf"), "arm7_hand"
    else:
        import stand_in

        directory = stand_in.write(tmp_path) / "panda"
        urdf, srdf, link = str(directory / "panda.urdf"), str(directory / "panda.srdf"), "panda_hand"
    planner.add_articulation(urdf_path=urdf, srdf_path=srdf, name="robot", end_effector=link)
    return planner, urdf, link


def test_no_sample_of_200_random_motions_is_faster(robot):
    planner, urdf, link = robot
    planner.set_motion_limits("robot", link_speeds={link: LIMIT})
    speeds = Speeds(urdf, link)
    proved = []
    for motion in plans(planner, "robot", 100, 1):
        (use,) = motion.certificate.link_speeds
        assert motion.certificate.holds
        assert speeds.fastest(motion)[0] <= use.speed * (1 + 1e-9)
        assert use.speed <= LIMIT * (1 + 1e-6)
        proved.append(use.fraction)
    assert np.median(proved) > 0.98  # and they are not much slower than they may be


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
@pytest.mark.parametrize("rate", [0, 500])
def test_points_and_several_limits(arm_alone, urdf, timing, rate):
    limits = [
        LinkSpeedLimit("arm7_hand", speed=0.2, angular_speed=0.5, point_in_link=POINT),
        LinkSpeedLimit("arm7_forearm", speed=0.1),
        LinkSpeedLimit(angular_speed=0.4),
    ]
    arm_alone.set_motion_limits("arm", link_speeds=limits)
    arm_alone.make_planner("arm", {"planner_id": "auto", "timing": timing, "sample_rate": rate})
    motion = arm_alone.plan("arm", READY, GOAL)
    hand, elbow, end_effector = motion.certificate.link_speeds
    speed, turning = Speeds(urdf, "arm7_hand", POINT).fastest(motion)
    assert speed <= hand.speed <= 0.2
    assert turning <= hand.angular_speed <= 0.5
    assert Speeds(urdf, "arm7_forearm").fastest(motion)[0] <= elbow.speed <= 0.1
    assert (end_effector.limit.link, end_effector.speed) == ("arm7_hand", 0)
    assert end_effector.angular_speed <= 0.4
    assert max(use.fraction for use in motion.certificate.link_speeds) > 0.98
    assert f"link speed     arm7_hand: {hand.speed:.4g} m/s" in motion.certificate.report()
    assert repr(limits[0]) == "LinkSpeedLimit('arm7_hand', 0.2 m/s, 0.5 rad/s)"


def test_every_motion_keeps_them(arm_alone, urdf):
    arm_alone.set_motion_limits("arm", link_speeds={"": LIMIT})
    speeds, here = Speeds(urdf, "arm7_hand"), arm_alone.compute_fk("arm", READY)
    line = arm_alone.plan_linear("arm", READY, Pose(p=np.add(here.p, [0, 0.2, 0]), q=here.q))
    plan = arm_alone.plan("arm", READY, GOAL)
    t = plan.duration / 2
    there_and_back = [srmp.Segment.move(GOAL), srmp.Segment.wait(0.1), srmp.Segment.move(READY)]
    motions = [
        line,
        plan,
        arm_alone.stop(plan, t),
        arm_alone.replan(plan, t, np.add(READY, [-0.8, 0.3, 0.2, 0, 0.3, 0, 0])),
        arm_alone.plan_sequence("arm", READY, there_and_back).trajectory,
        plan.slice(0.1, t),
        plan.resample(0.05, arm_alone.motion_limits("arm")),
        *arm_alone.plan_multi({"arm": READY}, {"arm": GOAL}).values(),
    ]
    for motion in motions:
        (use,) = motion.certificate.link_speeds
        assert motion.certificate.holds
        assert speeds.fastest(motion)[0] <= use.speed * (1 + 1e-9)
        assert use.speed <= LIMIT * (1 + 1e-6)
    assert motions[3].positions[0].tolist() == plan.sample(t).tolist()
    assert motions[3].certificate.link_speeds[0].fraction > 0.95


def test_robots_together_keep_them(arm_alone, urdf):
    arm_alone.add_articulation(
        urdf_path=urdf, srdf_path=srmp.data_path("arm7.srdf"), name="other", end_effector="arm7_hand",
        base_pose=Pose(p=[0.0, 0.6, 0.0]),
    )  # fmt: skip
    arm_alone.set_motion_limits("other", link_speeds={"": 0.1})
    starts = {"arm": READY, "other": READY}
    goal = np.add(READY, [0, 0.2, 0, 0.2, 0, 0, 0.5])
    motions = arm_alone.plan_multi(starts, {"arm": goal, "other": goal})
    assert motions["arm"].certificate.link_speeds == []
    (use,) = motions["other"].certificate.link_speeds
    assert Speeds(urdf, "arm7_hand").fastest(motions["other"])[0] <= use.speed <= 0.1


def test_without_limits_nothing_changes(arm_alone):
    before = arm_alone.plan("arm", READY, GOAL)
    arm_alone.set_motion_limits("arm", link_speeds={"": LIMIT})
    slow = arm_alone.plan("arm", READY, GOAL)
    assert slow.duration > before.duration
    np.testing.assert_array_equal(slow.waypoints, before.waypoints)
    arm_alone.set_motion_limits("arm", velocity=arm_alone.motion_limits("arm").velocity)  # others stay
    assert arm_alone.motion_limits("arm").link_speeds == [LinkSpeedLimit("", speed=LIMIT)]
    arm_alone.set_motion_limits("arm", link_speeds={})
    assert arm_alone.plan("arm", READY, GOAL) == before


def test_a_limit_that_is_never_reached_changes_no_bit(arm_alone):
    before = arm_alone.plan("arm", READY, GOAL)
    arm_alone.set_motion_limits("arm", link_speeds={"": 100})
    after = arm_alone.plan("arm", READY, GOAL)
    np.testing.assert_array_equal(after.positions, before.positions)
    np.testing.assert_array_equal(after.times, before.times)


@pytest.mark.parametrize("at_rest", [True, False])
def test_verify_finds_the_fault(arm_alone, urdf, at_rest):
    motion = arm_alone.plan("arm", READY, GOAL)
    fastest = Speeds(urdf, "arm7_hand").fastest(motion)[0]
    known = arm_alone.motion_limits("arm")
    values = (known.velocity, known.acceleration, known.jerk)
    for factor, faults in ((1.001, []), (0.999, [FaultKind.link_speed_limit])):
        limits = MotionLimits(*values, link_speeds={"arm7_hand": factor * fastest})
        certificate = arm_alone.verify("arm", motion, limits=limits, at_rest=at_rest)
        assert [fault.kind for fault in certificate.faults] == faults
        assert certificate.link_speeds[0].speed >= fastest
    assert certificate.faults[0].text.startswith("link 'arm7_hand': the speed reaches up to")
    assert "its limit is" in certificate.faults[0].text
    assert 0 < certificate.faults[0].time < motion.duration


def test_they_are_kept_in_files(arm_alone, tmp_path):
    arm_alone.set_motion_limits("arm", link_speeds={"": (LIMIT, None), "arm7_forearm": (None, 1)})
    motion = arm_alone.plan("arm", READY, GOAL)
    assert pickle.loads(pickle.dumps(motion)).certificate == motion.certificate
    limits = arm_alone.motion_limits("arm")
    assert pickle.loads(pickle.dumps(limits)) == limits
    assert motion.certificate.to_dict()["link_speeds"][0]["limit"]["speed"] == LIMIT
    motion.save(tmp_path / "motion.json")
    assert srmp.Trajectory.load(tmp_path / "motion.json").certificate == motion.certificate
    arm_alone.save(tmp_path / "problem.json")
    again = srmp.PlannerInterface.load(tmp_path / "problem.json")
    assert again.motion_limits("arm") == limits


def test_time_parameterize_needs_the_robot(arm_alone, urdf):
    known = arm_alone.motion_limits("arm")
    limits = MotionLimits(known.velocity, known.acceleration, known.jerk, link_speeds={"": LIMIT})
    names = arm_alone.get_joint_names("arm")
    motion = srmp.time_parameterize([READY, GOAL], names, limits, planner=arm_alone)
    assert 0.98 * LIMIT < Speeds(urdf, "arm7_hand").fastest(motion)[0] <= LIMIT
    with pytest.raises(srmp.InvalidArgument, match="need the robot whose joints these are"):
        srmp.time_parameterize([READY, GOAL], names, limits)
    with pytest.raises(srmp.InvalidArgument, match="the joints are 'a'"):
        srmp.time_parameterize([[0], [1]], ["a"], MotionLimits([1], [1], [1], link_speeds={"": 1}), planner=arm_alone)
    with pytest.raises(srmp.InvalidArgument, match="no planner to find it in"):
        srmp.time_parameterize([READY, GOAL], names, limits, robot="arm")
    with pytest.raises(srmp.InvalidArgument, match="does not know its robot"):
        pickle.loads(pickle.dumps(motion)).resample(0.01, limits)


def test_a_start_that_is_too_fast_is_refused(arm_alone):
    motion = arm_alone.plan("arm", READY, GOAL)
    t = motion.duration / 2
    arm_alone.set_motion_limits("arm", link_speeds={"": 0.1})
    with pytest.raises(srmp.InvalidArgument, match=r"moves the end effector at [\d.]+ times its speed limit"):
        arm_alone.replan(motion, t, READY)
    with pytest.raises(srmp.PlanningError, match="the speed reaches up to"):
        arm_alone.stop(motion, t)


@pytest.mark.parametrize(
    ("link_speeds", "text"),
    [
        ({"arm7_hnad": 0.25}, "did you mean 'arm7_hand'"),
        ({"arm7_base": 0.25}, "no planned joint moves it"),
        ({"arm7_hand": 0}, "the speed limit of link 'arm7_hand' is 0; it must be"),
        ({"arm7_hand": -1}, "is -1; it must be"),
        ({"": np.nan}, "the speed limit of the end effector is NaN"),
        ({"": (0.25, 0)}, "the angular speed limit of the end effector is 0"),
        ({"": (None, None)}, "neither the speed nor the angular speed of the end effector is limited"),
        ({"": np.inf}, "neither the speed nor the angular speed"),
        ({"": (1, 2, 3)}, "it must be a number [m/s], or two"),
        ({"": "slow"}, "the speed limit of link '' is 'slow'"),
        ({"": True}, "the speed limit of link '' is True"),
        (0.25, "link_speeds must be a dictionary from links to speeds [m/s], or a list of LinkSpeedLimit, but is 0.25"),
        ("arm7_hand", "or a list of LinkSpeedLimit, but is 'arm7_hand'"),
        ([0.25], "or a list of LinkSpeedLimit, but holds 0.25"),
    ],
)
def test_bad_limits_are_refused_and_change_nothing(arm_alone, link_speeds, text):
    before = arm_alone.motion_limits("arm")
    with pytest.raises(srmp.InvalidArgument) as error:
        arm_alone.set_motion_limits("arm", velocity=0.5, link_speeds=link_speeds)
    assert text in str(error.value)
    assert len(str(error.value)) < 500
    assert arm_alone.motion_limits("arm") == before


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({}, "neither the speed nor the angular speed of the end effector is limited"),
        ({"speed": 0}, "the speed limit of the end effector is 0"),
        ({"angular_speed": -1}, "the angular speed limit of the end effector is -1"),
        ({"speed": 1, "point_in_link": [0, np.nan, 0]}, "must be three finite numbers"),
        ({"speed": 1, "point_in_link": [0, 0]}, "point_in_link"),
        ({"speed": "slow"}, "speed"),
    ],
)
def test_bad_limits_of_a_link(arguments, text):
    with pytest.raises(srmp.InvalidArgument) as error:
        LinkSpeedLimit(**arguments)
    assert text in str(error.value)
