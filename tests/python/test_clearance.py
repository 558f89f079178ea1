"""The options `clearance` and `preferred_clearance`, by distances of Pinocchio's and Coal's own Python packages."""

import copy
import itertools
import pickle

import numpy as np
import pytest

import srmp

CLEARANCE = 0.015
TOLERANCE = 3e-5  # [m] that the rule at the ends allows, and Coal's rounding
BUILT_CLOSE = frozenset(("arm/arm7_wrist", "arm/arm7_flange"))  # 20 mm, wherever the joint between them is


def random_objects(rng, count=8):
    objects = []
    for k in range(count):
        kind = ("box", "sphere", "cylinder")[k % 3]
        size = rng.uniform(0.04, 0.2, {"box": 3, "sphere": 1, "cylinder": 2}[kind])
        angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.35, 0.8)
        p = [radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.0, 0.9)]
        objects.append({"name": f"object{k}", "type": kind, "size": size.tolist(), "pose": [*p, 0, 0, 0, 1]})
    return objects


def add(planner, item):
    pose = srmp.Pose(p=item["pose"][:3])
    adders = {"box": planner.add_box, "sphere": planner.add_sphere, "cylinder": planner.add_cylinder}
    size = [item["size"]] if item["type"] == "box" else item["size"]
    adders[item["type"]](item["name"], *size, pose)


def scenario(objects, held=()):
    robot = {
        "urdf": srmp.data_path("arm7.urdf"),
        "srdf": srmp.data_path("arm7.srdf"),
        "package_dirs": [],
        "base": [0, 0, 0, 0, 0, 0, 1],
        "fixed_joints": {},
    }
    return {"robots": {"arm": robot}, "held": list(held), "objects": objects}


def make_arm():
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="arm",
        end_effector="arm7_hand",
    )
    return planner


class Measured:
    """Distances of all pairs of bodies along a motion, by Pinocchio and Coal alone."""

    def __init__(self, suite, objects, held=()):
        self.pin = pytest.importorskip("pinocchio")
        suite("recheck_multi")
        from srmp.recheck.world import World

        self.world = World(scenario(objects, held))
        parts = [self.world.body(part) for part in self.world.geometry.geometryObjects]
        pairs = self.world.geometry.collisionPairs
        self.pairs = [frozenset((parts[pair.first], parts[pair.second])) for pair in pairs]

    def at(self, names, position):
        world = self.world
        q = world.default_q.copy()
        for name, value in zip(names, position, strict=True):
            world.set_joint(q, f"arm/{name}", value)
        self.pin.updateGeometryPlacements(world.model, world.data, world.geometry, world.geometry_data, q)
        self.pin.computeDistances(world.geometry, world.geometry_data)
        return np.array([result.min_distance for result in world.geometry_data.distanceResults])

    def along(self, motion):
        """(instants, pairs) [m], of bodies, at instants that no joint moves by more than 4 mrad between."""
        times = [motion.times[0]]
        for a, b, t, u in zip(motion.positions, motion.positions[1:], motion.times, motion.times[1:], strict=False):
            steps = int(np.ceil(np.abs(b - a).max() / 4e-3)) + 1
            times += np.linspace(t, u, steps + 1)[1:].tolist()
        found = np.array([self.at(motion.joint_names, motion.sample(t)) for t in times])
        bodies = list(dict.fromkeys(self.pairs))
        of = [[k for k, pair in enumerate(self.pairs) if pair == body] for body in bodies]
        return np.array(times), bodies, np.stack([found[:, columns].min(axis=1) for columns in of], axis=1)


def require_kept(distances, clearance):
    """One pair's: above the clearance but near ends that are closer, and there never less than nearer to that end."""
    kept = np.flatnonzero(distances >= clearance - TOLERANCE)
    assert len(kept)
    first, last = kept[0], kept[-1]
    assert (distances[first : last + 1] >= clearance - TOLERANCE).all()
    for way in (distances[: first + 1], distances[last:][::-1]):
        assert (way >= np.maximum.accumulate(way) - TOLERANCE).all()


def ends(planner, rng, count):
    """Free configurations, many of them close to something."""
    limits = np.clip(np.array(planner.get_joint_limits("arm"))[:, :2], -2.9, 2.9)
    q = rng.uniform(limits[:, 0], limits[:, 1], (400, len(limits)))
    q = q[planner.collision_checker("arm").are_free(q)]
    distance = np.array([planner.distance_to_collision("arm", row) for row in q])
    close, far = q[(distance > 2e-3) & (distance < CLEARANCE)], q[distance > CLEARANCE]
    picked = [close if k % 2 else far for k in range(count)]
    return [rows[k // 2] for k, rows in enumerate(picked)]


@pytest.mark.parametrize("seed", range(4))
def test_motions_in_random_worlds_keep_it_except_near_ends_that_are_closer(suite, seed):
    rng = np.random.default_rng(seed)
    objects = random_objects(rng)
    planner = make_arm()
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
        times, bodies, distances = measured.along(motion)
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
    _, bodies, distances = Measured(suite, [POST], [carried]).along(motion)
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
    assert motion.slice(0, 1).followed_by(motion.slice(1, motion.duration)).certificate.clearance_kept is None


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


@pytest.mark.parametrize("name", ["clearance", "preferred_clearance"])
def test_what_cannot_keep_it_says_so(post, name):
    post.make_planner(["arm"], {name: 0.01})
    here = post.compute_fk("arm", START)
    away = srmp.Pose(p=here.p + np.array([0, 0, 0.05]), q=here.q)
    for call in (
        lambda: post.plan_multi({"arm": START}, {"arm": GOAL}),
        lambda: post.plan_linear("arm", START, away),
        lambda: post.follow("arm", START, [away]),
        lambda: post.plan_sequence("arm", START, [srmp.Segment.move(GOAL)]),
    ):
        with pytest.raises(srmp.NotSupported, match=f"{name} is 0.01 m, but .* cannot keep a clearance"):
            call()


def test_ends_in_contact_are_invalid_as_ever(post):
    post.add_sphere("in the way", 0.1, srmp.Pose(p=post.compute_fk("arm", GOAL).p))
    post.make_planner(["arm"], {"clearance": 0.01})
    with pytest.raises(srmp.PlanningError, match=r"the goal is invalid: .* overlap") as caught:
        post.plan("arm", START, GOAL)
    assert caught.value.status == srmp.Status.goal_invalid
    with pytest.raises(srmp.PlanningError, match=r"the start is invalid: .* overlap") as caught:
        post.plan("arm", GOAL, START)
    assert caught.value.status == srmp.Status.start_invalid


# --- preferred_clearance


def levels(clearance):
    return [clearance * fraction for fraction in (1, 0.5, 0.25, 0.125, 0)]


@pytest.mark.parametrize("seed", range(2))
def test_shortening_gives_away_no_clearance_that_the_searched_path_had(suite, seed):
    rng = np.random.default_rng(100 + seed)
    objects = random_objects(rng, 6)
    planner = make_arm()
    for item in objects:
        add(planner, item)
    measured = Measured(suite, objects)
    points = ends(planner, rng, 4)

    def least(start, goal, **options):
        planner.make_planner(["arm"], {"time_limit": 20.0, **options})
        motion = planner.plan("arm", start, goal)
        assert motion.certificate.proved_free
        _, _, distances = measured.along(motion)
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
