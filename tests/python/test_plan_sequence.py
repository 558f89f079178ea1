"""Sequences: motions, grasps and waits in a row, as docs/sequences.md says, and every bad segment."""

import pickle
from math import inf, nan, pi, radians

import numpy as np
import pytest

import srmp
from srmp import PathConstraint, Pose, Segment, SegmentType

LEFT, RIGHT = [0.55, 0.3, 0.38], [0.55, -0.3, 0.48]


def forward(p):
    """The end effector at p, its z axis forward, fingers left and right."""
    return Pose.from_rpy(p, [0, pi / 2, 0])


def above(p, height):
    return np.add(p, [0, 0, height])


@pytest.fixture
def planner(arm_alone):
    """A can on the left stand, a wall in between, a free stand on the right."""
    arm_alone.add_box("floor", size=[2, 2, 0.1], pose=Pose(p=[0, 0, -0.051]))
    arm_alone.add_box("stand_left", size=[0.2, 0.2, 0.3], pose=Pose(p=[0.55, 0.3, 0.15]))
    arm_alone.add_box("stand_right", size=[0.2, 0.2, 0.4], pose=Pose(p=[0.55, -0.3, 0.2]))
    arm_alone.add_box("wall", size=[0.4, 0.02, 0.7], pose=Pose(p=[0.6, 0, 0.35]))
    arm_alone.add_cylinder("can", radius=0.028, length=0.14, pose=Pose(p=[0.55, 0.3, 0.371]))
    arm_alone.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    return arm_alone


@pytest.fixture
def ready(arm_alone):
    return arm_alone.get_group_states("arm")["ready"]


def pick_and_place(ready):
    upright = PathConstraint.cone([-1, 0, 0], [0, 0, 1], radians(5))
    return [
        Segment.move(forward([0.45, 0.3, 0.38])),
        Segment.linear(forward(LEFT)),
        Segment.attach("can", "arm7_hand", touch_links=["arm7_palm"]),
        Segment.allow("can", "stand_left"),
        Segment.linear(offset=[0, 0, 0.1]),
        Segment.allow("can", "stand_left", allowed=False),
        Segment.move(forward(above(RIGHT, 0.1)), constraints=[upright]),
        Segment.linear(offset=[0, 0, -0.1]),
        Segment.detach("can"),
        Segment.linear(offset=[-0.13, 0, 0]),
        Segment.wait(0.25),
        Segment.move(ready),
    ]


def scene_of(planner):
    """What a sequence must leave as it was, as text."""
    poses = {name: planner.get_object_pose(name) for name in planner.object_names}
    return repr((list(planner.get_qpos("arm")), poses, planner))


def assert_one_motion(result, start, segments):
    """Parts in a row without gaps or jumps, from the start, in the order of the segments."""
    assert [part.type for part in result.parts] == [segment.type for segment in segments]
    time, position = 0.0, np.asarray(start)
    for part in result.parts:
        assert part.begin == time
        if part.motion is None:
            assert part.end == part.begin
            continue
        assert part.motion.certificate.holds and part.motion.certificate.proved_free
        np.testing.assert_allclose(part.motion.positions[0], position, atol=1e-12)
        assert part.end - part.begin == pytest.approx(part.motion.duration, abs=1e-9)
        for t in np.linspace(0, part.motion.duration, 20):
            np.testing.assert_allclose(result.trajectory.state(part.begin + t)[0], part.motion.state(t)[0], atol=1e-9)
        time, position = part.end, part.motion.positions[-1]
    assert result.trajectory.times[-1] == time
    assert np.all(np.diff(result.trajectory.times) > 0)
    assert result.trajectory.certificate.holds and result.trajectory.certificate.proved_free


def test_pick_and_place(planner, ready):
    segments = pick_and_place(ready)
    before = scene_of(planner)
    result = planner.plan_sequence(ready, segments)
    assert scene_of(planner) == before
    assert_one_motion(result, ready, segments)
    assert result == planner.plan_sequence("arm", ready, segments)
    assert pickle.loads(pickle.dumps(result)) == result

    # The same by hand: every part is valid in the scene as it is then, by the verifier alone.
    for segment, part in zip(segments, result.parts, strict=True):
        if segment.type == SegmentType.attach:
            planner.attach_object("can", "arm", "arm7_hand", touch_links=["arm7_palm"])
        elif segment.type == SegmentType.detach:
            planner.detach_object("can")
        elif segment.type == SegmentType.allow:
            planner.set_allowed_collision(segment.object, segment.other, allowed=segment.allowed)
        else:
            certificate = planner.verify("arm", part.motion)
            assert certificate.holds, certificate.faults
            planner.set_qpos("arm", part.motion.positions[-1])
    np.testing.assert_allclose(planner.get_object_pose("can").p, [0.55, -0.3, 0.471], atol=1e-3)
    carried = result.parts[6].motion
    tilts = [
        np.arccos(np.clip(-planner.compute_fk("arm", q).matrix()[2, 0], -1, 1))
        for q in (carried.state(t)[0] for t in np.arange(0, carried.duration, 1e-3))
    ]
    assert max(tilts) <= radians(5)
    assert result.parts[10].motion.duration == 0.25


