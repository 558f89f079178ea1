"""plan_multi: motions of many robots together, their goals and options, what is returned, and time limits."""

import collections.abc
import pickle
import re
import signal
import threading
import time

import numpy as np
import pytest
from multi_arms import GOALS, STARTS, in_contact, quarter_turns, ring, two
from support import READY, joints, turned

import srmp
from srmp import GoalConstraint, GoalType, Pose

PLANNERS = ("auto", "CBS", "ECBS", "xECBS", "prioritised")


@pytest.mark.parametrize("planner_id", ["auto", "ECBS", "xECBS", "prioritised"])
def test_arms_in_each_others_way_reach_their_goals(planner_id):
    planner = two(planner_id)
    trajectory = planner.plan_multi(STARTS, GOALS)
    for name in STARTS:
        one = trajectory[name]
        assert one.joint_names == planner.get_joint_names(name)
        np.testing.assert_array_equal(one.positions[0], STARTS[name])
        np.testing.assert_allclose(one.positions[-1], turned(-0.6), atol=1e-12)
        assert one.times[0] == 0
        assert one.certificate.holds
        assert one.certificate.proved_free
    assert in_contact(planner, trajectory) == []


@pytest.mark.parametrize("planner_id", PLANNERS)
def test_every_planner_solves_an_easy_request(planner_id):
    planner = two(planner_id, distance=0.9)
    trajectory = planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    assert statistics["path_cost_rad"] == pytest.approx(2.4)  # straight
    assert statistics["bound"] == (float("inf") if planner_id == "prioritised" else 1)
    assert all(one.certificate.proved_free for one in trajectory.values())


def test_the_statistics():
    planner = two()
    trajectory = planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    assert statistics["status"] == srmp.Status.solved
    assert statistics["reason"] == ""
    assert set(statistics["robot_cost_rad"]) == {"left", "right"}
    assert sum(statistics["robot_cost_rad"].values()) == pytest.approx(statistics["path_cost_rad"], rel=1e-12)
    for name, cost in statistics["robot_cost_rad"].items():
        waypoints = trajectory[name].waypoints
        assert cost == pytest.approx(np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum(), rel=1e-9)
    assert statistics["path_cost_rad"] <= statistics["search_cost_rad"] * (1 + 1e-12)
    assert statistics["path_cost_rad"] >= 2.4 - 1e-9  # straight, one waits for the other
    assert statistics["bound"] >= 1
    assert statistics["bound_graph"] == "every path"
    assert trajectory["left"].certificate.bound == statistics["bound"]
    assert statistics["makespan_s"] == trajectory.duration == max(one.duration for one in trajectory.values())
    assert statistics["makespan_s"] < statistics["flow_time_s"] <= 2 * statistics["makespan_s"]
    assert 0 < statistics["plan_time_s"] <= statistics["total_time_s"]
    assert statistics["expansions"] > 0


def test_constraint_tree_nodes_are_counted():
    planner = two("ECBS", multi_resolution=False)
    planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    assert "lattices of 15 degrees" in statistics["bound_graph"]
    assert statistics["tree_nodes"] > 1
    assert statistics["samples"] == 0
    assert statistics["found_by"] == "conflict-based search"
    assert 1 <= statistics["bound"] <= 1.3 * 1.3 * 50


@pytest.mark.parametrize("planner_id", ["auto", "RRTConnect"])
def test_paths_without_lattices_are_compared_with_every_path(planner_id):
    planner = two(planner_id, distance=5)
    planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    assert statistics["found_by"] == "each robot alone"
    assert statistics["bound_graph"] == "every path"
    straight = sum(np.linalg.norm(GOALS[name].targets[0] - STARTS[name]) for name in STARTS)
    assert statistics["bound"] == pytest.approx(statistics["path_cost_rad"] / straight)


def test_the_bound_of_ecbs_is_about_the_lattices_in_which_it_found_the_paths():
    planner = two("ECBS", resolution=10)
    planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    lattice = re.search(r"lattices of ([\d.]+) degrees", statistics["bound_graph"])
    assert lattice and float(lattice[1]) in (60, 30, 15, 7.5)
    assert statistics["states"] > 0
    assert 1 <= statistics["bound"] <= 1.3 * 1.3 * 50
    planner = two("ECBS", resolution=60)  # 6 and 3 times as much are more than 90 degrees
    planner.plan_multi(STARTS, GOALS)
    assert "lattices of 90 degrees" in planner.get_planning_stats()["bound_graph"]


