"""Verify: any trajectory is verified in a scene, against limits, start and goals."""

import json
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp._files import write_json
from srmp.cli import main
from srmp.result import plan_result


@pytest.fixture
def solved(arm, ready):
    """The arm, a plan around the post, and the goal it reaches."""
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, ready - [1.8, 0, 0, 0, 0, 0, 0])
    return arm, arm.plan("arm", ready, goal), goal


def kinds(certificate):
    return [fault.kind for fault in certificate.faults]


def test_a_plan_holds(solved, ready):
    arm, plan, goal = solved
    certificate = arm.verify("arm", plan, start=ready, goals=goal, max_deviation=0.005)
    assert certificate.holds, certificate.report()
    assert certificate.proved_free
    assert certificate.goal_error < 1e-9
    assert certificate.limits == arm.motion_limits("arm")
    # made by the same code as the plan's own, which also knows the search
    assert certificate.clearance == plan.certificate.clearance
    assert certificate.velocity == plan.certificate.velocity
    assert pickle.loads(pickle.dumps(certificate)) == certificate


def test_faults_are_named(solved, ready):
    arm, plan, goal = solved
    slow = srmp.MotionLimits([0.1] * 7, [10.0] * 7, [1000.0] * 7)
    assert set(kinds(arm.verify("arm", plan, limits=slow))) == {srmp.FaultKind.velocity_limit}
    jerky = srmp.MotionLimits([9.0] * 7, [90.0] * 7, [1e-3] * 7)
    assert arm.verify("arm", plan, limits=jerky).holds
    assert set(kinds(arm.verify("arm", plan, limits=jerky, jerk=True))) == {srmp.FaultKind.jerk_limit}
    assert kinds(arm.verify("arm", plan, start=ready + 0.01)) == [srmp.FaultKind.start]
    elsewhere = srmp.GoalConstraint(srmp.GoalType.JOINTS, ready)
    assert kinds(arm.verify("arm", plan, goals=elsewhere)) == [srmp.FaultKind.goal]
    assert arm.verify("arm", plan, goals=[elsewhere, goal]).holds
    straight = srmp.Trajectory(plan.joint_names, plan.positions[[0, -1]], plan.times[[0, -1]])
    assert srmp.FaultKind.collision in kinds(arm.verify("arm", straight))
    assert kinds(arm.verify("arm", plan, max_deviation=0.0)) == [srmp.FaultKind.deviation]


def test_the_scene_counts_as_it_is(solved):
    arm, plan, _ = solved
    arm.add_sphere("in the way", 0.05, arm.compute_fk("arm", plan.sample(plan.duration / 2)))
    certificate = arm.verify("arm", plan)
    assert kinds(certificate) == [srmp.FaultKind.collision]
    assert not certificate.proved_free
    assert "proved free    no: it collides" in certificate.report()
    assert "in the way" in certificate.faults[0].text


@pytest.mark.parametrize("far", [1e9, 2.0**70, 1e99])
def test_motions_that_no_robot_makes_are_verified_too(arm, ready, far):
    q = np.array([ready, ready])
    q[0, 0] = far
    certificate = arm.verify("arm", srmp.Trajectory(arm.get_joint_names("arm"), q, [0, 3], np.zeros((2, 7))))
    assert srmp.FaultKind.position_limit in kinds(certificate)
    assert not certificate.proved_free  # the proof crashed: it halved parts without end


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"start": [0, 0]}, "start of 'arm'"),
        ({"goals": srmp.GoalConstraint(srmp.GoalType.JOINTS, [0, 0])}, "goal of 'arm'"),
        ({"goals": []}, "a goal must be a GoalConstraint, a Pose,"),
        ({"limits": srmp.MotionLimits([1], [1], [1])}, "velocity limits: got 1, but there are 7 joints"),
        ({"max_deviation": -1}, "max_deviation is -1; it must be 0 m or above"),
        ({"max_deviation": np.nan}, "max_deviation is NaN"),
        ({"gap_tolerance": 0}, "gap_tolerance is 0; it must be above 0 and below 1"),
        ({"gap_tolerance": 1}, "gap_tolerance is 1"),
    ],
)
def test_invalid_arguments_are_refused(solved, arguments, text):
    arm, plan, _ = solved
    with pytest.raises(srmp.InvalidArgument) as error:
        arm.verify("arm", plan, **arguments)
    assert text in str(error.value)


