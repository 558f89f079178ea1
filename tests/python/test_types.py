"""The type stubs: complete, and right for a user's program."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import srmp
from srmp import _srmp
from srmp._authors_words import Missing

STUBS = Path(srmp.__file__).parent / "_srmp.pyi"

USER_PROGRAM = """
import numpy as np
from numpy.typing import NDArray

import srmp


def plan(q: NDArray[np.float64]) -> srmp.Trajectory | str:
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), name="arm", end_effector="arm7_hand")
    planner.add_box("post", size=[0.1, 0.1, 0.8], pose=srmp.Pose(p=[0.3, 0, 0.4]))
    planner.add_point_cloud("cloud", points=np.zeros((3, 3)), resolution=0.01)
    planner.make_planner(["arm"], {"planner_id": "wAstar", "time_limit": "5", "weight": 10})
    planner.make_planner("arm", srmp.WAStar(weight=10, heuristic="bfs"))
    ranges: dict[str, str] = {option.name: option.range for option in srmp.planner_info("wAstar").options}
    planner.add_heuristic("mine", lambda configurations, goals: configurations[:, 0] * goals[0, 0], consistent=True)
    goal = srmp.GoalConstraint(srmp.GoalType.POSE, list(srmp.Pose([0.6, 0, 0.5])))
    try:
        trajectory = planner.plan("arm", q, [goal, srmp.GoalConstraint(srmp.GoalType.JOINTS, q)])
        planner.plan("arm", q, ["ready", q])
        planner.plan("arm", q, ["ready", srmp.Pose([0.6, 0, 0.5])])
    except srmp.PlanningError as error:
        return f"{error.status.name}: {error}"
    except (srmp.InvalidArgument, srmp.FileError, srmp.NotSupported) as error:
        return str(error)
    positions: NDArray[np.float64] = trajectory.positions
    samples: NDArray[np.float64] = trajectory.sample([0, 0.5])
    both: srmp.Trajectory = trajectory.slice(0, 1) + srmp.Trajectory.from_dict(trajectory.to_dict())[1:]
    tip: NDArray[np.float64] = both.resample(0.1).end_effector_path(planner, "arm", link="arm7_hand")
    both.plot("profile.png", limits=srmp.MotionLimits(samples[0], samples[1], [1.0] * 7))
    if trajectory.certificate is not None and trajectory.certificate.faults:
        print(tip, trajectory.certificate.faults[0].kind is srmp.FaultKind.goal, trajectory.certificate.report())
    planner.set_motion_limits("arm", velocity=1.5, acceleration=q, jerk={"arm7_joint1": 30})
    unused: list[str] = planner.load_joint_limits("arm", "joint_limits.yaml")
    timed = srmp.time_parameterize(
        positions, planner.get_joint_names("arm"), srmp.default_limits(q), method="ruckig", is_free=lambda a, b: True
    )
    limits: srmp.MotionLimits = planner.motion_limits("arm")
    certificate: srmp.Certificate = srmp.verify(planner, timed, start=q, goals=[goal], limits=limits)
    if not planner.verify("arm", timed, jerk=True, max_deviation=0.01).holds:
        print(unused, certificate.to_dict()["clearance"])
    solutions: NDArray[np.float64] = planner.compute_ik("arm", planner.compute_fk("arm", positions[-1]))
    numbers: list[float] = [x for x in srmp.Pose() @ srmp.Pose()]
    assert len(solutions) + len(numbers) + len(ranges) + planner.get_planning_stats()["expansions"]
    for result in planner.plan_many([srmp.PlanRequest("arm", q, goal, srmp.Auto())], threads=2, progress=print):
        length: float = result.trajectory.length if result.solved else result.statistics["search_time_s"]
        print(length, result.status.name, result.reason)
    for contact in planner.contacts("arm", q):
        print(contact.body_a, contact.distance, contact.point_a[0], srmp.Status.solved, srmp.__version__)
    return trajectory
"""


def test_stubs_know_every_public_name():
    tree = ast.parse(STUBS.read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    for name, value in vars(_srmp).items():
        if name.startswith("_"):
            continue
        assert name in (classes if inspect.isclass(value) else functions), name
        if not inspect.isclass(value) or issubclass(value, Exception):
            continue
        members = {getattr(node, "name", None) for node in classes[name].body}
        members |= {
            node.targets[0].id
            for node in classes[name].body
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
        }
        known = {member for member, is_ in vars(value).items() if not isinstance(is_, Missing)}
        assert {member for member in known if not member.startswith(("_", "@"))} <= members, name


def test_every_public_method_has_a_docstring():
    named = ("Pose", "GoalConstraint", "Trajectory", "PlannerInterface", "Contact", "PlanRequest", "PlanResult")
    many = ("MultiTrajectory", "MultiPlanRequest", "MultiPlanResult")
    parts = ("Certificate", "Fault", "LimitUse", "MotionLimits", "SampledInterval")
    registry = ("PlannerInfo", "OptionInfo")
    for cls in (getattr(srmp, name) for name in (*named, *many, *parts, *registry)):
        assert cls.__doc__
        for name, member in vars(cls).items():
            if not name.startswith("_"):
                assert (member.__doc__ or "").strip(), f"{cls.__name__}.{name}"


@pytest.mark.parametrize("strict", [False, True])
def test_a_users_program_is_clean(tmp_path, strict):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(USER_PROGRAM)
    cache = f"--cache-dir={tmp_path / 'cache'}"
    command = [sys.executable, "-m", "mypy", cache, *(["--strict"] if strict else []), str(program)]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr
