"""Programs of bench/suites in their smallest form: they run, and refuse what is wrong."""

import json
import sys

import numpy as np
import pytest

import srmp
from srmp.bench.paper.contestants import NO_OMPL, ompl_module


def test_growth(suite, tmp_path):
    growth = suite("growth")
    result = growth.run("boxes,joints,arms,passage", 0.05, 1, tmp_path / "growth.png")
    sizes = {(row["series"], row["size"]) for row in result["rows"]}
    assert sizes == {("boxes", 10), ("boxes", 30), ("boxes", 100), ("boxes", 300), ("arms", 2), ("arms", 4)} | {
        ("passage", 100),
        ("passage", 30),
    }
    assert all(row["status"] == "solved" and row["plan_s"] > 0 for row in result["rows"])
    assert set(result["exponents"]) == {"boxes", "arms", "passage"}
    assert growth.table(result).count("\n") == len(result["rows"]) + 2
    for name in ("growth.png", "growth.svg"):
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(srmp.InvalidArgument, match="only 'bxes': there are boxes, triangles"):
        growth.run("bxes", 1, 1, None)


def test_a_chain_of_joints_is_planned_for(suite):
    growth = suite("growth")
    assert growth.joints(10)().certificate.holds


def test_any_robot_among_boxes(suite):
    any_robot = suite("any_robot")
    result = any_robot.run(["arm7"], None, worlds=1, problems=2, boxes=4, repeats=1, limit=10.0)
    assert len(result["rows"]) == 2
    assert all(row["status"] == "solved" and row["verification_time_s"] > 0 for row in result["rows"])
    result["rows"] += [{**row, "baseline": True} for row in result["rows"]]
    last_line = any_robot.table(json.loads(json.dumps(result))).splitlines()[-1]
    assert "2/2" in last_line and last_line.endswith("1.00")


def test_similar_problems_have_similar_paths(suite, mbm_data):
    """Of other problems than those of the documentation's table, which has 3 % as its aim."""
    consistency = suite("consistency")
    result = consistency.run(str(mbm_data), "panda", "urdf", "41-43", ["auto", "wAstar"], 10.0, 2, {})
    for name, found in result["planners"].items():
        assert found["failed"] == 0, name
        assert found["mean_variation"] < 0.04, name
    assert consistency.table(result).count("\n") == 3


def test_speed_with_a_baseline_in_pairs(suite, stand_in_dir, monkeypatch):
    speed = suite("speed")
    monkeypatch.setattr(speed, "SCENARIOS", ("box",))
    monkeypatch.setattr(speed, "OTHERS", {})
    monkeypatch.setattr(speed, "has_wheel", lambda: False)  # its wheel may be there
    result = speed.run(str(stand_in_dir), None, "1,2", "1-2", 2, sys.executable)
    assert [row["name"] for row in result["rows"]] == ["box, spheres", "box, meshes", "box, meshes, to poses"]
    for row in result["rows"]:
        assert row["own"].keys() == row["baseline"].keys() == {"box/0001", "box/0002"}
        assert all(own["seconds"] > 0 for own in row["own"].values())
        assert [own["cost"] for own in row["own"].values()] == [other["cost"] for other in row["baseline"].values()]
    result["rows"].append({"aim": 2, "name": "a yardstick", "goal": "–", "own": result["rows"][0]["own"]})
    assert "2/2" in speed.table(json.loads(json.dumps(result)))
    with pytest.raises(srmp.InvalidArgument, match="aims '1,7': they are 1 to 5"):
        speed.run(str(stand_in_dir), None, "1,7", "1", 1, None)
    with pytest.raises(srmp.Error, match=r"'box, spheres' by .* failed: .*is not a directory"):
        speed.run("/nowhere", None, "1", "1", 1, None)


def test_the_other_measurements_of_speed(suite, stand_in_dir, monkeypatch):
    speed = suite("speed")
    monkeypatch.setattr(speed, "TIMES", (0.001, 2.0))  # a busy machine finds the first path late
    for kind in ("certified", "first", "after_change"):
        (row,) = speed.KINDS[kind](str(stand_in_dir), "1", "panda", "urdf", "box").values()
        assert row["seconds"] is not None
    (row,) = speed.anytime(str(stand_in_dir), "1", "panda", "urdf", "box").values()
    assert row["cost"] == min(cost for cost in row["costs"].values() if cost is not None)
    for arms in (speed.arms, speed.arms_to_poses):
        (row,) = arms(str(stand_in_dir), "1", "grid", 2, None).values()
        assert row["seconds"] > 0


