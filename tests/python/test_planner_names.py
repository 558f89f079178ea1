"""The planner that the options name is the one that searches: no trees and no roadmaps under the names of searches.

For every planner id of the registry, so that a new one is looked at too.
"""

import heapq
import itertools

import numpy as np
import pytest
from multi_arms import GOALS, STARTS, in_contact, ring, two, world
from support import joints, turned

import srmp
from srmp import Pose

BY_SAMPLING = {"auto", "RRTConnect"}
SEARCHES = [name for name in srmp.available_planners() if name not in BY_SAMPLING]
FOR_ONE = [name for name in SEARCHES if srmp.planner_info(name).one_robot]
FOR_MANY = [name for name in SEARCHES if srmp.planner_info(name).many_robots]
OF_MANY = {
    "each robot alone",
    "conflict-based search",
    "conflict-based search along known paths",
    "conflict-based search on lattices",
}


def test_all_planners_are_looked_at():
    assert {"Astar", "wAstar", "ARAstar", "MHAstar", "wPASE", "AMRAstar"} == set(FOR_ONE)
    assert {"CBS", "ECBS", "xECBS", "prioritised"} == set(FOR_MANY)
    assert all(srmp.planner_info(name).one_robot and srmp.planner_info(name).many_robots for name in BY_SAMPLING)
    assert set(SEARCHES) == set(FOR_ONE) | set(FOR_MANY)


def arm_behind_a_wall(planner_id, **options):
    """The straight motion from one side of the wall to the other is not free."""
    planner = world({"arm": (0, 0, 0)}, planner_id, **{"resolution": 30, "time_limit": 3, **options})
    planner.add_box("wall", [0.6, 0.04, 0.5], Pose([0.5, 0, 0.25]))
    return planner


@pytest.mark.parametrize("planner_id", FOR_ONE)
def test_searches_of_one_robot_search_lattices_alone(planner_id):
    planner = arm_behind_a_wall(planner_id)
    try:
        planner.plan("arm", turned(0.8), turned(-0.8))
        assert planner.get_planning_stats()["found_by"].startswith("the lattice of")
    except srmp.PlanningError as error:  # A* on one lattice
        assert error.status == srmp.Status.timed_out
    statistics = planner.get_planning_stats()
    assert statistics["samples"] == 0
    assert statistics["expansions"] > 0


@pytest.mark.parametrize("planner_id", ["auto", "RRTConnect"])
def test_what_draws_samples_says_so(planner_id):
    planner = arm_behind_a_wall(planner_id)
    planner.plan("arm", turned(0.8), turned(-0.8))
    assert planner.get_planning_stats()["samples"] > 0
    assert planner.get_planning_stats()["found_by"] == "RRT-Connect"


def test_rrt_connect_of_two_arms_grows_trees_alone():
    found = []
    for _ in range(2):
        planner = two("RRTConnect")
        trajectory = planner.plan_multi(STARTS, GOALS)
        found.append([one.positions.tobytes() for one in trajectory.values()])
    assert found[0] == found[1]
    assert in_contact(planner, trajectory) == []
    statistics = planner.get_planning_stats()
    assert statistics["found_by"] == "composite RRT-Connect"
    assert statistics["samples"] > 0
    assert statistics["expansions"] == statistics["tree_nodes"] == 0
    assert statistics["large_neighbourhood_search"] is False


def test_rrt_connect_of_two_arms_says_what_it_did_without_a_path():
    planner = bars("RRTConnect", distance=0.6, time_limit=0.3)  # so near that bars on one side cannot get to the other
    said = r"no paths within the time limit of 0\.3 s \(\d+ configurations sampled\)"
    with pytest.raises(srmp.PlanningError, match=said):
        planner.plan_multi({"a": [1.4], "b": [-1.4]}, {"a": joints([-1.4]), "b": joints([1.4])})
    statistics = planner.get_planning_stats()
    assert statistics["status"] == srmp.Status.timed_out
    assert statistics["samples"] > 0


