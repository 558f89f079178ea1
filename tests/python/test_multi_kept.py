"""A request for many robots is kept: saved, loaded, planned again to the same result, and verified."""

import copy
import json
import math
import pickle
import re

import numpy as np
import pytest
from click.testing import CliRunner
from support import READY, arms, joints, turned

import srmp
from srmp import GoalConstraint, GoalType, Pose
from srmp.cli import main

ROWS = ("positions", "velocities", "accelerations", "times")
NAMES = ["holder", "idler", "left", "right"]


@pytest.fixture
def world():
    """Two arms face to face, three beside them, of which one is committed."""
    bases = {"left": (0, 0, 0), "right": (0.7, 0, np.pi), "holder": (0.35, 0.9, -np.pi / 2)}
    bases |= {"idler": (0.35, -0.9, np.pi / 2), "committed": (-0.8, 0, np.pi)}
    planner = arms({name: Pose.from_rpy([x, y, 0], [0, 0, yaw]) for name, (x, y, yaw) in bases.items()})
    planner.make_planner(NAMES, {"planner_id": "xECBS", "time_limit": 20})
    return planner


@pytest.fixture
def request_(world):
    """Goals of every kind, and a motion that is settled."""
    there = GoalConstraint(
        GoalType.POSE, world.compute_fk("right", turned(-0.6)), rotation_tolerance=[0.1, 0.1 / 3, math.inf]
    )
    committed = srmp.Trajectory(
        world.get_joint_names("committed"), [turned(-0.9), turned(0.1 / 3)], [0, 2], np.zeros((2, 7))
    )
    return srmp.MultiPlanRequest(
        {"left": turned(0.6), "right": turned(0.6), "holder": READY, "idler": turned(0.1 / 3)},
        {
            "left": joints(turned(-0.6), turned(-0.65)),
            "right": there,
            "holder": GoalConstraint.hold(),
            "idler": GoalConstraint.any(),
        },
        {"committed": committed},
    )


@pytest.fixture
def problem(world, request_, tmp_path):
    world.plan_multi(request_.starts, request_.goals, request_.obstacles)
    world.save(tmp_path / "p.srmp.json")
    return tmp_path / "p.srmp.json"


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def again(value):
    return [pickle.loads(pickle.dumps(value)), copy.copy(value), copy.deepcopy(value)]


def test_the_last_request_and_its_result_are_kept(world, request_):
    trajectory = world.plan_multi(request_.starts, request_.goals, request_.obstacles)
    assert world.last_request == request_
    result = world.last_result
    assert isinstance(result, srmp.MultiPlanResult)
    assert result.solved
    assert (result.status, result.reason) == (srmp.Status.solved, "")
    assert result.trajectory == trajectory
    assert result.statistics == world.get_planning_stats()
    assert repr(result) == "MultiPlanResult(solved)"
    assert repr(world.last_request) == "MultiPlanRequest(4 robots among 1 that are committed)"


def test_a_loaded_problem_is_the_one_that_was_saved(world, problem, tmp_path):
    loaded = srmp.PlannerInterface.load(problem)
    assert loaded.get_planning_stats() == world.get_planning_stats()
    assert loaded.last_request == world.last_request
    assert loaded.last_result == world.last_result
    request = loaded.last_request
    assert loaded.plan_multi(request.starts, request.goals, request.obstacles) == world.last_result.trajectory
    for name in ("expansions", "edge_checks", "states", "memory_bytes", "tree_nodes", "makespan_s"):
        assert loaded.get_planning_stats()[name] == world.get_planning_stats()[name]
    srmp.PlannerInterface.load(problem).save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == problem.read_text()


def test_the_file_says_it_by_robot(world, problem):
    content = json.loads(problem.read_text(), parse_constant=pytest.fail)
    assert content["request"]["starts"]["idler"] == world.last_request.starts["idler"].tolist()
    assert {name: goal["type"] for name, goal in content["request"]["goals"].items()} == {
        "holder": "hold",
        "idler": "any",
        "left": "joints",
        "right": "pose",
    }
    assert list(content["request"]["obstacles"]) == ["committed"]
    assert list(content["result"]["trajectories"]) == NAMES
    assert content["result"]["statistics"]["robot_cost_rad"] == world.get_planning_stats()["robot_cost_rad"]