def test_the_gil_is_released(solved):
    arm, plan, _ = solved
    done = threading.Event()
    other = threading.Thread(target=done.set)
    certificates = []
    checker = threading.Thread(target=lambda: certificates.append(arm.verify("arm", plan)))
    checker.start()
    other.start()
    checker.join()
    other.join()
    assert done.is_set()
    assert certificates[0].holds


# --- srmp.verify ------------------------------------------------------------------------------------------------------


def test_scenes_and_problems_are_files_too(solved, tmp_path):
    arm, plan, _ = solved
    arm.save(tmp_path / "problem.json")
    arm.save_scene(tmp_path / "scene.json")
    assert srmp.verify(arm, plan).holds
    assert np.isnan(srmp.verify(str(tmp_path / "scene.json"), plan).goal_error)
    assert srmp.verify(tmp_path / "problem.json", plan).goal_error < 1e-9


def test_the_request_of_a_problem_file_is_used_too(solved, ready, tmp_path):
    arm, plan, _ = solved
    arm.save(tmp_path / "problem.json")
    half = plan.slice(0, plan.duration / 2)
    found = srmp.verify(tmp_path / "problem.json", half, "arm")
    assert kinds(found) == [srmp.FaultKind.not_at_rest, srmp.FaultKind.goal]
    here = srmp.GoalConstraint(srmp.GoalType.JOINTS, half.positions[-1])
    assert kinds(srmp.verify(tmp_path / "problem.json", half, goals=here)) == [srmp.FaultKind.not_at_rest]
    assert srmp.FaultKind.start in kinds(srmp.verify(tmp_path / "problem.json", plan, start=ready + 0.01))


def test_the_robot_is_the_one_with_these_joints(solved):
    arm, plan, _ = solved
    turned = srmp.Trajectory(plan.joint_names[::-1], plan.positions[:, ::-1], plan.times)
    assert kinds(srmp.verify(arm, turned)) == [srmp.FaultKind.joint_names]
    renamed = srmp.Trajectory(list("abcdefg"), plan.positions, plan.times)
    assert kinds(srmp.verify(arm, renamed)) == [srmp.FaultKind.joint_names]  # of the only robot
    urdf = srmp.data_path("arm7.urdf")
    arm.add_articulation(urdf, name="twin", end_effector="arm7_hand", base_pose=srmp.Pose(p=[0, 3, 0]))
    assert srmp.verify(arm, plan, "arm").holds
    with pytest.raises(srmp.InvalidArgument, match=r"name the robot .*: 'arm', 'twin' all have its joints"):
        srmp.verify(arm, plan)
    with pytest.raises(srmp.InvalidArgument, match="'arm', 'twin' do not have its joints"):
        srmp.verify(arm, renamed)
    with pytest.raises(srmp.InvalidArgument, match="unknown robot 'amr'"):
        srmp.verify(arm, plan, "amr")
    with pytest.raises(srmp.InvalidArgument, match="the scene has no robot"):
        srmp.verify(srmp.PlannerInterface(), plan)


def test_files_that_are_not_scenes_are_refused(solved, tmp_path):
    _, plan, _ = solved
    plan.save(tmp_path / "plan.json")
    with pytest.raises(srmp.FileError, match="the format is 'srmp trajectory'; expected is"):
        srmp.verify(tmp_path / "plan.json", plan)
    with pytest.raises(srmp.FileError, match="there is no such file"):
        srmp.verify(tmp_path / "nowhere.json", plan)


# --- files and the command line ---------------------------------------------------------------------------------------


