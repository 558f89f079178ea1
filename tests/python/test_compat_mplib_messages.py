"""srmp.compat.mplib: what is refused, what has no meaning here, and what is said of both."""

import logging
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from mplib_arm import ANY, P, Q, arm_planner
from support import READY

import srmp
from srmp.compat.mplib import Planner, Pose


@pytest.fixture
def planner():
    return arm_planner()


BAD = {
    "no such link": (lambda p: Planner(p, "arm7_hnad"), "move_group has 'arm7_hnad'.* did you mean 'arm7_hand'"),
    "no file": (lambda p: Planner("nowhere.urdf", "hand"), "nowhere.urdf"),
    "package": (lambda p: Planner(p, "arm7_hand", srdf="nowhere.srdf"), "nowhere.srdf"),
    "joint unknown": (
        lambda p: Planner(p, "arm7_hand", user_joint_names=["arm7_jiont1"]),
        "user_joint_names has 'arm7_jiont1', which the robot has not, did you mean 'arm7_joint1'",
    ),
    "joint missing": (
        lambda p: Planner(p, "arm7_hand", user_joint_names=[f"arm7_joint{i}" for i in range(1, 7)]),
        r"user_joint_names lacks \['arm7_joint7'\]",
    ),
    "joint twice": (lambda p: Planner(p, "arm7_hand", user_joint_names=["arm7_joint1"] * 7), "something twice"),
    "links": (
        lambda p: Planner(p, "arm7_hand", user_link_names=["arm7_base"]),
        "move_group has 'arm7_hand', which the robot has not",
    ),
    "velocities": (lambda p: Planner(p, "arm7_hand", joint_vel_limits=[1, 2]), "velocity"),
    "accelerations": (lambda p: Planner(p, "arm7_hand", joint_acc_limits=[-1] * 7), "acceleration"),
    "objects": (
        lambda p: Planner(p, "arm7_hand", objects=["sphere"]),
        "objects cannot be given to Planner; add_object",
    ),
}


@pytest.mark.parametrize("call, sentence", BAD.values(), ids=BAD)
def test_bad_robots_are_refused(call, sentence):
    with pytest.raises(srmp.Error, match=sentence):
        call(srmp.data_path("arm7.urdf"))


def test_broken_urdfs_are_refused(tmp_path):
    for text in (
        "<robot",
        "<robot name='r'><link name='a'/><joint name='j' type='revolute'><limit lower='x'/></joint></robot>",
    ):
        (tmp_path / "broken.urdf").write_text(text)
        with pytest.raises(srmp.FileError, match=r"broken\.urdf"):
            Planner(tmp_path / "broken.urdf", "a")


WRONG = {
    "size": (lambda p: p.plan_qpos([READY], [1, 2]), r"qpos has the shape \(2,\); it must be 7 numbers, of all joints"),
    "text": (lambda p: p.plan_qpos([READY], "here"), "qpos must be numbers, but is 'here'"),
    "one goal": (lambda p: p.plan_qpos(READY, ANY), r"qpos has the shape \(\)"),
    "no goal": (lambda p: p.plan_qpos([], ANY), "target"),
    "NaN": (lambda p: p.plan_qpos([READY], np.full(7, np.nan)), "'arm7_joint1' is NaN"),
    "time step": (lambda p: p.plan_qpos([READY], ANY, time_step=0), "time_step is 0; it must be above 0"),
    "time": (lambda p: p.plan_pose(Pose(), ANY, planning_time=-1), "planning_time is -1; it must be above 0"),
    "qpos step": (lambda p: p.plan_screw(Pose(), ANY, qpos_step=np.inf), "qpos_step is inf"),
    "mask": (lambda p: p.plan_pose(Pose(), ANY, [True] + [False] * 6), "mask holds 'arm7_joint1', which is planned"),
    "IK mask": (lambda p: p.IK(Pose(), ANY, [False] * 6 + [True]), "mask holds 'arm7_joint7', which is planned"),
    "long mask": (lambda p: p.plan_pose(Pose(), ANY, [False] * 8 + [True]), "mask names joint 8; there are 7"),
    "fixed": (
        lambda p: p.plan_qpos([READY], ANY, fixed_joint_indices=[2]),
        "fixed_joint_indices holds 'arm7_joint3'",
    ),
    "constraint": (lambda p: p.plan_qpos([READY], ANY, constraint_function=print), "constraint_function"),
    "tolerance": (lambda p: p.plan_pose(Pose(), ANY, constraint_tolerance=1e-2), "constraint_tolerance"),
    "robot": (lambda p: p.update_attached_box([1, 1, 1], Pose(), art_name="panda"), "art_name is 'panda'; .* 'arm7'"),
    "link": (lambda p: p.update_attached_box([1, 1, 1], Pose(), link_id=99), r"link_id is 99; it must be in 0\.\."),
    "link name": (lambda p: p.update_attached_sphere(1, Pose(), link_id="arm_hand"), "did you mean 'arm7_hand'"),
    "shape": (lambda p: p.update_attached_object("sphere", Pose()), "a geometry must be a Box, .* but is 'sphere'"),
    "object": (lambda p: p.attach_object("sphere"), "there is no object 'sphere'"),
    "full": (lambda p: p.set_qpos(READY[:3], full=True), "qpos has 3 numbers; with full=True it has 7"),
}


