"""srmp.compat.mplib: MPLib's and ManiSkill's calls, on this planner."""

import re
import types
from pathlib import Path

import numpy as np
import pytest
from mplib_arm import ANY, DOWN, TURN, P, Q, arm_planner, assert_a_plan, hand
from support import READY

import srmp
from srmp.compat import mplib
from srmp.compat._pose import screw
from srmp.compat.mplib import Box, CollisionObject, Planner, Pose, Sphere


@pytest.fixture
def planner():
    return arm_planner()


# --- poses

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
