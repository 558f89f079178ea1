"""The options `clearance` and `preferred_clearance`, by distances of Pinocchio's and Coal's own Python packages."""

import copy
import itertools
import pickle

import numpy as np
import pytest
from clearance_worlds import (
    BUILT_CLOSE,
    CLEARANCE,
    FACING_BASES,
    TOLERANCE,
    Measured,
    add,
    ends,
    make_arms,
    random_objects,
    require_kept,
)

import srmp


@pytest.mark.parametrize("seed", range(4))
def test_motions_in_random_worlds_keep_it_except_near_ends_that_are_closer(suite, seed):
    rng = np.random.default_rng(seed)
    objects = random_objects(rng)
    planner = make_arms()
    for item in objects:
        add(planner, item)
    planner.make_planner(["arm"], {"clearance": CLEARANCE, "time_limit": 20.0})
    measured = Measured(suite, objects)
    points = ends(planner, rng, 4)
    solved = 0
    for start, goal in itertools.pairwise(points):
        try:
            motion = planner.plan("arm", start, goal)
        except srmp.PlanningError as error:
            assert error.status != srmp.Status.timed_out
            continue
        solved += 1
        certificate = motion.certificate
        kept = certificate.clearance_kept
        assert certificate.holds
        assert certificate.proved_free
        assert kept.required == CLEARANCE
        assert kept.violation == 0
        np.testing.assert_array_equal(motion.positions[0], start)
        np.testing.assert_allclose(motion.positions[-1], goal, atol=1e-9)
        times, bodies, distances = measured.along({"arm": motion})
        for k, pair in enumerate(bodies):
            if pair != BUILT_CLOSE:
                require_kept(distances[:, k], CLEARANCE)
        within = (times >= kept.from_time) & (times <= kept.to_time)
        others = [k for k, pair in enumerate(bodies) if pair != BUILT_CLOSE]
        assert (distances[np.ix_(within, others)] >= CLEARANCE - 3e-6).all()
        close = {frozenset((r.body_a, r.body_b)) for r in kept.relaxed}
        for row in (0, -1):
            at_end = {bodies[k] for k in others if distances[row, k] < CLEARANCE - 1e-5}
            assert {frozenset(name.removeprefix("arm/") for name in pair) for pair in at_end} <= close
    assert solved >= 2


START = [-0.7, 0.4, 0.0, 1.2, 0.0, 1.0, 0.0]
GOAL = [0.7, 0.4, 0.0, 1.2, 0.0, 1.0, 0.0]
POST = {"name": "post", "type": "box", "size": [0.04, 0.04, 1.0]}


@pytest.fixture
def post(arm_alone):
    """A post in the way of the hand from side to side: the shortest paths graze it."""
    between = arm_alone.compute_fk("arm", np.mean([START, GOAL], axis=0)).p
    POST["pose"] = [*(between - np.array([0, 0, 0.4])), 0, 0, 0, 1]
    add(arm_alone, POST)
    return arm_alone


def plan(planner, **options):
    planner.make_planner(["arm"], options)
    return planner.plan("arm", START, GOAL)


def test_the_whole_motion_keeps_it_where_both_ends_do(post):
    closest = plan(post).certificate.clearance
    motion = plan(post, clearance=0.05)
    kept = motion.certificate.clearance_kept
    assert (kept.from_time, kept.to_time) == (motion.times[0], motion.times[-1])
    assert kept.relaxed == []
    assert kept.close_links
    assert "required       50 mm, kept" in motion.certificate.report()
    assert plan(post).certificate.clearance == closest  # and 0 is what it was
    assert plan(post).certificate.clearance_kept is None


def test_objects_that_are_held_keep_it_too(post, suite):
    held = {"name": "rod", "type": "cylinder", "size": [0.01, 0.3], "pose": [0, 0, 0.1, 0, 0, 0, 1]}
    post.add_cylinder("rod", 0.01, 0.3, srmp.Pose(p=[2, 2, 2]))
    touched = [link for link in post.get_link_names("arm") if link.split("_")[-1] in ("hand", "palm", "flange")]
    post.attach_object("rod", "arm", "arm7_hand", touch_links=touched, pose_in_link=srmp.Pose(p=[0, 0, 0.1]))
    motion = plan(post, clearance=0.015)
    carried = {**held, "robot": "arm", "link": "arm7_hand", "may_touch": touched}
    _, bodies, distances = Measured(suite, [POST], [carried]).along({"arm": motion})
    assert distances[:, bodies.index(frozenset(("rod", "post")))].min() >= 0.015 - 3e-6


def test_a_robot_that_stands_beside_keeps_its_distance_too(post):
    post.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="other",
        base_pose=srmp.Pose(p=[0.9, 0, 0]),
    )
    motion = plan(post, clearance=0.03)
    apart = [post.distance_to_collision("arm", q) for q in motion.positions]
    assert motion.certificate.clearance_kept.violation == 0
    assert min(apart) > 0


