"""Several robots planned as one: what they do together, such as holding one box."""

from math import pi, radians, sqrt

import numpy as np
import pytest
from support import needs_example_robot_data

import srmp
from srmp import PathConstraint, Pose

pinocchio = pytest.importorskip("pinocchio")

BASES = {"left": Pose(p=[0, 0.3, 0]), "right": Pose.from_rpy([0.9, -0.2, 0.1], [0, 0, 2.5])}
JOINTS = [f"{robot}_arm7_joint{i}" for robot in BASES for i in range(1, 8)]


def two(bases=BASES, **more):
    planner = srmp.PlannerInterface()
    for name, base in bases.items():
        files = {"urdf_path": srmp.data_path("arm7.urdf"), "srdf_path": srmp.data_path("arm7.srdf")}
        planner.add_articulation(**{**files, "name": name, "end_effector": "arm7_hand", "base_pose": base, **more})
    return planner


def joined(**more):
    planner = two(**more)
    planner.join_robots("both", list(BASES))
    return planner


def copy_of(planner, directory):
    planner.save(directory / "copy.json")
    return srmp.PlannerInterface.load(directory / "copy.json")


def pairs_in_contact(planner, robot):
    """Of the robot as it stands, with the names that links have when the robots are joined."""

    def body(name):  # own links are called without the robot
        if name in planner.object_names or robot == "both":
            return name
        return name.replace("/", "_") if "/" in name else f"{robot}_{name}"

    return {tuple(sorted((body(c.body_a), body(c.body_b)))) for c in planner.contacts(robot, planner.get_qpos(robot))}


# --- what it is -------------------------------------------------------------------------------------------------------


def test_joints_links_and_states_are_those_of_the_robots():
    planner = joined()
    assert planner.robot_names == ["both"]
    assert planner.get_joint_names("both") == JOINTS
    assert {"both_origin", "left_arm7_hand", "right_arm7_hand"} <= set(planner.get_link_names("both"))
    ready = two().get_group_states("left")["ready"]
    np.testing.assert_array_equal(planner.get_group_states("both")["ready"], [*ready, *ready])
    np.testing.assert_array_equal(planner.get_joint_limits("both")[:7], two().get_joint_limits("left"))


def test_hands_are_where_they_were():
    before, after = two(), joined()
    for q in np.random.default_rng(0).uniform(-2, 2, (50, 14)):
        for part, robot in enumerate(BASES):
            one = before.compute_fk(robot, q[7 * part : 7 * part + 7])
            other = after.compute_fk("both", q, f"{robot}_arm7_hand")
            np.testing.assert_allclose(other.matrix(), one.matrix(), atol=1e-12)


def test_contacts_are_those_of_the_robots(tmp_path):
    """Of each with itself, with the other, with an object, and with what the other one holds."""
    before = two()
    before.add_box("box", [0.5, 0.5, 0.6], Pose([0.45, 0, 0.3]))
    before.add_sphere("ball", 0.05, before.compute_fk("right", before.get_qpos("right")))
    before.attach_object("ball", "right", "arm7_hand")
    before.set_allowed_collision("left/arm7_upper_arm", "box")
    before.set_allowed_collision("left", "right/arm7_forearm")
    some = 0
    for q in np.random.default_rng(0).uniform(-1.9, 1.9, (40, 14)):
        before.set_qpos("left", q[:7])
        before.set_qpos("right", q[7:])
        expected = pairs_in_contact(before, "left") | pairs_in_contact(before, "right")
        after = copy_of(before, tmp_path)
        after.join_robots("both", ["left", "right"])
        np.testing.assert_array_equal(after.get_qpos("both"), q)
        assert pairs_in_contact(after, "both") == expected
        some += bool(expected)
    assert 8 < some < 40


def test_padding_and_motion_limits_are_kept():
    planner = two()
    for robot in BASES:
        planner.set_padding(robot, 0.02)
    planner.set_motion_limits("left", velocity=0.5, link_speeds={"": 0.25})
    planner.join_robots("both", ["left", "right"])
    limits = planner.motion_limits("both")
    np.testing.assert_array_equal(limits.velocity[:7], np.full(7, 0.5))
    np.testing.assert_array_equal(limits.velocity[7:], two().motion_limits("right").velocity)
    assert [(each.link, each.speed) for each in limits.link_speeds] == [("left_arm7_hand", 0.25)]


def test_of_settings_that_contradict_each_other_the_same_one_counts():
    for first in (True, False):
        planner = two()
        for a, b, allowed in (("left", "right/arm7_hand", first), ("left/arm7_palm", "right", not first)):
            planner.set_allowed_collision(a, b, allowed=allowed)
        before = planner.allowed_collision("left/arm7_palm", "right/arm7_hand")
        planner.join_robots("both", ["left", "right"])
        assert planner.allowed_collision("left_arm7_palm", "right_arm7_hand") == before


