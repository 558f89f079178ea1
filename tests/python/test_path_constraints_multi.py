"""Path constraints of plan_multi and verify_multi: random worlds by Pinocchio's kinematics, and every bad argument."""

import itertools
import pickle

import numpy as np
import pytest
from clearance_worlds import FACING_BASES, Measured, add, make_arms, random_objects
from multi_arms import GOALS, STARTS, in_contact, two
from support import joints, refuses, turned

import srmp
from srmp import PathConstraint, Pose

PLANNERS = ["auto", "xECBS", "prioritised"]
TOLERANCE = np.radians(5)
DOWN = PathConstraint.cone([0, 0, 1], [0, 0, -1], TOLERANCE)
BOTH_DOWN = {"left": [DOWN], "right": [DOWN]}


class Tilt:
    """Of a hand's z axis from straight down, by Pinocchio alone; the arms' bases are upright."""

    def __init__(self):
        self.pin = pytest.importorskip("pinocchio")
        self.model = self.pin.buildModelFromUrdf(srmp.data_path("arm7.urdf"))
        self.data = self.model.createData()
        self.hand = self.model.getFrameId("arm7_hand")

    def at(self, motion, t):
        q = self.pin.neutral(self.model)
        for name, value in zip(motion.joint_names, motion.sample(t), strict=True):
            q[self.model.joints[self.model.getJointId(name)].idx_q] = value
        self.pin.framesForwardKinematics(self.model, self.data, q)
        return np.arccos(np.clip(-self.data.oMf[self.hand].rotation[2, 2], -1, 1))

    def largest(self, motion):
        """[rad] of instants 1 ms apart."""
        return max(self.at(motion, t) for t in np.append(np.arange(0, motion.duration, 1e-3), motion.duration))


def hands_down(planner, rng, count):
    """Configurations of both arms, hands down and in the space that both reach, that touch nothing."""
    found = []
    for _ in range(2000):
        q = {}
        for name in FACING_BASES:
            hand = Pose.from_rpy(
                [rng.uniform(0.35, 0.75), rng.uniform(-0.4, 0.4), rng.uniform(0.2, 0.5)], [np.pi, 0, 0]
            )
            solutions = planner.compute_ik(name, hand)
            if len(solutions):
                q[name] = solutions[0]
                planner.set_qpos(name, q[name])
        if len(q) == 2 and not any(planner.is_state_colliding(name, row) for name, row in q.items()):
            found.append(q)
        if len(found) == count:
            return found
    raise AssertionError("too few configurations are free")


@pytest.mark.parametrize("planner_id", PLANNERS)
@pytest.mark.parametrize("seed", range(2))
def test_motions_in_random_worlds_keep_them(suite, seed, planner_id):
    rng = np.random.default_rng(300 + seed)
    objects = random_objects(rng, 3)
    planner = make_arms(FACING_BASES)
    for item in objects:
        add(planner, item)
    points = hands_down(planner, rng, 6)
    planner.make_planner(["arm", "other"], {"planner_id": planner_id, "time_limit": 20.0})
    measured, tilt, constraints = Measured(suite, objects, bases=FACING_BASES), Tilt(), {"arm": [DOWN], "other": [DOWN]}
    solved = 0
    for starts, goals in itertools.pairwise(points):
        try:
            motions = planner.plan_multi(starts, goals, constraints=constraints)
        except srmp.PlanningError as error:
            assert error.status in (srmp.Status.exhausted, srmp.Status.timed_out), str(error)
            continue
        solved += 1
        assert measured.along(dict(motions.items()))[2].min() > 0
        verified = planner.verify_multi(motions, starts, goals, constraints=constraints)
        for name, motion in motions.items():
            (kept,) = motion.certificate.constraints
            assert tilt.largest(motion) <= kept.deviation + 1e-9
            assert kept.deviation <= kept.tolerance == pytest.approx(TOLERANCE)
            assert verified[name].holds
            assert verified[name].constraints == motion.certificate.constraints
    assert solved >= 4