VAMP_STAND_IN = """
class Path(list):
    def cost(self): return 2.5
class Result:
    def __init__(self, path): self.path, self.nanoseconds, self.solved = path, 1000, bool(path)
class Robot:
    def halton(self): return self
    def reset(self): pass
    def simplify(self, path, *_): return Result(path)
class Environment:
    def add_cuboid(self, cuboid): assert len(cuboid) == 3
    def add_capsule(self, capsule): assert len(capsule) == 4
class Settings:
    max_iterations = 7
def plan(start, goals, scene, settings, sampler):
    assert len(start) == len(goals[0]) == 7
    return Result(Path([start, goals[0]]) if settings.max_iterations != 100 else Path())
def Cuboid(*of): return of
Cylinder = Cuboid
def configure_robot_and_planner_with_kwargs(robot, planner): return Robot(), plan, Settings(), None
"""


def test_speed_beside_vamp(suite, stand_in_dir, monkeypatch, tmp_path):
    speed = suite("speed")
    monkeypatch.setattr(speed, "SCENARIOS", ("box",))
    monkeypatch.setattr(speed, "has_wheel", lambda: False)
    (tmp_path / "vamp.py").write_text(VAMP_STAND_IN)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (row,) = speed.run(str(stand_in_dir), None, "1", "1-2", 1, None, sys.executable)["rows"][1:]
    assert row["name"] == "box, VAMP's RRT-Connect"
    assert [each["cost"] for each in row["own"].values()] == [2.5, 2.5]
    assert [each["seconds"] for each in row["own"].values()] == pytest.approx([2e-6, 2e-6])
    found = speed.vamp(str(stand_in_dir), "1", "aorrtc", "box", sys.executable)
    assert found["box/0001"]["costs"] == {"0.001": 2.5, "0.01": 2.5, "0.03": 2.5, "0.1": 2.5}
    (tmp_path / "vamp.py").write_text("raise RuntimeError('no robot')")
    with pytest.raises(srmp.Error, match=r"VAMP by .* failed: RuntimeError: no robot"):
        speed.vamp(str(stand_in_dir), "1", "rrtc", "box", sys.executable)


def test_a_problem_that_one_round_does_not_solve_counts_as_not_solved(suite):
    speed = suite("speed")
    solved, failed = {"a": {"seconds": 2.0, "cost": 1.0}}, {"a": {"seconds": None, "cost": None}}
    assert speed.merge([solved, {"a": {"seconds": 1.0, "cost": 1.0}}])["a"]["seconds"] == 1.0
    assert speed.merge([solved, failed])["a"]["seconds"] is None
    assert speed.pair_cells(solved, failed) == ["–", "–"]


def test_upright_motions_beside_ompl(suite, stand_in_dir, monkeypatch):
    constrained = suite("constrained")
    monkeypatch.setattr(constrained, "SCENARIOS", ("table_under_pick",))
    result = constrained.run(str(stand_in_dir), "panda", "2-3", "auto", 10.0)
    rows = [row for row in result["rows"] if row["status"] != "left out"]
    assert rows and not any(map(constrained.is_wrong, rows))
    if ompl_module() is None:
        assert {row["no_ompl"] for row in rows} == {NO_OMPL}
        return
    for row in (row[name] for row in rows for name in constrained.OMPL):
        assert row["status"] in ("solved", "timed_out")
        assert row["status"] == "timed_out" or row["tilt_rad"] <= constrained.TOLERANCE
    assert "all, OMPL" in constrained.table(result)
    monkeypatch.setattr(constrained, "ompl_module", lambda: None)
    assert constrained.why_no_ompl(rows) == NO_OMPL


def test_a_robot_without_limits_is_not_for_ompl(suite):
    constrained = suite("constrained")
    if ompl_module() is not None:
        assert "need joint limits" in constrained.why_no_ompl(np.array([[-1, 1], [-np.inf, np.inf]]))


def test_lines_and_brute_force(suite, stand_in_dir):
    lines = suite("lines")
    result = lines.run(str(stand_in_dir), "panda", 3, 0, True)
    assert len(result["rows"]) == 3
    assert any(row["status"] == "solved" for row in result["rows"])
    assert not any(map(lines.is_wrong, result["rows"]))
    assert "more by brute force" in lines.table(result)