def test_rrt_connect_of_two_arms_refuses_path_constraints():
    planner = two("RRTConnect")
    upright = {"left": [srmp.PathConstraint.cone([0, 0, 1], [0, 0, -1], 0.5)]}
    with pytest.raises(srmp.NotSupported, match="constraints of 'left': the trees of RRTConnect for several robots"):
        planner.plan_multi(STARTS, GOALS, constraints=upright)


def require_conflict_based_search(statistics):
    assert statistics["samples"] == 0
    assert set(statistics["found_by"].split(", ")) <= OF_MANY


@pytest.mark.parametrize("planner_id", FOR_MANY)
def test_searches_of_two_arms_are_by_conflicts_alone(planner_id):
    planner = two(planner_id, distance=0.8 if planner_id == "CBS" else 0.7)
    try:
        trajectory = planner.plan_multi(STARTS, GOALS)
        assert in_contact(planner, trajectory) == []
    except srmp.PlanningError as error:  # CBS is optimal, and slow
        assert (planner_id, error.status) == ("CBS", srmp.Status.timed_out)
    statistics = planner.get_planning_stats()
    assert statistics["samples"] == 0
    if statistics["status"] == srmp.Status.solved:
        require_conflict_based_search(statistics)
    assert statistics["tree_nodes"] >= 1 or statistics["found_by"] == "each robot alone"


def shelf(planner_id):
    """Three arms around a table with boxes, two of which reach into the same place."""
    bases = {"left": (0, 0, 0), "right": (0.75, 0, np.pi), "far": (0, 1.6, 0)}
    planner = world(bases, planner_id)
    planner.add_box("table", [0.3, 0.3, 0.05], Pose([0.375, 0, 0.1]))
    planner.add_box("post", [0.04, 0.04, 0.5], Pose([0.375, 1.6, 0.25]))
    starts = {name: turned(0.6) for name in bases}
    return planner, starts, {name: joints(turned(-0.6)) for name in bases}


@pytest.mark.parametrize("planner_id", ["xECBS", "prioritised"])
@pytest.mark.parametrize("make", [shelf, lambda planner_id: (ring(planner_id=planner_id), None, None)])
def test_a_constraint_tree_resolves_what_robots_do_to_each_other(make, planner_id):
    planner, starts, goals = make(planner_id)
    if starts is None:
        starts = {name: turned(0.5) for name in planner.robot_names}
        goals = {name: joints(turned(-0.5)) for name in planner.robot_names}
    planner.plan_multi(starts, goals)
    statistics = planner.get_planning_stats()
    require_conflict_based_search(statistics)
    assert "conflict-based search" in statistics["found_by"]
    assert statistics["tree_nodes"] >= 1


# --- options that are not part of the published algorithms ------------------------------------------------------------


def outcome(planner_id, **options):
    planner = two(planner_id, **options)
    trajectory = planner.plan_multi(STARTS, GOALS)
    return planner.get_planning_stats(), [one.positions.tobytes() for one in trajectory.values()]


@pytest.mark.parametrize(("planner_id", "first_alone"), [("ECBS", False), ("xECBS", True), ("prioritised", True)])
def test_what_is_beside_the_algorithm_is_an_option_and_said(planner_id, first_alone):
    by_default, positions = outcome(planner_id)
    said, same = outcome(planner_id, independence_detection=first_alone, large_neighbourhood_search=True)
    assert same == positions
    assert by_default["independence_detection"] is said["independence_detection"] is first_alone
    assert by_default["large_neighbourhood_search"] is said["large_neighbourhood_search"] is True

    without, _ = outcome(planner_id, large_neighbourhood_search=False)
    assert without["large_neighbourhood_search"] is False
    assert without["path_cost_rad"] >= by_default["path_cost_rad"] - 1e-9
    bare, _ = outcome(planner_id, shortcut=False)
    assert bare["large_neighbourhood_search"] is False


