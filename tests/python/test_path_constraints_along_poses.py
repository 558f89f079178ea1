"""Path constraints of motions along poses: random worlds by Pinocchio alone, and every bad argument."""

import pickle

import numpy as np
import pytest
from clearance_worlds import Measured, add, make_arms, random_objects
from support import READY, refuses

import srmp
from srmp import PathConstraint, Pose, Segment

ELBOW, HAND = "arm7_forearm", "arm7_hand"


class Places:
    """Of the arm's links, by Pinocchio alone; the arm's base is at the origin."""

    def __init__(self):
        self.pin = pytest.importorskip("pinocchio")
        self.model = self.pin.buildModelFromUrdf(srmp.data_path("arm7.urdf"))
        self.data = self.model.createData()

    def along(self, motion, link):
        """Position and rotation every 2 ms."""
        frame, q = self.model.getFrameId(link), self.pin.neutral(self.model)
        assert frame < len(self.model.frames)
        for t in np.append(np.arange(0, motion.duration, 2e-3), motion.duration):
            for name, value in zip(motion.joint_names, motion.sample(t), strict=True):
                q[self.model.joints[self.model.getJointId(name)].idx_q] = value
            self.pin.framesForwardKinematics(self.model, self.data, q)
            yield self.data.oMf[frame].translation.copy(), self.data.oMf[frame].rotation.copy()


def moved(pose, by):
    return Pose(p=pose.p + by, q=pose.q)


def rotation(pose):
    return np.asarray(pose.matrix())[:3, :3]


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def constraints_at(elbow):
    """Of the elbow, and how much of each tolerance a place uses."""
    z, centre = rotation(elbow)[:, 2], elbow.p - [0.1, 0, 0]
    off = np.linalg.norm(elbow.p - centre)
    return {
        "cone": (
            PathConstraint.cone([0, 0, 1], z, np.radians(10), link=ELBOW),
            lambda p, r: angle(r[:, 2], z) / np.radians(10),
        ),
        "box": (
            PathConstraint.box([0.08, 0.04, 0.08], Pose(p=elbow.p), link=ELBOW),
            lambda p, r: (np.abs(p - elbow.p) / [0.04, 0.02, 0.04]).max(),
        ),
        "distance": (
            PathConstraint.distance(centre, off - 0.02, off + 0.02, link=ELBOW),
            lambda p, r: abs(np.linalg.norm(p - centre) - off) / 0.02,
        ),
        "plane": (
            PathConstraint.plane(elbow.p, [0, 1, 0], 0.01, link=ELBOW),
            lambda p, r: abs(p[1] - elbow.p[1]) / 0.01,
        ),
    }


@pytest.mark.parametrize("kind", ["cone", "box", "distance", "plane"])
@pytest.mark.parametrize("seed", range(2))
def test_lines_in_random_worlds_keep_them(suite, seed, kind):
    rng = np.random.default_rng(500 + seed)
    objects = random_objects(rng, 4)
    planner = make_arms()
    for item in objects:
        add(planner, item)
    planner.make_planner("arm", {"time_limit": 5.0})
    measured, places = Measured(suite, objects), Places()
    solved = broken_without = 0
    for _ in range(12):
        start = READY + rng.uniform(-0.5, 0.5, 7)
        if planner.is_state_colliding("arm", start):
            continue
        goal = moved(planner.compute_fk("arm", start), rng.uniform(-0.15, 0.15, 3))
        constraint, used = constraints_at(planner.compute_fk("arm", start, ELBOW))[kind]
        try:
            motion = planner.plan_linear("arm", start, goal, constraints=[constraint])
        except srmp.PlanningError as error:
            assert error.status in (srmp.Status.exhausted, srmp.Status.goal_invalid, srmp.Status.timed_out)
            continue
        solved += 1
        (kept,) = motion.certificate.constraints
        assert motion.certificate.holds and motion.certificate.proved_free
        assert kept.deviation <= kept.tolerance * (1 + 1e-6)
        assert motion.certificate.cartesian_deviation.position <= 1e-3
        largest = max(used(*place) for place in places.along(motion, ELBOW))
        assert largest <= kept.deviation / kept.tolerance + 1e-6
        assert measured.along({"arm": motion})[2].min() > 0
        assert planner.verify("arm", motion, constraints=[constraint]).constraints == motion.certificate.constraints
        again = planner.plan_linear("arm", start, goal, constraints=[constraint])
        assert again == motion
        free = planner.plan_linear("arm", start, goal)
        assert free.certificate.constraints == []
        broken_without += max(used(*place) for place in places.along(free, ELBOW)) > 1
    assert solved >= 2