def test_files_with_the_former_name_of_a_goal_type_are_read(problem, tmp_path):
    older = tmp_path / "older.json"
    older.write_text(problem.read_text().replace('"type": "any"', '"type": "aside"'))
    loaded = srmp.PlannerInterface.load(older)
    assert loaded.last_request.goals["idler"] == GoalConstraint.any()


def test_values_pickle_copy_and_compare(world, problem):
    request, result = world.last_request, world.last_result
    fewer = srmp.MultiPlanRequest(request.starts, request.goals)
    assert fewer != request
    assert fewer.obstacles == {}
    with pytest.raises(srmp.PlanningError) as caught:
        world.plan_multi(request.starts, {"left": GoalConstraint(GoalType.POSITION, [9, 9, 9])})
    failed = world.last_result
    assert failed.statistics == caught.value.statistics
    assert failed != result
    for value in (request, result, fewer, failed):
        for copied in again(value):
            assert copied == value
            assert type(copied) is type(value)
            assert copied != "something else"
        with pytest.raises(TypeError, match="unhashable"):
            hash(value)


def test_requests_refuse_what_plan_multi_refuses():
    with pytest.raises(srmp.InvalidArgument, match="start of 'left' must be numbers, but is 'up'"):
        srmp.MultiPlanRequest({"left": "up"}, {})
    with pytest.raises(srmp.InvalidArgument, match="of 'left' must be"):
        srmp.MultiPlanRequest({"left": READY}, {"left": object()})


def test_without_a_trajectory_the_reason_is_kept(world, request_, tmp_path):
    world.add_box("box", [0.1, 0.1, 0.1], world.compute_fk("holder", READY))  # in the hand of one that holds
    with pytest.raises(srmp.PlanningError, match=r"robot 'holder': the start is invalid: .*'arm7_.* and object 'box'"):
        world.plan_multi(request_.starts, request_.goals)
    world.save(tmp_path / "p.json")
    loaded = srmp.PlannerInterface.load(tmp_path / "p.json")
    assert loaded.last_result == world.last_result
    assert loaded.last_result.status == srmp.Status.start_invalid
    costs = loaded.get_planning_stats()["robot_cost_rad"]
    assert costs == world.get_planning_stats()["robot_cost_rad"] == dict.fromkeys(costs, 0)
    assert costs
    assert "holder" not in costs
    with pytest.raises(srmp.PlanningError, match="'holder': the start is invalid"):
        _ = loaded.last_result.trajectory
    result = run("replay", tmp_path / "p.json")
    assert (result.exit_code, result.output) == (0, "the same: start_invalid\n")
    result = run("verify", tmp_path / "p.json")
    assert result.exit_code == 2
    assert result.output.strip().endswith("it holds no trajectory: the plan ended with start_invalid")


def test_the_last_one_counts(world, request_):
    world.plan_multi(request_.starts, request_.goals)
    world.make_planner("left", {"planner_id": "auto"})
    world.plan("left", turned(2), joints(turned(2.1)))
    assert isinstance(world.last_request, srmp.PlanRequest)
    assert isinstance(world.last_result, srmp.PlanResult)
    world.set_padding("left", 0.001)
    assert world.last_result is None
    world.plan_multi(request_.starts, request_.goals)
    world.remove_articulation("holder")
    assert world.last_request is None


# --- bad input: each place is tested in C++ (kept_test.cpp)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"starts": {', '"begin": {', "request: it has neither 'robot', as one of plan has, nor 'starts'"),
        ('"type": "any"', '"type": "anny"', r"request\.goals\.idler\.type is 'anny'; known are 'joints', 'pose'"),
        ('"committed": {', '"comitted": {', "request: unknown robot 'comitted', did you mean 'committed'"),
        ('"trajectories": {', '"trajectoris": {', "result"),
    ],
)
def test_damaged_problems_are_refused_with_the_place(problem, old, new, message):
    text = problem.read_text()
    at = text.index(old, text.index('"request":'))
    problem.write_text(text[:at] + text[at:].replace(old, new, 1))
    with pytest.raises(srmp.FileError, match=rf"^{re.escape(str(problem))}:\d+: .*{message}"):
        srmp.PlannerInterface.load(problem)
    srmp.PlannerInterface().load_scene(problem)  # that is as it was
    for command in ("replay", "verify"):
        result = run(command, problem)
        assert result.exit_code == 2
        assert len(result.output.strip().splitlines()) == 1


