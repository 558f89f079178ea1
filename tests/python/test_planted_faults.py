"""A good plan, one fault planted in its file at a time: `srmp verify` finds each, and names joint, value and time."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp import demo
from srmp.cli import main


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """The directory of problem.json and plan.json, and what the latter holds."""
    directory = tmp_path_factory.mktemp("plan")
    result = demo.run()
    result.planner.save(directory / "problem.json")
    result.trajectory.save(directory / "plan.json")
    return directory, json.loads((directory / "plan.json").read_text())


def verify(directory, motion, *arguments):
    text = json.dumps({key: np.asarray(value).tolist() if key in ARRAYS else value for key, value in motion.items()})
    (directory / "planted.json").write_text(text)
    command = ["verify", directory / "planted.json", "--scene", directory / "problem.json", *arguments]
    return CliRunner().invoke(main, [str(argument) for argument in command])


ARRAYS = ("times", "positions", "velocities", "accelerations", "waypoints")


def arrays(motion):
    return {key: np.array(value) if key in ARRAYS else value for key, value in motion.items()}


def even_pieces(motion):
    """Rows that come 20 ms after the one before, and before the next."""
    step = np.diff(motion["times"])
    return [i for i in range(2, len(step) - 2) if abs(step[i - 1] - 0.02) < 1e-6 and abs(step[i] - 0.02) < 1e-6]


# --- what is planted --------------------------------------------------------------------------------------------------


def velocity_between_samples(motion):
    """The fastest row's neighbours run backwards, within their limits: the piece between must hurry."""
    row, joint = np.unravel_index(np.abs(motion["velocities"]).argmax(), motion["velocities"].shape)
    motion["velocities"][row : row + 2, joint] *= -1


def acceleration_between_samples(motion):
    row = even_pieces(motion)[0]
    motion["positions"][row, 6] += 1e-3  # rows still say small accelerations


def position_between_samples(motion):
    row = even_pieces(motion)[0]
    motion["positions"][row : row + 2, 3] = 2.4 - 1e-4  # of 2.4
    motion["velocities"][row : row + 2, 3] = [1.0, -1.0]


def collision_between_samples(motion):
    """Straight from the first row to the last, both free, slowly."""
    for key in ("positions", "velocities", "accelerations"):
        motion[key] = motion[key][[0, -1]]
    motion["velocities"][:] = motion["accelerations"][:] = 0
    motion["times"] = np.array([0.0, 20.0])


def names_permuted(motion):
    motion["joint_names"][1:3] = reversed(motion["joint_names"][1:3])


def names_of_another_robot(motion):
    motion["joint_names"] = [name.replace("arm7", "arm8") for name in motion["joint_names"]]


def columns_permuted(motion):
    for key in ("positions", "velocities", "accelerations", "waypoints"):
        motion[key] = motion[key][:, ::-1]


def time_stands_still(motion):
    motion["times"][7] = motion["times"][6]


def time_runs_back(motion):
    motion["times"][7] = motion["times"][5]


def a_jump(motion):
    motion["positions"][20:, 5] += 0.5


def another_start(motion):
    motion["positions"][0, 0] += 1e-3


def missed_goal(motion):
    keep = len(motion["times"]) // 2
    for key in ("times", "positions", "velocities", "accelerations"):
        motion[key] = motion[key][:keep]


def moving_at_the_start(motion):
    motion["velocities"][0, 2] = 1e-3


def moving_at_the_end(motion):
    motion["velocities"][-1, 4] = -1e-3


def jerk(motion):
    row = even_pieces(motion)[0]
    motion["positions"][row, 6] += 1e-4


def a_detour(motion):
    motion["waypoints"] = motion["waypoints"][[0, -1]]


