"""The paper's experiments at a tiny size: rows, re-check, tables, statements, figures and page."""

import itertools
import json
import re
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp.bench import ompl_wheel
from srmp.bench.paper import contestants, page, run, solve, statements, tables
from srmp.bench.runner import Execution
from srmp.cli import main

needs_ompl = pytest.mark.skipif(
    contestants.ompl_module() is None, reason="OMPL's planners were not built (libompl-dev, -DSRMP_BUILD_BENCH=ON)"
)
PLANNERS = ("wA*", "xECBS", "auto", "RRT-Connect")


@pytest.fixture(scope="module")
def small(stand_in_dir, tmp_path_factory):
    """The directory that a tiny run wrote, and what it said."""
    out = tmp_path_factory.mktemp("experiments")
    arguments = ["--problems", "1", "--repetitions", "2", "--time-limit", "1", "--data", str(stand_in_dir)]
    arguments += [argument for name in PLANNERS for argument in ("--planner", name)]
    outcome = CliRunner().invoke(main, ["bench", "paper", *arguments, "--out", str(out)])
    assert outcome.exit_code == 0, outcome.output
    return out, outcome.output


@pytest.fixture(scope="module")
def results(small):
    return json.loads((small[0] / "experiments.json").read_text())


# --- the command ------------------------------------------------------------------------------------------------------


def test_every_experiment_has_rows_that_were_checked(results):
    rows = results["rows"]
    assert {row["experiment"] for row in rows} == {"a", "b", "c"}
    assert {row["scenario"] for row in rows} == {"binpick", "shelves", "panda"}
    own = [row for row in rows if row["library"] == "SRMP"]
    assert {row["planner"] for row in own} == {"wA*", "xECBS", "auto"}
    assert [row["problem"] for row in own if row["fault"]] == []
    solved = [row for row in rows if row["status"] == "solved"]
    assert len(solved) > 0.7 * len(rows)
    assert all(row["ee_cost_m"] > 0 and row["path_cost_rad"] > 0 for row in solved)
    assert all(row["found_by"] for row in solved if row["library"] == "SRMP")
    assert all(row["found_by"].startswith("the lattice of") for row in solved if row["planner"] == "wA*")
    assert results["header"]["complete"]
    assert results["seconds"].keys() == {"a", "b", "c"}


def test_the_page_has_tables_statements_figures_and_how_long_it_took(small, results):
    out, said = small
    text = (out / "experiments.md").read_text()
    for letter in "abc":
        assert f"## ({letter}) " in text
        assert f"](experiments-{letter}.svg)" in text
        for suffix in ("svg", "png"):
            assert (out / f"experiments-{letter}.{suffix}").stat().st_size > 5000
    assert "This is a smaller run than the paper's" in text
    assert re.search(r"Setting up, planning and checking took \(a\) \d+ s", text)
    findings = {statement["finding"] for statement in results["statements"]}
    assert findings <= {"reproduced", "exceeded", "not", "not measured"}
    assert len(results["statements"]) == text.count("** |")
    assert f"wrote {out / 'experiments.md'}" in said
    assert "MotionBenchMaker's problems for ur5, fetch were not run" in said


@needs_ompl
def test_ompls_planners_have_their_columns(small, results):
    text = (small[0] / "experiments.md").read_text()
    assert "| RRT-Connect | OMPL |" in text
    assert "| RRT-Connect | OMPL, plain Coal |" in text
    assert [row["problem"] for row in results["rows"] if row["library"] == "OMPL" and row["fault"]] == []


def small_run(**settings):
    return run.run(**{"experiments": "a", "problems": "1", "repetitions": 1, "time_limit": 0.5, **settings})


def test_two_workers_give_the_same_rows(stand_in_dir):
    runs = [small_run(data=stand_in_dir, planners=["wA*"], execution=Execution(workers)) for workers in (1, 2)]
    rows = [[{k: v for k, v in row.items() if not k.endswith("_time_s")} for row in run["rows"]] for run in runs]
    assert rows[0] == rows[1]
    assert [row["status"] for row in rows[0]] == ["solved"] * 2


def test_without_ompl_one_sentence_says_so(monkeypatch, stand_in_dir, tmp_path):
    for module in (contestants, run):
        monkeypatch.setattr(module, "ompl_module", lambda: None)
    result = small_run(data=stand_in_dir, planners=["MHAstar", "PRM", "STOMP"])
    (note,) = result["header"]["notes"]
    assert "OMPL's planners were not run: install libompl-dev" in note
    page.write(result, tmp_path)
    text = (tmp_path / "experiments.md").read_text()
    assert note in text
    assert "| `MHA*` | SRMP | 1/1 |" in text
    assert "| PRM | OMPL | no OMPL |" in text
    assert "only the planners MHAstar, PRM, STOMP" in text
    assert "| STOMP | MoveIt | not run |" in text
    assert "**not measured**" in text


