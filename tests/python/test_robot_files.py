"""Robot files that people have: what does not change the meaning is a warning, and every refusal says what helps."""

import warnings

import numpy as np
import pytest

import srmp

LIMIT = "<limit lower='-1' upper='1' velocity='1' effort='1'/>"


def joint(name, parent, child, inside=LIMIT, kind="revolute"):
    ends = f"<parent link='{parent}'/><child link='{child}'/>"
    return f"<joint name='{name}' type='{kind}'>{ends}{inside}<axis xyz='0 0 1'/></joint>"


def urdf(*joints, links="abcd"):
    return f"<robot name='r'>{''.join(f'<link name={link!r}/>' for link in links)}{''.join(joints)}</robot>"


CHAIN = urdf(joint("one", "a", "b"), joint("two", "b", "c"), joint("three", "c", "d"))
GRIPPER = urdf(
    joint("one", "a", "b"),
    joint("two", "b", "c"),
    joint("left", "c", "d", LIMIT, "prismatic"),
    joint("right", "c", "e", LIMIT + "<mimic joint='left'/>", "prismatic"),
    links="abcde",
)


def load(urdf_text, srdf="", **options):
    planner = srmp.PlannerInterface()
    srdf_text = f"<robot name='r'>{srdf}</robot>" if srdf else ""
    planner.add_articulation(urdf_text=urdf_text, srdf_text=srdf_text, **options)
    return planner


def state(name="home", group=" group='arm'", joints=("one", "two", "three")):
    return (
        f"<group_state name='{name}'{group}>"
        + "".join(f"<joint name='{j}' value='0.5'/>" for j in joints)
        + "</group_state>"
    )


ARM = "<group name='arm'><chain base_link='a' tip_link='d'/></group>"
WARNED = [
    (CHAIN, ARM + state(group=""), "<group_state> has no attribute 'group'"),
    (CHAIN, ARM + state(joints=("root_joint", "one", "two", "three")), "names the unknown joint 'root_joint'"),
    (CHAIN.replace("effort='1'", "effort='1' gear_velocity='3'"), ARM, "unknown attribute 'gear_velocity' of <limit>"),
    (CHAIN, ARM + "<end_effector name='e' group='arm' parent_link='lost'/>", "names the unknown link 'lost'"),
    (CHAIN.replace("velocity='1'", "velocity='0'"), ARM, "has no velocity limit above 0; 1 rad/s is taken"),
    (CHAIN, ARM + "<group name='hand'><joint name='finger'/></group>", "group 'hand' cannot be used: <joint> names"),
]


@pytest.mark.parametrize(("urdf_text", "srdf", "sentence"), WARNED)
def test_what_does_not_change_the_meaning_is_a_warning(urdf_text, srdf, sentence):
    with pytest.warns(srmp.RobotWarning, match=f"robot 'r': .*{sentence}") as record:
        planner = load(urdf_text, srdf, group="arm")
    assert record[0].filename == __file__
    assert any(sentence in warning for warning in planner.warnings("r"))
    assert planner.get_joint_names("r") == ["one", "two", "three"]
    with pytest.raises((srmp.FileError, srmp.InvalidArgument), match=sentence.split(";")[0]):
        load(urdf_text, srdf, group="arm", strict=True)


def test_states_of_such_files_are_there():
    with pytest.warns(srmp.RobotWarning):
        planner = load(CHAIN, state(group="", joints=("root_joint", "one", "two", "three")))
    assert planner.get_group_states("r")["home"].tolist() == [0.5, 0.5, 0.5]


def test_robots_without_a_fault_have_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        planner = load(CHAIN, ARM + state(), group="arm")
    assert planner.warnings("r") == []


def test_where_warnings_are_errors_nothing_is_added():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        planner = srmp.PlannerInterface()
        with pytest.raises(srmp.RobotWarning):
            planner.add_articulation(urdf_text=CHAIN, srdf_text=f"<robot name='r'>{state(group='')}</robot>")
    assert planner.robot_names == []


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_joints_of_several_degrees_of_freedom_are_said_loudly(kind):
    text = urdf(joint("rail", "a", "b", "", kind), joint("two", "b", "c"), joint("three", "c", "d"))
    with pytest.warns(srmp.RobotWarning, match="joint 'rail' has more than one degree of freedom; it is not planned"):
        planner = load(text)
    with pytest.raises(srmp.InvalidArgument, match="'rail' of robot 'r' has more than one degree of freedom and stays"):
        planner.set_joint_positions("r", {"rail": 0.1})


def test_degrees_are_named():
    planner = load(CHAIN)
    sentence = r"angles are in radians \(45 degrees are 0.7854 rad\)"
    for call in (
        lambda: planner.set_qpos("r", [0, 45, 0]),
        lambda: planner.set_joint_positions("r", {"two": 45}),
        lambda: load(GRIPPER.replace("prismatic", "revolute"), end_effector="c", fixed_joints={"left": 45}),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            call()
    for start, goal in (([0, 45, 0], np.zeros(3)), (np.zeros(3), [0, 45, 0])):
        with pytest.raises(srmp.PlanningError, match=sentence):
            planner.plan("r", start, goal)
    with pytest.warns(srmp.RobotWarning, match="limits -170 to 170 rad, more than two turns; are they in degrees?"):
        load(CHAIN.replace("lower='-1' upper='1'", "lower='-170' upper='170'"))
    with pytest.warns(srmp.RobotWarning, match="an angle of 90 rad, more than a turn; is it in degrees?"):
        load(CHAIN.replace("<axis", "<origin rpy='0 0 90'/><axis"))


def test_mimic_joints_name_the_joint_to_set():
    planner = load(GRIPPER, end_effector="c")
    sentence = "joint 'right' of robot 'r' follows joint 'left'.*set that one"
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.set_joint_positions("r", {"right": 0.1})
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        planner.goal("r", {"right": 0.1})
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        load(GRIPPER, end_effector="c", fixed_joints={"right": 0.1})
    planner.set_joint_positions("r", {"left": 0.1})


@pytest.mark.parametrize(
    ("end_effector", "sentence"),
    [
        ("three", "it is a joint, which moves the link 'd'"),
        ("arm", "it is a group of the SRDF: give it as group"),
        ("grip", "the SRDF's end effector 'grip' is at the link 'd'"),
        ("tool0_of_this_robot", "links at the ends of its chains are 'd'"),
    ],
)
def test_wrong_end_effectors_name_the_right_one(end_effector, sentence):
    srdf = ARM + "<group name='hand'><link name='d'/></group><end_effector name='grip' group='hand' parent_link='d'/>"
    with pytest.raises(srmp.InvalidArgument, match=f"'{end_effector}' is not a link of robot 'r'; {sentence}"):
        load(CHAIN, srdf, end_effector=end_effector)


@pytest.mark.parametrize(
    "text",
    [
        CHAIN.replace("lower='-1'", "lower='${-pi}'"),
        CHAIN.replace("<robot", "<robot xmlns:xacro='http://ros.org/wiki/xacro'", 1).replace(
            "</robot>", "<xacro:include filename='x.xacro'/></robot>"
        ),
        urdf().replace("</robot>", "<xacro:arm name='left'/></robot>"),
    ],
)
def test_xacro_is_named(text):
    with pytest.raises(srmp.FileError, match=r"Xacro.*; expand the file first \(xacro FILE.xacro > FILE\)"):
        load(text)


def test_a_file_that_xacro_made_is_no_xacro_file():
    load(CHAIN.replace("<robot", "<robot xmlns:xacro='http://ros.org/wiki/xacro'", 1))
