"""What PlannerInterface promises, on the package's own arm."""

import itertools
import pickle
import signal
import threading
import time

import numpy as np
import pytest

import srmp


def mirrored(q):
    return np.concatenate([[-q[0]], q[1:]])


def check_trajectory(planner, trajectory, start, goal=None):
    limits = planner.get_joint_limits("arm")
    assert trajectory.positions.shape == trajectory.velocities.shape == trajectory.accelerations.shape
    assert trajectory.positions.shape == (len(trajectory.times), 7)
    assert trajectory.joint_names == planner.get_joint_names("arm")
    np.testing.assert_array_equal(trajectory.positions[0], start)
    if goal is not None:
        np.testing.assert_array_equal(trajectory.positions[-1], goal)
    assert (np.diff(trajectory.times) > 0).all()
    assert (np.abs(trajectory.velocities) <= limits[:, 2] * (1 + 1e-9)).all()
    assert not trajectory.velocities[[0, -1]].any()
    for a, b in zip(trajectory.waypoints[:-1], trajectory.waypoints[1:], strict=True):
        for t in np.linspace(0, 1, 30):
            assert not planner.is_state_colliding("arm", a + t * (b - a))


@pytest.mark.parametrize("planner_id", ["wAstar", "ARAstar", "MHAstar", "wPASE", "auto", "wA*", "mha*"])
def test_every_planner_goes_round_the_post(arm, ready, planner_id):
    goal = mirrored(ready)
    assert not arm.is_motion_free("arm", ready, goal)
    arm.make_planner("arm", {"planner_id": planner_id, "time_limit": 2})
    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
    check_trajectory(arm, trajectory, ready, goal)
    stats = arm.get_planning_stats()
    assert stats["status"] == srmp.Status.solved
    assert 1 <= stats["bound"] <= 100
    assert stats["path_cost_rad"] <= stats["search_cost_rad"] + 1e-9
    assert 0.98 * stats["path_cost_rad"] <= trajectory.length <= stats["path_cost_rad"] + 1e-9  # corners are rounded


@pytest.mark.parametrize(
    "options", [srmp.Auto(improve_time=60, time_limit=60), srmp.ARAStar(time_limit=60), srmp.WAStar()]
)
def test_solutions_get_better_and_never_worse(arm, ready, options):
    goal = mirrored(ready)
    arm.make_planner("arm", options)
    seen = []

    def on_solution(solution, waypoints):
        seen.append((solution, waypoints))
        return len(seen) < 2

    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal), on_solution=on_solution)
    check_trajectory(arm, trajectory, ready, goal)
    stats = arm.get_planning_stats()
    assert [solution for solution, _ in seen] == stats["solutions"]
    assert stats["solutions"][-1]["cost_rad"] == stats["path_cost_rad"]
    assert stats["solutions"][-1]["bound"] == stats["bound"]
    assert stats["solutions"][-1]["graph"] == stats["bound_graph"] != ""
    for solution, waypoints in seen:
        assert 0 < solution["time_s"] <= stats["plan_time_s"]
        steps = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
        assert steps.sum() == pytest.approx(solution["cost_rad"])
        np.testing.assert_array_equal(waypoints[[0, -1]], [ready, goal])
    for (a, _), (b, _) in itertools.pairwise(seen):
        assert b["cost_rad"] <= a["cost_rad"]
        assert b["bound"] <= a["bound"]
        assert b["cost_rad"] < a["cost_rad"] or b["bound"] < a["bound"]
    if not isinstance(options, srmp.WAStar):
        assert len(seen) == 2