def test_without_matplotlib_one_sentence_says_so(monkeypatch, results, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    said = page.write(results, tmp_path)
    assert said[0] == page.NO_FIGURES
    assert sorted(file.name for file in tmp_path.iterdir()) == ["experiments.json", "experiments.md"]
    assert "![" not in (tmp_path / "experiments.md").read_text()


def test_the_page_can_be_written_again(small, tmp_path):
    arguments = ["bench", "paper", "--out", str(tmp_path), "--table"]
    assert CliRunner().invoke(main, [*arguments, str(small[0] / "experiments.json")]).exit_code == 0
    for name in ("experiments.md", "experiments.json", "experiments-a.svg"):
        assert (tmp_path / name).read_bytes() == (small[0] / name).read_bytes()
    (tmp_path / "other.json").write_text('{"header": {"benchmark": "MotionBenchMaker"}, "rows": []}')
    refused = CliRunner().invoke(main, [*arguments, str(tmp_path / "other.json")])
    assert refused.exit_code == 2
    assert "holds no results of `srmp bench paper`" in refused.output


def test_without_data_the_third_is_not_run():
    result = run.run(experiments="c")
    assert result["rows"] == []
    assert "--data DIR" in result["header"]["notes"][-1]


def test_sizes_can_be_given_for_one_experiment(stand_in_dir):
    sizes = {"problems": ["1", "b=2"], "time_limit": ["a=0.5", "2"]}
    header = small_run(experiments="a,b", planners=["auto"], data=stand_in_dir, **sizes)["header"]
    assert header["options"]["problems"] == {"a": "1", "b": "2"}
    assert header["options"]["time_limit"] == {"a": 0.5, "b": 2.0}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"experiments": "a,d"}, "experiment 'd' is not one of a, b, c"),
        ({"planners": ["RRT-Conect"]}, "did you mean 'RRT-Connect'"),
        ({"repetitions": 0}, "repetitions 0"),
        ({"problems": "0-1"}, "numbered from 1"),
        ({"problems": "x=1"}, "'x' is not one of a"),
        ({"time_limit": "soon"}, "time-limit 'soon' must be seconds above 0"),
        ({"time_limit": ["a=0"]}, "time-limit '0' must be"),
    ],
)
def test_wrong_choices_are_refused(settings, message):
    with pytest.raises(srmp.InvalidArgument, match=re.escape(message)):
        small_run(**settings)


# --- OMPL -------------------------------------------------------------------------------------------------------------


@needs_ompl
@pytest.mark.parametrize("checker", ["srmp", "coal"])
def test_the_same_seed_gives_the_same_path(arm, ready, checker, capfd):
    from srmp import _srmp_ompl

    goal = ready - np.array([1.8, 0, 0, 0, 0, 0, 0])
    plan = [_srmp_ompl.plan(arm, ["arm"], ready, goal, "RRT-Connect", 5.0, seed, checker) for seed in (1, 1, 2)]
    assert [answer["status"] for answer in plan] == ["solved"] * 3
    assert plan[0]["waypoints"] == plan[1]["waypoints"] != plan[2]["waypoints"]
    np.testing.assert_allclose(plan[0]["waypoints"][0], ready)
    np.testing.assert_allclose(plan[0]["waypoints"][-1], goal)
    assert capfd.readouterr() == ("", "")  # OMPL says nothing


@needs_ompl
def test_ompl_refuses_what_it_does_not_know(arm, ready):
    from srmp import _srmp_ompl

    with pytest.raises(ValueError, match="'RRT' is not a planner of this OMPL"):
        _srmp_ompl.plan(arm, ["arm"], ready, ready, "RRT", 1.0, 1)
    with pytest.raises(ValueError, match="neither srmp nor coal"):
        _srmp_ompl.plan(arm, ["arm"], ready, ready, "PRM", 1.0, 1, "fcl")
    beyond = ready + np.array([100, 0, 0, 0, 0, 0, 0])
    assert _srmp_ompl.plan(arm, ["arm"], ready, beyond, "PRM", 0.2, 1)["status"] in ("goal_invalid", "timed_out")
    assert _srmp_ompl.plan(arm, ["arm"], beyond, ready, "PRM", 0.2, 1)["status"] == "start_invalid"


