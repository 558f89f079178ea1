"""Goals of several links, planning groups with branches, grippers of the SRDF, and two hands on one box."""

import pickle
import warnings
from math import inf, nan, pi, radians
from pathlib import Path

import numpy as np
import pytest
from support import needs_example_robot_data

import srmp
import srmp.robots
from srmp import GoalConstraint, GoalType, PathConstraint, Pose, Segment

pinocchio = pytest.importorskip("pinocchio")

HANDS = {  # on both sides of a box that is 0.3 m wide, in its frame
    "left_hand": Pose.from_rpy([0, 0.151, 0], [pi / 2, 0, 0]),
    "right_hand": Pose.from_rpy([0, -0.151, 0], [-pi / 2, 0, 0]),
}
BOX = Pose(p=[0.5, 0, 0.45])


def hands_on(box):
    return {link: box @ grasp for link, grasp in HANDS.items()}


def robot(**more):
    planner = srmp.PlannerInterface()
    files = {"urdf_path": srmp.data_path("two_arms.urdf"), "srdf_path": srmp.data_path("two_arms.srdf")}
    planner.add_articulation(**{**files, "name": "robot", "group": "both_arms", **more})
    return planner


@pytest.fixture
def planner():
    return robot()


@pytest.fixture
def ready(planner):
    return planner.get_group_states("robot")["ready"]


class Kinematics:
    """Poses of links by Pinocchio alone."""

    def __init__(self, urdf):
        self.model = pinocchio.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()

    def __call__(self, joint_names, q, *links):
        full = pinocchio.neutral(self.model)
        for name, value in zip(joint_names, q, strict=True):
            full[self.model.joints[self.model.getJointId(name)].idx_q] = value
        pinocchio.framesForwardKinematics(self.model, self.data, full)
        return [self.data.oMf[self.model.getFrameId(link)].copy() for link in links]


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics(srmp.data_path("two_arms.urdf"))


def error_of(found, pose):
    """[m] and [rad]"""
    off = pinocchio.SE3(np.asarray(pose.matrix())).inverse() * found
    return np.linalg.norm(off.translation), np.linalg.norm(pinocchio.log3(off.rotation))


# --- goals of links ---------------------------------------------------------------------------------------------------


def test_both_hands_reach_their_poses_at_the_same_time(planner, ready, kinematics):
    goals = hands_on(BOX)
    motion = planner.plan(ready, goals)
    for link, found in zip(goals, kinematics(motion.joint_names, motion.positions[-1], *goals), strict=True):
        metres, radian = error_of(found, goals[link])
        assert metres < 2e-5
        assert radian < 2e-4
    assert motion.certificate.holds
    assert motion.certificate.goal_error <= 1
    again = planner.plan("robot", ready, dict(reversed(list(goals.items()))))
    assert (again.positions == motion.positions).all()
    assert (planner.plan(ready, GoalConstraint.of_links(goals)).positions == motion.positions).all()


def test_the_error_of_a_goal_is_that_of_the_worst_link(planner, ready):
    motion = planner.plan(ready, hands_on(BOX))
    moved = hands_on(BOX)
    moved["right_hand"] = Pose(p=np.add(moved["right_hand"].p, [0, 0, 0.005]), q=moved["right_hand"].q)
    certificate = planner.verify("robot", motion, goals=moved)
    assert certificate.goal_error == pytest.approx(5, abs=0.05)  # times the tolerance of 1 mm
    assert "misses the goal" in str(certificate.faults[0])
    assert planner.verify("robot", motion, goals=hands_on(BOX)).holds


def test_any_link_can_have_the_goal(planner, ready, kinematics):
    target = planner.compute_fk("robot", ready + 0.1, "left_wrist")
    for goal in ({"left_wrist": target}, GoalConstraint(GoalType.POSE, target, link="left_wrist")):
        motion = planner.plan(ready, goal)
        assert error_of(*kinematics(motion.joint_names, motion.positions[-1], "left_wrist"), target)[0] < 2e-5
    goal = GoalConstraint(GoalType.POSITION, target.p, link="left_wrist")
    motion = planner.plan(ready, goal)
    found = kinematics(motion.joint_names, motion.positions[-1], "left_wrist")[0]
    assert np.linalg.norm(found.translation - target.p) < 2e-5


