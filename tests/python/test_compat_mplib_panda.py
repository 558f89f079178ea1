"""srmp.compat.mplib: joints that move and are not planned, as the Panda's fingers in ManiSkill."""

import types
from pathlib import Path

import numpy as np
import pytest
from mplib_arm import ANY, DOWN, assert_a_plan, hand
from support import READY

import srmp
from srmp.compat.mplib import Planner, Pose

PANDA = np.array([0, -0.4, 0, -2, 0, 1.6, 0.78, 0.04, 0.04])


@pytest.fixture
def make_panda(mbm_dir, tmp_path):
    """A Panda whose fingers move, as ManiSkill's, the second listed as the mimic of the first."""
    text = (mbm_dir / "panda" / "panda.urdf").read_text()
    for finger in ("panda_finger_joint1", "panda_finger_joint2"):
        limit = '<limit effort="20" lower="0" upper="0.04" velocity="0.2"/>'
        text = text.replace(f'name="{finger}" type="fixed">', f'name="{finger}" type="prismatic">{limit}')
    (tmp_path / "panda.urdf").write_text(text)

    def make(**options):
        return Planner(
            urdf=tmp_path / "panda.urdf",
            srdf=mbm_dir / "panda" / "panda.srdf",
            move_group="panda_hand",
            new_package_keyword=f"{mbm_dir}/panda/",
            **options,
        )

    return make


def test_joints_are_in_mplibs_order(make_panda):
    panda = make_panda()
    arm, fingers = [f"panda_joint{i}" for i in range(1, 8)], ["panda_finger_joint1", "panda_finger_joint2"]
    assert panda.user_joint_names == [*arm, *fingers]  # what mplib 0.2.1 says
    assert panda.user_link_names[-4:] == ["panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_grasptarget"]
    assert panda.move_group_joint_indices == list(range(7)) and panda.link_name_2_idx["panda_hand"] == 9
    np.testing.assert_array_equal(panda.joint_limits[7:], [[0, 0.04]] * 2)


def test_fingers_stand_as_told(make_panda):
    panda = make_panda()
    goal = Pose([0.5, 0.2, 0.5], DOWN)
    whole = panda.plan_pose(goal, PANDA, time_step=0.02)
    assert_a_plan(panda, whole, PANDA[:7], 0.02)
    arm = panda.plan_pose(goal, PANDA[:7], time_step=0.02)  # the fingers stay
    np.testing.assert_array_equal(arm["position"], whole["position"])
    panda.set_qpos([*PANDA[:7], 0.03, 0.0400001], full=True)  # each for itself, and on its limit
    np.testing.assert_array_equal(panda.get_qpos()[7:], [0.03, 0.04])
    left, right = (panda.srmp.compute_fk("panda", PANDA[:7], f"panda_{side}finger") for side in ("left", "right"))
    palm = hand(panda, PANDA[:7]).inverse()
    np.testing.assert_allclose([(palm @ left).p[1], (palm @ right).p[1]], [0.065 + 0.03, -0.065 - 0.04], atol=1e-9)
    found = panda.IK(goal, PANDA)[1]
    assert all((q[7:] == PANDA[7:]).all() for q in found)
    assert panda.plan_qpos([found[0]], PANDA)["status"] == "Success"


def test_joints_that_follow_planned_ones_do_so(tmp_path):
    """Two levers on the base: one goes with the first joint, half as far; one with the first lever, twice as far."""
    levers = "".join(
        f'''<link name="{name}"/>
        <joint name="{name}_joint" type="revolute">
          <parent link="arm7_base"/> <child link="{name}"/> <axis xyz="0 0 1"/>
          <limit lower="-3" upper="3" velocity="1"/> <mimic joint="{source}" multiplier="{factor}"/>
        </joint>'''
        for name, source, factor in (("half", "arm7_joint1", 0.5), ("whole", "half_joint", 2))
    )
    text = Path(srmp.data_path("arm7.urdf")).read_text().replace("</robot>", levers + "</robot>")
    (tmp_path / "arm.urdf").write_text(text)
    planner = Planner(tmp_path / "arm.urdf", "arm7_hand")
    assert planner.user_joint_names[-2:] == ["half_joint", "whole_joint"]
    assert planner.plan_qpos([READY], [*ANY, 3, 3])["status"] == "Success"  # the last two numbers are not used
    for link, angle in (("half", 0.45), ("whole", 0.9)):
        turn = Pose(planner.srmp.compute_fk("arm7", ANY, link)).q
        np.testing.assert_allclose(turn, [np.cos(angle / 2), 0, 0, np.sin(angle / 2)], atol=1e-12)