def test_a_path_that_is_shown_optimal_has_bound_1():
    planner = two("CBS", distance=0.9)
    planner.plan_multi(STARTS, GOALS)
    assert planner.get_planning_stats()["bound"] == 1


def test_many_planners_for_one_robot():
    planner = two(distance=5)
    for options in (srmp.XECBS(), srmp.ECBS(), srmp.CBS(), srmp.Prioritised(), srmp.Auto()):
        planner.make_planner(["left"], options)
        trajectory = planner.plan_multi({"left": READY}, {"left": joints(turned(1.0))})
        np.testing.assert_allclose(trajectory["left"].positions[-1], turned(1.0), atol=1e-12)


# --- goals


def test_pose_and_position_goals():
    planner = two()
    pose = planner.compute_fk("left", turned(-0.6))
    point = planner.compute_fk("right", turned(-0.6)).p
    trajectory = planner.plan_multi(
        STARTS, {"left": GoalConstraint(GoalType.POSE, pose), "right": GoalConstraint(GoalType.POSITION, point)}
    )
    reached = planner.compute_fk("left", trajectory["left"].positions[-1])
    assert np.linalg.norm(reached.p - pose.p) < 1e-3
    assert abs(np.dot(reached.q, pose.q)) > 1 - 1e-4
    assert np.linalg.norm(planner.compute_fk("right", trajectory["right"].positions[-1]).p - point) < 1e-3
    assert all(one.certificate.goal_error <= 1 for one in trajectory.values())


def test_any_of_several_targets_will_do():
    planner = two()
    trajectory = planner.plan_multi(
        STARTS, {"left": joints(turned(-0.6), turned(0.9)), "right": joints(turned(-0.6), turned(0.8))}
    )
    np.testing.assert_allclose(trajectory["left"].positions[-1], turned(0.9), atol=1e-12)
    np.testing.assert_allclose(trajectory["right"].positions[-1], turned(0.8), atol=1e-12)


def test_targets_that_do_not_go_together_are_left_for_others():
    """Both are nearest to ready, but there is room for one."""
    planner = two()
    goal = joints(READY, turned(-0.6))
    trajectory = planner.plan_multi(STARTS, {"left": goal, "right": goal})
    ends = [abs(one.positions[-1] - READY).max() < 1e-9 for one in trajectory.values()]
    assert sum(ends) <= 1


@pytest.mark.parametrize("goal", [{"right": GoalConstraint.hold()}, {}], ids=["hold", "no goal"])
def test_who_holds_is_planned_around(goal):
    planner = two()
    starts = {"left": turned(0.6), "right": READY}
    trajectory = planner.plan_multi(starts, {"left": GOALS["left"], **goal})
    assert set(trajectory) == {"left", "right"}
    assert (trajectory["right"].positions == READY).all()
    assert trajectory["right"].duration == 0
    assert planner.get_planning_stats()["path_cost_rad"] > 1.2 + 1e-6  # not straight
    assert trajectory["left"].certificate.proved_free
    assert in_contact(planner, trajectory) == []


def test_a_robot_without_a_start_stands_where_set_qpos_put_it():
    planner = two()
    planner.make_planner(["left"], {"planner_id": "xECBS"})
    planner.set_qpos("right", READY)
    among = planner.plan_multi({"left": turned(0.6)}, {"left": GOALS["left"]})
    assert list(among) == ["left"]
    held = planner.plan_multi({"left": turned(0.6), "right": READY}, {"left": GOALS["left"]})  # by the planner of both
    assert held["left"] == among["left"]
    planner.set_qpos("right", turned(2.5))
    planner.plan_multi({"left": turned(0.6)}, {"left": GOALS["left"]})
    assert planner.get_planning_stats()["path_cost_rad"] == pytest.approx(1.2)