@needs_ompl
@pytest.mark.parametrize("sampled", [False, True])
def test_ompl_keeps_a_cone(arm, ready, sampled):
    from srmp import _srmp_ompl

    def angle(q):
        return np.arccos(min(1.0, arm.compute_fk("arm", q).matrix()[:3, 2] @ axis))

    goal = ready - np.array([1.8, 0, 0, 0, 0, 0, 0])
    axis = arm.compute_fk("arm", ready).matrix()[:3, 2]
    cone = srmp.PathConstraint.cone([0, 0, 1], axis, np.radians(5))
    plan = [
        _srmp_ompl.plan(arm, ["arm"], ready, goal, "RRT-Connect", 10.0, 1, cone=cone, sampled=sampled) for _ in range(2)
    ]
    assert plan[0]["status"] == "solved" and plan[0]["waypoints"] == plan[1]["waypoints"]
    path = np.array(plan[0]["waypoints"])
    np.testing.assert_allclose(path[[0, -1]], [ready, goal], atol=1e-12)
    between = [a + (b - a) * t for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 11)]
    assert max(map(angle, between)) <= np.radians(5)
    assert sampled or arm.collision_checker("arm").motions_free(path[:-1], path[1:]).all()


@needs_ompl
def test_ompl_refuses_other_constraints(arm, ready):
    from srmp import _srmp_ompl

    plane = srmp.PathConstraint.plane([0, 0, 0], [0, 0, 1], 0.1)
    with pytest.raises(ValueError, match="only a cone"):
        _srmp_ompl.plan(arm, ["arm"], ready, ready, "RRT-Connect", 1.0, 1, cone=plane)
    cone = srmp.PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1)
    with pytest.raises(ValueError, match="a cone is for one robot"):
        _srmp_ompl.plan(arm, ["arm", "arm"], ready, ready, "RRT-Connect", 1.0, 1, cone=cone)


@pytest.mark.skipif(ompl_wheel.module() is None, reason="the ompl wheel is not installed (pip install ompl)")
@pytest.mark.parametrize("name", ompl_wheel.PLANNERS)
def test_planners_of_the_wheel_use_our_checker(arm, ready, name):
    goal = ready - np.array([1.8, 0, 0, 0, 0, 0, 0])
    found = ompl_wheel.plan(arm, "arm", ready, goal, name, 1.0)
    assert found["status"] == "solved"
    path = found["waypoints"]
    np.testing.assert_allclose(path[[0, -1]], [ready, goal])
    assert arm.collision_checker("arm").motions_free(path[:-1], path[1:]).all()


def test_aorrtc_is_the_wheels_where_the_module_has_none(monkeypatch):
    single = {(c.name, c.library): c for c in contestants.EXPERIMENTS["a"].contestants}
    aorrtc = single["AORRTC", contestants.OMPL]
    monkeypatch.setattr(contestants, "ompl_module", lambda: None)
    monkeypatch.setattr(ompl_wheel, "has", lambda name: True)
    assert contestants.why_not_run(aorrtc) == ""
    assert contestants.why_not_run(single["RRT-Connect", contestants.OMPL]) == "no OMPL"
    assert contestants.why_not_run(single["AORRTC", contestants.COAL]) == "no OMPL"
    monkeypatch.setattr(ompl_wheel, "has", lambda name: False)
    assert contestants.why_not_run(aorrtc) == "no OMPL"


# --- re-check ---------------------------------------------------------------------------------------------------------


def fault(arm, path, start=None, goal=None):
    start, goal = (path[0] if start is None else start), (path[-1] if goal is None else goal)
    query = solve.Query(arm, {"arm": start}, {"arm": goal})
    return solve.fault_of(query, solve.Found("solved", "", 0.0, {"arm": np.array(path)}))


def test_the_recheck_finds_faults(arm, ready):
    aside = ready + np.array([0.3, 0, 0, 0, 0, 0, 0])
    assert fault(arm, [ready, aside]) is None
    assert "from the start to the goal" in fault(arm, [ready, aside], goal=ready)
    assert "from the start to the goal" in fault(arm, [ready, aside], start=aside)
    through = ready - np.array([1.8, 0, 0, 0, 0, 0, 0])  # on the other side of the post
    assert re.fullmatch(r"arm, segment 2 of 2: .* and post collide", fault(arm, [aside, ready, through]))
    assert "joint limits" in fault(arm, [ready, ready + 10, aside])


