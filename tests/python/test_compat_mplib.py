"""srmp.compat.mplib: MPLib's and ManiSkill's calls, on this planner."""

import logging
import re
import subprocess
import sys
import types
import warnings
from pathlib import Path

import numpy as np
import pytest

import srmp
from srmp.compat import mplib
from srmp.compat._pose import screw
from srmp.compat.mplib import Box, CollisionObject, Planner, Pose, Sphere

READY = np.array([0, 0, 0, np.pi / 2, 0, np.pi / 2, 0])
TURN = np.array([0.9, 0, 0, 0, 0, 0, 0])
ANY = READY + TURN
PANDA = np.array([0, -0.4, 0, -2, 0, 1.6, 0.78, 0.04, 0.04])
DOWN = [0, 1, 0, 0]  # w, x, y, z: half a turn about x


@pytest.fixture
def planner():
    return Planner(srmp.data_path("arm7.urdf"), "arm7_hand", srdf=srmp.data_path("arm7.srdf"))


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


def hand(planner, q):
    """The move group's pose, in the world."""
    return planner.srmp.compute_fk(planner.get_name(), q)


def assert_a_plan(planner, result, start, time_step):
    assert result["status"] == "Success"
    n, dof = len(result["time"]), len(planner.move_group_joint_indices)
    assert all(result[key].shape == (n, dof) for key in ("position", "velocity", "acceleration"))
    steps = np.diff(result["time"])
    assert np.ptp(steps) < 1e-9 and 0.5 * time_step < steps[0] <= time_step * (1 + 1e-12)
    assert result["time"][0] == 0 and result["time"][-1] == result["duration"]
    np.testing.assert_array_equal(result["position"][0], start)
    np.testing.assert_allclose(result["velocity"][[0, -1]], 0, atol=1e-9)
    assert (np.abs(result["velocity"]) <= np.asarray(planner.joint_vel_limits) + 1e-6).all()
    assert (np.abs(result["acceleration"]) <= np.asarray(planner.joint_acc_limits) + 1e-6).all()
    motion = planner.srmp.collision_checker(planner.get_name())
    assert motion.are_free(result["position"]).all()


# --- poses


P = [0.45, 0.25, 0.35]
Q = np.array([0.3, 0.9, 0.2, 0.1]) / np.linalg.norm([0.3, 0.9, 0.2, 0.1])  # w, x, y, z: all different
SAME_POSE = {
    "Pose": Pose(P, Q),
    "MPLib 0.1": [*P, *Q],
    "sapien.Pose": types.SimpleNamespace(p=np.array(P), q=Q),
    "ManiSkill's batch": types.SimpleNamespace(p=np.array([P]), q=Q[None]),
    "srmp.Pose": srmp.Pose(P, [Q[1], Q[2], Q[3], Q[0]]),
    "matrix": srmp.Pose.from_wxyz(P, Q).matrix(),
}


@pytest.mark.parametrize("value", SAME_POSE.values(), ids=SAME_POSE)
def test_quaternions_are_wxyz_but_those_of_srmp_poses(value):
    pose = Pose(value)
    np.testing.assert_allclose(pose.p, P, atol=1e-15)
    np.testing.assert_allclose(pose.q, Q, atol=1e-15)


def test_poses_have_mplibs_calls():
    a, b = Pose([0.1, 0.2, 0.3], Q), Pose(q=DOWN)
    np.testing.assert_allclose(
        (a * b).to_transformation_matrix(), a.to_transformation_matrix() @ np.diag([1, -1, -1, 1])
    )
    np.testing.assert_allclose(b * np.array([1, 2, 3]), [1, -2, -3])
    assert (a * a.inv()).distance(Pose()) < 1e-12
    assert Pose([1, 2, 3]).distance(Pose([1, 2, 5])) == 2
    assert Pose(a.p, -a.q).distance(a) < 1e-12
    b.p, b.q = a.p, 2 * a.q
    np.testing.assert_allclose([*b.p, *b.q], [*a.p, *a.q])
    assert b == Pose(b) and b != Pose()
    assert repr(Pose([1, 2, 3])) == "Pose([1.0, 2.0, 3.0], [1.0, 0.0, 0.0, 0.0])"