def crossing(planner_id="auto", constraints=BOTH_DOWN, distance=0.6, **options):
    """Hands that have to pass each other, and what was found."""
    planner = two(planner_id, distance, **options)
    return planner, planner.plan_multi(STARTS, GOALS, constraints=constraints)


@pytest.mark.parametrize("planner_id", PLANNERS)
def test_robots_in_each_others_way_keep_them(planner_id):
    planner, motions = crossing(planner_id)
    assert "conflict-based search" in planner.get_planning_stats()["found_by"]
    unconstrained = crossing(planner_id, constraints={})[1]
    assert any(Tilt().largest(motion) > TOLERANCE for motion in unconstrained.values())
    for motion in motions.values():
        assert Tilt().largest(motion) <= TOLERANCE
        assert motion.certificate.constraints[0].deviation <= TOLERANCE


def test_one_of_them_may_have_none():
    _, motions = crossing(constraints={"left": [DOWN], "right": []})
    assert Tilt().largest(motions["left"]) <= TOLERANCE
    assert motions["right"].certificate.constraints == []


def test_goal_positions_are_met_by_configurations_that_keep_them():
    planner = two(distance=0.9)
    hands = {name: planner.compute_fk(name, turned(-0.6)) for name in planner.robot_names}
    goals = {name: srmp.GoalConstraint(srmp.GoalType.POSITION, hand.p) for name, hand in hands.items()}
    motions = planner.plan_multi(STARTS, goals, constraints=BOTH_DOWN)
    for name, motion in motions.items():
        assert Tilt().largest(motion) <= TOLERANCE
        assert np.linalg.norm(planner.compute_fk(name, motion.positions[-1]).p - hands[name].p) < 2e-3


def test_they_can_be_about_what_a_robot_holds():
    planner = two(distance=0.6)
    planner.set_qpos("left", STARTS["left"])
    planner.add_sphere("ball", 0.01, planner.compute_fk("left", STARTS["left"]))
    planner.attach_object("ball", "left", "arm7_hand")
    held = PathConstraint.cone([0, 0, 1], [0, 0, -1], TOLERANCE, link="ball")
    motions = planner.plan_multi(STARTS, GOALS, constraints={"left": [held]})
    assert Tilt().largest(motions["left"]) <= TOLERANCE
    refuses(
        lambda: planner.plan_multi(STARTS, GOALS, constraints={"right": [held]}),
        "about the object 'ball', which 'right' does not hold",
    )


@pytest.mark.parametrize("planner_id", PLANNERS)
def test_the_same_bits_twice_and_with_two_threads(planner_id):
    first = pickle.dumps([motion.positions for motion in crossing(planner_id)[1].values()])
    for options in ({}, {"num_threads": 2}):
        again = crossing(planner_id, **options)[1]
        assert pickle.dumps([motion.positions for motion in again.values()]) == first


def test_verify_multi_says_by_how_much_a_motion_breaks_one():
    planner, motions = crossing(constraints={})
    tilted = PathConstraint.cone([0, 0, 1], [0, np.sin(0.5), -np.cos(0.5)], 0.1)
    broken = planner.verify_multi(motions, constraints={"left": [tilted]})
    assert not broken["left"].holds
    assert broken["left"].constraints[0].deviation >= 0.5 - 1e-9
    assert broken["right"].holds
    assert broken["right"].constraints == []