def srmp_command(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


ROBOT = (
    *("--urdf", srmp.data_path("arm7.urdf")),
    *("--srdf", srmp.data_path("arm7.srdf"), "--end-effector", "arm7_hand"),
)
MOVEIT = Path(__file__).parents[2] / "examples" / "moveit"
SCENE, REQUEST = ("--scene", MOVEIT / "scene.yaml"), ("--request", MOVEIT / "request.yaml")


def test_certificates_are_saved_bit_for_bit(solved, tmp_path):
    arm, plan, _ = solved
    plan.save(tmp_path / "t.json")
    arm.save(tmp_path / "p.json")
    write_json(tmp_path / "r.json", plan_result(arm.get_planning_stats(), plan.joint_names, plan))
    for name in ("t.json", "p.json", "r.json"):
        assert srmp.Trajectory.load(tmp_path / name).certificate == plan.certificate, name


def test_a_certificate_is_plain_data(solved):
    _, plan, _ = solved
    data = plan.certificate.to_dict()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["faults"] == []
    assert data["velocity"] == {
        "fraction": plan.certificate.velocity.fraction,
        "joint": plan.certificate.velocity.joint,
        "time": plan.certificate.velocity.time,
    }
    assert data["limits"]["velocity"] == plan.certificate.limits.velocity.tolist()
    fields = {name for name in dir(srmp.Certificate) if not name.startswith("_")}
    assert set(data) == fields - {"holds", "proved_free", "report", "to_dict"} - {
        "cartesian_deviation",
        "constraints",
        "clearance_kept",
        "link_speeds",
        "torque",
    }  # no poses, no path constraints, no clearance required, no speed of a link or torque limited: no keys


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """What `srmp plan` wrote."""
    directory = tmp_path_factory.mktemp("plan")
    arguments = ("-o", directory / "plan.json", "--save", directory / "problem.json")
    result = srmp_command("plan", *ROBOT, *SCENE, *REQUEST, *arguments)
    assert result.exit_code == 0, result.output
    return directory, result.output


def test_plan_writes_and_tells_the_certificate(planned):
    directory, output = planned
    certificate = srmp.Trajectory.load(directory / "plan.json").certificate
    assert certificate == srmp.PlannerInterface.load(directory / "problem.json").last_result.trajectory.certificate
    assert "certificate: holds, proved free, clearance " in output
    assert f"{certificate.clearance * 1e3:.3g} mm" in output


def test_verify_takes_plans_and_problems(planned, tmp_path):
    directory, _ = planned
    world = srmp.PlannerInterface.load(directory / "problem.json")
    world.save_scene(tmp_path / "scene.json")
    srmp.Trajectory.load(directory / "plan.json").save(tmp_path / "t.json")
    for arguments in (
        (directory / "problem.json",),
        (directory / "plan.json", "--scene", directory / "problem.json"),
        (directory / "plan.json", "--scene", tmp_path / "scene.json", *REQUEST),
        (tmp_path / "t.json", *ROBOT, *SCENE, *REQUEST),
        (tmp_path / "t.json", *ROBOT),
    ):
        result = srmp_command("verify", *arguments)
        assert result.exit_code == 0, result.output
        assert "velocities     " in result.output
        assert result.output.splitlines()[-1].startswith("holds, proved free, clearance ")


def test_verify_names_every_fault(planned, tmp_path):
    directory, _ = planned
    limits = tmp_path / "joint_limits.yaml"
    limits.write_text("joint_limits: {arm7_joint1: {max_velocity: 1.0e-3, max_acceleration: 1.0e-3}, finger: {}}")
    result = srmp_command("verify", directory / "problem.json", "--joint-limits", limits)
    assert result.exit_code == 1
    assert "FAULT velocity_limit: arm7_joint1: the velocity reaches" in result.output
    assert "FAULT acceleration_limit: arm7_joint1: " in result.output
    assert "also limits finger, which are not planned joints of the robot" in result.output
    assert result.output.splitlines()[-1] == "2 faults: velocity_limit, acceleration_limit"
    motion = srmp.Trajectory.load(directory / "plan.json")
    motion.slice(0, motion.duration / 2).save(tmp_path / "half.json")
    half = srmp_command("verify", tmp_path / "half.json", "--scene", directory / "problem.json")
    assert half.exit_code == 1
    assert half.output.splitlines()[-1] == "2 faults: not_at_rest, goal"
    slice_ = srmp_command("verify", tmp_path / "half.json", "--scene", directory / "problem.json", "--in-motion")
    assert slice_.output.splitlines()[-1] == "1 fault: goal"
    assert srmp_command("verify", directory / "problem.json", "--max-deviation", 0.005).exit_code == 0
    jerk = srmp_command("verify", directory / "problem.json", "--jerk")
    assert jerk.exit_code == (0 if motion.certificate.jerk.fraction <= 1 else 1)


def test_joint_limits_make_plans_slower(planned, tmp_path):
    directory, _ = planned
    limits = tmp_path / "joint_limits.yaml"
    limits.write_text("default_velocity_scaling_factor: 0.2\njoint_limits: {finger: {}}")
    arguments = ("-o", tmp_path / "slow.json", "--joint-limits", limits)
    result = srmp_command("plan", *ROBOT, *SCENE, *REQUEST, *arguments)
    assert result.exit_code == 0, result.output
    assert "also limits finger" in result.output
    slow = srmp.Trajectory.load(tmp_path / "slow.json")
    assert slow.duration > 1.5 * srmp.Trajectory.load(directory / "plan.json").duration
    assert slow.certificate.limits.velocity[0] == 0.2 * 2.2


def test_plan_keeps_the_speed_that_the_request_allows(tmp_path):
    request = tmp_path / "request.yaml"
    request.write_text((MOVEIT / "request.yaml").read_text() + "\nmax_cartesian_speed: 0.1\n")
    result = srmp_command("plan", *ROBOT, *SCENE, "--request", request, "-o", tmp_path / "plan.json")
    assert result.exit_code == 0, result.output
    (use,) = srmp.Trajectory.load(tmp_path / "plan.json").certificate.link_speeds
    assert 0.09 < use.speed <= 0.1


def test_a_damaged_problem_file_is_what_is_wrong(planned, tmp_path):
    damaged = tmp_path / "damaged.srmp.json"
    content = json.loads((planned[0] / "problem.json").read_text())
    content["scene"]["robots"][0]["name"] = 7
    damaged.write_text(json.dumps(content))
    result = srmp_command("verify", damaged)
    assert result.exit_code == 2
    assert "--scene" not in result.output


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["nowhere.json"], "nowhere.json"),
        (["PLAN"], "; say with --scene what the trajectory is to be verified against"),
        (["PLAN", "--scene", MOVEIT / "scene.yaml"], "a MoveIt scene needs its robot too: --urdf"),
        (["PLAN", "--srdf", srmp.data_path("arm7.srdf")], "for the robot of --urdf, which is not given"),
        (["PROBLEM", "--robot", "amr"], "unknown robot 'amr'"),
        (["PROBLEM", "--max-deviation", "-1"], "max_deviation is -1"),
        (["PROBLEM", "--joint-limits", MOVEIT / "scene.yaml"], "in a joint limits file"),
        ([srmp.data_path("arm7.urdf")], "arm7.urdf"),
    ],
)
def test_wrong_calls_end_in_one_sentence(planned, arguments, text):
    directory, _ = planned
    files = {"PLAN": directory / "plan.json", "PROBLEM": directory / "problem.json"}
    result = srmp_command("verify", *(files.get(argument, argument) for argument in arguments))
    assert result.exit_code == 2
    assert text in result.output
    assert "Traceback" not in result.output