def test_joints_may_be_in_any_order(make_panda):
    names = make_panda().user_joint_names
    turned, panda = make_panda(user_joint_names=names[::-1]), make_panda()
    goal = np.add(PANDA, [0.3, 0, 0, 0.1, 0, 0, 0.2, 0, 0])
    result = turned.plan_qpos([goal[::-1]], PANDA[::-1])
    assert_a_plan(turned, result, PANDA[6::-1], 0.1)
    np.testing.assert_array_equal(result["position"][-1], goal[6::-1])
    assert turned.move_group_joint_indices == list(range(2, 9))
    assert panda.plan_qpos([goal], PANDA)["status"] == "Success"


def test_what_is_held_may_touch_the_whole_hand(make_panda):
    panda = make_panda()
    closed = [*PANDA[:7], 0.0, 0.0]
    panda.update_attached_box([0.05, 0.3, 0.05], Pose([0, 0, 0.1]))
    assert panda.check_for_self_collision(closed) == []
    panda.update_attached_box([0.4, 0.4, 0.05], Pose([0, 0, -0.15]))  # in the arm
    assert {c.link_name1 for c in panda.check_for_self_collision(closed)} <= {f"panda_link{i}" for i in range(7)}
    assert panda.check_for_self_collision(closed) != []


def test_a_pick_as_maniskills_solvers_make_it(make_panda):
    """Approach, reach, close, lift, carry round an obstacle; the cube's pose is checked at the end."""
    links = make_panda().user_link_names
    joints = make_panda().user_joint_names
    panda = make_panda(
        user_link_names=links,
        user_joint_names=joints,
        joint_vel_limits=np.ones(7) * 0.9,
        joint_acc_limits=np.ones(7) * 0.9,
    )
    base = types.SimpleNamespace(p=np.array([-0.615, 0, 0], np.float32), q=np.array([1, 0, 0, 0], np.float32))
    panda.set_base_pose(np.hstack([base.p, base.q]))
    qpos = PANDA.copy()

    def move(result):
        assert result["status"] == "Success", result["status"]
        for row, velocity in zip(result["position"], result["velocity"], strict=True):
            qpos[:7] = row
            assert (np.abs(velocity) <= 0.9 + 1e-6).all() and not panda.check_for_collision(qpos)

    cube = np.array([0.0, -0.1, 0.02])
    table = np.random.default_rng(0).uniform([-0.4, -0.5, -0.02], [0.4, 0.5, -0.01], (2000, 3))
    panda.update_point_cloud(table)  # 1 mm
    grasp = np.hstack([np.add(cube, [0, 0, 0.105]), DOWN])
    above = np.add(grasp, [0, 0, 0.12, 0, 0, 0, 0])
    move(panda.plan_qpos_to_pose(above, qpos, time_step=0.05, use_point_cloud=True, wrt_world=True))
    move(panda.plan_screw(grasp, qpos, time_step=0.05, use_point_cloud=True))
    qpos[7:] = 0.02
    panda.set_qpos(qpos, True)
    panda.update_attached_box([0.04, 0.04, 0.035], Pose([0, 0, 0.105]))
    move(panda.plan_screw(above, qpos, time_step=0.05, use_point_cloud=True))
    wall = np.array([[x, 0.1, z] for x in np.arange(-0.2, 0.2, 0.01) for z in np.arange(0, 0.25, 0.01)])
    panda.update_point_cloud(np.vstack([table, wall]), resolution=0.01)
    goal = np.hstack([[0.0, 0.3, 0.2], DOWN])
    assert panda.plan_screw(goal, qpos)["status"].startswith("Screw plan failed.")
    move(panda.plan_qpos_to_pose(goal, qpos, time_step=0.05, planning_time=5))
    panda.set_qpos(qpos, True)
    assert panda.detach_object(f"panda_{panda.move_group_link_id}_box")
    left = panda.srmp.get_object_pose(f"panda_{panda.move_group_link_id}_box")
    np.testing.assert_allclose(left.p, [0, 0.3, 0.2 - 0.105], atol=1e-4)