def test_rounds_of_improvement_are_the_same_every_time(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    costs, samples = [], []
    for rounds in (0, 1, 2):
        arm.make_planner("arm", srmp.Auto(improve_rounds=rounds, time_limit=60))
        paths = [arm.plan("arm", ready, goal).waypoints for _ in range(2)]
        np.testing.assert_array_equal(*paths)
        costs.append(arm.get_planning_stats()["path_cost_rad"])
        samples.append(arm.get_planning_stats()["samples"])
    assert samples[0] < samples[1] < samples[2]  # each round grows trees of other samples
    assert costs == sorted(costs, reverse=True)
    assert costs[1] < costs[0]


def test_bounds_are_true_of_the_lattice_they_name(arm, ready, tmp_path):
    primitives = tmp_path / "three_joints.yaml"
    primitives.write_text(
        "units: degrees\nfamilies:\n"
        + "".join(f"  - {{name: j{j}, joints: [arm7_joint{j}], by: 20}}\n" for j in (1, 2, 4))
    )
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    lattice = {"mprim_path": str(primitives), "direction": "forward", "time_limit": 60}
    arm.make_planner("arm", srmp.AStar(**lattice))
    arm.plan("arm", ready, goal)
    optimum = arm.get_planning_stats()["search_cost_rad"]
    direct = np.linalg.norm(mirrored(ready) - ready)
    arm.make_planner("arm", srmp.Auto(improve_time=0.5, **lattice))
    arm.plan("arm", ready, goal)
    solutions = arm.get_planning_stats()["solutions"]
    for solution in solutions:
        lower = direct if solution["graph"] == "every path" else optimum
        assert solution["cost_rad"] <= solution["bound"] * lower * (1 + 1e-9)
        if solution["bound"] > 1:
            assert solution["cost_rad"] / solution["bound"] <= lower * (1 + 1e-9)
    assert any(str(primitives) in solution["graph"] for solution in solutions)


def test_a_solution_that_is_good_enough_ends_the_plan(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    for options in (srmp.Auto(improve_time=60, time_limit=60), srmp.ARAStar(time_limit=60)):
        arm.make_planner("arm", options)
        arm.plan("arm", ready, goal, on_solution=lambda solution, waypoints: False)
        stats = arm.get_planning_stats()
        assert len(stats["solutions"]) == 1
        assert stats["plan_time_s"] < 30


@pytest.mark.parametrize(
    "options",
    [srmp.Auto(improve_time=60, time_limit=60), srmp.ARAStar(time_limit=60), srmp.AMRAStar(time_limit=60)],
    ids=lambda options: type(options).__name__,
)
def test_a_straight_line_ends_the_plan(arm, ready, options):
    goal = np.array(ready)
    goal[:2] += [0.2, -0.1]
    arm.make_planner("arm", options)
    arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
    stats = arm.get_planning_stats()
    assert stats["path_cost_rad"] == pytest.approx(np.linalg.norm(goal - np.array(ready)), rel=1e-9)
    assert stats["bound"] == 1
    assert stats["plan_time_s"] < 30


def test_auto_stops_at_the_bound_asked_for(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    arm.make_planner("arm", srmp.Auto(improve_time=60, time_limit=60, final_weight=20))
    arm.plan("arm", ready, goal)
    stats = arm.get_planning_stats()
    assert stats["bound"] <= 20
    assert stats["plan_time_s"] < 30


def test_a_callback_that_raises_ends_the_plan(arm, ready):
    def fail(solution, waypoints):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)), on_solution=fail)
    with pytest.raises(srmp.InvalidArgument, match="on_solution must be a function"):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)), on_solution=3)


def test_auto_is_the_default():
    assert srmp.planner_options({})["planner_id"] == "auto"


@pytest.mark.parametrize("heuristic", ["joint_euclidean", "bfs"])
@pytest.mark.parametrize("direction", ["forward", "backward", "auto"])
def test_heuristics_and_directions(arm, ready, heuristic, direction):
    arm.make_planner("arm", srmp.WAStar(heuristic=heuristic, direction=direction))
    goal = mirrored(ready)
    check_trajectory(arm, arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal)), ready, goal)


def test_the_straight_line_is_taken_when_it_is_free(arm, ready):
    goal = ready + 0.3
    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
    assert len(trajectory.waypoints) == 2


def test_pose_and_position_goals(arm, ready):
    target = arm.compute_fk("arm", mirrored(ready))
    trajectory = arm.plan(["arm"], ready, srmp.GoalConstraint(srmp.GoalType.POSE, list(target)))
    reached = arm.compute_fk("arm", trajectory.positions[-1])
    np.testing.assert_allclose(reached.matrix(), target.matrix(), atol=1e-3)
    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSITION, target.p))
    np.testing.assert_allclose(arm.compute_fk("arm", trajectory.positions[-1]).p, target.p, atol=1e-4)


