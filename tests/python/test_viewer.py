"""The viewer without a browser: what it serves, refreshes, plans and says."""

import subprocess
import sys
import threading
import time
import urllib.request

import numpy as np
import pytest

import srmp

pytest.importorskip("viser", reason="the viewer needs viser: pip install '.[viewer]'")
from support import eventually

from srmp.viewer import Viewer

ARM = srmp.data_path("arm7.urdf")


def arm_world(names=("arm",)):
    planner = srmp.PlannerInterface()
    for k, name in enumerate(names):
        planner.add_articulation(
            ARM,
            srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=srmp.Pose(p=[0, 1.1 * k, 0]),
        )
        planner.set_qpos(name, planner.get_group_states(name)["ready"])
    planner.add_box("post", [0.1, 0.1, 0.8], srmp.Pose(p=[0.35, 0.35, 0.4]))
    return planner


def moved(planner, robot="arm", by=(0, -0.1, 0.1)):
    pose = planner.compute_fk(robot, planner.get_qpos(robot))
    return srmp.Pose(np.add(pose.p, by), pose.q)


@pytest.fixture
def planner():
    return arm_world()


@pytest.fixture
def viewer(planner):
    with Viewer(planner, port=0) as viewer:
        yield viewer


def test_it_serves_a_page_and_ends(planner, capfd):
    with planner.show(port=0, open_browser=False) as viewer:
        assert urllib.request.urlopen(viewer.url).status == 200
        assert repr(viewer) == f"Viewer({viewer.url})"
    assert repr(viewer).endswith(", closed)")
    viewer.wait()
    viewer.close()
    assert capfd.readouterr().out == ""


