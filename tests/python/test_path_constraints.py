"""Path constraints of plan: what docs/path-constraints.md says of each type, and every bad argument."""

import pickle

import numpy as np
import pytest

import srmp
from srmp import PathConstraint, Pose

START = [0.0, 0.4, 0.0, -1.6, 0.0, 1.0, 0.0]
AWAY = [0.5, 0.3, 0.6]  # what the goals of these tests ask of the first three joints, besides the constraint
TOLERANCE = np.radians(5)


def rotation(pose):
    return np.asarray(pose.matrix())[:3, :3]


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def sampled(planner, motion, link=""):
    """Poses of the link every millisecond."""
    times = np.append(np.arange(0, motion.duration, 1e-3), motion.duration)
    return [planner.compute_fk("arm", motion.sample(t), link) for t in times]


@pytest.fixture
def here(arm_alone):
    return arm_alone.compute_fk("arm", START)


@pytest.fixture
def goal(here):
    """Beside the start, and turned about the vertical."""
    return Pose(p=here.p + np.array([-0.05, 0.3, 0.1]), q=here.q)


def constraints_at(here):
    """Each type, as the start and the goal keep it, and how much of its tolerance a pose uses."""
    z = rotation(here)[:, 2]
    line = np.array([-0.05, 0.3, 0.1]) / np.linalg.norm([-0.05, 0.3, 0.1])
    normal = np.cross(line, [0, 0, 1.0])
    normal /= np.linalg.norm(normal)
    centre = here.p + np.array([-0.025, 0.15, 0.05])
    off = np.linalg.norm(here.p - centre)

    def of_rotation(pose):
        return 2 * np.arctan2(np.linalg.norm((here.inverse() @ pose).q[:3]), abs((here.inverse() @ pose).q[3]))

    return {
        "cone": (
            PathConstraint.cone([0, 0, 1], z, TOLERANCE),
            lambda pose: angle(rotation(pose)[:, 2], z) / TOLERANCE,
        ),
        "orientation": (PathConstraint.orientation(here.q, 0.1), lambda pose: of_rotation(pose) / 0.1 / np.sqrt(3)),
        "pose": (
            PathConstraint.pose(here, [np.inf, np.inf, np.inf], 0.1),
            lambda pose: of_rotation(pose) / 0.1 / np.sqrt(3),
        ),
        "box": (
            PathConstraint.box([0.2, 0.5, 0.2], Pose(p=centre)),
            lambda pose: (np.abs(pose.p - centre) / [0.1, 0.25, 0.1]).max(),
        ),
        "plane": (
            PathConstraint.plane(here.p, normal, 0.01),
            lambda pose: abs((pose.p - here.p) @ normal) / 0.01,
        ),
        "line": (
            PathConstraint.line(here.p, line, 0.02),
            lambda pose: np.linalg.norm(np.cross(pose.p - here.p, line)) / 0.02,
        ),
        "distance": (
            PathConstraint.distance(centre, off - 0.03, off + 0.03),
            lambda pose: abs(np.linalg.norm(pose.p - centre) - off) / 0.03,
        ),
    }


TYPES = ["cone", "orientation", "pose", "box", "plane", "line", "distance"]


@pytest.mark.parametrize("kind", TYPES)
def test_each_type_is_kept_at_every_instant(arm_alone, here, goal, kind):
    constraint, used = constraints_at(here)[kind]
    assert constraint.type == kind
    motion = arm_alone.plan("arm", START, goal, constraints=[constraint])
    (kept,) = motion.certificate.constraints
    assert motion.certificate.holds
    assert motion.certificate.proved_free
    assert 0 < kept.deviation <= kept.tolerance * (1 + 1e-6)
    assert max(map(used, sampled(arm_alone, motion))) <= kept.deviation / kept.tolerance + 1e-6
    assert "constraint     " in motion.certificate.report()
    again = arm_alone.plan(START, goal, constraints=[constraint])
    np.testing.assert_array_equal(again.positions, motion.positions)


@pytest.mark.parametrize("planner_id", ["wAstar", "ARAstar", "MHAstar", "RRTConnect"])
def test_the_planner_that_is_named_keeps_constraints_too(arm_alone, here, goal, planner_id):
    constraint, used = constraints_at(here)["cone"]
    arm_alone.make_planner("arm", {"planner_id": planner_id, "time_limit": 20.0})
    motion = arm_alone.plan("arm", START, goal, constraints=[constraint])
    assert max(map(used, sampled(arm_alone, motion))) <= 1


def test_a_wall_is_passed_upright(arm_alone, here, goal):
    constraint, used = constraints_at(here)["cone"]
    arm_alone.add_box("wall", size=[0.3, 0.02, 0.25], pose=Pose(p=here.p + np.array([0.0, 0.15, -0.05])))
    free = arm_alone.plan("arm", START, goal)
    motion = arm_alone.plan("arm", START, goal, constraints=[constraint])
    assert motion.certificate.proved_free
    assert max(map(used, sampled(arm_alone, motion))) <= 1
    assert free.certificate.constraints == []


