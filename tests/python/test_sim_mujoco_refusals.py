"""MuJoCo: what is refused, in one sentence, and changes nothing."""

from pathlib import Path

import numpy as np
import pytest

import srmp

pytest.importorskip("mujoco", reason="pip install '.[mujoco]' to test what is said of MuJoCo")

import mujoco
from mujoco_scenes import read, small_scene


def refused(error, match, sim, kind="mujoco", **options):
    planner = srmp.PlannerInterface()
    planner.add_box("mine", size=[0.1] * 3)
    with pytest.raises(error, match=match):
        planner.read_sim(sim, kind, **options)
    assert planner.robot_names == []
    assert planner.object_names == ["mine"]
    assert planner.simulated_world is None


@pytest.fixture(scope="module")
def small():
    model = small_scene().compile()
    return model, mujoco.MjData(model)


@pytest.mark.parametrize(
    ("match", "articulations"),
    [
        (r"unknown articulation 'arn'; did you mean 'arm'\?", ["arn"]),
        (r"unknown articulation 'gripper'; known: arm", {"gripper": {}}),
        (
            r"articulations\['arm'\] has 'end_efector'; known: .*did you mean 'end_effector'",
            {"arm": {"end_efector": "x"}},
        ),
        (r"articulations of mujoco are named by strings, not by 3", [3]),
    ],
)
def test_robots_that_are_not_there(match, articulations, small):
    refused((srmp.InvalidArgument, srmp.NotSupported), match, small, articulations=articulations)


def test_a_joint_that_does_not_match(small, tmp_path):
    text = Path(srmp.data_path("arm7.urdf")).read_text().replace("arm7_joint4", "arm7_join4")
    match = r"robot 'arm' has a joint 'arm7_join4', articulation 'arm' has none of that name; did you mean"
    description = {"urdf_text": text, "end_effector": "arm7_hand"}
    refused(srmp.InvalidArgument, match, small, articulations={"arm": description})


def test_a_scene_of_another_kind(small):
    refused(srmp.InvalidArgument, r"a MuJoCo scene is a pair \(MjModel, MjData\), not int", 3)
    refused(srmp.InvalidArgument, r"unknown simulator 'mujocco'; did you mean 'mujoco'\?", small, kind="mujocco")
    refused(srmp.InvalidArgument, r"unknown simulator 'gazebo'; known: mujoco, sapien", small, kind="gazebo")


def test_a_geometry_that_cannot_be_read():
    planner = srmp.PlannerInterface()
    spec = small_scene()
    model = spec.compile()
    model.geom_type[model.body("post").geomadr[0]] = mujoco.mjtGeom.mjGEOM_SDF
    data = mujoco.MjData(model)
    refused(srmp.NotSupported, r"object 'post': a geom of type sdf cannot be read", (model, data))
    planner.read_sim((model, data), "mujoco", exclude=["post"])
    assert planner.object_names == ["cube", "floor"]


def test_a_missing_package(small, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    refused(srmp.NotSupported, r"needs the Python package 'mujoco'.*pip install mujoco", small)


def test_reading_twice_and_queries_before_reading(small):
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.InvalidArgument, match="has read no simulator; call read_sim first"):
        srmp.sim.check_parity(planner, small)
    planner.read_sim(small, "mujoco")
    with pytest.raises(srmp.InvalidArgument, match="read_sim was called before"):
        planner.read_sim(small, "mujoco")
    other = small_scene().compile()
    with pytest.raises(srmp.InvalidArgument, match="not the scene that the planner has read"):
        srmp.sim.check_parity(planner, (other, mujoco.MjData(other)))
    planner.reset()
    assert planner.simulated_world is None
    planner.read_sim(small, "mujoco")


