"""The MotionBenchMaker runner: choosing problems, statistics, result files. Planning is tested elsewhere."""

import io
import json
import math
import re
import tarfile

import numpy as np
import pytest

import srmp
from srmp._files import write_json
from srmp._table import format_seconds, format_table
from srmp.bench import mbm


def add_problem(directory, scenario, number, kinds=("scene", "request")):
    (directory / scenario).mkdir(parents=True, exist_ok=True)
    for kind in kinds:
        (directory / scenario / f"{kind}{number:04d}.yaml").write_text(f"{kind} {number}")


@pytest.fixture
def problems(tmp_path):
    for scenario in ("box_arm", "cage_arm"):
        for number in (1, 2, 3, 10):
            add_problem(tmp_path / "problems", scenario, number)
    return tmp_path


def names(directory, *choice):
    with mbm.open_problems(directory, "arm", *choice) as chosen:
        return [problem.name for problem in chosen]


def test_problems_come_in_order_without_the_robot_in_the_name(problems):
    every = [f"{scenario}/{number:04d}" for scenario in ("box", "cage") for number in (1, 2, 3, 10)]
    assert names(problems) == every


def test_problems_are_chosen_by_scenario_and_number(problems):
    assert names(problems, ["cage"], mbm.parse_numbers("2-9")) == ["cage/0002", "cage/0003"]


def test_archive_is_read_without_touching_the_data(problems):
    with tarfile.open(problems / "problems.tar.bz2", "w:bz2") as tar:
        for file in (problems / "problems").rglob("*.yaml"):
            tar.add(file, file.relative_to(problems / "problems"))
        evil = tarfile.TarInfo("../../box_arm/scene0099.yaml")
        tar.addfile(evil, io.BytesIO())
    before = names(problems)
    for file in (problems / "problems").rglob("*.yaml"):
        file.unlink()
    for directory in [*(problems / "problems").iterdir(), problems / "problems"]:
        directory.rmdir()
    with pytest.raises(srmp.FileError, match="cannot be unpacked"):
        names(problems)  # a member that climbs out of the directory is refused
    with tarfile.open(problems / "problems.tar.bz2", "w:bz2") as tar:
        for name in before:
            scenario, number = name.split("/")
            for kind in ("scene", "request"):
                tar.addfile(tarfile.TarInfo(f"./{scenario}_arm/{kind}{number}.yaml"), io.BytesIO())
    with mbm.open_problems(problems, "arm") as chosen:
        assert [problem.name for problem in chosen] == before
        assert all(problem.scene.is_file() for problem in chosen)
        assert not any(problem.scene.is_relative_to(problems) for problem in chosen)
    assert not any(problem.scene.exists() for problem in chosen)
    assert [file.name for file in problems.iterdir()] == ["problems.tar.bz2"]


@pytest.mark.parametrize(
    ("text", "numbers"), [("1-3", {1, 2, 3}), ("1,3,5-7", {1, 3, 5, 6, 7}), (" 4 ", {4}), ("2-2,2", {2})]
)
def test_numbers(text, numbers):
    assert mbm.parse_numbers(text) == numbers


@pytest.mark.parametrize("text", ["", "a", "1-", "-3", "5-2", "1,,2", "1.5"])
def test_numbers_refuses(text):
    with pytest.raises(srmp.InvalidArgument, match="problems"):
        mbm.parse_numbers(text)


def test_wrong_choices_are_refused(problems):
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'cage'"):
        names(problems, ["cagee"])
    with pytest.raises(srmp.InvalidArgument, match=r"no problem has the numbers 77; there are 1 … 10\."):
        names(problems, [], {77})
    add_problem(problems / "problems", "box_arm", 11, ["scene"])
    with pytest.raises(srmp.FileError, match="box/0011 has only one of scene and request"):
        names(problems)
    with pytest.raises(srmp.FileError, match="neither problems/ nor"):
        names(problems / "problems")


def test_robot_files_are_found_or_refused(problems):
    with pytest.raises(srmp.FileError, match="did you mean 'problems'"):
        mbm.robot_files(problems, "problms", "urdf")
    with pytest.raises(srmp.InvalidArgument, match="neither 'urdf' nor 'spheres'"):
        mbm.robot_files(problems, "problems", "cubes")
    with pytest.raises(srmp.FileError, match=r"problems_spherized\.urdf does not exist"):
        mbm.robot_files(problems, "problems", "spheres")


def test_real_data_has_fifty_problems_of_seven_scenarios(mbm_data):
    for robot in ("panda", "ur5", "fetch"):
        with mbm.open_problems(mbm_data / robot, robot) as chosen:
            assert len(chosen) == 350
            assert len({problem.scenario for problem in chosen}) == 7


def row(problem, status, time=math.nan, cost=math.nan):
    costs = {"path_cost_rad": cost, "straight_cost_rad": 0.9 * cost, "ee_cost_m": cost / 2}
    return {"problem": problem, "status": status, "plan_time_s": time, **costs}


ROWS = [
    row("box/0001", "solved", 0.1, 4.0),
    row("box/0002", "solved", 0.3, 6.0),
    row("box/0003", "timed_out"),
    row("box/0004", "goal_invalid"),
    row("cage/0001", "start_invalid"),
]


def test_invalid_problems_are_no_failures():
    box, cage, every = mbm.statistics(ROWS)
    assert (box.solved, box.valid, box.total) == (2, 3, 4)
    assert (cage.solved, cage.valid, cage.total) == (0, 0, 1)
    assert (every.solved, every.valid, every.total) == (2, 3, 5)
    np.testing.assert_allclose(
        [box.time_median, box.time_mean, box.time_p95, box.time_max],
        [0.2, 0.2, 0.29, 0.3],
    )
    np.testing.assert_allclose(
        [box.mean_cost_rad, box.mean_straight_cost_rad, box.mean_ee_cost_m],
        [5.0, 4.5, 2.5],
    )
    assert math.isnan(cage.time_median)


def test_the_straight_way_takes_continuous_joints_by_the_short_way():
    class Planner:
        def get_joint_limits(self, robot):
            return np.array([[-np.inf, np.inf], [-3.0, 3.0]])

    path = np.array([[3.0, 1.0], [5.0, 0.0], [3.0 + 2 * np.pi + 0.3, 1.4]])  # once round too often
    assert mbm.straight_length(Planner(), "arm", path) == pytest.approx(0.5)


def test_table():
    first = mbm.format_statistics(ROWS).splitlines()[2]
    assert re.sub(" +", " ", first) == "box 2/3/4 200 ms 200 ms 290 ms 300 ms 5.00 4.50 2.50 – 0"
    assert format_table(["a", "n"], [["x", "10"], ["long", "1"]]) == "a      n\n────  ──\nx     10\nlong   1"
    assert [format_seconds(s) for s in (0.00042, 0.0123, 0.4567, 1.234)] == ["0.42 ms", "12.3 ms", "457 ms", "1.23 s"]


def test_json_is_written_whole_and_reads_back_bit_for_bit(tmp_path):
    file = tmp_path / "results.json"
    path = np.array([[0.1, 1 / 3], [1e-17, -0.0]])
    value = {"path": path, "bound": math.inf, "n": np.int64(3), "text": "±π", "empty": []}
    write_json(file, value)
    again = json.loads(file.read_text())
    assert again == {"path": [[0.1, 1 / 3], [1e-17, -0.0]], "bound": None, "n": 3, "text": "±π", "empty": []}
    with pytest.raises(TypeError):
        write_json(file, {"broken": object()})
    assert json.loads(file.read_text()) == again
    assert [entry.name for entry in tmp_path.iterdir()] == ["results.json"]
