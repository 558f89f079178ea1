"""`clearance` in motions along poses and in sequences, by distances of Pinocchio's and Coal's own packages."""

import itertools
import pickle

import numpy as np
import pytest
from clearance_worlds import BUILT_CLOSE, CLEARANCE, Measured, add, ends, make_arms, random_objects, require_kept
from support import READY

import srmp
from srmp import Pose, Segment


def moved(pose, by):
    return Pose(p=pose.p + by, q=pose.q)


CLOSE_LINKS = (BUILT_CLOSE, frozenset(("arm/arm7_palm", "arm/arm7_palm_mount")))


def require_clearance(measured, motion, clearance=CLEARANCE, close=(BUILT_CLOSE,)):
    """The rule, by distances that the library has not computed."""
    certificate = motion.certificate
    kept = certificate.clearance_kept
    assert certificate.holds and certificate.proved_free
    assert (kept.required, kept.violation) == (clearance, 0)
    times, bodies, distances = measured.along({"arm": motion})
    others = [k for k, pair in enumerate(bodies) if pair not in close]
    for k in others:
        require_kept(distances[:, k], clearance)
    within = (times >= kept.from_time) & (times <= kept.to_time)
    assert (distances[np.ix_(within, others)] >= clearance - 3e-6).all()
    relaxed = {frozenset((r.body_a, r.body_b)) for r in kept.relaxed}
    for row in (0, -1):
        at_end = {bodies[k] for k in others if distances[row, k] < clearance - 1e-5}
        assert {frozenset(name.removeprefix("arm/") for name in pair) for pair in at_end} <= relaxed


@pytest.mark.parametrize("seed", range(4))
def test_lines_in_random_worlds_keep_it_except_near_ends_that_are_closer(suite, seed):
    rng = np.random.default_rng(300 + seed)
    objects = random_objects(rng)
    planner = make_arms()
    for item in objects:
        add(planner, item)
    planner.make_planner(["arm"], {"clearance": CLEARANCE, "time_limit": 5.0})
    measured = Measured(suite, objects)
    solved = 0
    for start in ends(planner, rng, 8):
        here = planner.compute_fk("arm", start)
        for by in rng.uniform(-0.15, 0.15, (3, 3)):
            try:
                motion = planner.plan_linear("arm", start, moved(here, by))
            except srmp.PlanningError as error:
                assert error.status != srmp.Status.start_invalid
                continue
            solved += 1
            np.testing.assert_array_equal(motion.positions[0], start)
            assert motion.certificate.cartesian_deviation.position <= 1e-3
            require_clearance(measured, motion)
    assert solved >= 4


@pytest.fixture
def table(arm_alone):
    """Its top is 0.1 m below the hand at READY, fingers down, which are what comes nearest to it."""
    hand = arm_alone.compute_fk("arm", READY)
    arm_alone.add_box("table", size=[0.3, 0.3, 0.05], pose=Pose(p=hand.p - [0, 0, 0.125]))
    arm_alone.make_planner("arm", {"clearance": 0.02, "time_limit": 60.0})
    return arm_alone


def above_table(planner, height, by=(0, 0)):
    """The hand, so far above the table and beside where it is at READY."""
    here = planner.compute_fk("arm", READY)
    return moved(here, [*by, height - 0.1])


def test_down_to_the_table_and_up_again(table, suite):
    down = table.plan_linear("arm", READY, above_table(table, 0.005))
    kept = down.certificate.clearance_kept
    assert kept.from_time == 0
    assert 0 < kept.to_time < down.duration
    (pair,) = kept.relaxed
    assert (pair.body_a, pair.body_b) == ("arm7_hand", "table")
    assert pair.clearance == pytest.approx(0.005, abs=2e-5)
    up = table.plan_linear("arm", down.positions[-1], above_table(table, 0.1))
    assert 0 < up.certificate.clearance_kept.from_time < up.duration
    assert up.certificate.clearance_kept.to_time == up.duration
    pose = [*table.get_object_pose("table").p, 0, 0, 0, 1]
    item = {"name": "table", "type": "box", "size": [0.3, 0.3, 0.05], "pose": pose}
    measured = Measured(suite, [item])
    for motion in (down, up):
        require_clearance(measured, motion, 0.02, close=CLOSE_LINKS)
        moving = np.abs(motion.velocities[1:-1]).max(axis=1)
        assert moving.min() > 1e-3  # no stop on the way
        certificate = table.verify("arm", motion, clearance=0.02)
        assert certificate.holds
        assert certificate.clearance_kept == motion.certificate.clearance_kept


def test_along_the_table_too_close_is_refused_with_the_pair(table):
    beside = [above_table(table, height, (0, y)) for height, y in ((0.005, 0), (0.005, 0.1), (0.1, 0.1))]
    words = r"came .* along its path; there, .*'table' are .* apart, less than the clearance of 0.02 m"
    with pytest.raises(srmp.PlanningError, match=words) as caught:
        table.follow("arm", READY, beside)
    assert caught.value.status == srmp.Status.exhausted
    table.make_planner("arm", {"clearance": 0.004})
    table.follow("arm", READY, beside)