def test_the_link_of_the_end_effector_is_the_end_effector():
    planner = robot(group="left_arm")
    assert planner.get_end_effector("robot") == "left_hand"
    ready = robot().get_group_states("robot")["ready"][:7]
    goal = planner.compute_fk("robot", ready + 0.3)
    plain = planner.plan(ready, goal)
    assert (planner.plan(ready, {"left_hand": goal}).positions == plain.positions).all()


def test_goals_of_links_are_kept_in_files_and_pickles(planner, ready, tmp_path):
    goal = GoalConstraint.of_links(hands_on(BOX), position_tolerance=[1e-3, 2e-3, inf], rotation_tolerance=0.02)
    for copy in (pickle.loads(pickle.dumps(goal)), planner.goal("robot", goal)):
        assert copy.links == ["left_hand", "right_hand"]
        assert (copy.targets == goal.targets).all()
        assert "'left_hand' and 'right_hand'" in repr(copy)
    assert goal.targets.shape == (1, 14)
    motion = planner.plan(ready, goal)
    planner.save(tmp_path / "problem.json")
    read = srmp.PlannerInterface.load(tmp_path / "problem.json")
    assert read.last_request.goals[0].links == goal.links
    assert (read.plan("robot", ready, read.last_request.goals).positions == motion.positions).all()


def test_one_of_several_goals_of_links(planner, ready):
    far = hands_on(Pose(p=[3, 0, 0.4]))
    planner.plan(ready, [far, hands_on(BOX)])
    assert planner.get_planning_stats()["goal_index"] == 1


def test_what_is_out_of_reach_is_named(planner, ready):
    goals = hands_on(BOX)
    goals["right_hand"] = Pose(p=[2, 0, 0.4])
    with pytest.raises(srmp.PlanningError, match=r"brings 'right_hand' to \[2, 0, 0\.4\]"):
        planner.plan(ready, goals)
    apart = hands_on(BOX)
    apart["left_wrist"] = planner.compute_fk("robot", ready, "left_wrist")  # can be reached, but not with this hand
    with pytest.raises(srmp.PlanningError, match=r"'left_wrist' to .* at the same time"):
        planner.plan(ready, apart)


def test_several_robots_have_goals_of_links(ready):
    planner = robot(name="a")
    planner.add_articulation(
        urdf_path=srmp.data_path("two_arms.urdf"),
        srdf_path=srmp.data_path("two_arms.srdf"),
        name="b",
        group="both_arms",
        base_pose=Pose(p=[5, 0, 0]),
    )
    there = {link: Pose(p=[5, 0, 0]) @ pose for link, pose in hands_on(BOX).items()}
    motions = planner.plan_multi({"a": ready, "b": ready}, {"a": hands_on(BOX), "b": there})
    assert all(motion.certificate.goal_error <= 1 for motion in motions.values())


WRONG = [
    (lambda p: {"left_hnad": Pose()}, "no link 'left_hnad'.*did you mean 'left_hand'"),
    (lambda p: {"left_hand": Pose(), "left_joint1": 0.1}, "either Poses of links or numbers of joints.*'left_joint1'"),
    (lambda p: {"left_hand": 0.1}, "'left_hand' is a link, whose goal is a Pose"),
    (lambda p: {"left_joint1": Pose()}, "'left_joint1' is a joint, whose goal is a number"),
    (lambda p: {"left_hand": [0, 0, 0]}, "numbers by name, and one by link names Poses"),
    (lambda p: {3: Pose()}, "a link's name is a string"),
    (lambda p: {"torso": Pose()}, "no planned joint moves the link 'torso'"),
    (lambda p: Pose(), "several: name the link, such as 'left_hand' and 'right_hand'"),
    (lambda p: GoalConstraint(GoalType.POSITION, [0, 0, 1]), "name the link"),
    (lambda p: GoalConstraint(GoalType.JOINTS, np.zeros(14), link="left_hand"), "'joints' is for no link"),
    (lambda p: GoalConstraint(GoalType.POSE, [0] * 14, link="left_hand"), "a pose is 7 numbers"),
    (lambda p: GoalConstraint(GoalType.POSE, Pose(), link=3), "link"),
    (lambda p: GoalConstraint(GoalType.POSE, Pose(), link="left_hnad"), "did you mean 'left_hand'"),
    (lambda p: GoalConstraint.of_links({}), "at least one link"),
    (lambda p: GoalConstraint.of_links({"": Pose()}), "no name"),
    (lambda p: GoalConstraint.of_links([Pose()]), "a dictionary by link name"),
    (lambda p: GoalConstraint.of_links(hands_on(BOX), position_tolerance=0), "position_tolerance is 0"),
    (lambda p: GoalConstraint.of_links(hands_on(BOX), rotation_tolerance=nan), "rotation_tolerance"),
    (lambda p: GoalConstraint.of_links({"left_hand": Pose([1e9, 0, 0])}), "position"),
]