def test_an_earlier_move_ends_where_the_later_ones_succeed(arm_alone, ready):
    """Above the nearer goal there is a shelf, which stops the way up."""
    planner = arm_alone
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    below, free = forward([0.5, 0.2, 0.2]), forward([0.5, -0.4, 0.2])
    planner.add_box("shelf", size=[0.2, 0.2, 0.02], pose=Pose(p=[0.58, 0.2, 0.45]))
    lift = Segment.linear(offset=[0, 0, 0.3])
    start = np.add(ready, [0.3, 0, 0, 0, 0, 0, 0])
    with pytest.raises(srmp.PlanningError, match=r"segment 1 \(linear\): .*shelf.*other ends of motions"):
        planner.plan_sequence(start, [Segment.move(below), lift])
    segments = [Segment.move([below, free]), lift]
    result = planner.plan_sequence(start, segments)
    assert_one_motion(result, start, segments)
    np.testing.assert_allclose(planner.compute_fk("arm", result.parts[0].motion.positions[-1]).p, free.p, atol=1e-3)


def test_a_grasp_takes_the_solution_of_inverse_kinematics_from_which_the_lift_works(arm_alone, ready):
    planner = arm_alone
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10})
    pose, lift = forward([0.4, 0.2, 0.2]), Segment.linear(offset=[0, 0, 0.2])

    def is_lifted(q):
        try:
            return planner.plan_sequence(q, [lift])
        except srmp.PlanningError:
            return None

    stuck = [q for q in planner.compute_ik("arm", pose, ready) if not is_lifted(q)]
    assert stuck
    for start in stuck:
        segments = [Segment.move(pose), lift]
        result = planner.plan_sequence(start, segments)  # the move's nearest end is the start itself
        assert_one_motion(result, start, segments)


def test_the_reason_names_the_segment_that_was_reached(planner, ready):
    before = scene_of(planner)
    segments = [*pick_and_place(ready)[:5], Segment.linear(offset=[0, -0.9, 0])]
    with pytest.raises(srmp.PlanningError, match=r"^segment 5 \(linear\): ") as failed:
        planner.plan_sequence(ready, segments)
    assert failed.value.status == srmp.Status.exhausted
    assert scene_of(planner) == before


def test_blended_moves_do_not_stop(planner, ready):
    vias = [np.add(ready, [0.5, 0.2, 0, 0, 0, 0, 0]), np.add(ready, [0.9, -0.2, 0, 0.3, 0, 0, 0])]
    goal = np.add(ready, [1.4, 0, 0, 0, 0, 0.4, 0])
    stops = planner.plan_sequence(ready, [Segment.move(q) for q in [*vias, goal]])
    segments = [*(Segment.move(q, blend_radius=0.05) for q in vias), Segment.move(goal)]
    result = planner.plan_sequence(ready, segments)
    assert_one_motion(result, ready, segments)
    assert result.trajectory.duration < stops.trajectory.duration
    inside = np.arange(0.05, result.trajectory.duration - 0.05, 0.005)
    speeds = [np.abs(result.trajectory.state(t)[1]).max() for t in inside]
    assert min(speeds) > 0.05
    for via, part in zip(vias, result.parts, strict=False):
        end = part.motion.positions[-1]
        distance = np.linalg.norm(planner.compute_fk("arm", end).p - planner.compute_fk("arm", via).p)
        assert distance <= 0.05
    sharp = planner.plan_sequence(ready, [Segment.move(vias[0], blend_radius=1e-4), *segments[1:]])
    end = sharp.parts[0].motion.positions[-1]
    assert np.linalg.norm(planner.compute_fk("arm", end).p - planner.compute_fk("arm", vias[0]).p) <= 1e-4