@pytest.mark.parametrize("value", [[1, 2, 3], "there", None, np.zeros((2, 7)), {"p": 1}])
def test_what_is_no_pose_is_refused(planner, value):
    with pytest.raises(srmp.InvalidArgument, match=r"a pose must be an object with p and q = \[w, x, y, z\]"):
        planner.plan_pose(value, ANY)


# --- plans


@pytest.mark.parametrize("form", SAME_POSE)
def test_plan_pose_reaches_it(planner, form):
    result = planner.plan_pose(SAME_POSE[form], ANY, time_step=0.02)
    assert_a_plan(planner, result, ANY, 0.02)
    assert Pose(hand(planner, result["position"][-1])).distance(Pose(P, Q)) < 1e-4


def test_poses_in_the_frame_of_the_base(planner):
    base, goal = Pose([0.4, -0.3, 0.2], [0.6, 0, 0, 0.8]), Pose(P, Q)
    planner.set_base_pose([*base.p, *base.q])
    assert planner.get_base_pose() == base
    in_base = planner.plan_pose(goal, ANY, wrt_world=False)
    in_world = planner.plan_pose(base * goal, ANY)
    for result in (in_base, in_world, planner.plan_screw(goal, in_base["position"][-1], wrt_world=False)):
        assert result["status"] == "Success"
        assert Pose(hand(planner, result["position"][-1])).distance(base * goal) < 1e-4
    status, found = planner.IK(goal, ANY)
    assert status == "Success"
    assert all(Pose(hand(planner, q)).distance(base * goal) < 1e-3 for q in found)


def test_plan_qpos_reaches_one_of_its_goals(planner):
    beyond = np.full(7, 9.0)
    result = planner.plan_qpos([beyond, READY], ANY, time_step=0.05)
    assert_a_plan(planner, result, ANY, 0.05)
    np.testing.assert_array_equal(result["position"][-1], READY)


def test_limits_are_those_given():
    slow = Planner(
        srmp.data_path("arm7.urdf"), "arm7_hand", joint_vel_limits=np.full(7, 0.2), joint_acc_limits=[0.5] * 7
    )
    assert_a_plan(slow, slow.plan_qpos([READY], ANY), ANY, 0.1)
    assert slow.plan_qpos([READY], ANY)["duration"] > 0.9 / 0.2


def test_urdfs_need_no_velocity_limits(planner, tmp_path):
    """ManiSkill's so100.urdf has zeros."""
    text = Path(srmp.data_path("arm7.urdf")).read_text()
    (tmp_path / "arm7.srdf").write_text(Path(srmp.data_path("arm7.srdf")).read_text())
    for velocity in ('velocity="0"', ""):
        (tmp_path / "arm7.urdf").write_text(re.sub(r'velocity="[^"]*"', velocity, text))
        other = Planner(tmp_path / "arm7.urdf", "arm7_hand")
        np.testing.assert_array_equal(other.joint_vel_limits, np.ones(7))
        same = (one.plan_qpos([READY], ANY)["position"] for one in (other, planner))
        np.testing.assert_array_equal(*same)


def test_calls_of_0_1(planner):
    goal = [*P, *Q]
    old = planner.plan_qpos_to_pose(goal, ANY, time_step=0.05, use_point_cloud=False, wrt_world=True)
    new = planner.plan_pose(Pose(goal), ANY, time_step=0.05)
    np.testing.assert_array_equal(old["position"], new["position"])
    old = planner.plan_qpos_to_qpos([READY], ANY, 0.05)
    np.testing.assert_array_equal(old["position"], planner.plan_qpos([READY], ANY, time_step=0.05)["position"])