NAMED = [
    (velocity_between_samples, "velocity_limit: {joint}: the velocity reaches {number} at {between}; its limit is"),
    (acceleration_between_samples, "acceleration_limit: arm7_joint7: the acceleration reaches {number} at {between}"),
    (position_between_samples, r"position_limit: arm7_joint4: the position is 2.40\d+ at {between}; its limits are \["),
    (collision_between_samples, r"collision: link '\w+' and object '\w+' overlap by {number} mm at {number} s"),
    (names_permuted, "joint_names: the joints are in another order: 'arm7_joint1', 'arm7_joint3', 'arm7_joint2'"),
    (names_of_another_robot, "joint_names: the joints are 'arm8_joint1'"),
    (
        columns_permuted,
        "joint_names: the columns are in another order than the joint names: "
        "{joint}: the trajectory starts at {number}",
    ),
    (time_stands_still, r"times: time stands still from row 6 \({number} s\) to row 7 \({number} s\)"),
    (time_runs_back, r"times: time runs back from row 6 \({number} s\) to row 7 \({number} s\)"),
    (a_jump, "velocity_limit: arm7_joint6: the velocity reaches {number} at {between}; its limit is 3"),
    (another_start, "start: arm7_joint1: the trajectory starts at {number}, not at {number}"),
    (missed_goal, "goal: the end misses the goal by {number} times its tolerance"),
    (moving_at_the_start, "not_at_rest: arm7_joint3: the velocity is 0.001 at the start; it should be 0"),
    (moving_at_the_end, "not_at_rest: arm7_joint5: the velocity is -0.001 at the end; it should be 0"),
]
WITH_OPTIONS = [
    (
        jerk,
        ("--jerk",),
        "jerk_limit: arm7_joint7: the acceleration jumps at {between}, where the jerk is unbounded; its limit is",
    ),
    (a_detour, ("--max-deviation", 0.01), r"deviation: the motion leaves its checked path by {number} m at {number} s"),
]


def expect_named(result, text):
    assert result.exit_code == 1, result.output
    parts = {
        "number": r"-?[\d.e-]+",
        "between": r"[\d.e-]+ s \((?:between rows \d+ and \d+|row \d+, the last)\)",
        "joint": r"arm7_joint\d",
    }
    for name, pattern in parts.items():
        text = text.replace("{" + name + "}", pattern)
    assert re.search(rf"^FAULT {text}", result.output, re.M), result.output


# --- what is found ----------------------------------------------------------------------------------------------------


def test_nothing_is_found_in_the_plan_itself(plan):
    directory, motion = plan
    result = verify(directory, arrays(motion))
    assert result.exit_code == 0, result.output
    assert "FAULT" not in result.output
    assert "proved free    all of the motion, also between samples" in result.output


@pytest.mark.parametrize(("plant", "text"), NAMED, ids=lambda value: getattr(value, "__name__", ""))
def test_a_planted_fault_is_found_and_named(plan, plant, text):
    directory, motion = plan
    planted = arrays(json.loads(json.dumps(motion)))
    plant(planted)
    expect_named(verify(directory, planted), text)


@pytest.mark.parametrize(("plant", "options", "text"), WITH_OPTIONS, ids=["jerk", "deviation"])
def test_a_fault_that_only_an_option_asks_for_is_found(plan, plant, options, text):
    directory, motion = plan
    planted = arrays(json.loads(json.dumps(motion)))
    plant(planted)
    assert verify(directory, planted).exit_code == 0
    expect_named(verify(directory, planted, *options), text)


@pytest.mark.parametrize("plant", [velocity_between_samples, position_between_samples, collision_between_samples])
def test_rows_alone_do_not_show_it(plan, plant):
    """What makes these faults worth looking for."""
    directory, motion = plan
    planted = arrays(json.loads(json.dumps(motion)))
    plant(planted)
    planner = srmp.PlannerInterface.load(directory / "problem.json")
    limits = np.array(planner.get_joint_limits("arm7"))
    assert (planted["positions"] >= limits[:, 0]).all()
    assert (planted["positions"] <= limits[:, 1]).all()
    assert (np.abs(planted["velocities"]) <= limits[:, 2]).all()
    if plant is collision_between_samples:
        assert not any(planner.is_state_colliding("arm7", q) for q in planted["positions"])


def test_what_is_no_trajectory_is_refused_by_name(plan):
    """Files that cannot be read end with 2, as everywhere."""
    directory, motion = plan
    for change, text in (
        (lambda m: m["velocities"].pop(), "velocities has 204 rows of 7 numbers; there are 205 rows of positions"),
        (
            lambda m: m["positions"][3].__setitem__(2, float("nan")),
            "positions[3] is NaN; only finite numbers are allowed",
        ),
        (lambda m: m["positions"].clear(), "positions"),
        (lambda m: m.pop("joint_names"), "joint_names"),
    ):
        planted = json.loads(json.dumps(motion))
        change(planted)
        (directory / "planted.json").write_text(json.dumps(planted))
        command = ["verify", directory / "planted.json", "--scene", directory / "problem.json"]
        result = CliRunner().invoke(main, [str(argument) for argument in command])
        assert result.exit_code == 2
        assert (
            text.replace("204", str(len(motion["times"]) - 1)).replace("205", str(len(motion["times"])))
            in result.output
        )