@pytest.mark.parametrize(("goal", "sentence"), WRONG)
def test_wrong_goals_of_links_are_refused(planner, ready, goal, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence) as error:
        planner.plan(ready, goal(planner))
    assert len(str(error.value)) < 500
    assert "\n" not in str(error.value)
    assert planner.last_request is None


# --- groups with branches ---------------------------------------------------------------------------------------------


def test_a_group_with_branches_ends_in_the_end_effectors_of_the_srdf(planner):
    assert planner.get_end_links("robot") == ["left_hand", "right_hand"]
    assert planner.get_end_effector("robot") == "left_hand"
    for call in (
        lambda: planner.compute_ik("robot", Pose()),
        lambda: planner.plan_linear("robot", np.zeros(14), Pose()),
        lambda: planner.plan(np.zeros(14), "ready", constraints=[PathConstraint.plane([0, 0, 1], [0, 0, 1], 0.1)]),
    ):
        with pytest.raises(srmp.InvalidArgument, match="name the link"):
            call()


def test_without_end_effectors_the_branches_end_where_their_chains_do():
    text = Path(srmp.data_path("two_arms.srdf")).read_text()
    plain = "\n".join(line for line in text.splitlines() if "<end_effector" not in line)
    assert robot(srdf_path="", srdf_text=plain).get_end_links("robot") == ["left_hand", "right_hand"]
    joints = [f"{side}_joint{k}" for side in ("left", "right") for k in range(1, 8)]
    by_name = robot(srdf_path="", srdf_text=plain, group="", joint_names=joints)
    assert by_name.get_end_links("robot") == ["left_flange", "right_flange"]
    assert robot(end_effector="right_hand").get_end_links("robot") == ["right_hand"]


def test_an_arm_with_its_gripper_ends_in_its_only_end_effector():
    text = Path(srmp.data_path("two_arms.srdf")).read_text()
    group = '<group name="more"><group name="left_arm"/><group name="left_gripper"/></group>'
    urdf = Path(srmp.data_path("two_arms.urdf")).read_text().replace('<mimic joint="left_finger_joint1"/>', "")
    planner = robot(
        urdf_path="",
        urdf_text=urdf,
        srdf_path="",
        srdf_text=text.replace("</robot>", f"{group}</robot>"),
        group="more",
    )
    assert len(planner.get_joint_names("robot")) == 9
    assert planner.get_end_links("robot") == ["left_hand"]


# --- grippers ---------------------------------------------------------------------------------------------------------


def test_end_effectors_are_listed_with_states_and_opening(planner):
    left, right = planner.end_effectors("robot")
    assert (left.name, left.link, left.group, left.parent_group) == (
        "left_gripper",
        "left_hand",
        "left_gripper",
        "left_arm",
    )
    assert left.joints == ["left_finger_joint1"]  # the other one mimics it
    assert right.states == {"open": {"right_finger_joint1": 0.04}, "close": {"right_finger_joint1": 0.0}}
    assert left.opening.max_width == pytest.approx(0.08)
    assert left.opening.closed == {"left_finger_joint1": 0}
    assert left.opening.opened == {"left_finger_joint1": 0.04}
    assert robot(srdf_path="", group="", end_effector="left_hand").end_effectors("robot") == []


def changed(urdf_edit=("", ""), srdf_edit=("", "")):
    urdf = Path(srmp.data_path("two_arms.urdf")).read_text()
    srdf = Path(srmp.data_path("two_arms.srdf")).read_text()
    return robot(
        urdf_path="", srdf_path="", urdf_text=urdf.replace(*urdf_edit), srdf_text=srdf.replace(*srdf_edit)
    ).end_effectors("robot")[0]