def test_paths_may_stay_as_they_were_found(planner):
    planner.add_object("post", CollisionObject(Box([0.1, 0.1, 0.8]), Pose([0.4, 0, 0.4])))
    goal = [READY - TURN]
    straight, found, old = (
        planner.plan_qpos(goal, ANY),
        planner.plan_qpos(goal, ANY, simplify=False),
        planner.plan_qpos_to_qpos(goal, ANY, no_simplification=True),
    )
    assert straight["duration"] < found["duration"]
    np.testing.assert_array_equal(found["position"], old["position"])


def test_the_same_request_has_the_same_result(planner):
    def outcomes(one):
        one.update_point_cloud(np.random.default_rng(1).uniform([0.3, 0.1, 0.1], [0.6, 0.3, 0.5], (200, 3)), 0.01)
        for result in (
            one.plan_pose(Pose([0.4, -0.3, 0.3], DOWN), ANY),
            one.plan_qpos([READY - TURN], ANY),
            one.plan_screw(Pose(hand(one, ANY)) * Pose([0, 0, 0.1]), ANY),
        ):
            yield result["status"], *(result[key].tobytes() for key in ("time", "position", "velocity", "acceleration"))

    first = list(outcomes(planner))
    assert first == list(outcomes(planner))
    assert first == list(outcomes(Planner(srmp.data_path("arm7.urdf"), "arm7_hand")))  # arm7.srdf lies beside it


def test_why_there_is_no_plan(planner):
    out_of_reach = planner.plan_pose(Pose([3, 0, 0.5]), ANY)
    assert set(out_of_reach) == {"status"}
    assert "goal_invalid: " in out_of_reach["status"] and "brings 'arm7_hand' to [3, 0, 0.5]" in out_of_reach["status"]
    planner.add_object("lid", CollisionObject(Sphere(0.1), Pose(hand(planner, READY))))
    assert re.match("goal_invalid: .*'lid' overlap", planner.plan_qpos([READY], ANY)["status"])
    assert re.match("start_invalid: .*'lid' overlap", planner.plan_qpos([ANY], READY)["status"])
    assert planner.plan_qpos([-ANY], ANY, planning_time=1e-9)["status"].startswith("timed_out: ")
    assert re.match("IK Failed! In the nearest .*'lid' overlap", planner.IK(Pose(hand(planner, READY)), ANY)[0])
    assert planner.IK(Pose([3, 0, 0]), ANY) == (
        "IK Failed! No configuration within limits brings 'arm7_hand' there.",
        None,
    )


def test_starts_beyond_a_limit(planner):
    beyond = ANY.copy()
    beyond[3] = planner.joint_limits[3, 1] + 0.01
    result = planner.plan_qpos([ANY], beyond)
    assert result["position"][0][3] == planner.joint_limits[3, 1]
    status = planner.plan_qpos([ANY], beyond, fix_joint_limits=False)["status"]
    assert re.match("start_invalid: .*arm7_joint4", status)


def test_ik_gives_free_configurations_the_nearest_first(planner):
    goal = Pose(P, Q)
    status, found = planner.IK(goal, ANY)
    far = [np.linalg.norm(q - ANY) for q in found]
    assert status == "Success" and len(found) > 1 and far == sorted(far)
    np.testing.assert_array_equal(planner.IK(goal, ANY, return_closest=True)[1], found[0])
    assert not planner.check_for_collision(found[0])
    assert len(planner.IK(goal, ANY, n_init_qpos=1)[1]) == 1
    assert planner.IK(goal, ANY, threshold=1e-300)[1] is None


# --- screw motions


def leaves_screw_by(planner, result, goal):
    """[m], [1] the farthest that the hand is from the nearest pose of the screw motion."""
    pose_at = screw(hand(planner, result["position"][0]), srmp.Pose.from_wxyz(goal.p, goal.q))
    line = [Pose(pose_at(fraction)) for fraction in np.linspace(0, 1, 1001)]
    points, turns = np.array([pose.p for pose in line]), np.array([pose.q for pose in line])
    off = []
    for q in result["position"]:
        here = Pose(hand(planner, q))
        turn = np.minimum(np.linalg.norm(turns - here.q, axis=1), np.linalg.norm(turns + here.q, axis=1))
        off.append(np.min(np.linalg.norm(points - here.p, axis=1) + turn))
    return max(off)


