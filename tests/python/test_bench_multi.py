"""Scenarios of several robots, the runner's rows and table, and the re-check of its results."""

import itertools
import json
import math
import os

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp._files import plain
from srmp.bench import multi, scenarios, scenes
from srmp.bench.repeated import variation
from srmp.cli import main

SMALL = {"ring": 3, "binpick": 4, "shelves": 3, "grid": 5, "mixed": 2}
APART = {
    "name": "apart",
    "bases": [{"position": [0, 0.6, 0.1], "yaw": 0.0}, {"position": [0, -0.6, 0.1], "yaw": 0.5}],
    "boxes": [{"name": "table", "size": [2, 3, 0.1], "position": [0, 0, 0.05]}],
    "attached_cylinders": [
        {
            "robot": 1,
            "radius": 0.01,
            "length": 0.3,
            "link": "panda_hand",
            "position": [0, 0, 0.11],
            "axis": "y of the link",
            "may_touch": ["panda_leftfinger", "panda_rightfinger"],
        }
    ],
    "states": {
        "ready": [[0, -0.785, 0, -2.356, 0, 1.571, 0.785], [0, -0.785, 0, -2.356, 0, 1.571, 0.785]],
        "left": [[0.4, -0.785, 0, -2.356, 0, 1.571, 0.785], [0.4, -0.785, 0, -2.356, 0, 1.571, 0.785]],
        "low": [[0, -0.485, 0, -2.356, 0, 1.871, 0.785], [0.2, -0.785, 0, -2.156, 0, 1.571, 0.785]],
    },
}


@pytest.fixture(scope="session")
def data():
    """Where Pandas come from: MotionBenchMaker's directory, or None, which means example-robot-data."""
    if directory := os.environ.get("SRMP_MBM_DIR", ""):
        return directory
    if scenes.example_robot_data() is None:
        pytest.skip("set SRMP_MBM_DIR or pip install example-robot-data to run this test")
    return None


@pytest.fixture
def write(tmp_path):
    def write(content):
        path = tmp_path / "scenario.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return str(path)

    return write


def free_together(planner, configurations):
    for name, q in configurations.items():
        planner.set_qpos(name, q)
    return not any(planner.is_state_colliding(name, q) for name, q in configurations.items())


def same(a, b):
    pairs = [(x[name], y[name]) for x, y in ((a.starts, b.starts), (a.goals, b.goals)) for name in x]
    return a.starts.keys() == b.starts.keys() and all(np.array_equal(x, y) for x, y in pairs)


# --- generators -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SMALL)
def test_generated_problems_are_free_at_both_ends(name, data):
    scenario = scenarios.find(name, SMALL[name], data=data)
    planner = scenario.world.build()
    for number in (1, 2, 6):
        problem = scenario.problem(number)
        assert len(problem.starts) == len(problem.goals) == SMALL[name]
        assert free_together(planner, problem.starts)
        assert free_together(planner, problem.goals)


@pytest.mark.parametrize("name", SMALL)
def test_a_problem_is_the_same_whatever_was_asked_for_before(name, data):
    one, other = (scenarios.find(name, SMALL[name], seed=3, data=data) for _ in range(2))
    in_order = [one.problem(number) for number in range(1, 8)]
    assert same(other.problem(7), in_order[6])
    assert same(other.problem(2), in_order[1])
    assert not any(same(a, b) for a, b in itertools.pairwise(in_order))
    assert not same(scenarios.find(name, SMALL[name], seed=4, data=data).problem(7), in_order[6])


@pytest.mark.parametrize("name", ["binpick", "shelves"])
def test_repetitions_move_one_joint_of_each_goal_by_two_degrees_at_most(name, data):
    scenario = scenarios.find(name, data=data)
    assert scenario.numbers == range(1, 76)
    first = scenario.problem(6)
    assert first.about == {"base": 1, "repetition": 0}
    for repetition in range(1, 5):
        moved = scenario.problem(6 + repetition)
        assert moved.about == {"base": 1, "repetition": repetition}
        for robot, q in moved.goals.items():
            assert np.array_equal(moved.starts[robot], first.starts[robot])
            difference = np.abs(q - first.goals[robot])
            assert np.count_nonzero(difference) == 1
            assert difference.max() <= np.deg2rad(2) + 1e-12
    assert not np.array_equal(scenario.problem(11).starts["panda_0"], first.starts["panda_0"])


@pytest.mark.parametrize("robots", [8, 16, 32])
def test_grids_of_many_arms(robots, data):
    assert len(scenarios.find("grid", robots, data=data).problem(1).goals) == robots


