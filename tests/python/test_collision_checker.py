"""Batch collision checking: spheres in front of Coal give Coal's results."""

import importlib.util
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import srmp

SUITE = Path(__file__).parents[2] / "bench" / "suites" / "agreement.py"
_spec = importlib.util.spec_from_file_location("agreement", SUITE)
agreement = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(agreement)
random_states = agreement.random_states


def assert_modes_agree(planner, name, count, seed=0):
    """Returns the fraction of free states."""
    counts, free = agreement.compare_modes(planner, name, random_states(planner, name, count, seed))
    assert counts["configurations"] == count
    assert counts["motions"] == count // 4
    assert (counts["exact"], counts["conservative"]) == (0, 0)
    return free.mean()


def test_exact_is_coal_and_conservative_is_never_free_wrongly(arm):
    arm.add_sphere("sphere", radius=0.15, pose=srmp.Pose(p=[0.2, 0.5, 0.5]))
    arm.add_capsule("bar", radius=0.05, length=0.5, pose=srmp.Pose(p=[-0.3, 0.3, 0.6]), padding=0.01)
    arm.add_cone("cone", radius=0.2, length=0.3, pose=srmp.Pose(p=[0.4, -0.4, 0.3]))
    cloud = np.random.default_rng(1).uniform([-0.6, -0.6, 0.2], [-0.4, -0.2, 0.8], (500, 3))
    arm.add_point_cloud("cloud", cloud, resolution=0.03)
    arm.add_box("held", size=[0.05, 0.1, 0.2], pose=srmp.Pose(p=[0, 0, 3]))
    arm.attach_object("held", "arm", "arm7_hand", pose_in_link=srmp.Pose(p=[0, 0, 0.2]))
    assert 0.02 < assert_modes_agree(arm, "arm", 4000) < 0.98


def test_statistics_say_which_layer_decided(arm):
    checker = arm.collision_checker("arm")
    agreement.check_all(checker, random_states(arm, "arm", 4000))
    stats = checker.stats()
    assert stats["states"] == 4000
    assert stats["motions"] == 1000
    assert stats["states_by_spheres"] + stats["motions_by_spheres"] > 2000