def test_the_recheck_finds_robots_that_collide():
    planner = srmp.PlannerInterface()
    for name, y in (("left", 0.3), ("right", -0.3)):
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_path=srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=srmp.Pose(p=[0, y, 0]),
        )
    ready = np.array(planner.get_group_states("left")["ready"])
    turn = np.array([1.5, 0, 0, 0, 0, 0, 0])

    def of(left, right):
        paths = {"left": np.array([ready, ready + left]), "right": np.array([ready, ready + right])}
        query = solve.Query(planner, {n: p[0] for n, p in paths.items()}, {n: p[-1] for n, p in paths.items()})
        assert query.names == ["left", "right"]
        assert query.parted(np.hstack([paths["left"], paths["right"]]))["right"].tolist() == paths["right"].tolist()
        return solve.fault_of(query, solve.Found("solved", "", 0.0, paths))

    assert of(turn, -turn) is None
    assert "collide" in of(-turn, turn)


# --- tables and statements --------------------------------------------------------------------------------------------


def row(planner, library, instance, length=1.0, time=0.1, status="solved", fault=None, experiment="a"):
    solved = status == "solved"
    return {
        "experiment": experiment,
        "scenario": "binpick",
        "instance": f"a/binpick/{instance}",
        "base": instance // 2,
        "planner": planner,
        "library": library,
        "status": status,
        "fault": fault,
        "plan_time_s": time,
        "ee_cost_m": length if solved else None,
    }


def result_of(rows, letter="a"):
    options = {"experiments": [letter], "planners": [], "time_limit": {letter: 5.0}}
    return {"header": {"options": options}, "rows": rows}


def entry_of(rows, planner, library):
    (entry,) = [e for e in tables.tables(result_of(rows)) if (e.planner, e.library) == (planner, library)]
    return entry


ROWS = [
    *(row("wA*", "SRMP", k, length, 0.01) for k, length in enumerate((1.0, 1.1, 2.0, 2.0))),
    *(row("RRT-Connect", "OMPL", k, length, 0.02) for k, length in enumerate((2.0, 3.0, 2.0))),
    row("RRT-Connect", "OMPL", 3, status="timed_out"),
    row("BiEST", "OMPL", 0, fault="panda_0, segment 1 of 1: a and b collide"),
]


def test_tables_count_faulty_paths_as_failures():
    ours, theirs, faulty = (entry_of(ROWS, *of) for of in (("wA*", "SRMP"), ("RRT-Connect", "OMPL"), ("BiEST", "OMPL")))
    assert (ours.solved, ours.valid, ours.success) == (4, 4, 1.0)
    assert ours.variation == pytest.approx(np.std([1, 1.1], ddof=1) / 1.05 / 2)
    assert ours.length_ratio == ours.time_ratio == 1.0
    assert (theirs.solved, theirs.valid) == (3, 4)
    assert theirs.length_ratio == pytest.approx(np.mean([2, 3 / 1.1, 1]))
    assert theirs.time_ratio == pytest.approx(2)
    assert (faulty.solved, faulty.valid, faulty.faults) == (0, 1, 1)
    assert "| BiEST | OMPL | 0/1, 1 faulty |" in tables.markdown([faulty])


def test_invalid_problems_count_for_nobody():
    rows = [row("wA*", "SRMP", 0, status="start_invalid"), row("RRT-Connect", "OMPL", 0, status="timed_out")]
    assert entry_of(rows, "RRT-Connect", "OMPL").valid == 0


def findings(rows, letter="a"):
    return [statement.finding for statement in statements.statements(result_of(rows, letter))]


def test_statements_have_verdicts():
    assert findings(ROWS) == ["exceeded", "exceeded", "exceeded", "not measured", "not measured"]
    swapped = {"SRMP": ("RRT-Connect", "OMPL"), "OMPL": ("wA*", "SRMP")}
    worse = [{**r, **dict(zip(("planner", "library"), swapped[r["library"]], strict=True))} for r in ROWS[:8]]
    assert findings(worse)[:3] == ["not", "not", "reproduced"]
    anytime = [row("ARA*", "SRMP", 0, time=1.0), row("RRT*", "OMPL", 0, time=5.0)]
    assert findings(anytime)[3:] == ["exceeded", "reproduced"]
    late = [{**r, "plan_time_s": 6.0 - r["plan_time_s"]} for r in anytime]
    assert findings(late)[3:] == ["not", "not"]


def test_times_of_the_paper_are_compared():
    rows = [row("xECBS", "SRMP", 0, time=1.6, experiment="b")]
    found = statements.statements(result_of(rows, "b"))
    (binpick,) = [s for s in found if "in binpick" in s.paper and "on average" in s.paper]
    assert binpick.finding == "reproduced"