def test_neighbours_of_a_grid_reach_each_other(data):
    """Hands come nearer to the next base than to their own."""
    scenario = scenarios.find("grid", 4, data=data)
    bases = {robot.name: np.array(robot.position[:2]) for robot in scenario.world.robots}
    planner = scenario.world.build()
    hands = [
        (name, planner.compute_fk(name, q).p[:2])
        for number in range(1, 13)
        for name, q in scenario.problem(number).goals.items()
    ]
    others = [min(math.dist(hand, base) for other, base in bases.items() if other != name) for name, hand in hands]
    assert any(other < math.dist(hand, bases[name]) for other, (name, hand) in zip(others, hands, strict=True))


def test_mixed_robots_differ(data):
    models = scenarios.find("mixed", 4, data=data).world.models
    assert len(models) == (len(scenes.MODELS) if data is None else 2)


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_file_is_read(write, data):
    scenario = scenarios.find(write(APART), data=data)
    assert scenario.name == "apart"
    assert scenario.numbers == range(1, 7)
    pairs = [tuple(scenario.problem(number).about.values()) for number in scenario.numbers]
    assert pairs == [(a, b) for a in APART["states"] for b in APART["states"] if a != b]
    assert np.array_equal(scenario.problem(2).goals["panda_1"], APART["states"]["low"][1])
    planner = scenario.world.build()
    assert planner.object_names == ["held_0", "table"]
    assert free_together(planner, scenario.problem(1).starts)
    hand, rod = planner.compute_fk("panda_1", planner.get_qpos("panda_1")), planner.get_object_pose("held_0")
    np.testing.assert_allclose((hand.inverse() @ rod).p, [0, 0, 0.11], atol=1e-9)
    np.testing.assert_allclose((hand.inverse() @ rod).matrix()[:3, 2], [0, 1, 0], atol=1e-9)


def changed(change):
    content = json.loads(json.dumps(APART))
    change(content)
    return content


BROKEN = {
    "no JSON": ("{", "cannot be read"),
    "no object": ([1], "not a JSON object"),
    "no bases": (changed(lambda c: c.pop("bases")), "there is no 'bases'"),
    "a robot too few": (
        changed(lambda c: c["states"]["left"].pop()),
        "state 'left' has 1 configurations for 2 robots",
    ),
    "a joint too few": (changed(lambda c: c["states"]["low"][1].pop()), "state 'low' must be 7 numbers"),
    "NaN": (changed(lambda c: c["bases"][0].update(position=[0, math.nan, 0])), "bases.0..position must be 3 numbers"),
    "text": (changed(lambda c: c["boxes"][0].update(size="big")), "could not convert"),
    "no such robot": (changed(lambda c: c["attached_cylinders"][0].update(robot=2)), "there are robots 0 to 1"),
    "no such axis": (changed(lambda c: c["attached_cylinders"][0].update(axis="w")), "not x, y or z"),
}


@pytest.mark.parametrize(("content", "message"), BROKEN.values(), ids=BROKEN)
def test_broken_files_are_refused(content, message, write, data):
    with pytest.raises(srmp.FileError, match=message):
        scenarios.find(write(content), data=data)


def test_invalid_requests_are_refused(write, data, monkeypatch):
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'binpick'"):
        scenarios.find("binpik", data=data)
    with pytest.raises(srmp.InvalidArgument, match="robots 129: 'grid' takes 2 to 128"):
        scenarios.find("grid", 129, data=data)
    with pytest.raises(srmp.InvalidArgument, match="robots 5: 'binpick' takes 1 to 4"):
        scenarios.find("binpick", 5, data=data)
    with pytest.raises(srmp.InvalidArgument, match=r"robots 3: .* has 2"):
        scenarios.find(write(APART), 3, data=data)
    with pytest.raises(srmp.InvalidArgument, match="seed -1"):
        scenarios.find("grid", seed=-1, data=data)
    with pytest.raises(srmp.InvalidArgument, match="numbered from 1"):
        multi.run("grid", 2, problems="0-3", planner_id="xECBS", data=data)
    with pytest.raises(srmp.InvalidArgument, match="'apart' has 1 to 6"):
        multi.run(write(APART), problems="7-9", planner_id="xECBS", data=data)
    monkeypatch.setattr(scenes, "example_robot_data", lambda: None)
    with pytest.raises(srmp.FileError, match="pip install example-robot-data"):
        scenarios.find("grid")
    with pytest.raises(srmp.InvalidArgument, match="geometry 'spheres': only MotionBenchMaker's robots have it"):
        scenarios.find("grid", geometry="spheres")


def test_robots_of_spheres(mbm_dir):
    result = multi.run("grid", 2, problems="1", planner_id="auto", data=str(mbm_dir), geometry="spheres")
    assert [row["status"] for row in result["rows"]] == ["solved"]
    assert result["rows"][0]["found_by"]
    assert result["rows"][0]["independence_detection"] is True
    assert result["header"]["options"]["geometry"] == "spheres"
    assert result["header"]["scenario"]["robots"]["panda_0"]["urdf"].name == "panda_spherized.urdf"
    with pytest.raises(srmp.InvalidArgument, match="neither 'urdf' nor 'spheres'"):
        multi.run("grid", 2, data=str(mbm_dir), geometry="balls")