TETRAHEDRON = ([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.3]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def add_object(planner, kind, name, pose):
    adders = {
        "box": lambda: planner.add_box(name, size=[0.05, 0.1, 0.3], pose=pose),
        "sphere": lambda: planner.add_sphere(name, radius=0.1, pose=pose),
        "cylinder": lambda: planner.add_cylinder(name, radius=0.05, length=0.3, pose=pose),
        "capsule": lambda: planner.add_capsule(name, radius=0.05, length=0.3, pose=pose),
        "cone": lambda: planner.add_cone(name, radius=0.1, length=0.3, pose=pose),
        "mesh": lambda: planner.add_mesh(name, vertices=TETRAHEDRON[0], triangles=TETRAHEDRON[1], pose=pose),
        "cloud": lambda: planner.add_point_cloud(
            name, np.random.default_rng(2).uniform(-0.1, 0.1, (60, 3)), resolution=0.02, pose=pose
        ),
    }
    adders[kind]()


def test_vertices_of_a_mesh_are_scaled(arm):
    hand = arm.compute_fk("arm", np.zeros(7)).p
    beside = srmp.Pose(p=np.add(hand, [0.5, 0, 0]))
    millimetres = 1000 * np.array(TETRAHEDRON[0])
    for name, vertices, scale in (("a", TETRAHEDRON[0], None), ("b", millimetres, [1e-3] * 3)):
        arm.add_mesh(name, vertices=vertices, triangles=TETRAHEDRON[1], scale=scale, pose=beside)
        distance = arm.distance_to_collision("arm", np.zeros(7))
        arm.remove_object(name)
        if scale is None:
            expected = distance
    assert 0 < distance == pytest.approx(expected, abs=1e-9)


KINDS = ["box", "sphere", "cylinder", "capsule", "cone", "mesh", "cloud"]


@pytest.mark.parametrize("held", KINDS)
@pytest.mark.parametrize("around", KINDS)
def test_every_kind_in_the_hand_against_every_kind_around(arm, held, around):
    add_object(arm, held, "held", srmp.Pose(p=[0, 0, 3]))
    arm.attach_object("held", "arm", "arm7_hand", pose_in_link=srmp.Pose(p=[0, 0, 0.3]))
    for i, place in enumerate([[0.5, 0.4, 0.4], [-0.5, 0.3, 0.7], [0.1, -0.6, 0.9], [0.0, 0.5, 1.1]]):
        add_object(arm, around, f"around{i}", srmp.Pose(p=place, q=[0.5, 0.5, 0.5, 0.5]))
    assert_modes_agree(arm, "arm", 400, seed=KINDS.index(held))


@pytest.mark.parametrize("robot", ["panda", "ur5", "fetch"])
def test_agreement_on_motion_bench_maker(mbm_dir, tmp_path, robot):
    """The suite itself, with fewer configurations: modes, instruction sets, and Pinocchio's and Coal's own packages."""
    if not (mbm_dir / robot).is_dir():
        pytest.skip(f"the stand-in for MotionBenchMaker's data has no {robot}")
    for package in ("pinocchio", "coal", "yaml"):
        pytest.importorskip(package, reason=f"the suite needs {package}: pip install '.[test]'")
    options = f"--data {mbm_dir} --robots {robot} --configurations 7000 --problems 1 --recheck 0.02"
    command = [sys.executable, str(SUITE), *options.split(), "--out", str(tmp_path / "result.json")]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    results = json.loads((tmp_path / "result.json").read_text())
    assert len(results["rows"]) == 7
    assert all(len(row["backends"]) >= 1 for row in results["rows"])
    total = results["total"]
    assert total["configurations"] == 7000
    assert total["rechecked"] == 140
    assert 0 < total["free"] < 7000
    assert all(total[fault] == 0 for fault in agreement.FAULTS)


def test_meshes_far_apart_are_not_called_near(mbm_data):
    """Found by the suite: Coal's tree of triangles called these two near on a 15 µm part of the motion."""
    planner = agreement.load_robot(mbm_data, "ur5")
    checker = planner.collision_checker("ur5", "coal")
    a = np.array([0.2062372, 0.2466945, -2.6512656, 1.5938370, 1.4263714, 0.5440000])
    b = np.array([0.2135874, 0.2791976, -2.5644320, 1.5715717, 1.5087547, 0.5482689])
    assert checker.clearance([a, b]).min() > 0.01
    assert checker.certify_motion(a, b)


def test_certificate_names_the_part_that_is_not_free(arm, ready):
    checker = arm.collision_checker("arm")
    through = np.array(ready)
    through[0] -= 1.8  # sweeps through the post
    proof = checker.certify_motion(ready, ready + 0.01)
    assert proof
    assert proof.interval == (0.0, 0.0)
    assert (proof.body_a, proof.body_b) == ("", "")
    refusal = checker.certify_motion(ready, through)
    assert not refusal.proved
    assert 0 <= refusal.interval[0] == refusal.interval[1] <= 1  # a contact
    assert not checker.are_free([ready + refusal.interval[0] * (through - ready)])[0]
    assert refusal.body_b == "post"
    assert not checker.motions_free([ready], [through])[0]


def test_motions_with_clearance_are_proved_and_samples_of_proved_ones_are_free(arm):
    checker = arm.collision_checker("arm", "coal")
    a = random_states(arm, "arm", 300)
    b = a + 0.1 * (random_states(arm, "arm", 300, 1) - a)
    steps = np.linspace(0, 1, 60)[:, None]
    proved = clear = 0
    for start, end in zip(a, b, strict=True):
        samples = start + steps * (end - start)
        free = checker.are_free(samples)
        proof = checker.certify_motion(start, end)
        assert not proof or free.all()
        if free.all() and checker.clearance(samples[::4]).min() > 0.005:
            clear += 1
            proved += proof.proved
    assert clear > 50
    assert proved >= 0.95 * clear


def nearest_on_the_way(arm, start, end):
    """[m] the least clearance from start to end, to less than a micrometre."""
    checker, low, high = arm.collision_checker("arm", "coal"), 0.0, 1.0
    for _ in range(4):
        fractions = np.linspace(low, high, 1001)
        found = checker.clearance(start + fractions[:, None] * (end - start))
        step, best = fractions[1] - low, fractions[found.argmin()]
        low, high = max(best - 2 * step, 0.0), min(best + 2 * step, 1.0)
    return found.min()


@pytest.mark.parametrize("gap", [6e-6, 8.5e-6, 15e-6])
@pytest.mark.parametrize("seed", range(8))
def test_motions_that_pass_by_micrometres_are_proved(seed, gap):
    arm = srmp.PlannerInterface()
    arm.add_articulation(
        urdf_path=srmp.data_path("arm7.urdf"),
        srdf_path=srmp.data_path("arm7.srdf"),
        name="arm",
        end_effector="arm7_hand",
    )
    rng = np.random.default_rng(seed)
    start = np.array([0.0, 0.5, 0.0, 1.2, 0.0, 1.0, 0.0]) + rng.uniform(-0.2, 0.2, 7)
    end = start + rng.uniform(-0.8, 0.8, 7) * [1, 0.2, 0.5, 0.2, 1, 0.5, 1]
    above = srmp.Pose(p=arm.compute_fk("arm", (start + end) / 2).p + np.array([0, 0, 0.25]))
    radius, nearest = 0.01, 1.0
    while nearest > 0.018:  # two links are 20 mm apart, wherever the joints are
        radius += min(nearest, 0.015)
        if "near" in arm.object_names:
            arm.remove_object("near")
        arm.add_sphere("near", radius, above)
        nearest = nearest_on_the_way(arm, start, end)
    arm.remove_object("near")
    arm.add_sphere("near", radius + nearest - gap, above)
    checker = arm.collision_checker("arm")
    if checker.motions_free([start], [end])[0]:
        assert checker.certify_motion(start, end)


def test_clearance_is_the_nearest_pair(arm):
    checker = arm.collision_checker("arm")
    q = random_states(arm, "arm", 50)
    clearance = checker.clearance(q)
    for row, distance in zip(q, clearance, strict=True):
        assert distance == checker.nearest(row).distance
        with_base = arm.distance_to_collision("arm", row)  # which is 1 mm above the table
        assert with_base == (distance if distance < 0.0009 else pytest.approx(0.001, abs=2e-6))
    np.testing.assert_array_equal(clearance > 0, checker.are_free(q))


def test_a_checker_is_a_snapshot(arm, ready):
    checker = arm.collision_checker("arm")
    assert checker.are_free(ready).tolist() == [True]
    arm.add_box("everywhere", size=[3, 3, 3], pose=srmp.Pose(p=[0, 0, 0]))
    assert checker.are_free(ready).tolist() == [True]
    assert arm.collision_checker("arm").are_free([ready, ready]).tolist() == [False, False]
    assert arm.collision_checker("arm").are_free(np.zeros((0, 7))).shape == (0,)


def test_threads_share_a_checker(arm):
    checker = arm.collision_checker("arm")
    q = random_states(arm, "arm", 2000)
    expected = checker.are_free(q)
    results = [None] * 4

    def work(i):
        results[i] = checker.are_free(q)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        np.testing.assert_array_equal(result, expected)


PLAN = """
import hashlib, srmp
from srmp.demo import run
print(hashlib.sha256(run({"planner_id": "wAstar", "time_limit": 60}).trajectory.positions.tobytes()).hexdigest())
"""


def test_paths_are_the_same_on_every_instruction_set():
    hashes = {}
    for backend in ("", "portable", "avx2", "avx512"):
        outcome = subprocess.run(
            [sys.executable, "-c", PLAN], env={**os.environ, "SRMP_SIMD": backend}, capture_output=True, text=True
        )
        if "which this CPU does not have" not in outcome.stderr:
            assert outcome.returncode == 0, outcome.stderr
            hashes[backend] = outcome.stdout
    assert len(hashes) >= 2
    assert len(set(hashes.values())) == 1


def test_unknown_instruction_set_is_refused():
    environment = {**os.environ, "SRMP_SIMD": "avx3"}
    outcome = subprocess.run([sys.executable, "-c", PLAN], env=environment, capture_output=True, text=True)
    assert "SRMP_SIMD is 'avx3', did you mean 'avx2'?" in outcome.stderr


@pytest.mark.parametrize(
    ("query", "message"),
    [
        (lambda p: p.collision_checker("arm", "exakt"), "mode is 'exakt', did you mean 'exact'"),
        (lambda p: p.collision_checker("harm"), "did you mean 'arm'"),
        (lambda p: p.collision_checker("arm").are_free([[0.0] * 6]), r"q must have the shape \(n, 7\), not \(1, 6\)"),
        (lambda p: p.collision_checker("arm").are_free([[0.0] * 7, [np.nan] * 7]), "configuration 1"),
        (lambda p: p.collision_checker("arm").motions_free([[0.0] * 7], [[0.0] * 7] * 2), "a has 1 rows and b has 2"),
        (lambda p: p.collision_checker("arm").certify_motion([0.0] * 7, [np.inf] * 7), "end of the motion"),
        (lambda p: p.collision_checker("arm").clearance("near"), "q must be numbers"),
    ],
)
def test_bad_input(arm, query, message):
    with pytest.raises(srmp.InvalidArgument, match=message):
        query(arm)


def test_a_robot_is_filtered_out_of_its_own_cloud(arm):
    start = np.zeros(7)
    arm.set_qpos("arm", start)
    arm.add_box("held", size=[0.06, 0.06, 0.2], pose=srmp.Pose(p=[0, 0, 3]))
    arm.attach_object("held", "arm", "arm7_hand", pose_in_link=srmp.Pose(p=[0, 0, 0.2]))
    # A grid around the arm: what the camera would see of it, and of the room.
    axis = np.arange(-0.6, 0.6, 0.02)
    grid = np.stack(np.meshgrid(axis, axis, np.arange(0.0, 1.4, 0.02), indexing="ij"), -1).reshape(-1, 3)
    pose = srmp.Pose(p=[0.01, 0.0, 0.005])
    arm.add_point_cloud("all", grid, resolution=0.02, pose=pose)
    assert arm.is_state_colliding("arm", start)
    arm.remove_object("all")
    arm.add_point_cloud("room", grid, resolution=0.02, pose=pose, self_filter_distance=0.04)
    assert not arm.is_state_colliding("arm", start)
    # Nothing else is taken away: what is left comes within twice the cube's diagonal of the distance.
    assert arm.distance_to_collision("arm", start) < 0.04 + 2 * 0.02 * np.sqrt(3)


def test_filtering_refuses_bad_distances_and_empty_rooms(arm):
    point = [[0.0, 0.0, 0.05]]
    for distance in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(srmp.InvalidArgument, match="self_filter_distance"):
            arm.add_point_cloud("cloud", point, self_filter_distance=distance)
    with pytest.raises(srmp.InvalidArgument, match="all 1 points are within self_filter_distance 3"):
        arm.add_point_cloud("cloud", point, self_filter_distance=3.0)
    assert "cloud" not in arm.object_names


@pytest.fixture
def two_arms():
    planner = srmp.PlannerInterface()
    for name, x in (("left", -0.3), ("right", 0.3)):
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"),
            srdf_path=srmp.data_path("arm7.srdf"),
            name=name,
            end_effector="arm7_hand",
            base_pose=srmp.Pose(p=[x, 0, 0]),
        )
    return planner