@pytest.mark.parametrize("call, sentence", WRONG.values(), ids=WRONG)
def test_bad_input_is_refused(planner, call, sentence):
    with pytest.raises(srmp.Error, match=sentence):
        call(planner)


UNKNOWN = {
    "rrt_rang": lambda p: p.plan_pose(Pose(), ANY, rrt_rang=0.1),
    "time_stp": lambda p: p.plan_qpos_to_qpos([READY], ANY, time_stp=0.1),
    "wrt_wrld": lambda p: p.plan_qpos_to_pose(Pose(), ANY, wrt_wrld=True),
    "qpos_stp": lambda p: p.plan_screw(Pose(), ANY, qpos_stp=0.1),
    "resolutoin": lambda p: p.update_point_cloud([[0, 0, 1]], resolutoin=0.1),
    "move_grup": lambda p: Planner("x.urdf", move_grup="hand"),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_keywords_name_the_nearest(planner, name):
    with pytest.raises(TypeError, match=rf"has no argument '{name}', did you mean '\w+'\?"):
        UNKNOWN[name](planner)


def test_what_has_no_meaning_here_is_said_once(planner):
    with pytest.warns(UserWarning, match="rrt_range has no effect") as said:
        planner.plan_qpos([READY], ANY, rrt_range=0.05)
    assert said[0].filename == __file__
    with pytest.warns(UserWarning, match="planner_name has no effect"):
        planner.plan_qpos_to_pose(Pose(P, Q), ANY, rrt_range=0.0, planner_name="RRTstar")
    with pytest.warns(UserWarning, match="use_convex has no effect") as said:
        Planner(srmp.data_path("arm7.urdf"), "arm7_hand", use_convex=True)
    assert said[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        planner.plan_qpos([READY], ANY, rrt_range=0.05, planner_name="RRTstar")
        planner.plan_pose(Pose(P, Q), ANY, mask=[False] * 7, planner_name="RRTConnect")


def test_only_the_rules_of_collisions_count_in_an_srdf(planner, tmp_path):
    """ManiSkill's panda_stick.srdf names a gripper that is not there."""
    gripper = """<group name="gripper"><link name="arm7_finger"/></group>
        <disable_collisions link1="arm7_finger" link2="arm7_hand" reason="Adjacent"/></robot>"""
    rules = Path(srmp.data_path("arm7.srdf")).read_text()
    (tmp_path / "arm.srdf").write_text(rules.replace("</robot>", gripper))
    other = Planner(srmp.data_path("arm7.urdf"), "arm7_hand", srdf=tmp_path / "arm.srdf")
    same = (one.plan_qpos([READY], ANY)["position"] for one in (other, planner))
    np.testing.assert_array_equal(*same)
    (tmp_path / "arm.srdf").write_text("<robot")
    with pytest.raises(srmp.FileError, match=r"SRDF file '.*arm\.srdf' cannot be read: .* line 1"):
        Planner(srmp.data_path("arm7.urdf"), "arm7_hand", srdf=tmp_path / "arm.srdf")


def test_what_mplib_has_and_this_has_not(planner):
    with pytest.raises(
        AttributeError, match=r"Planner has no 'pinocchio_model'.* Planner\.srmp has all that srmp can do"
    ):
        _ = planner.pinocchio_model
    assert planner.robot is planner and planner.planning_world is planner
    assert not hasattr(planner, "TOPP")


def test_it_is_quiet_and_logs_when_asked(planner, capfd, caplog):
    with caplog.at_level(logging.INFO, logger="srmp.compat.mplib"):
        planner.plan_qpos([READY], ANY)
        planner.plan_pose(Pose([3, 0, 0]), ANY)
        assert caplog.text == ""
        planner.plan_qpos([READY], ANY, verbose=True)
        planner.plan_pose(Pose([3, 0, 0]), ANY, verbose=True)
        planner.plan_screw(Pose([3, 0, 0]), ANY, verbose=True)
        planner.IK(Pose([3, 0, 0]), ANY, verbose=True)
    assert re.search(r"a plan of .* s\n(.|\n)*no plan: .*brings(.|\n)*no plan: After(.|\n)*IK: 0 config", caplog.text)
    assert capfd.readouterr() == ("", "")


def test_neither_mplib_nor_sapien_is_imported():
    code = "import sys, srmp.compat.mplib; print(sorted({'mplib', 'sapien', 'toppra'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_every_public_call_has_a_docstring():
    for cls in (Planner, Pose):
        for name in dir(cls):
            if not name.startswith("_"):
                assert (getattr(cls, name).__doc__ or "").strip(), f"{cls.__name__}.{name}"