def test_path_constraints_are_verified_as_plans_prove_them(arm_alone):
    start = np.array([0.0, 0.4, 0.0, -1.6, 0.0, 1.0, 0.0])
    here = arm_alone.compute_fk("arm", start)
    beside = srmp.Pose(p=here.p + np.array([-0.05, 0.3, 0.1]), q=here.q)
    axis = np.asarray(here.matrix())[:3, 2]
    upright = srmp.PathConstraint.cone([0, 0, 1], axis, np.radians(5))
    kept = arm_alone.plan("arm", start, beside, constraints=[upright])
    certificate = arm_alone.verify("arm", kept, constraints=[upright])
    assert certificate.holds, certificate.report()
    assert certificate.constraints == kept.certificate.constraints
    assert arm_alone.verify("arm", kept).constraints == []
    tight = srmp.PathConstraint.cone([0, 0, 1], axis, 1e-4)
    broken = arm_alone.verify("arm", kept, constraints=[upright, tight])
    assert kinds(broken) == [srmp.FaultKind.constraint]
    assert [c.tolerance for c in broken.constraints] == pytest.approx([np.radians(5), 1e-4])


def test_a_clearance_is_verified_as_plans_prove_it(arm, ready):
    goal = srmp.GoalConstraint(srmp.GoalType.JOINTS, ready - [1.8, 0, 0, 0, 0, 0, 0])
    arm.make_planner("arm", {"planner_id": "auto", "clearance": 0.02})
    plan = arm.plan("arm", ready, goal)
    certificate = arm.verify("arm", plan, clearance=0.02)
    assert certificate.holds, certificate.report()
    assert certificate.clearance_kept == plan.certificate.clearance_kept
    assert arm.verify("arm", plan).clearance_kept is None
    more = arm.verify("arm", plan, clearance=plan.certificate.clearance + 0.02)
    assert kinds(more) == [srmp.FaultKind.clearance]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"clearance": -0.01}, "clearance is -0.01; it must be 0 m or above"),
        ({"clearance": float("nan")}, "clearance is NaN; it must be 0 m or above"),
        (
            {"constraints": [srmp.PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1, link="arm7_hnd")]},
            "'arm7_hnd'.*did you mean 'arm7_hand'",
        ),
    ],
)
def test_bad_constraints_and_clearances_are_refused(solved, arguments, message):
    arm, plan, _ = solved
    with pytest.raises(srmp.InvalidArgument, match=message):
        arm.verify("arm", plan, **arguments)