def test_any_goal_moves_out_of_the_way_only_when_it_must():
    planner = two()
    anywhere = GoalConstraint.any()
    goals = {"left": joints(READY), "right": anywhere}  # where the right arm's hand is
    trajectory = planner.plan_multi({"left": turned(0.9), "right": READY}, goals)
    assert np.abs(trajectory["right"].positions[-1] - READY).max() > 0.05
    np.testing.assert_allclose(trajectory["left"].positions[-1], READY, atol=1e-12)
    assert in_contact(planner, trajectory) == []
    trajectory = planner.plan_multi({"left": turned(0.9), "right": turned(0.9)}, goals)
    assert (trajectory["right"].positions == turned(0.9)).all()
    assert planner.get_planning_stats()["robot_cost_rad"]["right"] == 0


def test_what_a_robot_holds_is_kept_clear_of_the_others():
    """Hands alone pass each other."""
    planner = two(distance=0.8)
    planner.plan_multi(STARTS, GOALS)
    assert planner.get_planning_stats()["path_cost_rad"] == pytest.approx(2.4)
    planner.set_qpos("left", STARTS["left"])
    hand = planner.compute_fk("left", STARTS["left"])
    planner.add_box("stick", size=[0.4, 0.02, 0.02], pose=Pose(hand.p, Pose.from_rpy([0, 0, 0], [0, 0, 0.6]).q))
    planner.attach_object("stick", "left", "arm7_hand", touch_links=["arm7_palm"])
    trajectory = planner.plan_multi(STARTS, GOALS)
    assert planner.get_planning_stats()["path_cost_rad"] > 2.4 + 1e-6
    assert all(one.certificate.proved_free for one in trajectory.values())
    assert in_contact(planner, trajectory) == []


def test_different_robots_in_one_scene():
    planner = two()
    planner.add_articulation(
        urdf_text="""<robot name='slider'><link name='rail'/><link name='car'><collision><geometry>
        <box size='0.1 0.1 0.3'/></geometry></collision></link><joint name='s' type='prismatic'><parent link='rail'/>
        <child link='car'/><axis xyz='1 0 0'/><limit lower='-0.5' upper='0.5' velocity='1' effort='1'/></joint>
        </robot>""",
        name="slider",
        end_effector="car",
        base_pose=Pose([0.35, 0, 0.35]),
    )
    names = ["slider", "left", "right"]
    planner.make_planner(names, {"planner_id": "xECBS", "time_limit": 20})
    starts = {"left": turned(1.5), "right": turned(1.5), "slider": [0.0]}
    goals = {"left": joints(turned(-1.5)), "right": GoalConstraint.hold(), "slider": GoalConstraint.any()}
    trajectory = planner.plan_multi(starts, goals)
    assert list(trajectory) == sorted(names)
    assert trajectory["slider"].positions.shape[1] == 1
    assert in_contact(planner, trajectory) == []


def test_a_start_that_is_a_hair_outside_is_moved_onto_the_limit():
    planner = two()
    planner.plan_multi({"left": turned(2.9 + 5e-7), "right": turned(0.6)}, {"left": joints(turned(2.0))})
    assert planner.get_planning_stats()["note"].startswith("robot 'left': the start was moved onto a joint limit")


def test_who_is_there_already_need_not_move():
    planner = two()
    trajectory = planner.plan_multi(STARTS, {name: joints(q) for name, q in STARTS.items()})
    assert trajectory.duration == planner.get_planning_stats()["flow_time_s"] == 0
    assert all((one.positions == turned(0.6)).all() for one in trajectory.values())


# --- what is returned


def test_the_result_is_a_mapping():
    trajectory = two().plan_multi(STARTS, GOALS)
    assert len(trajectory) == 2
    assert list(trajectory) == trajectory.keys() == ["left", "right"]
    assert "left" in trajectory
    assert "lft" not in trajectory
    assert trajectory.values() == [trajectory["left"], trajectory["right"]]
    assert dict(trajectory.items()) == {name: trajectory[name] for name in trajectory}
    assert repr(trajectory) == f"MultiTrajectory(2 robots, {round(trajectory.duration, 6)} s)"
    with pytest.raises(srmp.InvalidArgument, match="no trajectory of robot 'lft', did you mean 'left'"):
        trajectory["lft"]


def test_a_result_pickles_and_compares():
    trajectory = two().plan_multi(STARTS, GOALS)
    again = pickle.loads(pickle.dumps(trajectory))
    assert again == trajectory
    assert again["left"].certificate == trajectory["left"].certificate
    assert srmp.MultiTrajectory(dict(trajectory.items())) == trajectory
    assert srmp.MultiTrajectory({"left": trajectory["left"]}) != trajectory


