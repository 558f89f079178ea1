"""One file holds a problem: what is saved comes back bit for bit, and plans again to the same result."""

import json
import math
import os
import re
import stat
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp._files import whole, write_bytes, write_json
from srmp.cli import main
from srmp.result import plan_result

CORNERS = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 1 / 30]]


@pytest.fixture
def world(arm):
    """The arm among one object of every kind, with a sphere in its hand."""
    far = srmp.Pose.from_rpy(p=[-1.2, 0.1, 0.3], rpy=[0.1, 0.2, 0.3])
    arm.add_sphere("sphere", 0.1 / 3, srmp.Pose(p=[-1.2, 0.5, 0.3]), padding=0.01)
    arm.add_cylinder("cylinder", 0.1, 0.2, srmp.Pose(p=[-1.2, 1.0, 0.3]))
    arm.add_capsule("capsule", 0.1, 0.2, srmp.Pose(p=[-1.2, -0.5, 0.3]))
    arm.add_cone("cone", 0.1, 0.2, srmp.Pose(p=[-1.2, -1.0, 0.3]))
    arm.add_mesh("surface", vertices=CORNERS, triangles=[[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]], pose=far)
    arm.add_point_cloud("cloud", np.array(CORNERS) / 3 + 1.1, resolution=0.1 / 3)
    arm.add_sphere("marble", 0.02)
    arm.attach_object("marble", "arm", "arm7_hand", pose_in_link=srmp.Pose.from_rpy(p=[0, 0, 0.1], rpy=[1, 2, 3]))
    arm.set_allowed_collision("marble", "table")
    return arm


@pytest.fixture
def goal(ready):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, ready - np.array([1.8, 0, 0, 0, 0, 0, 0]))


@pytest.fixture
def problem(world, ready, goal, tmp_path):
    world.plan("arm", ready, goal)
    world.save(tmp_path / "p.srmp.json")
    return tmp_path / "p.srmp.json"


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_a_loaded_problem_is_the_one_that_was_saved(world, problem, tmp_path):
    loaded = srmp.PlannerInterface.load(problem)
    assert loaded.get_planning_stats() == world.get_planning_stats()
    assert loaded.last_result == world.last_result
    assert loaded.last_request == world.last_request
    assert loaded.object_names == world.object_names
    for name in world.object_names:
        assert loaded.get_object_pose(name) == world.get_object_pose(name)
    request = loaded.last_request
    again = loaded.plan(request.robot, request.start, request.goals)
    assert again == world.last_result.trajectory
    for name in ("expansions", "edge_checks", "states"):
        assert loaded.get_planning_stats()[name] == world.get_planning_stats()[name]
    srmp.PlannerInterface.load(problem).save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == problem.read_text()


def test_files_are_json(world, problem, tmp_path):
    world.save_scene(tmp_path / "s.json")
    world.last_result.trajectory.save(str(tmp_path / "t.json"))
    for path, kind in ((problem, "problem"), (tmp_path / "s.json", "scene"), (tmp_path / "t.json", "trajectory")):
        content = json.loads(path.read_text(), parse_constant=lambda text: pytest.fail(f"{text} is not JSON"))
        assert content["format"] == f"srmp {kind}"
        assert content["format_version"] == 1
        assert content["srmp_version"] == srmp.__version__
    content = json.loads(problem.read_text())
    assert content["result"]["trajectory"]["positions"] == world.last_result.trajectory.positions.tolist()
    assert content["scene"]["robots"][0]["urdf"] == Path(srmp.data_path("arm7.urdf")).read_text()
    assert content["request"]["start"] == world.last_request.start.tolist()


def test_infinity_and_odd_names_survive(arm, ready, tmp_path):
    name = 'a "quoted" \\ näme 😀\r\n\t\x01 {[: #'
    arm.add_box(name, [0.1, 0.1, 0.1], srmp.Pose(p=[-2, 0, 0]))
    goal = srmp.GoalConstraint(
        srmp.GoalType.POSE, arm.compute_fk("arm", ready), rotation_tolerance=[0.1, 0.1 / 3, math.inf]
    )
    arm.plan("arm", ready, goal)
    arm.save(tmp_path / "p.json")
    json.loads((tmp_path / "p.json").read_text(), parse_constant=pytest.fail)
    loaded = srmp.PlannerInterface.load(tmp_path / "p.json")
    assert name in loaded.object_names
    assert loaded.get_planning_stats() == arm.get_planning_stats()
    assert np.isinf(loaded.last_request.goals[0].rotation_tolerance[2])
    assert loaded.last_request.goals == [goal]