def decreasing(motion):
    motion["times"][1] = -1.0


def six_joints(motion):
    motion["joint_names"].pop()
    for name in ("positions", "velocities", "accelerations", "waypoints"):
        motion[name] = [row[:6] for row in motion[name]]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda motion: motion["positions"][2].__setitem__(0, "nan"), "positions, row 2: arm7_joint1 is NaN"),
        (lambda motion: motion["times"].clear(), "it has velocities, but no times"),
        (decreasing, "times must increase, but row 1 is at -1 s, after 0 s"),
        (lambda motion: [motion[name].clear() for name in ROWS], "it has no rows"),
        (six_joints, "the joints are .* but those of robot"),
        (
            lambda motion: motion["joint_names"].__setitem__(0, "foreign"),
            "the joints are 'foreign'.* but those",
        ),
    ],
)
def test_damaged_results_are_refused_with_the_place(world, problem, tmp_path, damage, message):
    def refused(path, edit, place):
        content = json.loads(path.read_text())
        damage(edit(content["result"]))
        path.write_text(json.dumps(content))
        with pytest.raises(srmp.FileError, match=rf"^{re.escape(str(path))}:\d+: {place}: .*{message}"):
            srmp.PlannerInterface.load(path)

    refused(problem, lambda result: result["trajectories"]["left"], r"result\.trajectories\.left")
    world.make_planner("left", {"planner_id": "auto"})
    world.plan("left", turned(2), joints(turned(2.1)))
    world.save(tmp_path / "one.json")
    refused(tmp_path / "one.json", lambda result: result["trajectory"], r"result\.trajectory")


# --- command line


def test_replay_says_same(problem):
    result = run("replay", problem)
    assert result.exit_code == 0, result.output
    assert result.output.startswith("the same: solved, MultiTrajectory(4 robots, ")


def test_replay_says_where_it_differs(problem):
    content = json.loads(problem.read_text())
    content["result"]["trajectories"]["right"]["positions"][3][2] += 1e-15
    problem.write_text(json.dumps(content))
    result = run("replay", problem)
    assert result.exit_code == 1
    assert re.match(
        r"differs: robot 'right': positions, row 3, column 2 \(.+\): was \S+ and is \S+\n", result.output
    ), result.output


def test_verify_checks_all_robots(problem):
    result = run("verify", problem)
    assert result.exit_code == 0, result.output
    assert re.findall(r"robot '(\w+)':", result.output) == NAMES
    assert result.output.count("holds, proved free, clearance") == 4
    content = json.loads(problem.read_text())
    for row in content["result"]["trajectories"]["left"]["positions"]:
        row[0] += 0.1  # it begins and ends elsewhere
    problem.write_text(json.dumps(content))
    result = run("verify", problem)
    assert result.exit_code == 1
    assert "the trajectory starts at" in result.output
    for option in (["--robot", "left"], ["--scene", problem], ["--jerk", "--urdf", srmp.data_path("arm7.urdf")]):
        refused = run("verify", problem, *option)
        assert refused.exit_code == 2
        assert "is for one robot" in refused.output
        assert "holds a plan_multi" in refused.output


def test_plan_asks_for_moveits_files(problem, tmp_path):
    arm = ["--urdf", srmp.data_path("arm7.urdf"), "-o", tmp_path / "plan.json"]
    result = run("plan", *arm, "--request", problem)
    assert result.exit_code == 2
    assert "not a MoveIt motion plan request; srmp replay plans a saved problem again" in result.output