def test_frames_are_of_what_stands_still():
    planner = two(distance=1.2)
    hand = planner.compute_fk("left", turned(0.3))
    level = PathConstraint.plane([0, 0, 0], [0, 0, 1], 0.02, frame="right/arm7_hand")
    planner.set_qpos("right", turned(0.0))
    height = planner.compute_fk("right", turned(0.6)).p[2]
    assert height == pytest.approx(hand.p[2])
    starts, constraints = {"left": turned(0.3), "right": turned(0.6)}, {"left": [level]}
    goals = {"left": joints(turned(-0.3))}
    motions = planner.plan_multi(starts, goals, constraints=constraints)
    planner.set_qpos("right", turned(-1.0))  # where it holds counts, not where it stood
    verified = planner.verify_multi(motions, starts, goals, constraints=constraints)
    assert verified["left"].constraints == motions["left"].certificate.constraints
    refuses(
        lambda: planner.plan_multi(starts, {**goals, "right": joints(turned(0.2))}, constraints=constraints),
        "'left' has the frame 'right/arm7_hand', which moves with 'right'",
    )
    planner.set_qpos("right", turned(0.6))
    planner.add_sphere("ball", 0.02, planner.compute_fk("right", turned(0.6)))
    planner.attach_object("ball", "right", "arm7_hand")
    of_ball = {"left": [PathConstraint.plane([0, 0, 0], [0, 0, 1], 0.02, frame="ball")]}
    refuses(
        lambda: planner.plan_multi(starts, {**goals, "right": joints(turned(0.2))}, constraints=of_ball),
        "frame 'ball', which moves with 'right'",
    )


def test_robots_that_hold_keep_them_too():
    planner = two(distance=1.2)
    goals = {"left": joints(turned(-0.3))}
    starts = {"left": turned(0.3), "right": turned(0.6)}
    motions = planner.plan_multi(starts, goals, constraints={"right": [DOWN]})
    assert motions["right"].certificate.constraints[0].deviation < 1e-6
    with pytest.raises(srmp.PlanningError, match=r"'right': the start is invalid: .*degrees") as error:
        planner.plan_multi(starts, goals, constraints={"right": [PathConstraint.cone([0, 0, 1], [1, 0, 0], 0.1)]})
    assert error.value.status == srmp.Status.start_invalid


def test_a_robot_that_holds_cannot_have_the_frame_of_one_that_moves():
    planner = two(distance=1.2)
    beside = PathConstraint.plane([0, 0, 0], [0, 0, 1], 0.1, frame="left/arm7_hand")
    refuses(
        lambda: planner.plan_multi(
            {"left": turned(0.3), "right": turned(0.6)},
            {"left": joints(turned(-0.3))},
            constraints={"right": [beside]},
        ),
        "'right' has the frame 'left/arm7_hand', which moves with 'left'",
    )


def test_ends_that_break_one_are_invalid():
    planner = two(distance=1.2)
    tipped = turned(-0.3)
    tipped[5] += 0.4
    for starts, goals, status in (
        ({"left": tipped}, {"left": joints(turned(0.3))}, srmp.Status.start_invalid),
        ({"left": turned(0.3)}, {"left": joints(tipped)}, srmp.Status.goal_invalid),
    ):
        with pytest.raises(srmp.PlanningError, match="an axis of 'arm7_hand' within") as error:
            planner.plan_multi(
                {**starts, "right": turned(0.6)},
                {**goals, "right": joints(turned(-0.6))},
                constraints=BOTH_DOWN,
            )
        assert error.value.status == status
        assert "off by 22.918 degrees, 5 degrees are allowed" in str(error.value)
        assert "robot 'left'" in str(error.value)


def test_requests_with_them_are_values_and_in_files(tmp_path):
    planner, motions = crossing()
    request = planner.last_request
    assert request.constraints == BOTH_DOWN
    assert pickle.loads(pickle.dumps(request)).constraints == BOTH_DOWN
    planner.save(tmp_path / "problem.json")
    loaded = srmp.PlannerInterface.load(tmp_path / "problem.json")
    assert loaded.last_request.constraints == BOTH_DOWN
    again = loaded.plan_multi(request.starts, request.goals, constraints=request.constraints)
    assert all(np.array_equal(again[name].positions, motion.positions) for name, motion in motions.items())