def test_trajectories_alone(world, problem, tmp_path):
    trajectory = world.last_result.trajectory
    trajectory.save(tmp_path / "t.json")
    assert srmp.Trajectory.load(tmp_path / "t.json") == trajectory
    assert srmp.Trajectory.load(problem) == trajectory
    write_json(tmp_path / "plan.json", plan_result(world.get_planning_stats(), trajectory.joint_names, trajectory))
    assert srmp.Trajectory.load(tmp_path / "plan.json") == trajectory


def test_scenes_alone(world, problem, ready, goal, tmp_path):
    trajectory = world.last_result.trajectory
    world.save_scene(tmp_path / "s.json")
    for path in (tmp_path / "s.json", problem):
        other = srmp.PlannerInterface()
        other.add_box("gone", [1, 1, 1])
        other.load_scene(path)
        assert other.object_names == world.object_names
        other.make_planner("arm", {"planner_id": "wAstar", "time_limit": 10})
        assert other.plan("arm", ready, goal) == trajectory


def test_the_urdf_may_change_or_go(tmp_path, ready):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(Path(srmp.data_path("arm7.urdf")).read_text())
    planner = srmp.PlannerInterface()
    planner.add_articulation(str(urdf), srmp.data_path("arm7.srdf"), name="arm", end_effector="arm7_hand")
    urdf.unlink()
    planner.save_scene(tmp_path / "s.json")
    loaded = srmp.PlannerInterface()
    loaded.load_scene(tmp_path / "s.json")
    assert loaded.compute_fk("arm", ready) == planner.compute_fk("arm", ready)
    assert loaded.get_group_states("arm").keys() == planner.get_group_states("arm").keys()


def test_robots_from_texts(ready):
    planner = srmp.PlannerInterface()
    texts = {
        "urdf_text": Path(srmp.data_path("arm7.urdf")).read_text(),
        "srdf_text": Path(srmp.data_path("arm7.srdf")).read_text(),
        "end_effector": "arm7_hand",
    }
    planner.add_articulation(**texts, name="arm")
    assert "ready" in planner.get_group_states("arm")
    with pytest.raises(srmp.InvalidArgument, match="either srdf_path or srdf_text, not both"):
        planner.add_articulation(**texts, srdf_path="x.srdf", name="b")
    with pytest.raises(srmp.InvalidArgument, match="urdf_directory is for a URDF given as text"):
        planner.add_articulation(srmp.data_path("arm7.urdf"), urdf_directory="/tmp", name="b")
    with pytest.raises(srmp.FileError, match="SRDF text"):
        planner.add_articulation(**{**texts, "srdf_text": "<robt/>"}, name="b")


def test_heuristics_of_the_user_cannot_be_saved(arm, tmp_path):
    arm.add_heuristic("mine", lambda q, goals: np.zeros(len(q)))
    arm.save(tmp_path / "p.json")
    arm.make_planner("arm", {"planner_id": "wAstar", "heuristic": "mine"})
    with pytest.raises(srmp.InvalidArgument, match="the planner of 'arm' uses the heuristic 'mine' of yours"):
        arm.save(tmp_path / "q.json")
    assert [path.name for path in tmp_path.iterdir()] == ["p.json"]


# --- bad input

BAD = {
    "empty": ("", r"the file is empty"),
    "blank": ("\n \n", r"the file is empty"),
    "a list": ("[]", r"this is no file of srmp; expected is a JSON map"),
    "binary": ("\x00\x01\x02\x7fELF", r""),
    "not JSON": ('{"format": "srmp problem"', r":\d+: not valid JSON"),
    "no format": ('{"a": 1}', r"it does not say its format"),
    "another format": ('{"format": "srmp report", "format_version": 1}', r":1: the format is 'srmp report'; expected"),
    "newer": (
        '{"format": "srmp problem",\n "format_version": 7,\n "srmp_version": "3.1.4"}',
        r":2: srmp 3\.1\.4 wrote version 7 of the format 'srmp problem', and srmp .* reads version 1; use a newer srmp",
    ),
    "no version": ('{"format": "srmp problem"}', r"it has no 'format_version'"),
    "no scene": ('{"format": "srmp problem", "format_version": 1, "srmp_version": "0.1.0"}', r"it has no 'scene'"),
}


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_wrong_files_are_refused_in_one_sentence(text, message, tmp_path):
    path = tmp_path / "p.json"
    path.write_text(text)
    with pytest.raises(srmp.FileError, match=rf"^{re.escape(str(path))}.*{message}"):
        srmp.PlannerInterface.load(path)
    with pytest.raises(srmp.FileError, match=str(path)):
        srmp.PlannerInterface().load_scene(path)
    with pytest.raises(srmp.FileError, match=str(path)):
        srmp.Trajectory.load(path)
    result = run("replay", path)
    assert result.exit_code == 2
    assert len(result.output.strip().splitlines()) == 1


