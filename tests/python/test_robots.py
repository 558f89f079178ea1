"""Robots by name, lists of robots, and allowed collisions by sampling."""

import re
import warnings
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from support import ERD, needs_example_robot_data

import srmp
import srmp.robots
from srmp.cli import main
from srmp.robots._packages import PACKAGES


@pytest.fixture(autouse=True)
def nothing_registered(monkeypatch):
    monkeypatch.setattr(srmp.robots, "_registered", {})
    monkeypatch.delenv("SRMP_ROBOTS", raising=False)


def write_list(directory, text):
    path = directory / "mine.toml"
    path.write_text(text)
    return path


def own_robot(directory, more=""):
    (directory / "mine.urdf").write_text(Path(srmp.data_path("arm7.urdf")).read_text())
    return write_list(directory, f'[mine]\nurdf = "mine.urdf"\nend_effector = "arm7_hand"\n{more}')


# --- by name ----------------------------------------------------------------------------------------------------------


def test_the_packages_own_arm_plans():
    planner = srmp.PlannerInterface()
    robot = planner.add_robot("arm7")
    assert robot.installed
    assert robot.groups == ["arm"]
    assert len(planner.plan(planner.get_group_states("arm7")["ready"], "upright")) > 1


def test_arguments_count_more_than_the_list():
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7", name="left", base_pose=srmp.Pose(p=[0, 1, 0]))
    planner.add_robot("arm7", name="right", end_effector="arm7_wrist")
    assert planner.robot_names == ["left", "right"]
    assert planner.get_end_effector("right") == "arm7_wrist"
    assert planner.compute_fk("left", planner.get_qpos("left"), "arm7_base").p[1] == 1


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"robot": "arm8"}, srmp.InvalidArgument, "no robot 'arm8' is known, did you mean 'arm7'"),
        ({"robot": 7}, srmp.InvalidArgument, "no robot 7 is known"),
        ({"robot": None}, srmp.InvalidArgument, "no robot None is known"),
        ({"robot": "arm7", "nmae": "x"}, srmp.InvalidArgument, "no argument 'nmae', did you mean 'name'"),
        ({"robot": "arm7", "group": "leg"}, srmp.InvalidArgument, "leg"),
        ({"robot": "hector"}, srmp.NotSupported, "cannot be planned: it has no joint that is planned"),
    ],
)
def test_wrong_calls_add_nothing(arguments, error, text):
    planner = srmp.PlannerInterface()
    with pytest.raises(error, match=text):
        planner.add_robot(**arguments)
    assert planner.robot_names == []


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(PACKAGES, "example-robot-data", lambda: None)
    with pytest.raises(srmp.NotSupported, match="pip install example-robot-data"):
        srmp.PlannerInterface().add_robot("panda")
    assert not srmp.robots.find("panda").installed
    assert srmp.robots.find("panda").groups == []


# --- lists of the user's own ------------------------------------------------------------------------------------------


def test_a_list_of_the_users_own(tmp_path, monkeypatch):
    own_robot(tmp_path, "[mine.limits]\narm7_joint1 = { acceleration = 3.5, velocity = 0.5 }\n")
    with pytest.raises(srmp.InvalidArgument, match="mine"):
        srmp.robots.find("mine")
    monkeypatch.setenv("SRMP_ROBOTS", str(tmp_path))
    planner = srmp.PlannerInterface()
    planner.add_robot("mine")
    assert planner.motion_limits("mine").acceleration[0] == 3.5
    assert planner.motion_limits("mine").velocity[0] == 0.5
    monkeypatch.delenv("SRMP_ROBOTS")
    assert [robot.name for robot in srmp.robots.register(tmp_path / "mine.toml")] == ["mine"]
    assert srmp.robots.find("mine").installed


def test_limits_of_unknown_joints_add_nothing(tmp_path):
    srmp.robots.register(own_robot(tmp_path, "[mine.limits]\narm7_joint9 = { jerk = 3.5 }\n"))
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.InvalidArgument, match=r"'arm7_joint9'.*did you mean"):
        planner.add_robot("mine")
    assert planner.robot_names == []