def test_an_opening_is_only_said_of_fingers_that_slide_against_each_other():
    mimic = '\n    <mimic joint="left_finger_joint1"/>'
    both = changed((mimic, ""))
    assert both.joints == ["left_finger_joint1", "left_finger_joint2"]
    assert both.opening.max_width == pytest.approx(0.08)
    assert both.opening.opened == {"left_finger_joint1": 0.04, "left_finger_joint2": 0.04}
    assert changed(('<axis xyz="0 -1 0"/>', '<axis xyz="0 1 0"/>')).opening is None  # both to the same side
    assert changed(('<axis xyz="0 -1 0"/>', '<axis xyz="1 0 0"/>')).opening is None
    assert changed((mimic, mimic.replace("/>", ' multiplier="0.5"/>'))).opening.max_width == pytest.approx(0.06)
    turning = ('"left_finger_joint1" type="prismatic"', '"left_finger_joint1" type="revolute"')
    assert changed(turning).opening is None


def test_partial_states_are_kept():
    edit = ('<group_state name="ready"', '<group_state name="half" group="left_gripper">')
    text = edit[1] + '<joint name="left_finger_joint1" value="0.02"/></group_state>\n  ' + edit[0]
    assert changed((edit[0], edit[0]), (edit[0], text)).states["half"] == {"left_finger_joint1": 0.02}


def test_grippers_move_in_sequences(planner, ready):
    planner.set_joint_positions("robot", {"left_finger_joint1": 0.01})
    finger = planner.compute_fk("robot", ready, "left_finger1")
    result = planner.plan_sequence(
        ready,
        [
            Segment.gripper("open", end_effector="left_gripper"),
            Segment.gripper(0.03, end_effector="left_gripper", duration=0.25),
            Segment.gripper("close", end_effector="right_gripper"),
            Segment.move(hands_on(BOX)),
        ],
    )
    assert [part.type.name for part in result.parts] == ["gripper", "gripper", "gripper", "move"]
    assert result.parts[1].end - result.parts[1].begin == pytest.approx(0.25)
    assert result.trajectory.certificate.holds
    assert planner.compute_fk("robot", ready, "left_finger1") == finger  # nothing has happened yet


def test_what_stops_a_gripper_is_named(planner, ready):
    planner.set_joint_positions("robot", {"left_finger_joint1": 0.04})
    hand = planner.compute_fk("robot", ready, "left_hand")
    planner.add_box("stone", size=[0.02, 0.03, 0.02], pose=Pose(p=np.add(hand.p, [0, 0, 0.02])))
    with pytest.raises(srmp.PlanningError, match=r"segment 0 \(gripper\): .*left_finger.*'stone'"):
        planner.plan_sequence(ready, [Segment.gripper("close", end_effector="left_gripper")])
    planner.plan_sequence(ready, [Segment.gripper(0.05, end_effector="left_gripper")])