def test_the_joints_that_are_left_free_keep_it(arm_alone):
    """A line that the nearest configurations follow with a wrist that moves 78 mm aside."""
    places, wrist = Places(), arm_alone.compute_fk("arm", READY, "arm7_wrist").p
    goal = moved(arm_alone.compute_fk("arm", READY), [0, 0.12, 0])

    def aside(motion):
        return max(abs(p[1] - wrist[1]) for p, _ in places.along(motion, "arm7_wrist"))

    assert aside(arm_alone.plan_linear("arm", READY, goal)) > 0.07
    plane = PathConstraint.plane(wrist, [0, 1, 0], 0.025, link="arm7_wrist")
    kept = arm_alone.plan_linear("arm", READY, goal, constraints=[plane])
    assert aside(kept) <= kept.certificate.constraints[0].deviation + 1e-9 <= 0.025 + 1e-9
    assert pickle.loads(pickle.dumps(kept)).certificate == kept.certificate


def test_with_a_clearance_too(arm_alone):
    here, elbow = arm_alone.compute_fk("arm", READY), arm_alone.compute_fk("arm", READY, ELBOW)
    arm_alone.add_box("table", size=[0.3, 0.3, 0.05], pose=Pose(p=here.p - [0, 0, 0.125]))
    arm_alone.make_planner("arm", {"clearance": 0.02})
    plane = PathConstraint.plane(elbow.p, [0, 1, 0], 0.01, link=ELBOW)
    motion = arm_alone.plan_linear("arm", READY, moved(here, [0, 0, -0.095]), constraints=[plane])
    assert motion.certificate.constraints[0].deviation <= 0.01
    assert motion.certificate.clearance_kept.violation == 0
    assert motion.certificate.clearance_kept.to_time < motion.duration


def test_starts_and_goals_that_break_one_say_by_how_much(arm_alone):
    here = arm_alone.compute_fk("arm", READY)
    aside = PathConstraint.cone([0, 0, 1], rotation(here)[:, 0], np.radians(5))
    with pytest.raises(srmp.PlanningError, match=r"start is invalid.*off by 90 degrees, 5 degrees") as caught:
        arm_alone.plan_linear("arm", READY, moved(here, [0, 0.1, 0]), constraints=[aside])
    assert caught.value.status == srmp.Status.start_invalid
    near = PathConstraint.box([0.1, 0.1, 0.1], Pose(p=here.p))
    goal = moved(here, [0, 0.1, 0])
    for call in (
        lambda: arm_alone.plan_linear("arm", READY, goal, constraints=[near]),
        lambda: arm_alone.follow("arm", READY, [here, goal], constraints=[near]),
    ):
        with pytest.raises(srmp.PlanningError, match=r"goal is invalid.*off by 100 mm") as caught:
            call()
        assert caught.value.status == srmp.Status.goal_invalid


def test_what_breaks_one_on_the_way_is_told(arm_alone):
    here = arm_alone.compute_fk("arm", READY)
    line = PathConstraint.line(here.p, [0, 1, 0], 0.02)
    poses = [moved(here, [0, 0.05, 0.04]), moved(here, [0, 0.1, 0])]
    with pytest.raises(srmp.PlanningError, match=r"'arm7_hand' c.* along its path.*within 0.02 m of a line") as caught:
        arm_alone.follow("arm", READY, poses, constraints=[line])
    assert caught.value.status == srmp.Status.exhausted