def test_beside_a_robot_that_moves(two_arms):
    rng = np.random.default_rng(3)
    limits = np.clip(two_arms.get_joint_limits("right")[:, :2], -2, 2)
    path = rng.uniform(limits[:, 0], limits[:, 1], (4, 7))
    times = np.array([0.0, 1.0, 1.5, 3.0])
    checker = two_arms.timed_collision_checker("left", {"right": (times, path)})
    assert checker.dof == 7
    q = rng.uniform(limits[:, 0], limits[:, 1], (60, 7))
    when = rng.uniform(-0.5, 3.5, 60)
    free, clearance = checker.are_free(q, when), checker.clearance(q, when)
    for i in range(60):
        two_arms.set_qpos("right", [np.interp(when[i], times, joint) for joint in path.T])
        assert free[i] == (not two_arms.is_state_colliding("left", q[i]))
        if free[i]:
            assert clearance[i] == pytest.approx(two_arms.distance_to_collision("left", q[i]), abs=1e-5)
    assert 0.1 < free.mean() < 1


def test_motions_beside_a_robot_that_moves(two_arms):
    rng = np.random.default_rng(4)
    limits = np.clip(two_arms.get_joint_limits("right")[:, :2], -2, 2)
    path = rng.uniform(limits[:, 0], limits[:, 1], (5, 7))
    times = np.array([0.0, 0.5, 1.0, 2.0, 3.0])
    exact, coal = (
        two_arms.timed_collision_checker("left", {"right": (times, path)}, mode) for mode in ("exact", "coal")
    )
    a = rng.uniform(limits[:, 0], limits[:, 1], (80, 7))
    b = a + rng.uniform(-0.4, 0.4, a.shape)
    start = rng.uniform(-0.2, 2.5, 80)
    end = start + rng.uniform(0, 1, 80)
    free = exact.motions_free(a, b, start, end)
    np.testing.assert_array_equal(free, coal.motions_free(a, b, start, end))
    assert 0.1 < free.mean() < 0.9
    for i in range(80):
        t = np.linspace(0, 1, 200)
        sampled = exact.are_free(a[i] + t[:, None] * (b[i] - a[i]), start[i] + t * (end[i] - start[i]))
        assert not free[i] or sampled.all()
        proof = exact.certify_motion(a[i], b[i], start[i], end[i])
        assert bool(proof) == free[i]
        if not proof and not sampled.all():
            assert 0 <= proof.interval[0] <= proof.interval[1] <= 1
    # What the other does by itself is not this robot's collision.
    two_arms.add_box("wall", size=[0.1, 3, 3], pose=srmp.Pose(p=[0.85, 0, 0]))
    ready = two_arms.get_group_states("left")["ready"]
    into_wall = np.array([[0, 1.5, 0, 0, 0, 0, 0]], float)
    assert two_arms.timed_collision_checker("left", {"right": ([0.0], into_wall)}).are_free(ready, 0.0).all()