def test_the_reason_is_the_first_pose_that_is_too_close(table):
    table.add_box("wall", size=[0.3, 0.02, 0.4], pose=moved(table.compute_fk("arm", READY), [0, 0.25, 0]))
    words = r"'arm7_hand' cannot be .* m of 0.4 m along its path: .*'wall'"
    with pytest.raises(srmp.PlanningError, match=words) as caught:
        table.plan_linear("arm", READY, above_table(table, 0.1, (0, 0.4)))
    assert caught.value.status == srmp.Status.exhausted


def test_a_motion_that_ends_before_the_clearance_is_kept_is_refused(table):
    low = table.plan_linear("arm", READY, above_table(table, 0.005)).positions[-1]
    words = r"came 0.005 m of 0.005 m along its path; there, .*'table'.* less than the clearance of 0.02 m, and it ends"
    with pytest.raises(srmp.PlanningError, match=words):
        table.plan_linear("arm", low, above_table(table, 0.01))


def test_posts_are_passed_at_an_even_distance(table):
    """8 mm from both sides of the hand, which leaves them upwards."""
    low = table.plan_linear("arm", READY, above_table(table, 0.03)).positions[-1]
    hand = table.compute_fk("arm", low).p
    alone = make_arms()  # with what the robot's links are close to
    links = alone.get_link_names("arm")
    for a, b in itertools.combinations(links, 2):
        alone.set_allowed_collision(a, b)
    for name, side in (("left", 1), ("right", -1)):
        size, p = [0.04, 0.02, 0.08], hand + np.array([0, side * 0.1, 0.02])
        alone.add_box(name, size=size, pose=Pose(p=p))
        apart = alone.distance_to_collision("arm", low)
        table.add_box(name, size=size, pose=Pose(p=p - np.array([0, side * (apart - 0.008), 0])))
        alone.remove_object(name)
    up = table.plan_linear("arm", low, above_table(table, 0.2))
    kept = up.certificate.clearance_kept
    assert kept.violation == 0
    assert {"left", "right"} <= {pair.body_b for pair in kept.relaxed}
    assert min(pair.clearance for pair in kept.relaxed) == pytest.approx(0.008, abs=1e-4)


def test_the_same_request_has_the_same_motion_and_none_is_what_it_was(table):
    low = above_table(table, 0.005)
    motions = [table.plan_linear("arm", READY, low) for _ in range(2)]
    table.make_planner("arm", {})
    without = table.plan_linear("arm", READY, low)
    assert without.certificate.clearance_kept is None
    table.make_planner("arm", {"clearance": 0.02, "time_limit": 60.0})
    motions.append(table.plan_linear("arm", READY, low))
    assert all(motion == motions[0] for motion in motions)


def test_starts_in_contact_are_invalid_as_ever(table):
    table.add_sphere("around", 0.1, Pose(p=table.compute_fk("arm", READY).p))
    with pytest.raises(srmp.PlanningError, match=r"start is invalid: .* overlap") as caught:
        table.plan_linear("arm", READY, moved(table.compute_fk("arm", READY), [0, 0, 0.1]))
    assert caught.value.status == srmp.Status.start_invalid


def test_a_preferred_clearance_is_no_reason_to_fail(table):
    here = table.compute_fk("arm", READY)
    table.make_planner("arm", {"preferred_clearance": 0.05})
    motion = table.follow("arm", READY, [moved(here, [0, 0.05, 0]), moved(here, [0, 0.05, 0.05])])
    assert motion.certificate.holds
    assert motion.certificate.clearance_kept is None


# --- sequences


def forward(p):
    """The end effector at p, its z axis forward, fingers left and right."""
    return Pose.from_rpy(p, [0, np.pi / 2, 0])


@pytest.fixture
def stands(arm_alone):
    """A can on the left stand, a wall in between, a free stand on the right."""
    arm_alone.add_box("floor", size=[2, 2, 0.1], pose=Pose(p=[0, 0, -0.051]))
    arm_alone.add_box("stand_left", size=[0.2, 0.2, 0.3], pose=Pose(p=[0.55, 0.3, 0.15]))
    arm_alone.add_box("stand_right", size=[0.2, 0.2, 0.4], pose=Pose(p=[0.55, -0.3, 0.2]))
    arm_alone.add_box("wall", size=[0.4, 0.02, 0.7], pose=Pose(p=[0.6, 0, 0.35]))
    arm_alone.add_cylinder("can", radius=0.028, length=0.14, pose=Pose(p=[0.55, 0.3, 0.371]))
    return arm_alone