def test_one_trajectory_of_it_is_told_to_be_many(problem):
    with pytest.raises(srmp.FileError, match="it holds the trajectories of a plan_multi, not one; load the file as"):
        srmp.Trajectory.load(problem)


def test_one_robot_of_it_is_verified_among_robots_that_stand_still(world, problem):
    motion = world.last_result.trajectory["idler"]
    certificate = srmp.verify(problem, motion, "idler")
    assert certificate.holds


# --- robots that hold


@pytest.mark.parametrize("timing", ["toppra", "ruckig", "none"])
def test_who_holds_has_a_certificate(world, request_, timing):
    world.make_planner(NAMES, {"planner_id": "xECBS", "time_limit": 20, "timing": timing})
    trajectory = world.plan_multi(request_.starts, request_.goals)
    certificate = trajectory["holder"].certificate
    assert certificate.proved_free
    assert 0 < certificate.clearance < 1
    assert certificate.bound == world.get_planning_stats()["bound"]
    assert math.isnan(certificate.goal_error)


def test_verify_multi_agrees_with_the_certificates(world, request_, problem):
    trajectory = world.last_result.trajectory
    verified = world.verify_multi(
        trajectory, starts=request_.starts, goals=request_.goals, obstacles=request_.obstacles
    )
    assert list(verified) == NAMES
    for name, certificate in verified.items():
        assert certificate.proved_free
        assert certificate.clearance == pytest.approx(trajectory[name].certificate.clearance, abs=1e-4)
    with pytest.raises(srmp.InvalidArgument, match="robot 'lft' has a start, but no trajectory to verify"):
        world.verify_multi(trajectory, starts={"lft": READY})
    with pytest.raises(srmp.InvalidArgument, match="must be a GoalConstraint"):
        world.verify_multi(trajectory, goals={"left": object()})


def test_one_that_holds_ends_where_it_begins(world, request_):
    world.plan_multi(request_.starts, request_.goals)
    hold = GoalConstraint.hold()
    motions = world.last_result.trajectory
    certificates = world.verify_multi(dict(motions), goals={"left": hold, "holder": hold})
    assert certificates["holder"].holds
    (fault,) = certificates["left"].faults
    assert fault.kind == srmp.FaultKind.goal
    assert certificates["left"].goal_error == pytest.approx(np.ptp(motions["left"].positions[[0, -1]], axis=0).max())


def test_slices_of_many_can_be_verified_in_motion(world, request_):
    trajectory = world.plan_multi(request_.starts, request_.goals)
    moving = {name: motion for name, motion in trajectory.items() if motion.duration > 0}
    end = 0.6 * min(motion.duration for motion in moving.values())
    slices = dict(trajectory.items()) | {name: motion.slice(0, end) for name, motion in moving.items()}
    kinds = {fault.kind for certificate in world.verify_multi(slices).values() for fault in certificate.faults}
    assert kinds == {srmp.FaultKind.not_at_rest}
    assert all(certificate.holds for certificate in world.verify_multi(slices, at_rest=False).values())


def test_verify_multi_sees_what_one_alone_does_not(world, request_):
    trajectory = world.plan_multi(request_.starts, request_.goals)
    late = srmp.MultiTrajectory({"left": trajectory["left"], "right": trajectory["left"]})  # face to face, alike
    assert all(certificate.holds for certificate in world.verify_multi(trajectory).values())
    faults = {name: certificate.faults for name, certificate in world.verify_multi(late).items()}
    for name, other in (("left", "right"), ("right", "left")):
        assert [fault.kind for fault in faults[name]] == [srmp.FaultKind.collision]
        assert f"'{other}/arm7_" in faults[name][0].text


@pytest.mark.parametrize("planner_id", ["auto", "CBS", "ECBS", "xECBS", "prioritised"])
def test_memory_is_counted(world, planner_id):
    world.make_planner(["left", "right"], {"planner_id": planner_id, "time_limit": 20})
    starts = {"left": turned(0.6), "right": turned(0.6)}
    world.plan_multi(starts, {name: joints(turned(0.3)) for name in starts})
    assert world.get_planning_stats()["memory_bytes"] > 0