def test_set_joints_are_proved_free_between_samples():
    """A gate that slides by 1 m through a plate that is thinner than a tenth of its way."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_text="""<robot name="gate"><link name="base"/><link name="arm"/>
        <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 5 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
        <joint name="slide" type="prismatic"><parent link="base"/><child link="gate_link"/><axis xyz="1 0 0"/>
        <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
        <link name="gate_link"><collision><geometry><box size="0.01 0.5 0.5"/></geometry></collision></link></robot>""",
        name="gate",
        joint_names=["turn"],
    )
    segments = [Segment.joints({"slide": 1.0})]
    planner.plan_sequence([0.0], segments)
    planner.add_box("plate", size=[0.002, 0.5, 0.5], pose=Pose(p=[0.55, 0, 0]))
    with pytest.raises(srmp.PlanningError, match="the motion of 'slide' cannot be proved free"):
        planner.plan_sequence([0.0], segments)
    planner.set_allowed_collision("plate", "gate_link")
    planner.plan_sequence([0.0], segments)


WRONG_GRIPPERS = [
    (Segment.gripper("open"), r"segment 0 \(gripper\): .*several end effectors; name one of"),
    (Segment.gripper("open", end_effector="left_griper"), "did you mean 'left_gripper'"),
    (Segment.gripper("opne", end_effector="left_gripper"), "no state 'opne'.*did you mean 'open'"),
    (Segment.gripper("ready", end_effector="left_gripper"), "no state 'ready'.*known are 'close' and 'open'"),
    (Segment.gripper(0.2, end_effector="left_gripper"), "is 0.2 m; allowed is 0 to 0.08"),
    (Segment.gripper(-0.01, end_effector="left_gripper"), "allowed is 0 to 0.08"),
    (Segment.gripper(nan, end_effector="left_gripper"), "allowed is 0 to 0.08"),
    (Segment.gripper("open", end_effector="left_gripper", duration=-1), "duration is -1"),
]


@pytest.mark.parametrize(("segment", "sentence"), WRONG_GRIPPERS)
def test_wrong_grippers_are_refused(planner, ready, segment, sentence):
    before = planner.compute_fk("robot", ready, "left_finger1")
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.plan_sequence(ready, [segment])
    assert planner.compute_fk("robot", ready, "left_finger1") == before


def test_grippers_that_are_not_there_are_refused(ready):
    with pytest.raises(srmp.InvalidArgument, match="has no end effector in its SRDF"):
        robot(srdf_path="", group="", end_effector="left_hand").plan_sequence(ready[:7], [Segment.gripper("open")])
    with pytest.raises(srmp.InvalidArgument, match="target"):
        Segment.gripper(None)
    planner = robot(group="", joint_names=["left_joint1", "left_finger_joint1"])
    with pytest.raises(srmp.InvalidArgument, match="'left_finger_joint1' is planned"):
        planner.plan_sequence([0, 0], [Segment.gripper("open", end_effector="left_gripper")])


# --- both hands on one box --------------------------------------------------------------------------------------------


def test_both_hands_carry_a_box(planner, ready, kinematics):
    """The relative pose of the hands is kept to 1 mm and 0.5 degrees at 1 kHz, by Pinocchio alone."""
    start = planner.plan(ready, hands_on(BOX)).positions[-1]
    planner.add_box("box", size=[0.2, 0.3, 0.2], pose=BOX)
    planner.set_qpos("robot", start)
    planner.attach_object("box", "robot", "left_hand", touch_links=["right_hand"])
    grasp = HANDS["left_hand"].inverse() @ HANDS["right_hand"]
    each = (1e-3 / np.sqrt(3), radians(0.5) / np.sqrt(3))  # along and about each axis
    closed = PathConstraint.pose(grasp, *each, link="right_hand", frame="left_hand")
    planner.make_planner("robot", srmp.Auto(time_limit=60))
    motion = planner.plan(start, hands_on(Pose.from_rpy([0.42, 0.1, 0.6], [0, 0, 0.2])), constraints=[closed])
    assert motion.certificate.holds
    times = np.append(np.arange(0, motion.duration, 1e-3), motion.duration)
    worst = 0.0
    for t in times:
        left, right = kinematics(motion.joint_names, motion.sample(t), "left_hand", "right_hand")
        metres, radian = error_of(left.inverse() * right, grasp)
        worst = np.maximum(worst, np.abs((left.inverse() * right).translation - grasp.p).max())
        assert metres <= 1e-3
        assert radian <= radians(0.5)
    proved = motion.certificate.constraints[0]
    assert proved.deviation <= proved.tolerance
    assert worst <= proved.deviation


# --- robots of example-robot-data -------------------------------------------------------------------------------------


@needs_example_robot_data
@pytest.mark.parametrize(
    ("name", "links"),
    [
        ("baxter_both_arms", ("left_gripper", "right_gripper")),
        ("tiago_dual_both_arms", ("arm_left_tool_link", "arm_right_tool_link")),
    ],
)
def test_two_armed_robots_reach_two_poses(name, links):
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        planner.add_robot(name, name="robot")
    start = planner.get_qpos("robot")
    rng = np.random.default_rng(0)
    limits = planner.get_joint_limits("robot")
    for _ in range(200):  # to a configuration without collisions near the start
        q = np.clip(start + rng.uniform(-0.5, 0.5, start.size), limits[:, 0], limits[:, 1])
        if not planner.is_state_colliding("robot", q):
            break
    goals = {link: planner.compute_fk("robot", q, link) for link in links}
    motion = planner.plan(start, goals)
    assert motion.certificate.goal_error <= 1
    for link, goal in goals.items():
        here = planner.compute_fk("robot", motion.positions[-1], link)
        assert np.linalg.norm(here.p - goal.p) < 2e-5