def test_the_same_request_has_the_same_result(post):
    for options in ({"clearance": 0.03}, {"preferred_clearance": 0.03}):
        motions = [plan(post, **options) for _ in range(2)]
        plan(post)
        motions.append(plan(post, **options))
        for motion in motions[1:]:
            np.testing.assert_array_equal(motion.positions, motions[0].positions)
            np.testing.assert_array_equal(motion.times, motions[0].times)


def test_the_certificate_is_a_value(post):
    motion = plan(post, clearance=0.03)
    kept = motion.certificate.clearance_kept
    assert pickle.loads(pickle.dumps(kept)) == kept == copy.deepcopy(kept)
    assert pickle.loads(pickle.dumps(motion)).certificate.clearance_kept == kept
    as_dict = motion.certificate.to_dict()["clearance_kept"]
    assert (as_dict["required"], as_dict["violation"]) == (0.03, 0)
    assert "violation 0 m" in repr(kept)
    half = motion.slice(0.0, motion.duration / 2).certificate.clearance_kept
    assert (half.from_time, half.to_time) == (0.0, motion.duration / 2)
    assert motion.slice(0, 1).followed_by(motion.slice(1, motion.duration)).certificate.clearance_kept == kept


def test_joined_motions_keep_what_both_of_them_keep(post):
    there = plan(post, clearance=0.03)

    def there_and_back(**options):
        post.make_planner(["arm"], options)
        return there.followed_by(post.plan("arm", GOAL, START)).certificate.clearance_kept

    whole = there_and_back(clearance=0.03)
    assert (whole.required, whole.violation, whole.from_time, whole.at_stops) == (0.03, 0, 0, [])
    assert whole.to_time > there.duration + 0.5
    assert there_and_back(clearance=0.02) is None
    assert there_and_back() is None


def test_the_certificate_is_in_files(post, tmp_path):
    motion = plan(post, clearance=0.03)
    motion.save(str(tmp_path / "motion.json"))
    again = srmp.Trajectory.load(str(tmp_path / "motion.json"))
    assert again.certificate.clearance_kept == motion.certificate.clearance_kept


@pytest.mark.parametrize("name", ["clearance", "preferred_clearance"])
@pytest.mark.parametrize("value", [-0.01, float("nan"), float("inf"), "near"])
def test_bad_values_are_refused(post, name, value):
    plan(post)
    before = post.get_planning_stats()
    with pytest.raises(srmp.InvalidArgument, match=name) as caught:
        post.make_planner(["arm"], {name: value})
    assert len(str(caught.value)) < 500
    assert "\n" not in str(caught.value)
    assert post.get_planning_stats() == before


def test_ends_in_contact_are_invalid_as_ever(post):
    post.add_sphere("in the way", 0.1, srmp.Pose(p=post.compute_fk("arm", GOAL).p))
    post.make_planner(["arm"], {"clearance": 0.01})
    with pytest.raises(srmp.PlanningError, match=r"the goal is invalid: .* overlap") as caught:
        post.plan("arm", START, GOAL)
    assert caught.value.status == srmp.Status.goal_invalid
    with pytest.raises(srmp.PlanningError, match=r"the start is invalid: .* overlap") as caught:
        post.plan("arm", GOAL, START)
    assert caught.value.status == srmp.Status.start_invalid


# --- several robots


def apart(planner, rng, count):
    """Configurations of both robots that keep 20 mm from everything and from each other."""
    found = []
    for _ in range(4000):
        q = {name: rng.uniform(-1.8, 1.8, 7) for name in planner.robot_names}
        for name, row in q.items():
            planner.set_qpos(name, row)
        if all(planner.distance_to_collision(name, row) > 0.02 - 1e-4 for name, row in q.items()):
            found.append(q)
        if len(found) == count:
            return found
    raise AssertionError("too few configurations are free")


@pytest.mark.parametrize("planner_id", ["auto", "xECBS", "prioritised"])
@pytest.mark.parametrize("seed", range(2))
def test_robots_keep_it_from_each_other_and_from_everything_else(suite, seed, planner_id):
    rng = np.random.default_rng(200 + seed)
    objects = random_objects(rng, 3)
    planner = make_arms(FACING_BASES)
    for item in objects:
        add(planner, item)
    points = apart(planner, rng, 4)
    measured = Measured(suite, objects, bases=FACING_BASES)
    planner.make_planner(["arm", "other"], {"planner_id": planner_id, "clearance": CLEARANCE, "time_limit": 20.0})
    solved = 0
    for starts, goals in itertools.pairwise(points):
        try:
            motions = planner.plan_multi(starts, goals)
        except srmp.PlanningError as error:
            assert "clearance" in str(error) or error.status != srmp.Status.start_invalid
            continue
        solved += 1
        _, bodies, distances = measured.along(dict(motions.items()))
        built_close = [frozenset(f"{name}/{part.split('/')[1]}" for part in BUILT_CLOSE) for name in FACING_BASES]
        for k, pair in enumerate(bodies):
            if pair not in built_close:
                assert distances[:, k].min() >= CLEARANCE - 3e-6, pair
        verified = planner.verify_multi(motions, starts, goals, clearance=CLEARANCE)
        for name, motion in motions.items():
            kept = motion.certificate.clearance_kept
            assert (kept.required, kept.violation, kept.relaxed) == (CLEARANCE, 0, [])
            assert (kept.from_time, kept.to_time) == (motion.times[0], motion.times[-1])
            assert motion.certificate.proved_free
            assert verified[name].holds
            assert verified[name].clearance_kept == kept
    assert solved >= 1