def test_without_independence_detection_all_that_can_reach_each_other_are_planned_jointly():
    starts, goals = (
        {"left": turned(0.6), "right": turned(0.6)},
        {"left": joints(turned(0.5)), "right": joints(turned(0.7))},
    )
    for planner_id in ("xECBS", "prioritised"):
        for first_alone in (True, False):
            planner = two(planner_id, independence_detection=first_alone)
            planner.plan_multi(starts, goals)
            statistics = planner.get_planning_stats()
            assert statistics["independence_detection"] is first_alone
            assert (statistics["found_by"] == "each robot alone") is first_alone
            assert (statistics["tree_nodes"] >= 1) is not first_alone


# --- the bound of xECBS against brute force ---------------------------------------------------------------------------

STEP = np.pi / 90
ANGLES = np.arange(-45, 46) * STEP
BOX = "<origin xyz='0.5 0 0'/><geometry><box size='0.9 0.08 0.08'/></geometry>"
BAR = (
    f"<robot name='bar'><link name='base'/><link name='bar'><collision>{BOX}</collision></link>"
    "<joint name='turn' type='revolute'><parent link='base'/>"
    "<child link='bar'/><axis xyz='0 0 1'/><limit lower='-1.58' upper='1.58' velocity='2' effort='1'/></joint></robot>"
)


def bars(planner_id="xECBS", distance=1.3, time_limit=20):
    """Two bars of 0.95 m that turn in the same plane, towards each other at angle 0."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=BAR, name="a", end_effector="bar")
    planner.add_articulation(
        urdf_text=BAR, name="b", end_effector="bar", base_pose=Pose.from_rpy([distance, 0, 0], [0, 0, np.pi])
    )
    planner.make_planner(["a", "b"], {"planner_id": planner_id, "resolution": 6, "time_limit": time_limit})
    return planner


def free_pairs():
    """free[i, j]: the bars at ANGLES[i] and ANGLES[j] do not touch."""
    planner = bars()
    free = np.zeros((len(ANGLES), len(ANGLES)), bool)
    for j, angle in enumerate(ANGLES):
        planner.set_qpos("b", [angle])
        free[:, j] = planner.collision_checker("a").are_free(ANGLES[:, None])
    return free


def optimum(free, start, goal):
    """The least sum of both bars' angles, by Dijkstra's algorithm on all pairs of angles: bars turn one at a time or
    together at the same cost, so nothing is lost but the last step before a contact."""
    best, queue = {start: 0.0}, [(0.0, start)]
    while queue:
        cost, (i, j) = heapq.heappop(queue)
        if (i, j) == goal:
            return cost
        for di, dj in itertools.product((-1, 0, 1), repeat=2):
            near = i + di, j + dj
            if min(near) < 0 or max(near) >= len(ANGLES) or not free[near]:
                continue
            more = cost + STEP * (abs(di) + abs(dj))
            if more < best.get(near, np.inf) - 1e-12:
                best[near] = more
                heapq.heappush(queue, (more, near))
    return np.inf


DETOURS = [  # numbers of angles, start and goal of both bars; no motion of the shortest paths alone is free
    ((75, 26), (9, 31)),
    ((15, 27), (74, 56)),
    ((58, 52), (43, 6)),
    ((40, 11), (33, 84)),
    ((14, 66), (69, 55)),
    ((26, 82), (61, 6)),
    ((61, 15), (65, 66)),
]


def test_the_bound_of_xecbs_holds_against_brute_force():
    free, planner = free_pairs(), bars()
    for start, goal in DETOURS:
        direct, least = STEP * np.abs(np.subtract(start, goal)).sum(), optimum(free, start, goal)
        assert least > 1.1 * direct
        ends = [{name: ANGLES[[pair[k]]] for k, name in enumerate("ab")} for pair in (start, goal)]
        planner.plan_multi(ends[0], {name: joints(q) for name, q in ends[1].items()})
        statistics = planner.get_planning_stats()
        require_conflict_based_search(statistics)
        assert statistics["tree_nodes"] >= 1
        assert statistics["bound_graph"] == "every path"
        assert statistics["path_cost_rad"] >= least - 4 * STEP  # the shortest path may end nearer to a contact
        assert statistics["path_cost_rad"] <= statistics["bound"] * least * (1 + 1e-9)
        assert statistics["path_cost_rad"] == pytest.approx(statistics["bound"] * direct)  # what is proved