def test_any_of_several_goals(arm, ready):
    far, near = mirrored(ready), ready + 0.1
    arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, [far, near]))
    assert arm.get_planning_stats()["goal_index"] == 1
    inside_post = srmp.Pose([0.3, 0, 0.4])
    goals = [srmp.GoalConstraint(srmp.GoalType.POSE, inside_post), srmp.GoalConstraint(srmp.GoalType.JOINTS, near)]
    arm.plan("arm", ready, goals)
    assert arm.get_planning_stats()["goal_index"] == 1


def test_the_same_request_has_the_same_result(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    outcomes = {arm.plan("arm", ready, goal).positions.tobytes() for _ in range(5)}
    arm.make_planner("arm", srmp.WPASE(num_threads=1))
    parallel = {arm.plan("arm", ready, goal).positions.tobytes()}
    for threads in (2, 4):
        arm.make_planner("arm", srmp.WPASE(num_threads=threads))
        parallel.add(arm.plan("arm", ready, goal).positions.tobytes())
    assert len(outcomes) == len(parallel) == 1


LAYERS = ("edges_free_by_spheres", "edges_colliding_by_spheres", "edges_free_by_coal", "edges_colliding_by_coal")


def counts(stats):
    """What a plan did, without the clock."""
    kept = {key: value for key, value in stats.items() if not key.endswith("time_s")}
    return kept | {"solutions": [counts(solution) for solution in stats.get("solutions", [])]}


@pytest.mark.parametrize("planner_id", ["wAstar", "ARAstar", "MHAstar", "wPASE", "auto"])
def test_statistics_tell_layers_and_memory_and_are_the_same_every_time(arm, ready, planner_id):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    seen = []
    for threads in (1, 2):
        options = {"num_threads": threads} if planner_id == "wPASE" else {}
        if planner_id == "ARAstar":
            options["final_weight"] = 20  # reached long before the time limit
        arm.make_planner("arm", {"planner_id": planner_id, "time_limit": 20, **options})
        arm.plan("arm", ready, goal)
        seen.append(counts(arm.get_planning_stats()))
    stats = seen[0]
    assert seen[1] == stats
    assert sum(stats[layer] for layer in LAYERS) == stats["edge_checks"] > 0
    assert stats["edges_free_by_spheres"] + stats["edges_free_by_coal"] >= 2  # the path is no straight line
    assert stats["edges_colliding_by_spheres"] + stats["edges_colliding_by_coal"] >= 1
    assert stats["memory_bytes"] > 32 * stats["states"]  # dof + 1 coordinates each


def test_a_finer_lattice_and_a_grid_take_more_memory(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    memory = {}
    for name, options in {
        "coarse": srmp.AStar(resolution=40),
        "fine": srmp.AStar(resolution=15, time_limit=1),
        "grid": srmp.WAStar(heuristic="bfs", bfs_resolution=0.02),
        "no grid": srmp.WAStar(),
    }.items():
        arm.make_planner("arm", options)
        try:
            arm.plan("arm", ready, goal)
        except srmp.PlanningError as error:
            assert error.status == srmp.Status.timed_out  # counted all the same
        memory[name] = arm.get_planning_stats()["memory_bytes"]
    assert memory["coarse"] < memory["fine"]
    assert memory["no grid"] + 100**3 < memory["grid"]


def test_start_in_collision_names_the_pair(arm, ready):
    arm.add_sphere("sphere", radius=0.1, pose=srmp.Pose(p=arm.compute_fk("arm", ready, "arm7_hand").p))
    with pytest.raises(srmp.PlanningError, match=r"'arm7_.*'sphere'.*mm") as error:
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)))
    assert error.value.status == srmp.Status.start_invalid
    with pytest.raises(srmp.PlanningError, match="'sphere'") as error:
        arm.plan("arm", mirrored(ready), srmp.GoalConstraint(srmp.GoalType.JOINTS, ready))
    assert error.value.status == srmp.Status.goal_invalid
    assert arm.get_planning_stats()["status"] == srmp.Status.goal_invalid


def test_a_hair_outside_a_limit_is_mended_and_said(arm, ready):
    lower = arm.get_joint_limits("arm")[0, 0]
    start = ready.copy()
    start[0] = lower - 5e-7
    arm.remove_object("post")
    trajectory = arm.plan("arm", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready))
    assert trajectory.positions[0, 0] == lower
    assert "joint limit" in arm.get_planning_stats()["note"]
    start[0] = lower - 1e-3
    with pytest.raises(srmp.PlanningError, match="below the lower limit") as error:
        arm.plan("arm", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready))
    assert error.value.status == srmp.Status.start_invalid