def test_timed_checkers_refuse_nonsense(two_arms):
    q = np.zeros(7)
    bad = {
        "unknown robot": ({"rigt": ([0.0], [q])}, "right"),
        "not a dict": ([1], "others must be a dict"),
        "no pair": ({"right": [0.0]}, r"others\['right'\] must be \(times, configurations\)"),
        "empty": ({"right": ([], np.zeros((0, 7)))}, "is empty"),
        "sizes": ({"right": ([0.0, 1.0], [q])}, "2 times, but 1 configurations"),
        "order": ({"right": ([1.0, 1.0], [q, q])}, "not after the one before"),
        "NaN time": ({"right": ([np.nan], [q])}, "times"),
        "NaN": ({"right": ([0.0], [q * np.nan])}, "configuration 0 of the path of robot 'right'"),
        "wrong dof": ({"right": ([0.0], [q[:3]])}, "configuration 0 of the path of robot 'right'"),
        "itself": ({"left": ([0.0], [q])}, "named twice"),
    }
    for others, message in bad.values():
        with pytest.raises(srmp.InvalidArgument, match=message):
            two_arms.timed_collision_checker("left", others)
    checker = two_arms.timed_collision_checker("left", {"right": ([0.0], [q])})
    with pytest.raises(srmp.InvalidArgument, match="before that"):
        checker.motions_free(q, q, 1.0, 0.0)
    with pytest.raises(srmp.InvalidArgument, match="times must be one time"):
        checker.are_free(np.zeros((3, 7)), [0.0, 1.0])
    with pytest.raises(srmp.InvalidArgument, match="finite time"):
        checker.are_free(q, np.inf)