@pytest.mark.parametrize(
    ("constraints", "sentence"),
    [
        ({"lef": [DOWN]}, "did you mean 'left'"),
        ({"third": [DOWN]}, "robot 'third' has path constraints but no"),
        ({"left": DOWN}, "constraints must be lists of PathConstraint objects .* of 'left'"),
        ({"left": 3}, "constraints must be lists of PathConstraint objects .* of 'left'"),
        ([DOWN], "constraints must be"),
        (
            {"left": [PathConstraint.cone([0, 0, 1], [0, 0, -1], 0.1, link="right/arm7_hand")]},
            "path constraint of 'left' is about 'right/arm7_hand', a link of another robot",
        ),
        ({"left": [PathConstraint.cone([0, 0, 1], [0, 0, -1], 0.1, link="arm7_hnd")]}, "did you mean 'arm7_hand'"),
        (
            {"left": [PathConstraint.cone([0, 0, 1], [0, 0, -1], 0.1, frame="right/arm7_hand")]},
            "frame 'right/arm7_hand', which moves",
        ),
    ],
)
def test_bad_constraints_are_refused(constraints, sentence):
    planner, motions = crossing(constraints={})
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="third",
        end_effector="arm7_hand",
        base_pose=Pose(p=[0, 5, 0]),
    )
    refuses(lambda: planner.plan_multi(STARTS, GOALS, constraints=constraints), sentence)
    refuses(lambda: planner.verify_multi(motions, constraints=constraints), sentence.replace(" but no", ", but no"))


def committed(angles, times):
    """A motion of the right arm that other work has committed it to."""
    rows = [turned(angle) for angle in angles]
    return srmp.Trajectory([f"arm7_joint{i}" for i in range(1, 8)], rows, times, np.zeros((len(rows), 7)))


def around(planner, start, goal, right):
    """The left arm's motion, upright, which no instant of the right one's touches."""
    starts, goals, constraints = {"left": start}, {"left": joints(goal)}, {"left": [DOWN]}
    motion = planner.plan_multi(starts, goals, {"right": right}, constraints)["left"]
    assert Tilt().largest(motion) <= motion.certificate.constraints[0].deviation + 1e-9 <= TOLERANCE + 1e-9
    assert not in_contact(planner, srmp.MultiTrajectory({"left": motion, "right": right}))
    assert np.array_equal(motion.positions[0], start)
    assert np.abs(motion.positions[-1] - goal).max() < 1e-6
    return motion


@pytest.mark.parametrize("planner_id", PLANNERS)
@pytest.mark.parametrize("duration", [1.0, 3.0])
def test_they_hold_among_robots_in_motion(planner_id, duration):
    planner = two(planner_id, 0.6)
    right = committed([-0.9, 0.9], [0, duration])
    motion = around(planner, turned(-0.9), turned(0.9), right)
    assert (
        planner.plan_multi({"left": turned(-0.9)}, {"left": joints(turned(0.9))}, {"right": right}, {"left": [DOWN]})[
            "left"
        ].positions.tobytes()
        == motion.positions.tobytes()
    )


def test_a_robot_that_gives_way_to_one_in_motion_keeps_them():
    planner = two(distance=0.6)
    motion = around(planner, turned(0.0), turned(0.0), committed([-0.9, 0.9], [0, 2]))
    assert np.abs(motion.positions - turned(0.0)).max() > 0.1


@pytest.mark.parametrize("seed", range(6))
def test_they_hold_among_random_motions(seed):
    rng = np.random.default_rng(seed)
    planner = two(distance=0.6)
    angles = rng.uniform(-1.0, 1.0, 4)
    angles[[0, -1]] = [-0.9, 0.9]
    around(planner, turned(-0.9), turned(0.9), committed(angles, np.cumsum([0, *rng.uniform(0.8, 2.0, 3)])))


def test_the_frame_of_a_robot_in_motion_is_refused():
    moving = PathConstraint.cone([0, 0, 1], [0, 0, -1], 0.1, frame="right/arm7_hand")
    refuses(
        lambda: two(distance=0.6).plan_multi(
            {"left": turned(-0.9)},
            {"left": joints(turned(0.9))},
            {"right": committed([-0.9, 0.9], [0, 2])},
            {"left": [moving]},
        ),
        "frame 'right/arm7_hand', which moves",
    )