def test_motions_are_a_mapping():
    one = srmp.Trajectory(["a"], [[0.0], [1.0]], [0, 1])
    motions = srmp.MultiTrajectory({"left": one})
    assert isinstance(motions, collections.abc.Mapping)
    assert srmp.MultiTrajectory(motions) == motions
    assert dict(motions) == {"left": one}
    assert motions.get("left") == one
    assert motions.get("right") is None
    assert motions.get("right", 7) == 7
    assert "left" in motions
    for unknown in ("right", 3, None):
        assert unknown not in motions
        with pytest.raises(KeyError) as error:
            motions[unknown]
        assert isinstance(error.value, srmp.UnknownRobot)
        assert isinstance(error.value, srmp.InvalidArgument)
    with pytest.raises(srmp.UnknownRobot, match=r"^there is no trajectory of robot 'lft', did you mean 'left'"):
        motions["lft"]
    for wrong in (None, [one], {"left": None}, {1: one}):
        with pytest.raises(srmp.InvalidArgument, match="the trajectories must be"):
            srmp.MultiTrajectory(wrong)


def test_merged_is_every_robots_motion_on_common_rows():
    trajectory = ring().plan_multi(*quarter_turns())
    merged = trajectory.merged()
    assert merged.joint_names == [f"{name}/{joint}" for name in trajectory for joint in trajectory[name].joint_names]
    assert merged.duration == trajectory.duration
    assert set(np.concatenate([one.times for one in trajectory.values()])) == set(merged.times)
    assert merged.certificate is None
    for t in np.linspace(0, merged.duration, 301):
        state = merged.state(t)
        for k, one in enumerate(trajectory.values()):
            mine = one.state(min(t, one.duration))
            columns = slice(7 * k, 7 * k + 7)
            np.testing.assert_allclose(state[0][columns], mine[0], atol=1e-9)
            if t < one.duration:
                np.testing.assert_allclose(state[1][columns], mine[1], atol=1e-6)


def test_nothing_is_merged_of_robots_with_and_without_times():
    timed = two().plan_multi(STARTS, GOALS)["left"]
    untimed = two(timing="none").plan_multi(STARTS, GOALS)["right"]
    with pytest.raises(srmp.InvalidArgument, match="some of the trajectories have times and others have not"):
        srmp.MultiTrajectory({"left": timed, "right": untimed}).merged()
    with pytest.raises(srmp.InvalidArgument, match="no robot to merge"):
        srmp.MultiTrajectory({}).merged()


def test_certificates_name_the_other_robot():
    trajectory = two().plan_multi(STARTS, GOALS)
    for name, other in (("left", "right"), ("right", "left")):
        certificate = trajectory[name].certificate
        assert 0 < certificate.clearance < 0.1
        assert certificate.body_a in ("arm7_wrist", "arm7_palm", "arm7_hand", "arm7_forearm", "arm7_flange")
        assert certificate.body_b.startswith(f"{other}/arm7_")


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
def test_limits_hold_whatever_times_them(timing):
    planner = two(timing=timing)
    planner.set_motion_limits("right", [0.5] * 7, [1.0] * 7, [10.0] * 7)
    trajectory = planner.plan_multi(STARTS, GOALS)
    assert all(one.certificate.holds for one in trajectory.values())
    assert np.abs(trajectory["right"].velocities).max() <= 0.5 + 1e-9
    assert np.abs(trajectory["left"].velocities).max() > 0.1
    assert in_contact(planner, trajectory) == []


def test_a_path_without_times():
    planner = two(timing="none")
    trajectory = planner.plan_multi(STARTS, GOALS)
    rows = {one.positions.shape for one in trajectory.values()}
    assert len(rows) == 1  # row by row together
    assert all(len(one.times) == 0 for one in trajectory.values())
    assert all(one.certificate.proved_free for one in trajectory.values())
    merged = trajectory.merged()
    assert merged.positions.shape == (rows.pop()[0], 14)
    statistics = planner.get_planning_stats()
    assert statistics["makespan_s"] == statistics["flow_time_s"] == 0
    held = planner.plan_multi(STARTS, {"left": joints(turned(0.7))})
    assert held.merged().positions.shape == (len(held["left"].positions), 14)