def test_a_start_in_collision_can_be_escaped_if_asked_for(arm, ready):
    arm.add_sphere("sphere", radius=0.1, pose=arm.compute_fk("arm", ready) @ srmp.Pose([0, 0, 0.09]))
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready))
    depths = {(c.body_a, c.body_b): c.distance for c in arm.contacts("arm", ready)}
    assert depths
    arm.make_planner("arm", srmp.WAStar(recover_start=True))
    trajectory = arm.plan("arm", ready, goal)
    np.testing.assert_array_equal(trajectory.positions[0], ready)
    np.testing.assert_array_equal(trajectory.positions[-1], mirrored(ready))
    stats = arm.get_planning_stats()
    assert "'sphere'" in stats["note"]
    end = stats["recovery_waypoints"]
    assert end >= 1
    length = stats["recovery_cost_rad"] + stats["path_cost_rad"]
    assert 0.98 * length <= trajectory.length <= length + 1e-9  # corners are rounded
    for q in trajectory.positions:  # the trajectory itself: depths never grow, and once free, always free
        now = {(c.body_a, c.body_b): c.distance for c in arm.contacts("arm", q)}
        for pair, distance in now.items():
            assert distance >= depths[pair] - 2e-5
        depths = {pair: max(distance, depths[pair]) for pair, distance in now.items()}
    assert not depths
    for a, b in itertools.pairwise(trajectory.waypoints[end:]):
        assert arm.is_motion_free("arm", a, b)
    result = arm.plan_many([srmp.PlanRequest("arm", ready, goal)] * 2, threads=2)[1]
    np.testing.assert_array_equal(result.trajectory.positions, trajectory.positions)
    assert result.statistics["recovery_cost_rad"] == stats["recovery_cost_rad"]


def test_out_of_reach_says_so(arm, ready):
    with pytest.raises(
        srmp.PlanningError, match="no configuration within the joint limits brings 'arm7_hand'"
    ) as error:
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose([5, 0, 0])))
    assert error.value.status == srmp.Status.goal_invalid


def test_time_limit_and_overshoot(arm, ready):
    arm.make_planner("arm", {"planner_id": "Astar", "time_limit": "0.2", "resolution": 3})
    began = time.perf_counter()
    with pytest.raises(srmp.PlanningError, match=r"0.2 s.*expanded") as error:
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)))
    assert error.value.status == srmp.Status.timed_out
    assert time.perf_counter() - began < 2.0


def test_exhausted_is_told_apart(arm, ready, tmp_path):
    """With primitives that only turn the hand, the post cannot be passed, and that is soon known."""
    primitives = tmp_path / "hand_only.yaml"
    last = arm.get_joint_names("arm")[-1]
    primitives.write_text(f"units: degrees\nfamilies:\n  - {{name: turn, joints: [{last}], by: 30, use: always}}\n")
    for planner in (srmp.WAStar, srmp.Auto):
        for direction, end in (("forward", "start"), ("backward", "goals")):
            arm.make_planner("arm", planner(mprim_path=str(primitives), direction=direction))
            with pytest.raises(srmp.PlanningError, match=f"hand_only.yaml' from the {end} holds no path") as error:
                arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)))
            assert error.value.status == srmp.Status.exhausted


def test_no_path_past_what_blocks_a_joint():
    """Whatever the planner: the rod that the first joint alone turns cannot get past the post."""
    urdf = """<robot name="rod"><link name="base"/>
      <link name="upper"><collision><origin xyz="0.4 0 0"/>
        <geometry><box size="0.6 0.05 0.05"/></geometry></collision></link>
      <link name="lower"><collision><origin xyz="0.2 0 0"/>
        <geometry><box size="0.2 0.05 0.05"/></geometry></collision></link>
      <joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
      <joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.7 0 0"/>
        <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"""
    planner = srmp.PlannerInterface()
    planner.add_articulation(name="rod", urdf_text=urdf, end_effector="lower")
    planner.add_box("post", [0.05, 0.05, 1], srmp.Pose([0.5, 0, 0]))
    start, goal = np.array([-1.0, 0.5]), srmp.GoalConstraint(srmp.GoalType.JOINTS, [1.0, -0.5])
    reason = (
        r"^there is no path: joint 'turn' cannot get from -1 to 1, because at -?0(\.\d+)? "
        r"link 'upper' and object 'post' overlap by [\d.]+ mm wherever the other joints are$"
    )
    for options in ("auto", "RRTConnect", "Astar", "wAstar", "ARAstar", "MHAstar", "wPASE", "AMRAstar"):
        planner.make_planner("rod", {"planner_id": options, "time_limit": 600})
        with pytest.raises(srmp.PlanningError, match=reason) as error:
            planner.plan("rod", start, goal)
        assert error.value.status == srmp.Status.exhausted