@pytest.mark.parametrize("name", ["left_arm", "right_arm", "a b/c<&\"'é"])
def test_names_that_groups_have_and_odd_ones(name):
    planner = two()
    planner.join_robots(name, ["left", "right"])
    start = planner.get_group_states(name)["ready"]
    assert planner.plan(start, start + 0.2).certificate.holds


def test_the_joined_robot_may_have_the_name_of_a_part():
    planner = two()
    planner.join_robots("left", ["right", "left"])
    assert planner.robot_names == ["left"]
    assert planner.get_joint_names("left")[0] == "right_arm7_joint1"


def test_it_is_kept_in_files(tmp_path):
    planner = joined()
    start = np.array(planner.get_group_states("both")["ready"])
    motion = planner.plan(start, start + 0.2)
    planner.save(tmp_path / "problem.json")
    assert srmp.PlannerInterface.load(tmp_path / "problem.json").plan("both", start, start + 0.2) == motion


# --- what they do together --------------------------------------------------------------------------------------------


class Hands:
    """Poses of the two hands in the world by Pinocchio alone, from the URDF of one arm."""

    def __init__(self, bases):
        self.model = pinocchio.buildModelFromUrdf(str(srmp.data_path("arm7.urdf")))
        self.data = self.model.createData()
        self.bases = {name: pinocchio.SE3(np.asarray(base.matrix())) for name, base in bases.items()}

    def __call__(self, parts):
        poses = []
        for name, q in parts.items():
            pinocchio.framesForwardKinematics(self.model, self.data, np.asarray(q))
            poses.append(self.bases[name] * self.data.oMf[self.model.getFrameId("arm7_hand")])
        return poses


def test_two_robots_carry_one_box_to_a_millimetre():
    bases = {"left": Pose(p=[0, 0.35, 0]), "right": Pose(p=[0, -0.35, 0])}
    planner = two(bases)
    planner.join_robots("both", ["left", "right"])
    planner.make_planner("both", {"time_limit": 60})
    left, right = Pose.from_rpy([0, 0.16, 0], [pi / 2, 0, 0]), Pose.from_rpy([0, -0.16, 0], [-pi / 2, 0, 0])

    def hands_on(box):
        return {"left_arm7_hand": box @ left, "right_arm7_hand": box @ right}

    grasp = planner.plan(planner.get_group_states("both")["ready"], hands_on(Pose([0.45, 0, 0.35])))
    planner.add_box("box", [0.2, 0.28, 0.2], Pose([0.45, 0, 0.35]))
    planner.set_qpos("both", grasp.positions[-1])
    planner.attach_object("box", "both", "left_arm7_hand", touch_links=["right_arm7_hand"])
    closed = PathConstraint.pose(
        left.inverse() @ right,
        1e-3 / sqrt(3),
        radians(0.5) / sqrt(3),
        link="right_arm7_hand",
        frame="left_arm7_hand",
    )
    goal = hands_on(Pose.from_rpy([0.4, 0.05, 0.5], [0, 0, 0.15]))
    carry = planner.plan(grasp.positions[-1], goal, constraints=[closed])
    assert carry.certificate.holds
    assert all(kept.deviation <= kept.tolerance for kept in carry.certificate.constraints)
    assert planner.plan(grasp.positions[-1], goal, constraints=[closed]) == carry

    parts = {name: carry.of_joints([joint for joint in carry.joint_names if joint.startswith(name)]) for name in bases}
    hands = Hands(bases)
    rigid = pinocchio.SE3(np.asarray((left.inverse() @ right).matrix()))
    for t in np.arange(0, carry.duration, 1e-3):
        one, other = hands({name: part.sample(t) for name, part in parts.items()})
        off = rigid.inverse() * (one.inverse() * other)
        assert np.linalg.norm(off.translation) <= 1e-3
        assert np.linalg.norm(pinocchio.log3(off.rotation)) <= radians(0.5)


@needs_example_robot_data
def test_grippers_of_the_srdfs_are_kept():
    planner = srmp.PlannerInterface()
    for name, y in {"left": 0.4, "right": -0.4}.items():
        planner.add_robot("panda", name=name, base_pose=Pose([0, y, 0]))
    before = {each.name: each for each in planner.end_effectors("left")}
    planner.join_robots("both", ["left", "right"])
    after = {each.name: each for each in planner.end_effectors("both")}
    assert set(after) == {f"{robot}_{name}" for robot in ("left", "right") for name in before}
    for name, each in before.items():
        assert after[f"left_{name}"].joints == [f"left_{joint}" for joint in each.joints]
        assert after[f"left_{name}"].states.keys() == each.states.keys()
        assert (after[f"left_{name}"].opening is None) == (each.opening is None)
    start = planner.get_group_states("both")["default"]
    assert planner.plan(start, start + [0.1] * 14).certificate.holds