@pytest.mark.parametrize(
    "old, new, message",
    [
        ('"padding": 0.01', '"padding": "much"', r"scene\.objects\[\d\]\.padding must be a number"),
        ('"padding": 0.01', '"pading": 0.01', r"scene\.objects\[\d\]: it has no 'padding'"),
        ('"padding": 0.01', '"padding": 0.01, "colour": "red"', r"unknown key 'colour' in scene\.objects\[\d\]"),
        ('"planners": [', '"planers": [', r"it has no 'planners'"),
        ('"weight": 50', '"weight": 0.5', r"planners\[0\]: option 'weight' is 0\.5; it must be at least 1"),
        ('"goals": [', '"goals": "there", "gaols": [', r"request\.goals must be a list, not 'there'"),
        (
            '"accelerations": [',
            '"accelerations": [\n[1, 2, 3],',
            r"result\.trajectory\.accelerations\[1\] is 7 numbers",
        ),
        ('"kind": "cone"', '"kind": "corn"', r"shape: the kind is 'corn'; known are 'box'"),
    ],
)
def test_damaged_problems_are_refused_with_the_place(problem, old, new, message):
    text = problem.read_text()
    assert text.count(old) >= 1
    problem.write_text(text.replace(old, new, 1))
    with pytest.raises(srmp.FileError, match=rf"^{re.escape(str(problem))}:\d+: .*{message}"):
        srmp.PlannerInterface.load(problem)


