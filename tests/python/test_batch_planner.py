"""BatchPlanner: many scenes at once give what each alone gives."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import srmp


def world(height=0.4, name="arm"):
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name=name,
        end_effector="arm7_hand",
    )
    planner.add_box("post", [0.1, 0.1, 0.8], srmp.Pose(p=[0.35, 0.2, height]))
    return planner


GOAL = [0.1, 0.45, 0.4, 0, 1, 0, 0]


@pytest.fixture
def ready():
    return world().get_group_states("arm")["ready"]


@pytest.mark.parametrize("threads", [1, 3, None])
def test_results_are_those_of_each_scene_alone(ready, threads):
    heights = [0.4, 0.35, 0.3, -5.0]
    batch = srmp.BatchPlanner([world(height) for height in heights], threads=threads)
    result = batch.plan([ready] * 4, poses=[GOAL] * 4)
    assert result.solved.all()
    for k, height in enumerate(heights):
        alone = world(height).plan(ready, srmp.Pose(GOAL[:3], GOAL[3:]))
        mask = result.mask[k]
        assert np.array_equal(result.positions[k][mask], alone.positions)
        assert np.array_equal(result.velocities[k][mask], alone.velocities)
        assert np.array_equal(result.times[k][mask], alone.times)
        assert np.array_equal(result.waypoints[k][result.waypoint_mask[k]], alone.waypoints)
        assert np.array_equal(result.positions[k][~mask], np.repeat(alone.positions[-1:], (~mask).sum(), 0))
        assert result.trajectories[k].certificate.holds


def test_a_failure_does_not_disturb_the_others(ready):
    batch = srmp.BatchPlanner([world(), world()])
    batch.scenes[1].add_box("around", [1, 1, 1], srmp.Pose(p=[0.3, 0, 0.5]))
    result = batch.plan([ready, ready], [ready + 0.1, ready + 0.1])
    assert result.solved.tolist() == [True, False]
    assert result.status[1] == "start_invalid"
    assert "around" in result.reasons[1]
    assert not result.mask[1].any()
    assert np.array_equal(result.positions[1], np.repeat(ready[None], result.positions.shape[1], 0))


def test_update_moves_objects(ready):
    batch = srmp.BatchPlanner([world(), world()])
    batch.update(1, {"post": [2, 0, 0.4, 0, 0, 0, 1]})
    assert batch.scenes[1].get_object_pose("post").p[0] == 2
    assert batch.scenes[0].get_object_pose("post").p[0] == 0.35
    result = batch.plan([ready] * 2, poses=[GOAL] * 2)
    batch.update(0, {"post": [2, 0, 0.4, 0, 0, 0, 1]})
    again = batch.plan([ready] * 2, poses=[GOAL] * 2)
    assert not np.array_equal(result.trajectories[0].positions, result.trajectories[1].positions)
    assert np.array_equal(again.trajectories[0].positions, result.trajectories[1].positions)
    assert np.array_equal(again.trajectories[1].positions, result.trajectories[1].positions)
    batch.update(0, {"post": srmp.Pose(p=[0.35, 0.2, 0.4])})
    with pytest.raises(srmp.InvalidArgument, match="unknown object 'psot'"):
        batch.update(0, {"post": srmp.Pose(p=[3, 0, 0]), "psot": srmp.Pose()})
    assert batch.scenes[0].get_object_pose("post").p[0] == 0.35
    with pytest.raises(srmp.InvalidArgument, match="scene 2: there are scenes 0 to 1"):
        batch.update(2, {})
    with pytest.raises(srmp.InvalidArgument, match=r"the pose of 'post' has the shape \(3,\)"):
        batch.update(0, {"post": [1, 2, 3]})


def test_what_is_refused(ready):
    one = world()
    other = srmp.PlannerInterface()
    other.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), name="arm", end_effector="arm7_wrist")
    for scenes, sentence in (
        ([], "at least one scene"),
        ([one, one], "a scene is there twice"),
        ([one, 3], r"scenes\[1\] is 3"),
        ([one, other], r"the robot of scenes\[1\] has the joints"),
        (3, "scenes is 3; it must have one for each scene"),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            srmp.BatchPlanner(scenes)
    with pytest.raises(srmp.InvalidArgument, match="threads 0"):
        srmp.BatchPlanner([one], threads=0)
    with pytest.raises(srmp.InvalidArgument, match="threads must be a whole number or None, but is 'two'"):
        srmp.BatchPlanner([one], threads="two")
    with pytest.raises(srmp.InvalidArgument, match=r"\bamr\b"):
        srmp.BatchPlanner([one], "amr")
    with pytest.raises(srmp.InvalidArgument, match="time_limit"):
        srmp.BatchPlanner([one], options={"time_limt": 1})
    batch = srmp.BatchPlanner([one], options={"time_limit": 1})
    for starts, goals, sentence in (
        (ready, [ready], "starts have the shape"),
        ([ready + np.nan], [ready], "not finite"),
        ([ready], [ready, ready], "there are 2 goals for 1 scenes"),
        ([ready], [[0.0]], "scene 0: goal of"),
        ([ready], None, "give either goals or poses"),
        ([["a"] * 7], [ready], "starts are not numbers in rows of the same length"),
        ([ready, ready[:2]], [ready], "starts are not numbers in rows of the same length"),
        ([ready], 3, "goals is 3; it must have one for each scene"),
        ([ready], ["raedy"], "goals\\[0\\]: .*did you mean 'ready'"),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            batch.plan(starts, goals)
    for poses, sentence in (
        ([[1, 2]], r"the pose of 'poses\[0\]'"),
        ([["a"] * 7], r"'poses\[0\]' are not numbers"),
        (3, "poses is 3"),
        ([GOAL, GOAL], "there are 2 goals for 1 scenes"),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            batch.plan([ready], poses=poses)
    for scene, poses, sentence in (
        ("a", {}, "scene must be a whole number, but is 'a'"),
        (0, [1], r"poses must be a dictionary .*, but is \[1\]"),
        (0, {"post": "up"}, "the pose of 'post' are not numbers"),
        (0, {"post": [np.nan] * 7}, "post|finite"),
    ):
        with pytest.raises(srmp.InvalidArgument, match=sentence):
            batch.update(scene, poses)


LONG = """
import sys, time
import numpy as np
import srmp
from test_batch_planner import world

scenes = [world() for _ in range(6)]
batch = srmp.BatchPlanner(scenes, options={"planner_id": "ARAstar", "time_limit": 30}, threads=2)
ready = scenes[0].get_group_states("arm")["ready"]
print("begins", flush=True)
try:
    batch.plan([ready] * 6, [ready + [1.5, 0, 0, 0.4, 0, 0, 0]] * 6)
except KeyboardInterrupt:
    print(f"ended {time.monotonic()}", flush=True)
    scenes[0].make_planner("arm", {"planner_id": "auto"})
    print(scenes[0].plan("arm", ready, ready + 0.1).certificate.holds, flush=True)  # and goes on after it
"""


def test_ctrl_c_ends_all_plans_at_once():
    process = subprocess.Popen(
        [sys.executable, "-c", LONG],
        cwd=Path(__file__).parent,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert process.stdout.readline() == "begins\n"
    time.sleep(1.0)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    ended = process.stdout.readline()
    assert float(ended.removeprefix("ended ")) - began < 1.0  # 0.02 s where nothing else needs the cores
    assert process.stdout.readline() == "True\n"  # communicate() does not see what the last readline() took with it
    assert process.wait(timeout=20) == 0