@needs_example_robot_data
def test_torque_limits_of_both_are_kept_and_two_payloads_refused(tmp_path):
    planner = srmp.PlannerInterface()
    for name, y in {"left": 0.4, "right": -0.4}.items():
        planner.add_robot("panda", name=name, base_pose=Pose([0, y, 0]))
    planner.set_motion_limits("left", torque="urdf", payload=1.5)
    both = copy_of(planner, tmp_path)
    both.join_robots("both", ["left", "right"])
    limits = both.motion_limits("both")
    np.testing.assert_array_equal(limits.torque[:7], planner.motion_limits("left").torque)
    assert np.isinf(limits.torque[7:]).all()
    assert limits.payload.mass == 1.5
    assert limits.payload.link == f"left_{planner.get_end_effector('left')}"
    start = both.get_group_states("both")["default"]
    assert both.plan("both", start, start + [0.1] * 14).certificate.torque is not None
    planner.set_motion_limits("right", torque=80, payload=1)
    with pytest.raises(srmp.InvalidArgument, match="more than one of the robots has a payload"):
        planner.join_robots("both", ["left", "right"])
    assert planner.robot_names == ["left", "right"]


# --- of_joints --------------------------------------------------------------------------------------------------------


def test_joints_of_a_motion():
    planner = joined()
    start = np.array(planner.get_group_states("both")["ready"])
    motion = planner.plan(start, start + 0.2)
    names = ["right_arm7_joint2", "left_arm7_joint1"]
    part = motion.of_joints(names)
    assert part.joint_names == names
    columns = [JOINTS.index(name) for name in names]
    for field in ("positions", "velocities", "accelerations", "waypoints"):
        np.testing.assert_array_equal(getattr(part, field), getattr(motion, field)[:, columns])
    np.testing.assert_array_equal(part.times, motion.times)
    assert part.certificate is None
    np.testing.assert_array_equal(part.sample(0.31), motion.sample(0.31)[columns])
    assert motion.of_joints(names, ["j2", "j1"]).joint_names == ["j2", "j1"]
    with pytest.raises(srmp.InvalidArgument, match="1 names for 2 joints"):
        motion.of_joints(names, ["j2"])
    path = motion.of_joints(JOINTS)
    assert path.positions.shape == motion.positions.shape


@pytest.mark.parametrize(
    ("joints", "sentence"),
    [
        ([], "no joint is named"),
        (["left_arm7_joint8"], "no joint 'left_arm7_joint8'.*did you mean 'left_arm7_joint"),
        (["left_arm7_joint1"] * 2, "'left_arm7_joint1' is named twice"),
    ],
)
def test_wrong_joints_of_a_motion(joints, sentence):
    planner = joined()
    start = np.array(planner.get_group_states("both")["ready"])
    motion = planner.plan(start, start + 0.2)
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        motion.of_joints(joints)


# --- bad input --------------------------------------------------------------------------------------------------------


def with_paddings(planner):
    planner.set_padding("right", 0.02)


def with_third(planner):
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="third",
        base_pose=Pose([9, 9, 0]),
    )


WRONG = [
    (None, "both", [], "0 robots are given; it takes two or more"),
    (None, "both", ["left"], "1 robots are given"),
    (None, "both", ["left", "left"], "'left' is named twice"),
    (None, "both", ["left", "rigth"], "'rigth'.*did you mean 'right'"),
    (None, "", ["left", "right"], "name of the joined robot is empty"),
    (None, "a\0b", ["left", "right"], "has a zero byte"),
    (with_paddings, "both", ["left", "right"], "'left' has a padding of 0 m and robot 'right' one of 0.02 m"),
    (with_third, "third", ["left", "right"], "a robot 'third' already"),
]


@pytest.mark.parametrize(("prepare", "name", "robots", "sentence"), WRONG)
def test_wrong_robots_are_refused_and_nothing_changes(prepare, name, robots, sentence, tmp_path):
    planner = two()
    if prepare:
        prepare(planner)
    planner.save(tmp_path / "before.json")
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.join_robots(name, robots)
    planner.save(tmp_path / "after.json")
    assert (tmp_path / "after.json").read_text() == (tmp_path / "before.json").read_text()


def test_names_that_would_be_the_same_are_refused():
    urdf = "<robot name='r'><link name='{0}'/><link name='{1}'/><joint name='{2}' type='revolute'><parent link='{0}'/>"
    urdf += "<child link='{1}'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint></robot>"
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=urdf.format("b_link", "tip", "joint"), name="a")
    planner.add_articulation(urdf_text=urdf.format("link", "end", "turn"), name="a_b")
    with pytest.raises(srmp.InvalidArgument, match="two elements <link> of the robots would be called 'a_b_link'"):
        planner.join_robots("both", ["a", "a_b"])
    assert planner.robot_names == ["a", "a_b"]