def pick_and_place(ready):
    return [
        Segment.move(forward([0.42, 0.3, 0.38])),
        Segment.linear(forward([0.55, 0.3, 0.38])),
        Segment.attach("can", "arm7_hand", touch_links=["arm7_palm"]),
        Segment.linear(offset=[0, 0, 0.1]),
        Segment.move(forward([0.55, -0.3, 0.58])),
        Segment.linear(offset=[0, 0, -0.1]),
        Segment.detach("can"),
        Segment.linear(offset=[-0.13, 0, 0]),
        Segment.move(ready),
    ]


def require_clearance_of_parts(whole, result):
    """Kept where one of the motions keeps it, and nowhere else; the same pairs are closer at the same times."""
    motions = [part for part in result.parts if part.motion and part.motion.certificate.clearance_kept]
    kept, relaxed = [], []
    for part in motions:
        own, begin = part.motion.certificate.clearance_kept, part.begin
        kept.append((begin + own.from_time, begin + own.to_time))
        relaxed += [(pair.body_a, pair.body_b, begin + pair.from_time) for pair in own.relaxed]
    stops = [(end, begin) for (_, end), (begin, _) in itertools.pairwise(kept) if begin > end + 1e-9]
    np.testing.assert_allclose([whole.from_time, whole.to_time], [kept[0][0], kept[-1][1]], atol=1e-9)
    np.testing.assert_allclose(whole.at_stops, stops, atol=1e-9)
    assert len(stops) == 2  # the can is taken and put down
    assert [(pair.body_a, pair.body_b) for pair in whole.relaxed] == [pair[:2] for pair in relaxed]
    np.testing.assert_allclose([pair.from_time for pair in whole.relaxed], [pair[2] for pair in relaxed], atol=1e-9)


def test_a_sequence_keeps_it_in_every_motion(stands, suite):
    planner, clearance = stands, 0.01
    planner.make_planner("arm", {"planner_id": "auto", "time_limit": 10, "clearance": clearance})
    ready = planner.get_group_states("arm")["ready"]
    segments = pick_and_place(ready)
    result = planner.plan_sequence(ready, segments)
    assert result == planner.plan_sequence(ready, segments)
    assert result.trajectory.certificate.holds
    whole = result.trajectory.certificate.clearance_kept
    assert (whole.required, whole.violation) == (clearance, 0)
    require_clearance_of_parts(whole, result)
    assert pickle.loads(pickle.dumps(whole)) == whole
    relaxed = set()
    for segment, part in zip(segments, result.parts, strict=True):
        if segment.type == srmp.SegmentType.attach:
            planner.attach_object("can", "arm", "arm7_hand", touch_links=["arm7_palm"])
        elif segment.type == srmp.SegmentType.detach:
            planner.detach_object("can")
        else:
            certificate = planner.verify("arm", part.motion, clearance=clearance)
            assert certificate.holds, certificate.faults
            kept = part.motion.certificate.clearance_kept
            assert (kept.required, kept.violation) == (clearance, 0)
            relaxed |= {frozenset((pair.body_a, pair.body_b)) for pair in kept.relaxed}
            planner.set_qpos("arm", part.motion.positions[-1])
    assert frozenset(("can", "stand_left")) in relaxed  # 1 mm apart at first
    np.testing.assert_allclose(planner.get_object_pose("can").p, [0.55, -0.3, 0.471], atol=1e-3)


def test_moves_are_blended_where_they_keep_it(arm_alone):
    planner = arm_alone
    vias = [np.add(READY, [0.5, 0.2, 0, 0, 0, 0, 0]), np.add(READY, [0.9, -0.2, 0, 0.3, 0, 0, 0])]
    goal = np.add(READY, [1.4, 0, 0, 0, 0, 0.4, 0])
    segments = [*(Segment.move(q, blend_radius=0.05) for q in vias), Segment.move(goal)]
    planner.make_planner("arm", {"clearance": 0.02})
    passed = planner.plan_sequence(READY, segments)
    speeds = [
        np.abs(passed.trajectory.state(t)[1]).max() for t in np.arange(0.05, passed.trajectory.duration - 0.05, 0.01)
    ]
    assert min(speeds) > 0.05
    assert all(part.motion.certificate.clearance_kept.violation == 0 for part in passed.parts)
    hand = planner.compute_fk("arm", vias[0])
    planner.add_box("near", size=[0.1, 0.1, 0.02], pose=Pose(p=hand.p + 0.02 * hand.matrix()[:3, 2], q=hand.q))
    assert planner.distance_to_collision("arm", vias[0]) == pytest.approx(0.01, abs=1e-4)
    stops = planner.plan_sequence(READY, segments)
    np.testing.assert_allclose(stops.parts[0].motion.positions[-1], vias[0], atol=1e-9)
    np.testing.assert_allclose(stops.parts[0].motion.velocities[-1], 0, atol=1e-9)
    assert stops.parts[0].motion.certificate.clearance_kept.to_time < stops.parts[0].motion.duration