def test_no_certificate_when_none_is_wanted():
    trajectory = two(certify=False).plan_multi(STARTS, GOALS)
    assert [one.certificate for one in trajectory.values()] == [None, None]


def test_no_shortcut_when_none_is_wanted():
    planner = two(shortcut=False)
    planner.plan_multi(STARTS, GOALS)
    statistics = planner.get_planning_stats()
    assert statistics["path_cost_rad"] == pytest.approx(statistics["search_cost_rad"], rel=1e-12)


# --- options of single robots


def test_a_robot_has_a_heuristic_of_its_own():
    calls = {"left": 0, "right": 0}

    def mine(name):
        def distance(configurations, goals):
            calls[name] += 1
            return np.linalg.norm(configurations[:, None] - goals[None], axis=2).min(axis=1)

        return distance

    planner = two()
    for name in calls:
        planner.add_heuristic(name, mine(name))
    planner.make_planner(["left", "right"], {"planner_id": "xECBS", "heuristic_left": "left"})
    planner.plan_multi(STARTS, GOALS)
    assert calls["left"] > 0
    assert calls["right"] == 0
    planner.make_planner(["left", "right"], srmp.XECBS(robots={"right": {"heuristic": "right"}}))
    planner.plan_multi(STARTS, GOALS)
    assert calls["right"] > 0


def test_a_robot_has_motion_primitives_of_its_own(tmp_path):
    file = tmp_path / "base.yaml"
    file.write_text("units: degrees\nfamilies:\n  - {name: turn, joints: [arm7_joint1], by: [[20]]}\n")
    planner = two("CBS", distance=0.9)
    planner.make_planner(["left", "right"], {"planner_id": "CBS", "mprim_path_left": str(file)})
    trajectory = planner.plan_multi(STARTS, GOALS)
    assert np.allclose(trajectory["left"].waypoints[:, 1:], READY[1:])  # no other joint has a primitive
    assert "or of their own primitives" in planner.get_planning_stats()["bound_graph"]
    planner.make_planner(["left", "right"], {"planner_id": "CBS", "mprim_path_left": str(tmp_path / "none.yaml")})
    with pytest.raises(srmp.FileError, match=r"none\.yaml"):
        planner.plan_multi(STARTS, GOALS)


def test_options_of_single_robots_are_kept(tmp_path):
    planner = two()
    planner.make_planner(["left", "right"], srmp.XECBS(robots={"left": {"heuristic": "bfs"}}))
    first = planner.plan_multi(STARTS, GOALS)
    planner.save(tmp_path / "two.json")
    again = srmp.PlannerInterface.load(tmp_path / "two.json")
    assert again.plan_multi(STARTS, GOALS) == first
    text = (tmp_path / "two.json").read_text()
    (tmp_path / "wrong.json").write_text(text.replace("heuristic_left", "heuristic_lfet"))
    with pytest.raises(srmp.FileError, match="robot 'lfet' alone"):
        srmp.PlannerInterface.load(tmp_path / "wrong.json")
    planner.add_heuristic("mine", lambda configurations, goals: np.zeros(len(configurations)))
    planner.make_planner(["left", "right"], {"planner_id": "xECBS", "heuristic_left": "mine"})
    with pytest.raises(srmp.InvalidArgument, match="heuristic 'mine' of yours"):
        planner.save(tmp_path / "mine.json")


# --- time


def test_the_time_limit_is_kept():
    planner = two("CBS", time_limit=0.05, resolution=2)
    with pytest.raises(srmp.PlanningError, match=r"no paths within the time limit of 0.05 s \(\d+ nodes") as error:
        planner.plan_multi(STARTS, GOALS)
    assert error.value.status == srmp.Status.timed_out
    statistics = planner.get_planning_stats()
    assert statistics["status"] == srmp.Status.timed_out
    assert statistics["reason"] == str(error.value)
    assert 0.05 <= statistics["total_time_s"] < 1
    assert error.value.statistics == statistics


@pytest.mark.parametrize("threads", [1, 3])
def test_ctrl_c_stops_it(threads):
    planner = two("CBS", time_limit=60, num_threads=threads, resolution=2)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
        began = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            planner.plan_multi(STARTS, GOALS)
        assert time.perf_counter() - began < 30
    finally:
        signal.signal(signal.SIGINT, before)