def test_a_file_cut_anywhere_is_refused(problem):
    text = problem.read_text()
    for size in range(1, len(text) - 2, len(text) // 60):
        problem.write_text(text[:size])
        with pytest.raises(srmp.FileError, match=re.escape(str(problem))):
            srmp.PlannerInterface.load(problem)


def test_directories_that_cannot_be_written(world, problem, tmp_path):
    for save in (world.save, world.save_scene, world.last_result.trajectory.save):
        with pytest.raises(srmp.FileError, match=r"nowhere/p\.json: the file cannot be written: No such file"):
            save(tmp_path / "nowhere" / "p.json")
        with pytest.raises(srmp.InvalidArgument, match=r"a path must be a str or an os\.PathLike, but is 3"):
            save(3)
    with pytest.raises(srmp.FileError, match="is a directory, not a file"):
        srmp.PlannerInterface.load(tmp_path)
    with pytest.raises(srmp.FileError, match="there is no such file"):
        srmp.Trajectory.load(tmp_path / "nothing.json")


def test_a_refused_save_leaves_the_old_file(world, problem):
    before = problem.read_text()
    world.add_heuristic("mine", lambda q, goals: np.zeros(len(q)))
    world.make_planner("arm", {"heuristic": "mine"})
    with pytest.raises(srmp.InvalidArgument):
        world.save(problem)
    assert problem.read_text() == before
    assert list(problem.parent.iterdir()) == [problem]
    umask = os.umask(0)
    os.umask(umask)
    assert stat.S_IMODE(problem.stat().st_mode) == 0o666 & ~umask


# --- command line


def test_replay_says_same(problem):
    result = run("replay", problem)
    assert result.exit_code == 0, result.output
    assert result.output.startswith("the same: solved, Trajectory(7 joints")


def test_replay_says_where_it_differs(problem):
    content = json.loads(problem.read_text())
    content["result"]["trajectory"]["positions"][3][2] += 1e-15
    problem.write_text(json.dumps(content))
    result = run("replay", problem)
    assert result.exit_code == 1
    assert re.match(r"differs: positions, row 3, column 2 \(.+\): was \S+ and is \S+\n", result.output)
    content["result"].pop("trajectory")
    content["result"]["statistics"]["status"] = "exhausted"
    problem.write_text(json.dumps(content))
    result = run("replay", problem)
    assert (result.exit_code, result.output) == (1, "differs: the status was exhausted and is solved\n")


@pytest.mark.parametrize(
    ("part", "name", "value", "expected"),
    [
        ("statistics", "path_cost_rad", 0.1, r"statistics, path_cost_rad: was 0\.1 and is \d"),
        ("statistics", "bound", 1.5, r"statistics, bound: was 1\.5 and is \d"),
        ("certificate", "clearance", 99, r"certificate, clearance: was 99\.0 and is \d"),
        ("certificate", "body_a", "nothing", r'certificate, body_a: was "nothing" and is "'),
    ],
)
def test_replay_compares_what_is_said_of_the_path(problem, part, name, value, expected):
    content = json.loads(problem.read_text())
    result = content["result"]
    (result if part == "statistics" else result["trajectory"])[part][name] = value
    problem.write_text(json.dumps(content))
    output = run("replay", problem)
    assert output.exit_code == 1
    assert re.match("differs: " + expected, output.output)


@pytest.mark.parametrize("in_motion", [False, True])
def test_replay_keeps_constraints_and_starts_in_motion(arm, ready, tmp_path, in_motion):
    here = arm.compute_fk("arm", ready)
    upright = srmp.PathConstraint.cone([0, 0, 1], here.matrix()[:3, 2], 0.2)
    q = ready + np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    velocity = [0.3, 0, 0, 0, 0, 0, 0] if in_motion else None
    arm.plan("arm", ready, q, constraints=[upright], start_velocity=velocity)
    arm.save(tmp_path / "p.json")
    result = run("replay", tmp_path / "p.json")
    assert result.exit_code == 0, result.output
    assert result.output.startswith("the same: solved")


def test_replay_of_an_unsolved_problem(arm, ready, tmp_path):
    with pytest.raises(srmp.PlanningError):
        arm.plan("arm", ready, srmp.GoalConstraint(srmp.GoalType.POSITION, [9, 9, 9]))
    arm.save(tmp_path / "p.json")
    result = run("replay", tmp_path / "p.json")
    assert (result.exit_code, result.output) == (0, "the same: goal_invalid\n")


def test_replay_needs_a_result(world, problem):
    world.set_padding("table", 0.001)
    assert world.last_result is None
    world.save(problem)
    result = run("replay", problem)
    assert result.exit_code == 2
    assert "it holds no request with its result" in result.output


def test_plan_saves_what_replay_reads(tmp_path):
    examples = Path(__file__).parents[2] / "examples" / "moveit"
    arguments = ["--urdf", srmp.data_path("arm7.urdf"), "--srdf", srmp.data_path("arm7.srdf")]
    arguments += ["--end-effector", "arm7_hand", "--scene", examples / "scene.yaml"]
    arguments += ["--request", examples / "request.yaml", "-o", tmp_path / "plan.json"]
    result = run("plan", *arguments, "--save", tmp_path / "p.srmp.json")
    assert result.exit_code == 0, result.output
    assert srmp.Trajectory.load(tmp_path / "plan.json") == srmp.Trajectory.load(tmp_path / "p.srmp.json")
    assert run("replay", tmp_path / "p.srmp.json").exit_code == 0


def test_no_command_writes_over_what_it_reads_or_writes(tmp_path):
    examples = Path(__file__).parents[2] / "examples" / "moveit"
    request, urdf = tmp_path / "request.yaml", tmp_path / "arm.urdf"
    request.write_bytes((examples / "request.yaml").read_bytes())
    urdf.write_bytes(Path(srmp.data_path("arm7.urdf")).read_bytes())
    arguments = ["plan", "--urdf", urdf, "--srdf", srmp.data_path("arm7.srdf"), "--request", request]
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    link = tmp_path / "link.yaml"
    link.symlink_to(request)
    cases = [
        ([*arguments, "-o", request], "--output is the file that --request reads"),
        ([*arguments, "-o", link], "--output is the file that --request reads"),
        ([*arguments, "-o", tmp_path / "." / "arm.urdf"], "--output is the file that --urdf reads"),
        (
            [*arguments, "-o", tmp_path / "p.json", "--save", tmp_path / "p.json"],
            "--save is the file that --output writes",
        ),
        (["srdf", urdf, "-o", urdf], "--output is the file that URDF reads"),
    ]
    for case, expected in cases:
        result = run(*case)
        assert result.exit_code == 2
        assert expected in " ".join(result.output.split())
    link.unlink()
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_what_is_made_whole_is_there_completely_or_not_at_all(tmp_path):
    path, part = tmp_path / "set", tmp_path / "set.part"
    part.mkdir()
    (part / "left by a killed run").touch()
    with whole(path) as made:
        assert not made.exists()
        made.mkdir()
        (made / "a").write_text("1")
        assert not path.exists()
    assert [item.name for item in path.iterdir()] == ["a"]
    with pytest.raises(KeyboardInterrupt), whole(tmp_path / "file") as made:
        made.write_text("half")
        raise KeyboardInterrupt
    write_bytes(tmp_path / "bytes", b"1")
    write_bytes(tmp_path / "bytes", b"2")
    assert (tmp_path / "bytes").read_bytes() == b"2"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["bytes", "set"]