def test_a_screw_without_a_turn_is_straight(planner):
    start = Pose(hand(planner, ANY))
    goal = Pose(np.add(start.p, [-0.15, -0.1, 0.12]), start.q)
    result = planner.plan_screw(goal, ANY, time_step=0.01)
    assert_a_plan(planner, result, ANY, 0.01)
    at = np.array([hand(planner, q).p for q in result["position"]]) - start.p
    way = (goal.p - start.p) / np.linalg.norm(goal.p - start.p)
    assert np.linalg.norm(at - np.outer(at @ way, way), axis=1).max() < 1e-3
    assert (np.diff(at @ way) > -1e-6).all()
    assert Pose(hand(planner, result["position"][-1])).distance(goal) < 1e-4


@pytest.mark.parametrize("angle", [1e-10, 1e-6, 0.5, np.pi])
def test_a_screw_with_a_turn_follows_it(planner, angle):
    start = Pose(hand(planner, READY))
    goal = Pose([0.02, -0.05, 0.03]) * start * Pose(q=[np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
    result = planner.plan_screw(goal, READY, time_step=0.01)
    assert_a_plan(planner, result, READY, 0.01)
    assert leaves_screw_by(planner, result, goal) < 2e-3  # positions and quaternions together, the line itself sampled
    assert Pose(hand(planner, result["position"][-1])).distance(goal) < 1e-4


def test_a_screw_motion_is_chasles(planner):
    start, goal = hand(planner, READY), srmp.Pose.from_wxyz([0.3, 0.4, 0.5], Q)
    pose_at = screw(start, goal)
    assert Pose(pose_at(0)).distance(start) < 1e-12 and Pose(pose_at(1)).distance(goal) < 1e-12
    step = Pose(pose_at(0.25)) * Pose(start).inv()
    assert (step * Pose(pose_at(0.5))).distance(pose_at(0.75)) < 1e-12  # the same motion everywhere


def test_screw_steps_are_as_small_as_asked(planner):
    start = hand(planner, ANY)
    path = planner._follow_screw(ANY, start @ srmp.Pose([0, 0, 0.1]), 0.02)
    assert 0 < np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 0.02


def test_a_screw_to_where_the_hand_is(planner):
    result = planner.plan_screw(Pose(hand(planner, ANY)), ANY)
    assert result["status"] == "Success"
    np.testing.assert_allclose(result["position"], [ANY] * len(result["time"]), atol=1e-6)


def test_why_there_is_no_screw(planner):
    start = Pose(hand(planner, ANY))
    status = planner.plan_screw(Pose([3, 0, 0.5], start.q), ANY)["status"]
    assert re.match(r"Screw plan failed. After \d+ % of the screw motion no configuration within limits", status)
    across = Pose(np.add(start.p, [0.15, -0.3, 0]), start.q)
    planner.add_object("sphere", CollisionObject(Sphere(0.02), Pose(np.add(start.p, [0.075, -0.15, 0]))))
    result = planner.plan_screw(across, ANY)
    assert set(result) == {"status"} and "Screw plan failed." in result["status"] and "'sphere'" in result["status"]
    assert planner.plan_pose(across, ANY)["status"] == "Success"  # round the sphere
    beyond = ANY.copy()
    beyond[3] = planner.joint_limits[3, 1] + 0.01
    assert "arm7_joint4" in planner.plan_screw(across, beyond)["status"]


# --- worlds


def test_point_clouds_are_avoided(planner):
    goal = READY - TURN
    free = planner.plan_qpos([goal], ANY, time_step=0.01)
    z, r = np.meshgrid(np.arange(0.1, 0.5, 0.02), np.arange(0.25, 0.4, 0.02))
    wall = np.column_stack([r.ravel(), np.zeros(r.size), z.ravel()])
    planner.update_point_cloud(wall, resolution=0.02)
    hits = [planner.check_for_env_collision(q) for q in free["position"]]
    assert {c.object_name2 for hit in hits for c in hit} == {"scene_pcd"}
    round_it = planner.plan_qpos([goal], ANY, time_step=0.01)
    assert_a_plan(planner, round_it, ANY, 0.01)
    np.testing.assert_array_equal(round_it["position"][-1], goal)
    through = planner.plan_qpos([goal], ANY, time_step=0.01, use_point_cloud=False)
    np.testing.assert_array_equal(through["position"], free["position"])
    assert planner.get_object_names() == ["scene_pcd"]
    planner.update_point_cloud(np.add(wall, [0, 0, 5]), resolution=0.02)  # in place of the first
    np.testing.assert_array_equal(planner.plan_qpos([goal], ANY, time_step=0.01)["position"], free["position"])
    assert planner.remove_point_cloud() and not planner.remove_point_cloud()


def test_attached_objects_count(planner):
    planner.add_object("shelf", CollisionObject(Box([0.4, 0.4, 0.02]), Pose(hand(planner, READY)) * Pose([0, 0, 0.2])))
    empty = planner.plan_qpos([READY], ANY)
    assert empty["status"] == "Success"
    planner.update_attached_box([0.04, 0.04, 0.5], Pose([0, 0, 0.2]))
    name = f"arm7_{planner.move_group_link_id}_box"
    assert planner.get_object_names() == [name, "shelf"]
    (contact,) = planner.check_for_env_collision(READY)
    assert contact.collision_type == "attached_sceneobject" and contact.object_name1 == name
    assert contact.object_name2 == "shelf" and contact.distance < 0
    assert planner.plan_qpos([READY], ANY)["status"].startswith("goal_invalid: ")
    without = planner.plan_qpos([READY], ANY, use_attach=False)
    np.testing.assert_array_equal(without["position"], empty["position"])
    assert planner.plan_qpos([READY], ANY)["status"].startswith("goal_invalid: ")  # it is back
    assert planner.detach_object(name, also_remove=True) and not planner.detach_object(name)
    assert planner.plan_qpos([READY], ANY)["status"] == "Success"


def test_attached_objects_of_every_kind(planner, tmp_path):
    (tmp_path / "tetrahedron.obj").write_text(
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    number = planner.move_group_link_id
    planner.update_attached_sphere(0.03, Pose([0, 0, 0.05]))
    planner.update_attached_mesh(tmp_path / "tetrahedron.obj", Pose([0, 0, 0.05]), link_id=number)
    planner.update_attached_object(mplib.Cylinder(0.02, 0.1), [0, 0, 0.1, *DOWN], art_name="arm7", link_id="arm7_hand")
    planner.update_attached_object(mplib.Capsule(0.02, 0.1), Pose([0, 0, 0.1]), name="pen")
    planner.update_attached_object(mplib.Cone(0.02, 0.1), Pose([0, 0, 0.1]), name="pen")  # in its place
    names = [f"arm7_{number}_mesh", f"arm7_{number}_sphere", "attached_geom", "pen"]
    assert planner.get_object_names() == names
    planner.set_qpos(ANY)
    at = Pose(planner.srmp.get_object_pose("attached_geom"))
    assert at.distance(Pose(hand(planner, ANY)) * Pose([0, 0, 0.1], DOWN)) < 1e-12
    assert all(planner.detach_object(name) for name in names)  # they stay where they were
    planner.set_qpos(READY)
    assert at.distance(planner.srmp.get_object_pose("attached_geom")) < 1e-12
    assert all(planner.remove_object(name) for name in names) and not planner.remove_object("pen")


def test_objects_of_the_world_can_be_attached(planner):
    planner.set_qpos(ANY)
    where = Pose(hand(planner, ANY)) * Pose([0, 0, 0.06])
    planner.planning_world.add_object("cube", CollisionObject(Box([0.03] * 3), where))
    planner.planning_world.attach_object("cube", planner.get_name(), planner.move_group_link_id)
    planner.set_qpos(READY)
    assert Pose(planner.srmp.get_object_pose("cube")).distance(Pose(hand(planner, READY)) * Pose([0, 0, 0.06])) < 1e-9
    planner.attach_object("cube", pose=Pose([0, 0, 0.07]))
    assert Pose(planner.srmp.get_object_pose("cube")).distance(Pose(hand(planner, READY)) * Pose([0, 0, 0.07])) < 1e-9
    assert planner.detach_object("cube")


def test_geometries_of_mplib_will_do(planner):
    """They have these names and attributes (mplib.collision_detection.fcl of 0.2.1)."""
    sphere = type("Sphere", (), {"radius": 0.05})()
    there = types.SimpleNamespace(p=[0, 0, 3], q=[1, 0, 0, 0])
    planner.add_object("sphere", types.SimpleNamespace(get_collision_geometry=lambda: sphere, pose=there))
    planner.update_attached_object(type("Box", (), {"side": np.array([0.1, 0.1, 0.1])})(), there, name="box")
    assert planner.get_object_names() == ["box", "sphere"]
    np.testing.assert_array_equal(planner.srmp.get_object_pose("sphere").p, [0, 0, 3])


def test_what_is_refused_changes_nothing(planner):
    planner.update_attached_box([0.05] * 3, Pose([0, 0, 0.1]))
    planner.update_point_cloud([[0, 0, 3.0]], 0.01)
    planner.srmp.add_box("table", [1, 1, 0.1], srmp.Pose([0, 0, -0.2]))
    for call in (
        lambda: planner.update_attached_box([0.05, -1, 0.05], Pose()),
        lambda: planner.update_point_cloud([[np.nan, 0, 0]]),
        lambda: planner.update_point_cloud(np.zeros((0, 3))),
        lambda: planner.update_point_cloud([[0, 0, 3.0]], name="table"),  # it is not this module's
        lambda: planner.plan_qpos([READY], np.full(7, np.nan)),
    ):
        with pytest.raises(srmp.InvalidArgument):
            call()
        assert planner.get_object_names() == [f"arm7_{planner.move_group_link_id}_box", "scene_pcd", "table"]
        assert planner.detach_object("scene_pcd") is False
        np.testing.assert_array_equal(planner.get_qpos(), np.zeros(7))
    assert planner.detach_object(f"arm7_{planner.move_group_link_id}_box")


def test_collisions_are_told_in_mplibs_words(planner):
    assert planner.check_for_collision(READY) == [] and planner.distance_to_collision(READY) > 0
    planner.add_object("sphere", CollisionObject(Sphere(0.05), hand(planner, READY)))
    (contact, *_) = planner.check_for_env_collision(READY)
    assert contact.collision_type == "self_sceneobject"
    assert (contact.object_name1, contact.object_name2, contact.link_name2) == ("arm7", "sphere", "sphere")
    assert contact.link_name1 in planner.user_link_names and contact.distance < 0
    assert planner.check_for_self_collision(READY) == []
    assert planner.distance_to_collision(READY) == pytest.approx(
        min(c.distance for c in planner.check_for_collision(READY))
    )
    planner.set_qpos(READY)
    assert planner.check_for_env_collision() == planner.check_for_collision(READY)
    planner.update_attached_box([0.05, 0.05, 2.0], Pose([0, 0, 0.2]))
    held = planner.check_for_self_collision(READY)
    assert {c.collision_type for c in held} == {"self_attached"}
    assert all(c.object_name1 == "arm7" and c.object_name2.endswith("_box") for c in held)
    np.testing.assert_array_equal(planner.get_qpos(), READY)


# --- the Panda, whose fingers move


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


# --- messages


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