def test_a_list_allows_collisions(tmp_path):
    srmp.robots.register(own_robot(tmp_path, 'allowed_collisions = [["arm7_base", "arm7_hand"]]\n'))
    planner = srmp.PlannerInterface()
    planner.add_robot("mine", name="other")
    assert planner.allowed_collision("other/arm7_base", "other/arm7_hand")


def test_allowed_collisions_of_unknown_links_add_nothing(tmp_path):
    srmp.robots.register(own_robot(tmp_path, 'allowed_collisions = [["arm7_base", "arm7_hnd"]]\n'))
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.InvalidArgument, match="arm7_hnd"):
        planner.add_robot("mine")
    assert planner.robot_names == []


@needs_example_robot_data
def test_another_group_plans_joints_that_the_list_fixes():
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        planner.add_robot("alex", group="right_arm")
    assert "RightElbowPitch" in planner.get_joint_names("alex")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[mine", "is not TOML"),
        ("mine = 3", "'mine' must be a table"),
        ("[mine]\n", "needs urdf"),
        ('[mine]\nurdf = "a"\nurfd = "b"', "unknown key 'urfd', did you mean 'urdf'"),
        ("[mine]\nurdf = 3", "urdf of robot 'mine' must be a string, but is 3"),
        ('[mine]\nurdf = "a"\ngripper = "finger"', "gripper of robot 'mine' must be a list of strings"),
        ('[mine]\nurdf = "a"\nfixed_joints = { j = "x" }', "must be a table of numbers by joint"),
        (
            '[mine]\nurdf = "a"\nallowed_collisions = ["a", "b"]',
            "allowed_collisions of robot 'mine' must be a list of pairs",
        ),
        ('[mine]\nurdf = "a"\nlimits = { j = { speed = 1 } }', "velocity, acceleration, jerk"),
        ('[mine]\nurdf = "a"\npackage = "example-robots-data"', "did you mean 'example-robot-data'"),
    ],
)
def test_broken_lists_are_refused(tmp_path, text, says):
    with pytest.raises(srmp.FileError, match=says):
        srmp.robots.register(write_list(tmp_path, text))
    assert "mine" not in srmp.robots.available()


def test_a_missing_list_is_refused(tmp_path):
    with pytest.raises(srmp.FileError, match=r"cannot read .*nowhere\.toml"):
        srmp.robots.register(tmp_path / "nowhere.toml")


# --- all robots of example-robot-data ---------------------------------------------------------------------------------


@needs_example_robot_data
def test_every_robot_of_example_robot_data_is_listed():
    listed = {robot.urdf for robot in srmp.robots.available().values() if robot.package == "example-robot-data"}
    assert listed == {str(path.relative_to(ERD)) for path in (ERD / "example-robot-data").rglob("*.urdf")}


@needs_example_robot_data
@pytest.mark.parametrize(
    "name", [name for name, robot in srmp.robots.available().items() if robot.package == "example-robot-data"]
)
def test_every_robot_of_example_robot_data_loads_or_says_why(name):
    planner, robot = srmp.PlannerInterface(), srmp.robots.find(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        if robot.refused:
            with pytest.raises(srmp.NotSupported, match="cannot be planned"):
                planner.add_robot(name)
            with pytest.raises(srmp.Error):  # it would not load either
                planner.add_articulation(**robot.arguments())
            return
        planner.add_robot(name)
    assert len(planner.get_joint_names(name)) >= 1
    assert not set(robot.gripper) & set(planner.get_joint_names(name))
    assert set(robot.gripper) <= {joint.get("name") for joint in ElementTree.parse(robot.urdf_path).iter("joint")}


@needs_example_robot_data
def test_limits_of_the_makers():
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        for name in ("panda", "panda_collision", "xarm7"):
            planner.add_robot(name, base_pose=srmp.Pose(p=[0, 2.0 * len(planner.robot_names), 0]))
    assert planner.motion_limits("panda_collision") == planner.motion_limits("panda")
    assert planner.motion_limits("xarm7").acceleration.tolist() == [20.0] * 7  # 1145 degrees per second squared


# --- allowed collisions -----------------------------------------------------------------------------------------------


def test_sampled_collisions_are_an_srdf_that_loads(tmp_path):
    urdf = srmp.data_path("arm7.urdf")
    found = srmp.robots.sample_allowed_collisions(urdf, samples=300, end_effector="arm7_hand")
    assert set(found.pairs.values()) <= {"Adjacent", "Always", "Default", "Never"}
    assert found.pairs["arm7_base", "arm7_shoulder"] == "Adjacent"
    assert found.checked
    assert not set(found.pairs) & set(found.checked)
    found.save(tmp_path / "arm.srdf")
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_path=urdf, srdf_path=str(tmp_path / "arm.srdf"), name="arm", group="arm")
    assert planner.warnings("arm") == []
    for (a, b), reason in found.pairs.items():
        assert planner.allowed_collision(f"arm/{a}", f"arm/{b}"), reason
    assert not any(planner.allowed_collision(f"arm/{a}", f"arm/{b}") for a, b in found.checked)