def test_segments_keep_them(arm_alone):
    here, elbow = arm_alone.compute_fk("arm", READY), arm_alone.compute_fk("arm", READY, ELBOW)
    plane = PathConstraint.plane(elbow.p, [0, 1, 0], 0.02, link=ELBOW)
    segments = [
        Segment.linear(offset=[0, 0.05, 0.05], constraints=[plane]),
        Segment.follow([moved(here, [0, 0.05, 0]), here], constraints=[plane]),
        Segment.linear(moved(here, [0, 0, 0.1])),
    ]
    result = arm_alone.plan_sequence("arm", READY, segments)
    for part in result.parts[:2]:
        (kept,) = part.motion.certificate.constraints
        assert kept.deviation <= kept.tolerance == 0.02
        assert max(abs(p[1] - elbow.p[1]) for p, _ in Places().along(part.motion, ELBOW)) <= kept.deviation + 1e-9
    assert result.parts[2].motion.certificate.constraints == []
    assert result.trajectory.certificate.constraints == []  # of the parts, not of the whole
    tight = PathConstraint.plane(elbow.p, [0, 1, 0], 1e-4, link=HAND)
    with pytest.raises(srmp.PlanningError, match=r"segment 0 \(linear\): the goal is invalid.*off by 50 mm"):
        arm_alone.plan_sequence("arm", READY, [Segment.linear(offset=[0, 0.05, 0], constraints=[tight])])


def test_a_move_may_be_blended_before_a_line_with_constraints(arm_alone):
    """It stops there, as before every line."""
    here = arm_alone.compute_fk("arm", READY)
    level = PathConstraint.cone([0, 0, 1], rotation(here)[:, 2], 0.1)
    via = READY + np.array([0.2, 0, 0, 0, 0, 0, 0])
    result = arm_alone.plan_sequence(
        "arm",
        READY,
        [Segment.move(via, blend_radius=0.05), Segment.linear(offset=[0, 0, 0.05], constraints=[level])],
    )
    assert result.parts[1].motion.certificate.constraints[0].deviation <= 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"link": "arm7_hnd"}, "did you mean 'arm7_hand'"),
        ({"link": "arm7_base"}, "no planned joint of 'arm' changes it"),
        ({"frame": "arm7_hnd"}, "did you mean 'arm7_hand'"),
        ({"frame": "other/link"}, "other"),
        ({"link": "table"}, "which 'arm' does not hold"),
    ],
)
def test_constraints_that_cannot_be_placed_are_refused(arm_alone, arguments, words):
    arm_alone.add_box("table", size=[0.1, 0.1, 0.1], pose=Pose(p=[-0.5, -0.5, 0]))
    goal = moved(arm_alone.compute_fk("arm", READY), [0, 0.1, 0])
    cone = PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1, **arguments)
    refuses(lambda: arm_alone.plan_linear("arm", READY, goal, constraints=[cone]), words)
    refuses(lambda: arm_alone.follow("arm", READY, [goal], constraints=[cone]), words)
    for segment in (Segment.linear(goal, constraints=[cone]), Segment.follow([goal], constraints=[cone])):
        refuses(lambda s=segment: arm_alone.plan_sequence("arm", READY, [s]), r"segment 0 .*" + words)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-12])
def test_tolerances_that_no_motion_is_proved_to_keep_end_as_failures(arm_alone, tolerance):
    """To prove one motion would take hours; proofs end after a count of halvings."""
    arm_alone.make_planner("arm", {"time_limit": 1})
    here = arm_alone.compute_fk("arm", READY)
    line = PathConstraint.line(here.p, [0, 1, 1], tolerance)
    for plan in (arm_alone.plan_linear, arm_alone.plan):
        with pytest.raises(srmp.PlanningError):
            plan("arm", READY, moved(here, [0, 0.03, 0.03]), constraints=[line])


@pytest.mark.parametrize("constraints", ["upright", [1], 3])
def test_constraints_of_another_type_are_refused(arm_alone, constraints):
    goal = moved(arm_alone.compute_fk("arm", READY), [0, 0.1, 0])
    for call in (
        lambda: arm_alone.plan_linear("arm", READY, goal, constraints=constraints),
        lambda: arm_alone.follow(READY, [goal], constraints=constraints),
        lambda: Segment.linear(goal, constraints=constraints),
        lambda: Segment.follow([goal], constraints=constraints),
    ):
        refuses(call, "constraints", srmp.WrongType)