def test_trajectories_that_cannot_be_executed(small):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(small, "mujoco")
    names = planner.get_joint_names("arm")
    for match, trajectory, options in (
        (
            r"unknown robot 'arn'; did you mean 'arm'",
            srmp.Trajectory(names, np.zeros((2, 7)), times=[0, 1]),
            {"robot": "arn"},
        ),
        (r"no robot has the joints elbow", srmp.Trajectory(["elbow"], [[0.0], [0.1]], times=[0, 1]), {}),
        (r"it has no times", srmp.Trajectory(names, np.zeros((2, 7))), {}),
        (
            r"joint 'arm7_joint1' of robot 'arm' is at .*starts at 1",
            srmp.Trajectory(names, np.ones((2, 7)), times=[0, 1]),
            {},
        ),
        (r"settle_time is -1", srmp.Trajectory(names, np.zeros((2, 7)), times=[0, 1]), {"settle_time": -1}),
        (r"there is no trajectory to execute", {}, {}),
    ):
        with pytest.raises(srmp.InvalidArgument, match=match):
            world.execute(trajectory, **options)
    with pytest.raises(srmp.InvalidArgument, match=r"no body 'cub'.*did you mean 'cube'"):
        world.grasp("cub", "arm")
    with pytest.raises(srmp.InvalidArgument, match=r"unknown robot 'arn'"):
        world.grasp("cube", "arn")


def test_exclude_takes_bodies_and_refuses_what_is_not_there(small):
    spec = small_scene()
    table = spec.worldbody.add_body(name="table", pos=[0, 0, -0.5])
    for z in (0.0, 0.1):
        table.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1] * 3, pos=[0, 0, z])
    planner, _, _, _ = read(spec, exclude="table")
    assert planner.object_names == ["cube", "floor", "post"]
    refused(srmp.InvalidArgument, r"in exclude: 'cub'; did you mean 'cube'\?", small, exclude=["cub"])
    refused(srmp.InvalidArgument, r"exclude is 3; it is to be a list of names", small, exclude=3)
    refused(srmp.InvalidArgument, r"exclude is None; it is to be a list of names", small, exclude=None)


@pytest.mark.parametrize(
    ("match", "articulations"),
    [
        (r"articulations is 3; it is to be a list of names", 3),
        (r"articulations\['arm'\] is 3; it is to be a dict", {"arm": 3}),
        (r"articulations\['arm'\] is 'arm\.urdf'; it is to be a dict", {"arm": "arm.urdf"}),
        (r"articulations\['arm'\] has '3'; known: articulation", {"arm": {3: 4}}),
        (r"a robot called ''; robots are called by strings", {"": {"articulation": "arm"}}),
        (r"a robot called 1; robots are called by strings", {1: {"articulation": "arm"}}),
        (r"among urdf_path=None; see what add_articulation takes", {"arm": {"urdf_path": None}}),
        (
            r"robots 'a' and 'b' are both articulation 'arm'",
            {"a": {"articulation": "arm"}, "b": {"articulation": "arm"}},
        ),
    ],
)
def test_robots_that_are_said_wrongly(match, articulations, small):
    refused(srmp.InvalidArgument, match, small, articulations=articulations)


def test_data_of_another_model_and_no_scene_at_all(small):
    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    refused(srmp.InvalidArgument, "this MjData is of another MjModel", (small[0], mujoco.MjData(other)))
    refused(srmp.InvalidArgument, r"a MuJoCo scene is a pair \(MjModel, MjData\), not NoneType", None)
    refused(srmp.InvalidArgument, r"unknown simulator 'None'", small, kind=None)
    for call in (
        srmp.sim.check_parity,
        lambda it: srmp.sim.execute(it, None),
        lambda it: srmp.sim.read_sim(it, small, ""),
    ):
        with pytest.raises(srmp.InvalidArgument, match="planner is a NoneType; it is to be a PlannerInterface"):
            call(None)


@pytest.mark.parametrize(
    ("match", "options"),
    [
        (r"samples is 1\.5", {"samples": 1.5}),
        (r"samples is None", {"samples": None}),
        (r"seed is -1", {"seed": -1}),
        (r"seed is 'x'", {"seed": "x"}),
        (r"margin is nan", {"margin": float("nan")}),
        (r"margin is -0\.1", {"margin": -0.1}),
    ],
)
def test_invalid_arguments_of_parity_are_refused(match, options):
    planner, _, _, _ = read(small_scene())
    with pytest.raises(srmp.InvalidArgument, match=match):
        srmp.sim.check_parity(planner, **options)


def test_the_other_data_of_a_model_is_another_scene():
    planner, world, model, _ = read(small_scene())
    other = mujoco.MjData(model)
    other.qpos[0] = 0.77
    with pytest.raises(srmp.InvalidArgument, match="not the scene that the planner has read"):
        srmp.sim.check_parity(planner, (model, other))
    world.refresh((model, other))
    assert planner.get_object_pose("cube").p[0] == 0.77