def test_a_program_may_end_with_an_open_viewer():
    program = (
        "import srmp; planner = srmp.PlannerInterface(); planner.add_robot('arm7');"
        "viewer = planner.show(port=0, open_browser=False)"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_it_follows_the_planner_and_sends_only_what_is_new(planner, viewer):
    bodies = viewer._stage._bodies
    before = viewer._stage.sent
    planner.add_sphere("ball", 0.05, srmp.Pose(p=[0.3, -0.3, 0.3]))
    eventually(lambda: "ball" in bodies)
    planner.set_object_pose("post", srmp.Pose(p=[0.4, 0.4, 0.4]))
    eventually(lambda: bodies["post"][1].position[0] == pytest.approx(0.4))
    planner.set_qpos("arm", np.zeros(7))
    hand = viewer._stage._frames["arm/arm7_hand"]
    eventually(lambda: np.allclose(hand.position, planner.compute_fk("arm", np.zeros(7)).p))
    planner.remove_object("ball")
    eventually(lambda: "ball" not in bodies)
    assert viewer._stage.sent == before + 1
    planner.remove_object("post")
    planner.add_sphere("post", 0.05, srmp.Pose(p=[0.4, 0.4, 0.4]))  # the same name and pose
    viewer.update()
    assert viewer._stage.sent == before + 2


def test_a_plan_of_the_program_is_played(planner, viewer):
    q = planner.get_qpos("arm")
    trajectory = planner.plan("arm", q, q - [0.5, 0, 0, 0, 0, 0, 0])
    eventually(lambda: "arm" in viewer.trajectory)
    assert viewer.trajectory["arm"] == trajectory
    hand = viewer._stage._frames["arm/arm7_hand"]
    eventually(lambda: np.allclose(hand.position, trajectory.end_effector_path()[-1], atol=1e-6))
    viewer.on_seek(0.0)
    assert np.allclose(hand.position, trajectory.end_effector_path()[0], atol=1e-6)


def test_a_motion_is_scrubbed_paused_and_played_slower(planner, viewer):
    q = planner.get_qpos("arm")
    slow = srmp.Trajectory(planner.get_joint_names("arm"), [q, q - 0.3], [0, 30])
    viewer.play(slow)
    eventually(lambda: viewer._time > 0.1)
    viewer.on_play()  # pauses
    time.sleep(0.2)  # the frame that was under way
    paused = viewer._time
    time.sleep(0.2)
    assert viewer._time == paused
    viewer.on_seek(15.0)
    assert viewer._time == 15.0 and not viewer._playing
    viewer._panel._speed.value = "0.1×"
    begin = time.perf_counter()
    viewer.on_play()
    eventually(lambda: viewer._time > 15.05)
    assert viewer._time - 15 < 0.1 * (time.perf_counter() - begin) + 0.05
    assert len(viewer._panel._plot_handles) >= 2 and viewer._panel._plots.visible


def test_goals_are_dragged_and_planned_to(planner, viewer):
    goal = moved(planner)
    viewer.set_goal("arm", goal)
    assert list(viewer.goals) == ["arm"] and viewer.status.startswith("goal of 'arm'")
    assert {body.robot for body, _ in viewer._ghost._bodies.values()} == {"arm"}
    viewer.plan()
    assert viewer.status.startswith("solved in")
    end = viewer.trajectory["arm"].positions[-1]
    assert np.allclose(planner.compute_fk("arm", end).p, goal.p, atol=1e-3)
    assert planner.last_request is None  # nothing reaches the program's planner
    viewer.on_seek(viewer._motion.duration)
    viewer.on_stand_here()
    eventually(lambda: not viewer.trajectory)
    assert np.allclose(viewer._world.get_qpos("arm"), end, atol=1e-6)
    viewer.on_reset_goals()
    eventually(lambda: not viewer.goals)


def test_worse_paths_of_an_anytime_planner_are_drawn(planner):
    planner.make_planner("arm", srmp.ARAStar(weight=50, time_limit=2))
    with Viewer(planner, port=0) as viewer:
        viewer.set_goal("arm", planner.compute_fk("arm", planner.get_qpos("arm") - [1.5, 0, 0, 0.4, 0, 0, 0]))
        viewer.plan()
        found = len(viewer._found)
        assert found >= 1 and len(viewer._path_nodes) == found  # all but the best, and what plays


def test_closing_ends_plans_that_run():
    """In another thread, which would plan on until its time limit."""
    for names in (("arm",), ("left", "right")):
        viewer = Viewer(arm_world(names), port=0)
        viewer.close()
        starts = {name: viewer._world.get_qpos(name) for name in names}
        goals = {name: srmp.GoalConstraint(srmp.GoalType.JOINTS, q + 0.3) for name, q in starts.items()}
        with pytest.raises(srmp.PlanningError) as caught:
            if len(names) == 1:
                viewer._world.plan(starts["arm"], goals["arm"])
            else:
                viewer._world.plan_multi(starts, goals)
        assert caught.value.status == srmp.Status.cancelled


def test_touches_at_a_goal_are_shown_with_names_and_depths(planner, viewer):
    viewer.set_goal("arm", srmp.Pose(p=[0.35, 0.35, 0.4], q=[0, 1, 0, 0]))
    assert any("post" in text and "mm deep" in text for text in viewer._marks.texts)
    assert tuple(viewer._stage._bodies["post"][1].color) == (219, 31, 31)
    viewer.plan()
    assert viewer.status.startswith("goal_invalid")
    assert any("post" in text for text in viewer._marks.texts)
    viewer.set_goal("arm", moved(planner))
    assert not viewer._marks.texts
    assert tuple(viewer._stage._bodies["post"][1].color) != (219, 31, 31)


def test_a_goal_out_of_reach_is_said(planner, viewer):
    viewer.set_goal("arm", srmp.Pose(p=[5, 0, 0]))
    assert viewer.status == "'arm' does not reach this goal"


def test_without_a_goal_there_is_nothing_to_plan(viewer):
    viewer.plan()
    assert viewer.status.startswith("drag the handle")


def test_a_failure_of_the_program_is_drawn(planner, viewer):
    q = planner.get_qpos("arm")
    with pytest.raises(srmp.PlanningError):
        planner.plan("arm", q, srmp.Pose(p=[0.35, 0.35, 0.4], q=[0, 1, 0, 0]))
    eventually(lambda: viewer.status.startswith("goal_invalid"))
    assert any("post" in text for text in viewer._marks.texts)


def test_several_robots_have_handles_and_one_clock():
    planner = arm_world(("left", "right"))
    with Viewer(planner, port=0) as viewer:
        for robot in ("left", "right"):
            viewer.set_goal(robot, moved(planner, robot))
        viewer.plan()
        assert viewer.status.startswith("solved in") and sorted(viewer.trajectory) == ["left", "right"]
        planner.remove_articulation("right")
        eventually(lambda: list(viewer._handles) == ["left"] and list(viewer.goals) == ["left"])


def test_robots_are_switched_to_spheres_and_back(viewer):
    viewer.on_switch("spheres", True)
    kinds = lambda: {body.kind for body, handle in viewer._stage._bodies.values() if handle.visible}  # noqa: E731
    eventually(lambda: kinds() == {"collision", "spheres", "object"}, 60)
    viewer.on_switch("collision", False)
    eventually(lambda: kinds() == {"spheres", "object"})
    viewer.on_switch("visual", True)
    eventually(lambda: viewer.status == "the robots have no visual geometry")


def test_planning_does_not_know_that_it_is_watched(planner, viewer):
    """No call of the program is refused because the viewer looks at its planner, and results stay as they are."""
    q = planner.get_qpos("arm")
    goal = q - [0.5, 0, 0, 0, 0, 0, 0]
    alone = arm_world().plan("arm", q, goal)
    for _ in range(200):
        planner.set_object_pose("post", srmp.Pose(p=[0.35, 0.35, 0.4]))
        assert planner.plan("arm", q, goal) == alone


def test_a_planner_that_plans_in_another_thread_is_left_alone(planner, viewer):
    planner.make_planner("arm", srmp.ARAStar(time_limit=1.5, final_weight=1.0))
    q = planner.get_qpos("arm")
    thread = threading.Thread(
        target=planner.plan, args=("arm", q, np.add(q, [1.6, 0.8, 0, 0, 0, 0, 0]))
    )  # around the post
    thread.start()
    eventually(lambda: repr(planner) == "PlannerInterface(planning)")
    viewer.set_goal("arm", moved(arm_world()))  # the viewer goes on meanwhile
    thread.join()
    eventually(lambda: "arm" in viewer.trajectory)


def test_four_arms_are_updated_20_times_a_second():
    planner = arm_world(("a", "b", "c", "d"))
    paths = {}
    for name in planner.robot_names:
        q = planner.get_qpos(name)
        paths[name] = srmp.Trajectory(planner.get_joint_names(name), [q, q - 0.3], [0, 2])
    with Viewer(planner, paths, port=0) as viewer:
        begin, updates = time.perf_counter(), 0
        while time.perf_counter() - begin < 1:
            viewer.on_seek(2 * (updates % 60) / 60)
            updates += 1
    assert updates >= 20


def test_a_search_is_drawn(planner, viewer):
    planner.make_planner("arm", srmp.WAStar())
    q = planner.get_qpos("arm")
    with srmp.SearchTrace() as trace:
        planner.plan("arm", q, q - [0.8, 0, 0, 0, 0, 0, 0])
    viewer.show_search(trace)
    assert "states expanded in" in viewer.status
    assert len(viewer._search_nodes) >= 2  # edges, and states in at least one shade
    viewer.show_search(None)
    assert not viewer._search_nodes and viewer.status == ""
    with srmp.SearchTrace() as empty:
        pass
    with pytest.raises(srmp.InvalidArgument, match="holds no lattice and no constraint tree"):
        viewer.show_search(empty)
    with pytest.raises(srmp.InvalidArgument, match="there is no constraint tree: show_search"):
        viewer.show_conflict(0)


def test_a_constraint_tree_and_its_conflicts_are_shown():
    planner = srmp.PlannerInterface()
    for name, x, yaw in (("left", 0.0, 0.0), ("right", 0.8, np.pi)):
        planner.add_robot("arm7", name=name, base_pose=srmp.Pose.from_rpy([x, 0, 0], [0, 0, yaw]))
    planner.make_planner(["left", "right"], srmp.ECBS())
    over = [srmp.Pose.from_rpy([0.4, y, 0.2], [np.pi, 0, 0]) for y in (0.2, -0.2)]
    ready = planner.get_group_states("left")["ready"]
    starts = {
        name: planner.compute_ik(name, pose, ready)[0] for name, pose in zip(("left", "right"), over, strict=True)
    }
    with srmp.SearchTrace() as trace:
        planner.plan_multi(starts, {"left": over[1], "right": over[0]})
    with Viewer(planner, port=0) as viewer:
        assert viewer._panel._certificates.visible and "clearance" in viewer._panel._claims.content
        viewer.show_search(trace)
        assert "constraint tree" in viewer.status
        assert viewer._panel._search.visible and "<svg" in viewer._panel._tree.content
        viewer.show_conflict(0)
        root = trace.constraint_nodes[0]
        hand = viewer._stage._frames["left/arm7_hand"]
        assert np.allclose(hand.position, planner.compute_fk("left", root.configurations["left"]).p, atol=1e-6)
        assert f"node 0: {root.robots[0]} – {root.robots[1]}" in viewer._panel._tree.content
        for wrong in (-1, len(trace.constraint_nodes), True, "0"):
            with pytest.raises(srmp.InvalidArgument, match="node must be a whole number from 0 to "):
                viewer.show_conflict(wrong)
        viewer.show_search(None)
        assert not viewer._panel._search.visible


def test_bad_input_is_refused(planner, viewer):
    one = srmp.Trajectory(["a"], [[0], [1]])
    for call, words in [
        (lambda: planner.show(port=-1), "port must be a whole number from 0 to 65535, but is -1"),
        (lambda: planner.show(port="8080"), "port must be .* but is '8080'"),
        (lambda: planner.show(host=""), "host must be"),
        (lambda: planner.show(5), "trajectory must be"),
        (lambda: planner.show({"arn": one}), "no robot 'arn', did you mean 'arm'"),
        (lambda: planner.show(kinds=["wire"]), "not 'wire'"),
        (lambda: srmp.viewer.show(3), "planner must be a PlannerInterface, but is 3"),
        (lambda: viewer.set_goal("arn", srmp.Pose()), "arn"),
        (lambda: viewer.set_goal("arm", [0, 0, 0]), r"pose must be a Pose, but is \[0, 0, 0\]"),
        (lambda: viewer.play({"arm": one}), "moves a, but the robot's joints are"),
    ]:
        with pytest.raises(srmp.InvalidArgument, match=words):
            call()


def test_without_viser_one_sentence_says_so(planner, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    with pytest.raises(srmp.NotSupported, match=r"the viewer needs viser: pip install '\.\[viewer\]'"):
        planner.show()