def test_the_same_seed_gives_the_same_file():
    urdf = srmp.data_path("arm7.urdf")
    first, again, other = (
        srmp.robots.sample_allowed_collisions(urdf, samples=100, seed=seed).to_srdf() for seed in (1, 1, np.int64(2))
    )
    assert first == again
    assert first != other


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"samples": 0}, "samples must be a whole number of at least 1, but is 0"),
        ({"samples": 1.5}, "samples must be"),
        ({"seed": -1}, "seed must be a whole number of at least 0"),
        ({"end_effector": "arm7_hnad"}, "no link 'arm7_hnad', did you mean 'arm7_hand'"),
    ],
)
def test_wrong_arguments_of_sampling(arguments, text):
    with pytest.raises(srmp.InvalidArgument, match=text):
        srmp.robots.sample_allowed_collisions(srmp.data_path("arm7.urdf"), **arguments)


def test_sampling_needs_a_urdf_with_joints(tmp_path):
    with pytest.raises(srmp.FileError, match="cannot read"):
        srmp.robots.sample_allowed_collisions(tmp_path / "nowhere.urdf")
    (tmp_path / "x.urdf").write_text("robot")
    with pytest.raises(srmp.FileError, match="is not a URDF"):
        srmp.robots.sample_allowed_collisions(tmp_path / "x.urdf")
    (tmp_path / "x.urdf").write_text('<robot name="stone"><link name="a"/></robot>')
    with pytest.raises(srmp.InvalidArgument, match="no movable joint"):
        srmp.robots.sample_allowed_collisions(tmp_path / "x.urdf")


# --- the commands -----------------------------------------------------------------------------------------------------


def invoke(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.output


def test_robots_are_listed_and_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    assert "panda" in invoke("robots")
    text = invoke("robots", "arm7", "--pictures", tmp_path / "pictures")
    assert "arm7_joint1: " in text
    assert "groups: arm" in text
    assert (tmp_path / "pictures" / "arm7.png").stat().st_size > 10_000


def test_srdf_is_written_with_a_report(tmp_path):
    urdf = srmp.data_path("arm7.urdf")
    text = invoke("srdf", urdf, "-o", tmp_path / "arm.srdf", "--samples", 100, "--end-effector", "arm7_hand")
    assert "stay checked" in text
    assert "100 samples, seed 0" in (tmp_path / "arm.srdf").read_text()


def test_readme_counts_the_robots_of_the_table():
    root = Path(__file__).parents[2]
    table = re.findall(r"^\| (\w+) \|.*\| (yes|no) \|.*$", (root / "docs/robots.md").read_text(), flags=re.M)
    names = [
        name
        for name, robot in srmp.robots.available().items()
        if robot.package == "example-robot-data" and not name.endswith("_both_arms")  # see test_two_hands.py
    ]
    assert [name for name, _ in table] == names
    loads = sum(loads == "yes" for _, loads in table)
    assert (
        f"{len(table)} robots of `example-robot-data` are listed, {loads} of them" in (root / "README.md").read_text()
    )