def test_joints_that_are_not_planned_move_and_return(ready):
    """The last joint turns the held bar, as a gripper's joint would close."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="arm",
        end_effector="arm7_hand",
        joint_names=[f"arm7_joint{i}" for i in range(1, 7)],
    )
    planner.make_planner("arm", {"planner_id": "auto"})
    start = ready[:6]
    planner.set_qpos("arm", start)
    hand = planner.compute_fk("arm", start)
    planner.add_box("bar", size=[0.3, 0.02, 0.02], pose=Pose(p=np.add(hand.p, [0, 0, -0.1])))
    turned = Segment.joints({"arm7_joint7": ready[6] + 1.5}, duration=0.4)
    segments = [Segment.attach("bar", "arm7_hand"), turned, Segment.move(np.add(start, [0.5, 0, 0, 0, 0, 0]))]
    result = planner.plan_sequence(start, segments)
    assert_one_motion(result, start, segments)
    assert result.parts[1].motion.duration == 0.4
    np.testing.assert_array_equal(result.parts[1].motion.velocities, 0)

    before = planner.get_object_pose("bar")
    planner.add_box("pole", size=[0.02, 0.02, 0.4], pose=Pose(p=np.add(hand.p, [0.1, -0.1, -0.1])))
    with pytest.raises(srmp.PlanningError, match=r"segment 1 \(joints\): .*pole") as failed:
        planner.plan_sequence(start, segments)
    assert failed.value.status == srmp.Status.start_invalid
    assert planner.get_object_pose("bar") == before
    with pytest.raises(srmp.InvalidArgument, match=r"segment 0 \(joints\): .*'arm7_joint8'"):
        planner.plan_sequence(start, [Segment.joints({"arm7_joint8": 0.0})])
    with pytest.raises(srmp.InvalidArgument, match=r"segment 0 \(joints\): .*arm7_joint7"):
        planner.plan_sequence(start, [Segment.joints({"arm7_joint7": 9.0})])


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
def test_a_wait_alone(planner, ready, timing):
    planner.make_planner("arm", {"timing": timing})
    result = planner.plan_sequence(ready, [Segment.wait(1.5)])
    assert result.trajectory.duration == 1.5
    assert result.trajectory.certificate.holds


HERE = Segment.move(forward([0.45, 0.3, 0.38]))

BAD = {
    "no segments": ([], "has no segments"),
    "no time": ([Segment.attach("can", "arm7_hand")], "no segment of the sequence moves the robot or waits"),
    "unknown object": ([HERE, Segment.attach("cam", "arm7_hand")], r"segment 1 \(attach\): .*'cam'.*'can'"),
    "unknown link": ([HERE, Segment.attach("can", "arm7_hnad")], "arm7_hand"),
    "unknown link of a line": ([Segment.linear(offset=[0, 0, 0.1], link="arm7_hnad")], "arm7_hand"),
    "not attached": ([HERE, Segment.detach("can")], r"segment 1 \(detach\): .*can"),
    "unknown body": ([Segment.allow("can", "stand_lfet"), HERE], r"segment 0 \(allow\): .*stand_left"),
    "unknown joint": ([Segment.joints({"finger": 0.01})], r"segment 0 \(joints\): .*finger"),
    "planned joint": ([Segment.joints({"arm7_joint1": 0.0})], "'arm7_joint1' is planned"),
    "nothing that takes time, and an unknown object": ([Segment.attach("cam", "arm7_hand")], "'cam'"),
    "long wait": ([Segment.wait(1e9)], r"it must be 0 s or above, and at most 1e\+06 s"),
    "line beyond everything": ([Segment.linear(offset=[0, 0, 1e9])], r"segment 0 \(linear\): .*at most 1000 m"),
    "negative wait": ([Segment.wait(-1)], r"segment 0 \(wait\): duration is -1"),
    "endless wait": ([Segment.wait(inf)], "duration is inf"),
    "no number": ([Segment.wait(nan)], "duration is NaN"),
    "negative radius": ([Segment.move([0] * 7, blend_radius=-0.1), HERE], "blend_radius is -0.1"),
    "goal of other joints": ([Segment.move([0] * 3)], r"segment 0 \(move\): .*3"),
    "goal that is NaN": ([HERE, Segment.move([nan] * 7)], r"segment 1 \(move\): "),
    "no line": ([Segment.linear()], r"segment 0 \(linear\): it needs a pose or an offset"),
    "two lines": ([Segment.linear(Pose(), offset=[0, 0, 1])], "needs a pose or an offset"),
    "line to nowhere": ([Segment.linear(offset=[0, 0, nan])], "offset"),
    "no poses": ([Segment.follow([])], r"segment 0 \(follow\): there are no poses"),
    "deviation": ([Segment.linear(offset=[0, 0, 0.1], max_deviation=0)], "max_deviation"),
    "constraint of an unknown link": (
        [Segment.move([0] * 7, constraints=[PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1, link="arm7_hnad")])],
        "arm7_hand",
    ),
    "blended constraint": (
        [Segment.move([0] * 7, constraints=[PathConstraint.cone([0, 0, 1], [0, 0, 1], 0.1)], blend_radius=0.1), HERE],
        "not blended",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_segments(planner, ready, case):
    segments, message = BAD[case]
    before = scene_of(planner)
    with pytest.raises(srmp.InvalidArgument, match=message):
        planner.plan_sequence(ready, segments)
    assert scene_of(planner) == before


def test_bad_calls(planner, ready):
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'arm'"):
        planner.plan_sequence("amr", ready, [HERE])
    with pytest.raises(srmp.InvalidArgument, match="7"):
        planner.plan_sequence([0, 0], [HERE])
    with pytest.raises(srmp.WrongType, match="segments"):
        planner.plan_sequence(ready, [forward(LEFT)])
    planner.make_planner("arm", {"timing": "none"})
    with pytest.raises(srmp.InvalidArgument, match="timing"):
        planner.plan_sequence(ready, [HERE])


def test_a_start_in_contact(planner, ready):
    planner.add_box("around", size=[0.3, 0.3, 0.3], pose=Pose(p=planner.compute_fk("arm", ready).p))
    with pytest.raises(srmp.PlanningError, match=r"segment 0 \(move\): .*around") as failed:
        planner.plan_sequence(ready, [HERE])
    assert failed.value.status == srmp.Status.start_invalid