def test_the_command_line_refuses_too(tmp_path):
    outcome = CliRunner().invoke(main, ["bench", "multi", "--scenario", "rng"])
    assert outcome.exit_code == 2
    assert "did you mean 'ring'?" in outcome.output
    outcome = CliRunner().invoke(main, ["bench", "multi", "--scenario", "ring", "--out", str(tmp_path / "no" / "x")])
    assert outcome.exit_code == 2
    assert "does not exist" in outcome.output


# --- table ------------------------------------------------------------------------------------------------------------


def row(number, status, length=None, **more):
    solved = status == "solved"
    return {
        "problem": f"binpick/{number:04d}",
        "status": status,
        "base": (number - 1) // 5,
        "plan_time_s": 0.1 * number,
        "total_time_s": 0.2 * number,
        "path_cost_rad": 8.0,
        "ee_cost_m": length,
        "tree_nodes": 3,
        "makespan_s": 2.5,
        "certificate": {"holds": True, "proved_free": True, "clearance": 0.004 * number} if solved else None,
        **more,
    }


ROWS = [row(1, "solved", 1.0), row(2, "solved", 1.2), row(3, "goal_invalid"), row(6, "timed_out"), row(7, "solved", 9)]


def test_table():
    head, _, line, last = multi.format_statistics(ROWS).splitlines()
    assert head.split()[:2] == ["scenario", "solved/valid/total"]
    assert line.split()[:2] == ["binpick", "3/4/5"]
    assert line.split()[-6:] == ["3", "3", "2.50", "s", "4", "mm"]
    assert "varies by 12.9%" in last
    assert "–" in multi.format_statistics([row(1, "timed_out")])


def test_variation_is_over_repetitions_that_were_solved():
    assert variation(ROWS) == pytest.approx(np.std([1.0, 1.2], ddof=1) / 1.1)
    assert math.isnan(variation(ROWS[1:]))


# --- re-check ---------------------------------------------------------------------------------------------------------


def straight(starts, goals, world):
    """A result file in which all robots go straight to their goals within 2 s."""
    robots = {
        name: {
            "joint_names": [f"panda_joint{k}" for k in range(1, 8)],
            "start": list(q),
            "goal": list(goals[name]),
            "times": [0.0, 2.0],
            "positions": [list(q), list(goals[name])],
            "velocities": [[0.0] * 7] * 2,
        }
        for name, q in starts.items()
    }
    rows = [{"problem": "made/0001", "status": "solved", "robots": robots}]
    return json.loads(json.dumps(plain({"header": {"scenario": world.to_dict(world.build())}, "rows": rows})))


@pytest.fixture(scope="module")
def recheck(suite):
    return suite("recheck_multi")


@pytest.fixture
def motions(write, data):
    """Results of robots 0.5 m apart that go straight from "ready", `moved` by the joints named."""
    near = changed(
        lambda c: [base.update(position=[0, 0.25 - 0.5 * k, 0.1], yaw=0) for k, base in enumerate(c["bases"])]
    )
    scenario = scenarios.find(write(near), data=data)
    starts = scenario.problem(1).starts

    def make(**moved):
        goals = {name: q.copy() for name, q in starts.items()}
        for name, changes in moved.items():
            for joint, value in changes.items():
                goals[name][joint] = value
        return straight(starts, goals, scenario.world)

    return make


def test_the_recheck_finds_nothing_wrong(recheck, motions):
    outcome = recheck.recheck(motions(panda_0={0: 0.3}, panda_1={0: -0.3}))
    assert outcome == {"checked": 1, "rate_hz": 1000.0, "faults": []}


@pytest.mark.parametrize(
    ("moved", "bodies"),
    [
        ({"panda_0": {0: -1.2}, "panda_1": {0: 1.2}}, ["panda_0/", "panda_1/"]),
        ({"panda_0": {1: 0.9}}, ["panda_0/", "table"]),
        ({"panda_1": {1: 0.5, 6: 2.3}}, ["held_0", "table"]),
        ({"panda_0": {1: -0.4, 3: -2.9, 5: 0.9}}, ["panda_0/", "panda_0/"]),
    ],
    ids=["robot and robot", "robot and box", "held and box", "robot and itself"],
)
def test_the_recheck_finds_what_touches(recheck, motions, moved, bodies):
    (fault,) = recheck.recheck(motions(**moved))["faults"]
    pair = fault.removeprefix("made/0001: ").partition(" touch at ")[0].split(" and ")
    assert all(body in name for body, name in zip(sorted(bodies), sorted(pair), strict=True)), fault