SIDE, OTHER_SIDE = [0.7, 0.9, 0, 1.2, 0, 1, 0], [-0.7, 0.9, 0, 1.2, 0, 1, 0]


def swap(planner, planner_id="auto", **options):
    """The hands of both pass each other between the robots."""
    planner.make_planner(["arm", "other"], {"planner_id": planner_id, **options})
    return planner.plan_multi({"arm": SIDE, "other": SIDE}, {"arm": OTHER_SIDE, "other": OTHER_SIDE})


def test_verify_multi_tells_by_how_much_robots_come_too_close():
    planner = make_arms(FACING_BASES)
    motions = swap(planner, "xECBS")  # auto's are 7 cm apart
    nearest = motions["arm"].certificate.clearance
    assert nearest < 0.02
    for certificate in planner.verify_multi(motions, clearance=0.03).values():
        assert [fault.kind for fault in certificate.faults] == [srmp.FaultKind.clearance]
        assert certificate.clearance_kept.violation == pytest.approx(0.03 - nearest, abs=1e-4)
    for certificate in planner.verify_multi(swap(planner, clearance=0.03), clearance=0.03).values():
        assert certificate.holds
    with pytest.raises(srmp.InvalidArgument, match="clearance is -1; it must be 0 m or above"):
        planner.verify_multi(motions, clearance=-1)


def test_several_robots_have_to_begin_and_end_with_it():
    planner = make_arms(FACING_BASES)
    near = planner.compute_fk("arm", SIDE).p
    planner.add_sphere("near", 0.02, srmp.Pose(p=near + np.array([0, 0, 0.27])))
    planner.set_qpos("arm", SIDE)
    distance = planner.distance_to_collision("arm", SIDE)
    assert 0 < distance < 0.019
    with pytest.raises(
        srmp.PlanningError, match=r"robot 'arm': the start is invalid: .* less than the clearance"
    ) as caught:
        swap(planner, clearance=distance + 0.01)
    assert caught.value.status == srmp.Status.start_invalid
    planner.remove_object("near")
    facing = [0.0, 0.9, 0, 1.2, 0, 1, 0]
    planner.make_planner(["arm", "other"], {"clearance": 0.3})
    with pytest.raises(
        srmp.PlanningError, match=r"'arm' and 'other' are too close: .* less than the clearance"
    ) as caught:
        planner.plan_multi({"arm": facing, "other": SIDE}, {"arm": SIDE, "other": OTHER_SIDE})
    assert caught.value.status == srmp.Status.start_invalid


def test_what_several_robots_cannot_keep_is_refused():
    planner = make_arms(FACING_BASES)
    motions = swap(planner)
    with pytest.raises(srmp.NotSupported, match="plan_multi knows no preferred clearance"):
        swap(planner, preferred_clearance=0.01)
    planner.make_planner(["arm"], {"clearance": 0.01})
    with pytest.raises(srmp.NotSupported, match="plan_multi among robots in motion cannot keep a clearance"):
        planner.plan_multi({"arm": SIDE}, {"arm": OTHER_SIDE}, obstacles={"other": motions["other"]})


# --- preferred_clearance


def levels(clearance):
    return [clearance * fraction for fraction in (1, 0.5, 0.25, 0.125, 0)]


@pytest.mark.parametrize("seed", range(2))
def test_shortening_gives_away_no_clearance_that_the_searched_path_had(suite, seed):
    rng = np.random.default_rng(100 + seed)
    objects = random_objects(rng, 6)
    planner = make_arms()
    for item in objects:
        add(planner, item)
    measured = Measured(suite, objects)
    points = ends(planner, rng, 4)

    def least(start, goal, **options):
        planner.make_planner(["arm"], {"time_limit": 20.0, **options})
        motion = planner.plan("arm", start, goal)
        assert motion.certificate.proved_free
        _, _, distances = measured.along({"arm": motion})
        return distances.min()

    for start, goal in itertools.pairwise(points):
        try:
            searched = least(start, goal, shortcut=False, blend_deviation=0.0)
        except srmp.PlanningError:
            continue
        kept = max(level for level in levels(CLEARANCE) if level < max(searched - 1e-4, 1e-9))
        assert least(start, goal, preferred_clearance=CLEARANCE) >= kept - TOLERANCE


def test_the_path_passes_at_the_preferred_clearance_where_it_can(post):
    grazing, wide = plan(post), plan(post, preferred_clearance=0.015)
    assert grazing.certificate.clearance < 0.01
    assert wide.certificate.clearance >= 0.015
    assert wide.certificate.clearance_kept is None