def test_relative_poses_and_held_objects(arm_alone, here, goal):
    arm_alone.set_qpos("arm", START)
    arm_alone.add_box("cup", size=[0.02, 0.02, 0.02], pose=Pose(p=here.p + rotation(here)[:, 2] * 0.1, q=here.q))
    links = arm_alone.get_link_names("arm")
    arm_alone.attach_object("cup", "arm", links[-1])
    up = rotation(here)[:, 2]
    cup = PathConstraint.cone([0, 0, 1], up, TOLERANCE, link="cup")
    elbow = arm_alone.compute_fk("arm", START, links[3])
    relative = elbow.inverse() @ here
    near = PathConstraint.distance(relative.p, 0.0, 0.5, frame=links[3])
    motion = arm_alone.plan("arm", START, goal, constraints=[cup, near])
    assert len(motion.certificate.constraints) == 2
    for q in (motion.sample(t) for t in np.arange(0, motion.duration, 1e-3)):
        hand, frame = arm_alone.compute_fk("arm", q), arm_alone.compute_fk("arm", q, links[3])
        assert angle(rotation(hand)[:, 2], up) <= TOLERANCE
        assert np.linalg.norm((frame.inverse() @ hand).p - relative.p) <= 0.5


def test_starts_and_goals_that_break_a_constraint_say_by_how_much(arm_alone, here, goal):
    aside = PathConstraint.cone([0, 0, 1], rotation(here)[:, 0], TOLERANCE)
    with pytest.raises(srmp.PlanningError, match=r"start is invalid.*off by 90 degrees, 5 degrees") as caught:
        arm_alone.plan("arm", START, goal, constraints=[aside])
    assert caught.value.status == srmp.Status.start_invalid
    near = PathConstraint.box([0.1, 0.1, 0.1], Pose(p=here.p))
    for target in (goal, arm_alone.plan("arm", START, goal).positions[-1]):
        with pytest.raises(srmp.PlanningError, match=r"goal is invalid.*off by 300 mm") as caught:
            arm_alone.plan("arm", START, target, constraints=[near])
        assert caught.value.status == srmp.Status.goal_invalid


def test_requests_certificates_and_constraints_are_kept(arm_alone, here, goal, tmp_path):
    constraint, _ = constraints_at(here)["cone"]
    motion = arm_alone.plan("arm", START, goal, constraints=[constraint])
    assert arm_alone.last_request.constraints == [constraint]
    assert motion.certificate.to_dict()["constraints"][0]["deviation"] <= TOLERANCE
    request = srmp.PlanRequest("arm", START, goal, constraints=[constraint])
    assert pickle.loads(pickle.dumps(request)) == request
    assert pickle.loads(pickle.dumps(motion)).certificate == motion.certificate
    (result,) = arm_alone.plan_many([request], threads=1)
    np.testing.assert_array_equal(result.trajectory.positions, motion.positions)
    arm_alone.save(str(tmp_path / "problem.json"))
    loaded = srmp.PlannerInterface.load(str(tmp_path / "problem.json"))
    assert loaded.last_request.constraints == [constraint]
    assert loaded.last_result.trajectory.certificate == motion.certificate


BAD = {
    "tolerance of a cone": lambda: PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.0),
    "below 3.14": lambda: PathConstraint.cone([0, 0, 1], [0, 0, 1], 4.0),
    "length 0": lambda: PathConstraint.cone([0, 0, 0], [0, 0, 1], 0.1),
    "3": lambda: PathConstraint.cone([0, 1], [0, 0, 1], 0.1),
    "4 numbers": lambda: PathConstraint.orientation([0, 0, 1], 0.1),
    "leaves every axis free": lambda: PathConstraint.orientation([0, 0, 0, 1], np.inf),
    "rotation_tolerance": lambda: PathConstraint.orientation([0, 0, 0, 1], -1.0),
    "half the size": lambda: PathConstraint.box([0.1, -0.1, 0.1], Pose()),
    "tolerance of a plane": lambda: PathConstraint.plane([0, 0, 0], [0, 0, 1], 0.0),
    "tolerance of a line": lambda: PathConstraint.line([0, 0, 0], [0, 0, 1], np.nan),
    "between 0.3 m and 0.2 m": lambda: PathConstraint.distance([0, 0, 0], 0.3, 0.2),
    "one number or three": lambda: PathConstraint.pose(Pose(), [0.1, 0.1], 0.1),
}


@pytest.mark.parametrize("words", BAD)
def test_bad_constraints_are_refused(words):
    with pytest.raises(srmp.Error, match=words):
        BAD[words]()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"link": "arm7_hnd"}, "did you mean 'arm7_hand'"),
        ({"link": "arm7_base"}, "no planned joint of 'arm' changes it"),
        ({"frame": "arm7_hand"}, "no planned joint of 'arm' changes it"),
        ({"frame": "arm7_hnd"}, "did you mean 'arm7_hand'"),
        ({"frame": "other/link"}, "other"),
        ({"link": "table"}, "which 'arm' does not hold"),
    ],
)
def test_constraints_that_cannot_be_placed_change_nothing(arm_alone, goal, arguments, words):
    arm_alone.add_box("table", size=[0.1, 0.1, 0.1], pose=Pose(p=[-0.5, -0.5, 0]))
    before = arm_alone.plan("arm", START, goal)
    with pytest.raises(srmp.InvalidArgument, match=words):
        arm_alone.plan("arm", START, goal, constraints=[PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1, **arguments)])
    assert arm_alone.last_result.trajectory == before
