"""SearchTrace: what searches did, without an effect on what they find; and figures of it."""

import numpy as np
import pytest

import srmp
from srmp.demo import GOAL, ROBOT, make_world, start_configuration
from srmp.viewer._search import drawing_of, sentence
from srmp.viewer._tree import drawn_tree, node_places

PLANNERS = ("wAstar", "ARAstar", "MHAstar", "wPASE", "AMRAstar")


def demo(planner_id, **options):
    planner = make_world()
    planner.make_planner(ROBOT, {"planner_id": planner_id, **options})
    return planner, start_configuration(planner)


def swap(planner_id):
    """Two arms face to face reach over each other's side."""
    planner = srmp.PlannerInterface()
    for name, x, yaw in (("left", 0.0, 0.0), ("right", 0.8, np.pi)):
        planner.add_robot("arm7", name=name, base_pose=srmp.Pose.from_rpy([x, 0, 0], [0, 0, yaw]))
    planner.make_planner(["left", "right"], {"planner_id": planner_id, "time_limit": 30})
    over_a, over_b = (srmp.Pose.from_rpy([0.4, y, 0.2], [np.pi, 0, 0]) for y in (0.2, -0.2))
    ready = planner.get_group_states("left")["ready"]
    starts = {
        name: planner.compute_ik(name, pose, reference=ready)[0] for name, pose in (("left", over_a), ("right", over_b))
    }
    return planner, starts, {"left": over_b, "right": over_a}


@pytest.fixture(scope="module")
def traced():
    planner, start = demo("wAstar", heuristic="bfs", weight=5)
    with srmp.SearchTrace() as trace:
        planner.plan(ROBOT, start, GOAL)
    return planner, trace


@pytest.fixture(scope="module")
def tree():
    planner, starts, goals = swap("ECBS")
    with srmp.SearchTrace() as trace:
        planner.plan_multi(starts, goals)
    return planner, trace


@pytest.mark.parametrize("planner_id", PLANNERS)
def test_a_plan_is_the_same_with_and_without(planner_id):
    improving = planner_id in ("ARAstar", "AMRAstar")  # until their bound is proved, or their time is over
    planner, start = demo(planner_id, **({"final_weight": 5.0} if improving else {}))
    with srmp.SearchTrace() as trace:
        traced = planner.plan(ROBOT, start, GOAL)
    expansions = planner.get_planning_stats()["expansions"]
    assert traced == planner.plan(ROBOT, start, GOAL)
    assert expansions == planner.get_planning_stats()["expansions"]
    assert sum(len(lattice.expanded) for lattice in trace.lattices) > 0


def test_every_expansion_is_recorded(traced):
    planner, trace = traced
    assert sum(len(lattice.expanded) for lattice in trace.lattices) == planner.get_planning_stats()["expansions"]
    numbers = np.sort(np.concatenate([lattice.order for lattice in trace.lattices]))
    assert (numbers == np.arange(len(numbers))).all()
    assert trace.complete
    for lattice in trace.lattices:
        assert lattice.robot == ROBOT
        assert lattice.name.startswith("the lattice of ")
        assert lattice.expanded.shape == (len(lattice.to_targets), 7)
        assert (lattice.to_targets >= 0).all()


def test_edges_are_free_where_the_checker_says_so(traced):
    planner, trace = traced
    lattice = trace.lattices[0]
    assert 0 < lattice.edges_free.mean() < 1
    rows = zip(lattice.edges_from, lattice.edges_to, lattice.edges_free, strict=True)
    for a, b, free in list(rows)[:40]:
        assert planner.is_motion_free(ROBOT, a, b) == bool(free)


def test_nothing_is_recorded_outside_of_the_statement(traced):
    planner, trace = traced
    before = repr(trace)
    planner.plan(ROBOT, start_configuration(planner), GOAL)
    assert repr(trace) == before


def test_the_innermost_records():
    planner, start = demo("wAstar")
    with srmp.SearchTrace() as outer:
        with srmp.SearchTrace() as inner:
            planner.plan(ROBOT, start, GOAL)
        assert not outer.lattices
    assert inner.lattices


def test_a_full_trace_says_that_it_is_not_complete():
    planner, start = demo("wAstar")
    with srmp.SearchTrace(max_records=10) as trace:
        planner.plan(ROBOT, start, GOAL)
    assert not trace.complete
    assert sum(len(lattice.expanded) + len(lattice.edges_free) for lattice in trace.lattices) == 10


def test_a_failed_plan_is_recorded_too():
    planner, start = demo("wAstar", time_limit=0.05, resolution=2)
    with srmp.SearchTrace() as trace, pytest.raises(srmp.PlanningError):
        planner.plan(ROBOT, start, [start + 10])  # outside the limits: no search at all
    assert not trace.lattices
    with pytest.raises(srmp.InvalidArgument, match="holds no lattice"):
        trace.plot(planner)


def test_a_constraint_tree_is_recorded(tree):
    planner, trace = tree
    nodes = trace.constraint_nodes
    assert len(nodes) == planner.get_planning_stats()["tree_nodes"] > 1
    assert not trace.lattices  # of several robots, threads plan each alone, in no order
    assert [node.number for node in nodes] == list(range(len(nodes)))
    assert all(node.parent < node.number for node in nodes[1:])
    assert any(node.conflicts == 0 for node in nodes)
    root = nodes[0]
    assert sorted(root.robots) == ["left", "right"]
    assert all(q.shape == (7,) for q in root.configurations.values())
    assert root.time_s >= 0
    solved = next(node for node in nodes if not node.conflicts)
    assert (solved.robots, solved.configurations) == ([], {})


def test_a_plan_of_several_robots_is_the_same_with_and_without():
    planner, starts, goals = swap("xECBS")
    with srmp.SearchTrace():
        traced = planner.plan_multi(starts, goals)
    assert traced == planner.plan_multi(starts, goals)


# --- figures ----------------------------------------------------------------------------------------------------------


def test_a_search_is_drawn(traced, tmp_path):
    planner, trace = traced
    figure = trace.plot(planner, tmp_path / "search.png")
    assert figure is not None
    assert (tmp_path / "search.png").stat().st_size > 10_000
    assert "states expanded in" in sentence(trace)
    trace.to_html(planner, tmp_path / "search.html")
    assert "states expanded" not in (tmp_path / "search.html").read_text()  # packed with the rest
    assert trace.to_html(planner).startswith("<!DOCTYPE html>")


def test_a_constraint_tree_is_drawn(tree, tmp_path):
    _, trace = tree
    figure = trace.plot_constraints(tmp_path / "tree.svg")
    assert "constraint tree: " in figure.axes[0].get_title()
    assert "left – right" in (tmp_path / "tree.svg").read_text() or len(trace.constraint_nodes) > 40
    places = node_places(trace.constraint_nodes)
    assert places[0][1] == 0
    assert len(set(places.values())) == len(places)


def test_a_page_has_the_constraint_tree_and_its_conflicts(tree):
    planner, trace = tree
    svg = drawn_tree(trace.constraint_nodes)
    assert svg.count("<circle") == min(len(trace.constraint_nodes), 400)
    assert "left – right, " in svg and "no conflict" in svg
    drawing = drawing_of(trace, planner)
    assert [title.split(":")[0] for title, _ in drawing.panels] == [
        "certificate of 'left'",
        "certificate of 'right'",
        "constraint tree",
    ]
    (conflicts,) = drawing.segments
    assert conflicts.name == "conflicts" and conflicts.points.shape[1:] == (2, 3)
    assert (np.abs(conflicts.points - [0.4, 0, 0.2]) < 0.6).all()  # between the arms
    assert "nodes of 1 constraint tree" in sentence(trace)
    assert trace.to_html(planner).startswith("<!DOCTYPE html>")


def test_wrong_calls_are_refused(traced):
    _, trace = traced
    with pytest.raises(srmp.InvalidArgument, match="max_records is 0; it must be at least 1"):
        srmp.SearchTrace(max_records=0)
    with pytest.raises(srmp.InvalidArgument, match="has recorded before"), trace:
        pass
    with srmp.SearchTrace() as own, pytest.raises(srmp.InvalidArgument, match="recording already"):
        own.__enter__()
    with pytest.raises(srmp.InvalidArgument, match="planner must be a PlannerInterface"):
        trace.plot("planner")
    with pytest.raises(srmp.InvalidArgument, match="no constraint tree"):
        trace.plot_constraints()
    with pytest.raises(srmp.Error, match="arm7"):
        trace.plot(srmp.PlannerInterface())