def ring_around_the_elbow(turning):
    """Half way from one side to the other: whichever way the lower link points, it is in the ring there."""
    urdf = f"""<robot name="rod"><link name="base"/><link name="upper"/>
      <link name="lower"><collision><origin xyz="0.2 0 0"/>
        <geometry><box size="0.2 0.05 0.05"/></geometry></collision></link>
      <link name="tool"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
      <joint name="turn" type="{turning}"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
      <joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.7 0 0"/>
        <axis xyz="0 0 1"/><limit lower="-3.2" upper="3.2" velocity="1" effort="1"/></joint>
      <joint name="lift" type="prismatic"><parent link="lower"/><child link="tool"/><origin xyz="0.3 0 0.1"/>
        <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint></robot>"""
    planner = srmp.PlannerInterface()
    planner.add_articulation(name="rod", urdf_text=urdf, end_effector="tool")
    for k, angle in enumerate(np.linspace(0, 2 * np.pi, 16, endpoint=False)):
        place = [0.7 + 0.2 * np.cos(angle), 0.2 * np.sin(angle), 0]
        planner.add_box(
            f"post {k}", [0.08, 0.08, 0.1], srmp.Pose(place, srmp.Pose.from_rpy([0, 0, 0], [0, 0, angle]).q)
        )
    return planner


def test_no_path_past_what_blocks_two_joints_together():
    planner = ring_around_the_elbow("revolute")
    start, goal = [-1.5, 0.5, 0.1], srmp.GoalConstraint(srmp.GoalType.JOINTS, [1.5, -0.5, 0.3])
    reason = (
        r"^there is no path: joints 'turn' and 'bend' cannot get from \(-1.5, 0.5\) to \(1.5, -0.5\) wherever the "
        r"other joints are, because they are in collision all around; so at \(.+, .+\), where link 'lower' and "
        r"object 'post \d+' overlap by [\d.]+ mm$"
    )
    said = set()
    for name in ("auto", "auto", "RRTConnect"):
        planner.make_planner("rod", {"planner_id": name, "time_limit": 600})
        with pytest.raises(srmp.PlanningError, match=reason) as error:
            planner.plan("rod", start, goal)
        assert error.value.status == srmp.Status.exhausted
        said.add(str(error.value))
    assert len(said) == 1

    # What is known of one target helps with the others.
    blocked = [[1.5, -0.5, 0.3], [1.2, 1.0, 0.0], [2.0, -2.0, 0.4]]
    planner.make_planner("rod", {"planner_id": "auto", "time_limit": 600})
    with pytest.raises(srmp.PlanningError, match=reason) as error:
        planner.plan("rod", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, blocked))
    assert error.value.status == srmp.Status.exhausted
    blocked.append([-1.0, 0.0, 0.2])
    planner.plan("rod", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, blocked))
    assert planner.get_planning_stats()["goal_index"] == 3

    # Inverse kinematics may know other ends, so nothing is proved; but the reason says what is likely.
    goal = srmp.GoalConstraint(srmp.GoalType.POSE, planner.compute_fk("rod", goal.targets[0]), 1e-3)
    planner.make_planner("rod", {"planner_id": "auto", "time_limit": 1})
    with pytest.raises(srmp.PlanningError, match="it may be joints 'turn' and 'bend' that block the way") as error:
        planner.plan("rod", start, goal)
    assert error.value.status == srmp.Status.timed_out