def test_what_refresh_refuses_moves_nothing():
    spec = small_scene()
    planner, world, model, data = read(spec)
    good = data.qpos.copy()

    def refused_refresh(match, *sim):
        q, cube, names = planner.get_qpos("arm"), planner.get_object_pose("cube").p, planner.object_names
        with pytest.raises(srmp.InvalidArgument, match=match):
            world.refresh(*sim)
        np.testing.assert_array_equal(planner.get_qpos("arm"), q)
        np.testing.assert_array_equal(planner.get_object_pose("cube").p, cube)
        assert planner.object_names == names

    data.joint("arm/arm7_joint2").qpos[0] = 0.3
    data.qpos[0] = np.nan
    refused_refresh("the pose of body 'cube' is not finite")
    data.qpos[0] = 0.5
    data.joint("arm/arm7_joint7").qpos[0] = 50
    refused_refresh(r"joint 'arm/arm7_joint7' stands at 50 in mujoco, outside")
    data.joint("arm/arm7_joint7").qpos[0] = 0
    planner.attach_object("cube", "arm", "arm7_hand")
    refused_refresh("'cube' of mujoco was attached without grasp")
    with pytest.raises(srmp.InvalidArgument, match="attached without grasp"):
        world.execute(srmp.Trajectory(planner.get_joint_names("arm"), [data.qpos[7:14]] * 2, times=[0, 1]))
    assert data.time == 0  # nothing moved
    planner.detach_object("cube")

    planner.add_box("sphere", size=[0.1] * 3, pose=srmp.Pose(p=[2, 2, 2]))
    spec.worldbody.add_body(name="sphere", pos=[0, 0.9, 0.5]).add_geom(size=[0.1, 0, 0])
    larger = spec.compile()
    refused_refresh("a new object 'sphere', and the planner has one", (larger, mujoco.MjData(larger)))
    text = "<mujoco><worldbody><body name='arm'><body><joint/><geom size='.1'/></body></body></worldbody></mujoco>"
    strange = mujoco.MjModel.from_xml_string(text)
    refused_refresh("joint 'arm/arm7_joint1' of robot 'arm' is no longer in", (strange, mujoco.MjData(strange)))
    data.qpos[:] = good
    world.refresh()  # of the scene as before
    assert world.simulator.model is model


def test_hands_are_asked_for_by_names(small):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(small, "mujoco")
    for match, call in (
        (r"bodies and .* named by strings, not by None", lambda: world.grasp(None, "arm")),
        (r"bodies and .* named by strings, not by \['cube'\]", lambda: world.release(["cube"])),
        (r"unknown robot \['arm'\]", lambda: world.grasp("cube", ["arm"])),
        (r"link is 3", lambda: world.grasp("cube", "arm", 3)),
        (r"touch_links is 3", lambda: world.grasp("cube", "arm", touch_links=3)),
        (r"no link 'nope'", lambda: world.grasp("cube", "arm", touch_links="nope")),
    ):
        with pytest.raises((srmp.InvalidArgument, srmp.NotSupported), match=match):
            call()
    planner.remove_object("cube")
    world.grasp("cube", "arm", touch_links="arm7_palm")  # read again, as it is still there
    assert planner.allowed_collision("arm7_palm", "cube")


def test_what_cannot_be_executed_is_said(small):
    planner = srmp.PlannerInterface()
    world = planner.read_sim(small, "mujoco")
    still = srmp.Trajectory(planner.get_joint_names("arm"), np.zeros((2, 7)), times=[0, 0.1])
    for match, trajectory, options in (
        (r"a NoneType cannot be executed; give a Trajectory", None, {}),
        (r"a ndarray cannot be executed", np.zeros((2, 7)), {}),
        (r"the trajectory of robot 'arm' is a NoneType, not a Trajectory", {"arm": None}, {}),
        (r"unknown robot 3", still, {"robot": 3}),
        (r"unknown robot ''", still, {"robot": ""}),
        (r"settle_time is None", still, {"settle_time": None}),
        (r"on_step is 3", still, {"on_step": 3}),
    ):
        with pytest.raises(srmp.InvalidArgument, match=match):
            world.execute(trajectory, **options)