def test_links_side_by_side_may_touch_where_no_srdf_says_so(recheck, motions):
    """As in srmp: one moving joint between them."""
    results = motions()
    for robot in results["header"]["scenario"]["robots"].values():
        robot["srdf"] = None
    world = recheck.World(results["header"]["scenario"])
    chosen = {
        frozenset(world.body(world.geometry.geometryObjects[i]) for i in (pair.first, pair.second))
        for pair in world.geometry.collisionPairs
    }
    assert frozenset(("panda_0/panda_link1", "panda_0/panda_link2")) not in chosen
    assert frozenset(("panda_0/panda_link1", "panda_0/panda_link3")) in chosen
    results["header"]["scenario"]["robots"]["panda_0"]["allowed"] = [["panda_link1", "panda_link3"]]
    less = recheck.World(results["header"]["scenario"])
    assert len(less.geometry.collisionPairs) == len(world.geometry.collisionPairs) - 1


def test_the_recheck_is_about_start_and_goal_too(recheck, motions):
    results = motions(panda_0={0: 0.3})
    results["rows"][0]["robots"]["panda_0"]["goal"][0] += 1e-3
    (fault,) = recheck.recheck(results, rate=50)["faults"]
    assert fault == "made/0001: panda_0 misses its goal by 0.001"


def test_a_robot_rests_when_its_own_times_are_over(recheck, motions):
    """The second arm swings through where the first is long since standing."""
    results = motions(panda_0={0: -0.6}, panda_1={0: 1.2})
    robot = results["rows"][0]["robots"]["panda_0"]
    robot["times"] = [0.0, 0.2]
    (fault,) = recheck.recheck(results, rate=200)["faults"]
    assert float(fault.split()[-2]) > 0.2


def test_the_recheck_agrees_with_every_pair_asked_for(recheck, motions):
    """Its tree of boxes leaves none out."""
    import pinocchio as pin

    results = motions()
    world = recheck.World(results["header"]["scenario"])
    random = np.random.default_rng(0)
    answers = set()
    for _ in range(200):
        q = world.default_q.copy()
        for name, robot in results["rows"][0]["robots"].items():
            for joint, value in zip(robot["joint_names"], robot["start"], strict=True):
                world.set_joint(q, f"{name}/{joint}", value + random.uniform(-0.4, 0.4))
        every = pin.computeCollisions(world.model, world.data, world.geometry, world.geometry_data, q, False)
        assert bool(world.touching(q)) == every
        answers.add(every)
    assert answers == {True, False}


# --- all of it --------------------------------------------------------------------------------------------------------


def test_a_scenario_from_file_to_re_check(recheck, write, data, tmp_path):
    """Of the first problem the start is invalid: a named state in which the arms touch."""
    content = changed(
        lambda c: c.update(states={"crossed": [[-1.2, *APART["states"]["ready"][0][1:]]] * 2, **c["states"]})
    )
    content["bases"] = [{"position": [0, 0.25, 0.1], "yaw": 0}, {"position": [0, -0.25, 0.1], "yaw": 0}]
    content["states"]["crossed"][1] = [1.2, *APART["states"]["ready"][0][1:]]
    out = tmp_path / "results.json"
    arguments = ["bench", "multi", "--scenario", write(content), "--planner", "xECBS", "--problems", "1,5"]
    arguments += ["--out", str(out), *(["--data", data] if data else [])]
    outcome = CliRunner().invoke(main, arguments)
    assert outcome.exit_code == 0, outcome.output
    assert "apart" in outcome.output
    assert "1/1/2" in outcome.output
    assert "apart/0001 is not a valid problem: " in outcome.output
    results = json.loads(out.read_text())
    assert results["header"]["complete"]
    invalid, solved = results["rows"]
    assert (invalid["status"], invalid["from"], invalid["to"]) == ("start_invalid", "crossed", "ready")
    assert invalid["robots"]["panda_0"]["path"] is None
    assert (solved["status"], solved["from"], solved["to"]) == ("solved", "ready", "left")
    assert solved["certificate"]["holds"]
    assert solved["certificate"]["clearance"] > 0
    assert isinstance(solved["tree_nodes"], int)  # 0 where the robots do not conflict
    assert solved["bound"] >= 1
    robots = solved["robots"].values()
    assert solved["path_cost_rad"] == pytest.approx(sum(robot["path_cost_rad"] for robot in robots))
    assert solved["ee_cost_m"] == pytest.approx(sum(robot["ee_cost_m"] for robot in robots))
    assert solved["makespan_s"] == pytest.approx(max(robot["times"][-1] for robot in robots))
    for robot in robots:
        assert robot["path"][0] == robot["start"]
        assert len(robot["times"]) == len(robot["positions"]) == len(robot["velocities"])
    assert recheck.recheck(results) == {"checked": 1, "rate_hz": 1000.0, "faults": []}