def test_a_continuous_joint_passes_on_the_other_side():
    planner = ring_around_the_elbow("continuous")
    planner.make_planner("rod", {"planner_id": "auto", "time_limit": 600})
    planner.plan("rod", [-1.5, 0.5, 0.1], srmp.GoalConstraint(srmp.GoalType.JOINTS, [1.5, -0.5, 0.3]))


OF_ONE_ROBOT = [name for name in srmp.available_planners() if srmp.planner_info(name).one_robot]


@pytest.mark.parametrize("direction", ["forward", "backward", "auto"])
@pytest.mark.parametrize("name", OF_ONE_ROBOT)
def test_every_planner_starts_at_the_start_itself(name, direction):
    """Not whole turns away from it, where the path comes from the goal or past half a turn."""
    planner, random = ring_around_the_elbow("continuous"), np.random.default_rng(1)
    info = srmp.planner_info(name)
    has_levels = any(option.name == "multi_resolution" for option in info.options)
    limit = 0.2 if "anytime" in info.guarantee else 60
    for levels in [{}, {"multi_resolution": False}] if has_levels else [{}]:
        planner.make_planner("rod", {"planner_id": name, "time_limit": limit, "direction": direction, **levels})
        for _ in range(3):
            start, goal = (np.append(random.uniform(-1, 1, 2), random.uniform(0, 0.5)) for _ in range(2))
            start[0], goal[0] = np.pi + 2 * np.pi * random.integers(-2, 3) - 0.3, -np.pi + 0.5
            trajectory = planner.plan("rod", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
            assert (trajectory.positions[0] == start).all() and (trajectory.waypoints[0] == start).all()


def test_lattices_reach_goals_that_are_whole_turns_away():
    """Where the search ended at a place on the grid, the goal itself is not a turn away from it."""
    planner, random = ring_around_the_elbow("continuous"), np.random.default_rng(0)
    for k in range(16):
        planner.remove_object(f"post {k}")
    for name in ("wAstar", "MHAstar", "ARAstar"):
        planner.make_planner("rod", {"planner_id": name, "time_limit": 600})
        for _ in range(20):
            start, goal = (np.append(random.uniform(-2, 2, 2), random.uniform(0, 0.5)) for _ in range(2))
            goal[0] += 2 * np.pi * random.integers(-2, 3)
            trajectory = planner.plan("rod", start, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
            assert np.abs(np.diff(trajectory.positions[:, 0])).max() < 0.1
            assert abs(np.remainder(trajectory.positions[-1, 0] - goal[0] + 1, 2 * np.pi) - 1) < 1e-6


@pytest.fixture
def interruptible():
    """Python's own Ctrl-C, which a program started in the background may have been told to ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_a_plan(arm, ready, interruptible):
    arm.make_planner("arm", {"planner_id": "Astar", "time_limit": 60, "resolution": 2})
    threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)))
    assert time.perf_counter() - began < 30


def test_the_gil_is_released_and_a_busy_planner_says_so(arm, ready):
    arm.make_planner("arm", {"planner_id": "Astar", "time_limit": 1, "resolution": 2})
    failed = []

    def plan():
        try:
            arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, mirrored(ready)))
        except srmp.PlanningError as error:
            failed.append(error.status)

    thread = threading.Thread(target=plan)
    thread.start()
    time.sleep(0.2)
    with pytest.raises(srmp.Error, match="no other thread may use it"):
        arm.add_sphere("late", radius=0.1)
    thread.join()
    assert failed == [srmp.Status.timed_out]
    assert "late" not in arm.object_names


def test_attached_object_is_heeded(arm, ready):
    hand = arm.compute_fk("arm", ready)
    arm.set_qpos("arm", ready)
    rod = hand @ srmp.Pose([0, 0, 0.1])
    arm.add_box("rod", size=[0.03, 0.03, 0.2], pose=rod)
    arm.attach_object("rod", "arm", "arm7_hand", touch_links=arm.get_link_names("arm")[-4:])
    goal = mirrored(ready)
    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, goal))
    check_trajectory(arm, trajectory, ready, goal)
    arm.set_qpos("arm", goal)
    arm.detach_object("rod")
    expected = arm.compute_fk("arm", goal) @ hand.inverse() @ rod
    np.testing.assert_allclose(arm.get_object_pose("rod").matrix(), expected.matrix(), atol=1e-9)


def test_kinematics_agree(arm, ready):
    jacobian = arm.compute_jacobian("arm", ready)
    pose = arm.compute_fk("arm", ready)
    for j in range(7):
        moved = arm.compute_fk("arm", ready + 1e-6 * np.eye(7)[j])
        np.testing.assert_allclose((moved.p - pose.p) / 1e-6, jacobian[:3, j], atol=1e-4)
    solutions = arm.compute_ik("arm", pose, reference=ready + 0.1)
    assert len(solutions)
    for q in solutions:
        np.testing.assert_allclose(arm.compute_fk("arm", q).matrix(), pose.matrix(), atol=1e-3)
    distances = np.linalg.norm(solutions - (ready + 0.1), axis=1)
    assert (np.diff(distances) >= 0).all()


def test_values_pickle(arm, ready):
    trajectory = arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.2))
    again = pickle.loads(pickle.dumps(trajectory))
    np.testing.assert_array_equal(again.positions, trajectory.positions)
    assert again.joint_names == trajectory.joint_names
    pose = srmp.Pose([1, 2, 3], [0, 0, 1, 1])
    assert pickle.loads(pickle.dumps(pose)) == pose
    goal = pickle.loads(pickle.dumps(srmp.GoalConstraint(srmp.GoalType.POSE, pose)))
    np.testing.assert_allclose(goal.targets[0], list(pose))


def test_typed_options_equal_the_library_defaults():
    for options in (
        srmp.AStar(),
        srmp.WAStar(),
        srmp.ARAStar(),
        srmp.MHAStar(),
        srmp.WPASE(),
        srmp.Auto(),
        srmp.XECBS(),
    ):
        assert srmp.planner_options({"planner_id": options.planner_id}) == options.to_dict()


def test_print_available_planners(arm, capsys):
    arm.print_available_planners()
    assert "ARAstar" in capsys.readouterr().out


def test_a_planner_is_not_used_by_what_it_calls(arm, ready):
    arm.add_heuristic("own", lambda q, goals: np.zeros(len(q)) + arm.is_state_colliding("arm", q[0]))
    arm.make_planner("arm", {"planner_id": "wAstar", "heuristic": "own"})
    with pytest.raises(srmp.Error, match="nor what it calls meanwhile, such as a heuristic; give each a Planner"):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.3))


@pytest.mark.parametrize("what", ["velocity", "acceleration"])
def test_scaling_that_leaves_no_limit_is_refused_by_its_name(arm, ready, what):
    arm.make_planner("arm", {f"{what}_scaling": 1e-7})
    expected = rf"{what}_scaling is 1e-07, which makes a limit of \d.*e-0[78]; limits must be 1e-06 or above"
    with pytest.raises(srmp.InvalidArgument, match=expected):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.JOINTS, ready + 0.3))


@pytest.mark.parametrize("heuristic", ["joint_euclidean", "bfs"])
def test_joints_that_are_not_planned_count_where_they_stand(arm, ready, heuristic):
    turned = srmp.PlannerInterface()
    turned.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="arm",
        end_effector="arm7_hand",
        joint_names=arm.get_joint_names("arm")[1:],
    )
    turned.set_joint_positions("arm", {"arm7_joint1": 0.7})
    whole = np.concatenate([[0.7], ready[1:]])
    assert turned.compute_fk("arm", ready[1:]) == arm.compute_fk("arm", whole)
    np.testing.assert_array_equal(turned.compute_jacobian("arm", ready[1:]), arm.compute_jacobian("arm", whole)[:, 1:])
    target = arm.compute_fk("arm", whole + np.array([0, 0.3, -0.2, 0.2, 0.1, 0, 0]))
    for q in turned.compute_ik("arm", target):
        assert np.linalg.norm(arm.compute_fk("arm", np.concatenate([[0.7], q])).p - target.p) < 1e-4
    turned.make_planner("arm", srmp.WAStar(heuristic=heuristic))
    trajectory = turned.plan("arm", ready[1:], srmp.GoalConstraint(srmp.GoalType.POSE, target))
    end = np.concatenate([[0.7], trajectory.positions[-1]])
    assert np.linalg.norm(arm.compute_fk("arm", end).p - target.p) < 1e-4
    assert trajectory.certificate.goal_error <= 1
    np.testing.assert_allclose(trajectory.end_effector_path()[-1], target.p, atol=1e-4)
