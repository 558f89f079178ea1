"""Input that once ended the process, never returned, or raised what is no srmp.Error."""

import contextlib
import os
import re
import struct
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import srmp

HUGE = [1e4, 1e20, 1e80, 1e160, 1e300]


def sentence(error):
    text = str(error.value)
    assert len(text) < 500 and "\n" not in text
    return text


def plate(seed, n=4, size=0.5):
    """A flat plate of n x n squares, turned, in float32: corners (m, 3) and triangles."""
    squares = [(i, j, k) for i in range(n) for j in range(n) for k in range(2)]
    corners = {0: ((0, 0), (1, 0), (1, 1)), 1: ((0, 0), (1, 1), (0, 1))}
    flat = np.array([(i + x, j + y, 0) for i, j, k in squares for x, y in corners[k]], float) / n * size
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    vertices = (flat @ turn).astype(np.float32)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def write_stl(path, vertices):
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *vertices[i : i + 3].ravel(), 0) for i in range(0, len(vertices), 3)
    )
    path.write_bytes(b"x" * 80 + struct.pack("<I", len(vertices) // 3) + facets)


def plate_urdf(path):
    return (
        f"<robot name='r'><link name='a'><collision><geometry><mesh filename='{path}'/></geometry></collision></link>"
        "<link name='b'/><joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
        "<limit lower='-1' upper='1' velocity='1' effort='1'/></joint></robot>"
    )


@pytest.mark.parametrize("way", ["vertices", "file", "urdf", "convex", "scene file", "attached"])
def test_flat_plates_are_meshes(way, tmp_path, arm, ready):
    for seed in range(20):
        vertices, triangles = plate(seed)
        write_stl(tmp_path / "plate.stl", vertices)
        planner = srmp.PlannerInterface()
        if way == "urdf":
            planner.add_articulation(urdf_text=plate_urdf(tmp_path / "plate.stl"))
            continue
        if way == "convex":  # a solid of hardly any volume
            with contextlib.suppress(srmp.InvalidArgument):
                planner.add_mesh("plate", vertices=vertices, triangles=triangles, convex=True)
            continue
        if way == "attached":
            arm.add_mesh("plate", vertices=0.1 * vertices, triangles=triangles)
            arm.attach_object("plate", "arm", "arm7_hand", pose_in_link=srmp.Pose(p=[0, 0, 0.2]))
            assert not arm.is_state_colliding("arm", ready)
            arm.remove_object("plate")
            continue
        if way == "vertices":
            planner.add_mesh("plate", vertices=vertices, triangles=triangles)
        else:
            planner.add_mesh("plate", path=str(tmp_path / "plate.stl"))
        if way == "scene file":
            planner.save_scene(tmp_path / "scene.json")
            planner = srmp.PlannerInterface.load(tmp_path / "scene.json")
        assert planner.object_names == ["plate"]


def test_a_flat_plate_is_collided_with(arm, ready):
    vertices, triangles = plate(3)
    hand = arm.compute_fk("arm", ready).p
    arm.add_mesh("plate", vertices=vertices - vertices.mean(axis=0), triangles=triangles, pose=srmp.Pose(p=hand))
    assert arm.is_state_colliding("arm", ready)


def test_a_hull_is_that_of_the_triangles(arm, ready):
    """Not of vertices that no triangle has."""
    hand = arm.compute_fk("arm", ready).p
    corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
    triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    found = []
    for vertices, more in (
        (corners, {"triangles": triangles}),
        ([*corners, [0.6, 0, 0]], {"triangles": triangles}),
        (corners, {}),
    ):
        arm.add_mesh("solid", vertices=vertices, convex=True, pose=srmp.Pose(hand - [0.5, 0, 0]), **more)
        found.append(arm.distance_to_collision("arm", ready))
        arm.remove_object("solid")
    assert found[0] == found[1] == found[2] > 0


def test_nearly_flat_point_sets_have_a_hull_or_a_sentence():
    """Thicknesses around the precision with which qhull computes."""
    random = np.random.default_rng(1)
    for _ in range(300):
        points = random.uniform(-1, 1, (random.integers(4, 30), 3)) * [1, 1, 10 ** random.uniform(-12, -5)]
        points = points @ np.linalg.qr(random.normal(size=(3, 3)))[0]
        try:
            srmp.PlannerInterface().add_mesh("m", vertices=points, convex=True)
        except srmp.InvalidArgument as error:
            assert "convex hull" in str(error)


# --- absurd sizes


@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize(
    "add",
    [
        lambda p, s: p.add_box("b", [1, s, 1]),
        lambda p, s: p.add_sphere("b", s),
        lambda p, s: p.add_cylinder("b", s, 1),
        lambda p, s: p.add_cylinder("b", 1, s),
        lambda p, s: p.add_capsule("b", 1, s),
        lambda p, s: p.add_cone("b", s, 1),
        lambda p, s: p.add_mesh("b", vertices=np.eye(3) * s, triangles=[[0, 1, 2]]),
        lambda p, s: p.add_mesh("b", vertices=np.vstack([np.eye(3), np.zeros(3)]) * s, convex=True),
        lambda p, s: p.add_point_cloud("b", [[0, s, 0]], resolution=min(s, 900)),
        lambda p, s: p.add_point_cloud("b", [[0, 0, 0]], resolution=s),
        lambda p, s: p.add_box("b", [1, 1, 1], pose=srmp.Pose(p=[0, 0, s])),
        lambda p, s: p.add_box("b", [1, 1, 1], padding=s),
        lambda p, s: p.set_object_pose("table", srmp.Pose(p=[-s, 0, 0])),
        lambda p, s: p.set_base_pose("arm", srmp.Pose(p=[s, 0, 0])),
        lambda p, s: p.attach_object("post", "arm", "arm7_hand", pose_in_link=srmp.Pose(p=[s, 0, 0])),
        lambda p, s: p.set_padding("arm", s),
    ],
)
def test_absurd_sizes_are_refused_by_name(arm, add, size):
    before = arm.object_names
    with pytest.raises(srmp.InvalidArgument, match=r"'(b|table|arm|post)'.* 1000 m") as error:
        add(arm, size)
    sentence(error)
    assert arm.object_names == before


@pytest.mark.parametrize("goal", [[0, 0, 1e4], [1e300, 0, 0, 1, 0, 0, 0]])
def test_goals_beyond_any_robot_are_refused(arm, goal):
    kind = srmp.GoalType.POSITION if len(goal) == 3 else srmp.GoalType.POSE
    with pytest.raises(srmp.InvalidArgument, match="1000") as error:
        arm.plan("arm", arm.get_qpos("arm"), srmp.GoalConstraint(kind, goal))
    sentence(error)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<cylinder radius="0.05" length="0.12"/>', '<cylinder radius="1e20" length="0.12"/>'),
        ('<cylinder radius="0.05" length="0.12"/>', '<box size="1 1 1001"/>'),
        ('<cylinder radius="0.05" length="0.12"/>', '<sphere radius="1e300"/>'),
        ('<origin xyz="', '<origin xyz="1e20 0 0" ignored="'),
    ],
)
def test_absurd_robots_are_refused_with_the_line(old, new):
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    assert old in urdf
    with pytest.raises(srmp.FileError, match=r"URDF text:\d+: .* 1000 m") as error:
        srmp.PlannerInterface().add_articulation(urdf_text=urdf.replace(old, new, 1))
    sentence(error)


def test_absurd_mesh_files_are_refused_with_the_remedy(tmp_path):
    vertices, _ = plate(0)
    write_stl(tmp_path / "big.stl", vertices * 1e4)
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.FileError, match="millimetres") as error:
        planner.add_mesh("m", path=str(tmp_path / "big.stl"))
    sentence(error)
    planner.add_mesh("m", path=str(tmp_path / "big.stl"), scale=[1e-3] * 3)


# --- Collada

COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="fa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#fa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>{library}
<library_visual_scenes><visual_scene id="vs">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>"""


def levels(count, width):
    nodes = [
        f"<node id='a{i}'>"
        + (f"<instance_node url='#a{i - 1}'/>" * width if i else "<instance_geometry url='#g'/>")
        + "</node>"
        for i in range(count)
    ]
    return "".join(nodes)


@pytest.mark.parametrize(
    ("library", "nodes"),
    [
        ("", '<node id="n"><instance_node url="#n"/></node>'),
        ("", '<node id="n" name="m"><node><instance_node url="#m"/></node></node>'),
        ("", '<node id="n"><instance_node url="#vs"/></node>'),
        (
            '<library_nodes><node id="a"><instance_node url="#b"/></node><node id="b"><instance_node url="#a"/></node>'
            "</library_nodes>",
            '<node id="n"><instance_node url="#a"/></node>',
        ),
        ("", levels(9, 10)),
        (f"<library_nodes>{levels(12, 5)}</library_nodes>", "<node id='n'><instance_node url='#a11'/></node>"),
        ("", levels(20_000, 1)),
    ],
)
def test_collada_scenes_without_end_are_refused(tmp_path, library, nodes):
    path = tmp_path / "bomb.dae"
    path.write_text(COLLADA.format(library=library, nodes=nodes))
    with pytest.raises(srmp.FileError, match=r"bomb\.dae") as error:
        srmp.PlannerInterface().add_mesh("m", path=str(path))
    sentence(error)
    with pytest.raises(srmp.FileError, match=r"bomb\.dae"):
        srmp.PlannerInterface().add_articulation(urdf_text=plate_urdf(path))


def test_collada_scenes_with_instances_are_read(tmp_path):
    path = tmp_path / "tree.dae"
    path.write_text(COLLADA.format(library="", nodes=levels(3, 10)))
    srmp.PlannerInterface().add_mesh("m", path=str(path))


@pytest.mark.parametrize("indices", ["<p>0 1 2</p>", '<p>0 1 2</p><input semantic="VERTEX" source="#v" offset="0"/>'])
def test_collada_indices_into_nothing_are_refused(tmp_path, indices):
    before, _, after = COLLADA.partition('<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>')
    path = tmp_path / "nothing.dae"
    path.write_text(
        (before + indices + after).format(library="", nodes="<node id='n'><instance_geometry url='#g'/></node>")
    )
    with pytest.raises(srmp.FileError, match=r"no <input> stands before the indices of <p> \(line \d+\)") as error:
        srmp.PlannerInterface().add_mesh("m", path=str(path))
    sentence(error)


def test_mesh_files_of_unknown_formats_are_refused(tmp_path):
    (tmp_path / "m.blend").write_bytes(b"BLENDER")
    with pytest.raises(srmp.FileError, match=r"'\.blend'; supported are '\.stl'") as error:
        srmp.PlannerInterface().add_mesh("m", path=str(tmp_path / "m.blend"))
    sentence(error)


def test_a_pipe_that_a_mesh_names_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "m.mtl")
    (tmp_path / "m.obj").write_text("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(srmp.FileError, match="pipe"):
        srmp.PlannerInterface().add_mesh("m", path=str(tmp_path / "m.obj"))


# --- motion limits


@pytest.mark.parametrize("limit", [1e-300, 1e-160, 1e-9, 1e10, 1e300])
@pytest.mark.parametrize("which", ["velocity", "acceleration", "jerk"])
def test_limits_that_no_machine_has_are_refused(arm, which, limit):
    with pytest.raises(srmp.InvalidArgument, match=f"{which} limit is .*; it must be from") as error:
        arm.set_motion_limits("arm", **{which: limit})
    sentence(error)
    with pytest.raises(srmp.InvalidArgument, match=f"{which} limit"):
        srmp.MotionLimits(**({"velocity": [1.0], "acceleration": [1.0], "jerk": [1.0]} | {which: [limit]}))


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize("limit", [1e-6, 1e-3, 1e9])
def test_extreme_limits_are_timed_or_refused(method, limit):
    for others in (1e-6, 1.0, 1e9):
        for path in ([[0.0, 0.0], [1.0, 0.5], [0.2, 3.0]], [[1e6, 0.0], [-1e6, 1e-6]], [[0.0, 0.0], [1e-7, 1e-300]]):
            try:
                limits = srmp.MotionLimits([limit] * 2, [others] * 2, [others] * 2)
                srmp.time_parameterize(path, ["a", "b"], limits, method=method, sample_period=1e6)
            except srmp.Error as error:
                assert len(str(error)) < 500


@pytest.mark.parametrize("value", [1e7, 1e160, -1e300])
def test_waypoints_beyond_all_joints_are_refused(value):
    with pytest.raises(srmp.InvalidArgument, match="waypoint 1: j is ") as error:
        srmp.time_parameterize([[0.0], [value]], ["j"], srmp.MotionLimits([1.0], [1.0], [1.0]))
    sentence(error)


def test_a_urdf_with_a_velocity_that_never_arrives_is_refused():
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    slow = re.sub(r'velocity="[^"]*"', 'velocity="1e-9"', urdf)
    with pytest.raises(srmp.InvalidArgument, match="velocity limit 1e-09"):
        srmp.PlannerInterface().add_articulation(urdf_text=slow, end_effector="arm7_hand")


# --- text that is no UTF-8

SCENE = (
    b'world:\n  collision_objects:\n    - {id: "g", primitives: [{type: box, dimensions: [1,1,1]}], '
    b"primitive_poses: [{position: [5,0,0], orientation: [0,0,0,1]}]}\n"
)


def test_files_that_are_no_utf8_are_refused_with_the_line(tmp_path, arm):
    for number, text in enumerate([SCENE.replace(b'"g"', b'"g\xff"'), SCENE.replace(b"box", b"bo\xff")]):
        path = tmp_path / f"{number}.yaml"
        path.write_bytes(text)
        for call in (arm.load_moveit_scene, srmp.load_moveit_request, srmp.PlannerInterface.load, srmp.Trajectory.load):
            with pytest.raises(srmp.FileError, match=r"\.yaml:3: .*not UTF-8") as error:
                call(str(path))
            sentence(error)
    arm_urdf = Path(srmp.data_path("arm7.urdf")).read_bytes()
    (tmp_path / "arm.urdf").write_bytes(arm_urdf.replace(b'type="revolute"', b'type="rev\xff"', 1))
    with pytest.raises(srmp.FileError, match=r"arm\.urdf:\d+: a byte is not UTF-8"):
        srmp.PlannerInterface().add_articulation(str(tmp_path / "arm.urdf"))
    (tmp_path / "arm.srdf").write_bytes(b"<robot name='\xe9'/>")
    with pytest.raises(srmp.FileError, match=r"arm\.srdf:1: a byte is not UTF-8"):
        srmp.PlannerInterface().add_articulation(srmp.data_path("arm7.urdf"), str(tmp_path / "arm.srdf"))


def test_names_in_latin_1_within_comments_do_no_harm(tmp_path):
    text = Path(srmp.data_path("arm7.urdf")).read_bytes()
    place = text.index(b"<robot")
    (tmp_path / "arm.urdf").write_bytes(text[:place] + b"<!-- J\xe9r\xf4me -->" + text[place:])
    srmp.PlannerInterface().add_articulation(str(tmp_path / "arm.urdf"), end_effector="arm7_hand")


def test_characters_that_do_not_exist_are_refused(arm):
    urdf = "<robot name='r'><link name='a&#xD800;'/></robot>"
    with pytest.raises(srmp.FileError, match="not UTF-8"):
        srmp.PlannerInterface().add_articulation(urdf_text=urdf)
    for call in (
        lambda: arm.plan("\udc80", [0], srmp.GoalConstraint.hold()),
        lambda: arm.make_planner("\udc80", {}),
        lambda: arm.make_planner("arm", {"\udc80": 1}),
        lambda: arm.make_planner("arm", {"planner_id": "\udc80"}),
        lambda: arm.set_motion_limits("arm", velocity={"\udc80": 1}),
        lambda: arm.plan_multi({"\udc80": [0]}, {}),
        lambda: arm.save("\udc80"),
    ):
        with pytest.raises(srmp.Error):
            call()


def test_names_in_any_script_are_kept(arm, tmp_path):
    for name in ("Tür", "桌子", "🤖"):
        arm.add_box(name, [0.1, 0.1, 0.1], pose=srmp.Pose(p=[3, 0, 0]))
    arm.save(tmp_path / "p.json")
    assert srmp.PlannerInterface.load(tmp_path / "p.json").object_names == arm.object_names


def test_sentences_stay_short_and_on_one_line(arm):
    for call in (
        lambda: arm.remove_object("x" * 100_000),
        lambda: arm.remove_object("a\nb\tc"),
        lambda: arm.make_planner("arm", {"k" * 10_000: 1}),
        lambda: arm.make_planner("arm", {"planner_id": "v" * 10_000}),
        lambda: arm.add_articulation(urdf_text="<robot name='r'><link name='" + "l" * 9999 + "'/><lonk/></robot>"),
    ):
        with pytest.raises(srmp.Error) as error:
            call()
        sentence(error)


# --- motions without end, and Ctrl-C


@pytest.mark.parametrize("length", [2e4, 1e7, 1e12, 1e300])
def test_endless_motions_are_refused(arm, length):
    a, b = np.zeros(7), np.eye(7)[6] * length
    checker = arm.collision_checker("arm", "coal")
    for call in (
        arm.is_motion_free,
        lambda _, a, b: checker.motions_free([a], [b]),
        lambda _, a, b: checker.certify_motion(a, b),
    ):
        with pytest.raises(srmp.InvalidArgument, match=r"'arm7_joint7' from 0 to .* 10000 rad or m") as error:
            call("arm", a, b)
        sentence(error)


INTERRUPTED = """
    import signal, struct, subprocess, sys, time
    import numpy as np, srmp
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells have jobs in the background ignore it
    p = srmp.PlannerInterface()
    p.add_articulation(srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf"), name="arm", end_effector="arm7_hand")
    {prepare}
    # Another process sends Ctrl-C, as a terminal does: a thread would have to wait for the GIL.
    send = "import os, signal, time; time.sleep(0.3); print(time.monotonic()); os.kill(os.getppid(), signal.SIGINT)"
    try:
        terminal = subprocess.Popen([sys.executable, "-c", send], stdout=subprocess.PIPE, text=True)
        while True:
            {work}
    except KeyboardInterrupt:
        now = time.monotonic()
    print(now - float(terminal.communicate()[0]))
"""
BIG_MESH = """random = np.random.default_rng(0)
    t = np.tile(random.uniform(-1, 1, (400_000, 3)), 3) + random.uniform(0, 0.01, (400_000, 9))
    t = t.astype(np.float32)
    rows = np.zeros(len(t), dtype=[("n", "3<f4"), ("v", "9<f4"), ("a", "<u2")])
    rows["v"] = t
    open("big.stl", "wb").write(b"x" * 80 + struct.pack("<I", len(t)) + rows.tobytes())"""
MANY_POINTS = """p.add_point_cloud("points", np.random.default_rng(0).uniform(1, 2, (30_000, 3)), 0.01)
    p.save("p.json")"""
MANY_LINKS = """n = 30
    links = "".join(
        f"<link name='l{i}'><collision><geometry><mesh filename='m.stl'/></geometry></collision></link>"
        for i in range(n))
    joints = "".join(
        f"<joint name='j{i}' type='revolute'><parent link='l{i}'/><child link='l{i + 1}'/>"
        "<limit lower='-1' upper='1' velocity='1' effort='1'/></joint>"
        for i in range(n - 1))
    t = np.random.default_rng(0).uniform(-1, 1, (3000, 9)).astype(np.float32)
    rows = np.zeros(len(t), dtype=[("n", "3<f4"), ("v", "9<f4"), ("a", "<u2")])
    rows["v"] = t
    open("m.stl", "wb").write(b"x" * 80 + struct.pack("<I", len(t)) + rows.tobytes())
    urdf = f"<robot name='many'>{links}{joints}</robot>\""""


@pytest.mark.parametrize(
    ("prepare", "work"),
    [
        ("q = np.zeros((2, 7)); q[1, 6] = 9999", "p.is_motion_free('arm', q[0], q[1])"),
        ("c = p.collision_checker('arm', 'coal'); q = np.zeros((9999, 7))", "c.motions_free(q, q + 3)"),
        ("c = p.collision_checker('arm', 'coal'); q = np.zeros((99999, 7))", "c.are_free(q)"),
        ("c = p.collision_checker('arm', 'coal'); q = np.zeros((99999, 7))", "c.clearance(q)"),
        (BIG_MESH, "p.add_mesh('m', path='big.stl')"),
        (BIG_MESH, "p.add_mesh('m', vertices=t.reshape(-1, 3), triangles=np.arange(3 * len(t)).reshape(-1, 3))"),
        (MANY_LINKS, "p.add_articulation(urdf_text=urdf, urdf_directory='.')"),
        (MANY_POINTS, "srmp.PlannerInterface.load('p.json')"),
    ],
    ids=["is_motion_free", "motions_free", "are_free", "clearance", "mesh file", "mesh", "allowed collisions", "load"],
)
def test_ctrl_c_is_heard(prepare, work, tmp_path):
    program = textwrap.dedent(INTERRUPTED).format(prepare=textwrap.dedent("    " + prepare), work=work)
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout, done.stderr[-2000:]
    assert float(done.stdout) < 10.0  # within 0.1 s on a machine that does nothing else


# --- caches


def cache_files(root):
    return sorted(path for path in root.rglob("*") if path.suffix in (".pairs", ".cover"))


def use_cache(tmp_path):
    bar = "<collision><origin xyz='0.2 0 0'/><geometry><box size='0.3 0.1 0.1'/></geometry></collision>"
    limit = "<limit lower='-3' upper='3' velocity='1' effort='1'/>"
    links = "".join(f"<link name='{name}'>{bar}</link>" for name in "abc")
    joints = "".join(
        f"<joint name='{parent}{child}' type='revolute'><parent link='{parent}'/><child link='{child}'/>{limit}</joint>"
        for parent, child in ("ab", "bc")
    )
    urdf = f"<robot name='r'>{links}{joints}</robot>"
    program = f"""
        import numpy as np, srmp
        p = srmp.PlannerInterface()
        p.add_articulation(urdf_text={urdf!r})
        p.make_planner("r", {{"planner_id": "auto"}})
        p.prepare()
        print(p.collision_checker("r").are_free(np.zeros((1, 2))))
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        env=os.environ | {"SRMP_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout


def make_directory(path):
    path.mkdir()


def make_pipe(path):
    os.mkfifo(path)


def make_sparse(path):
    path.touch()
    os.truncate(path, 1 << 40)


def make_short(path):
    path.write_bytes(b"SRMPFILE")


def make_loop(path):
    path.symlink_to(path)


@pytest.mark.parametrize("damage", [make_directory, make_pipe, make_sparse, make_short, make_loop])
def test_damaged_cache_files_are_rebuilt_silently(tmp_path, damage):
    expected = use_cache(tmp_path)
    files = cache_files(tmp_path)
    assert files
    for path in files:
        path.unlink()
        damage(path)
    assert use_cache(tmp_path) == expected


# --- memory


def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_robots_that_are_removed_leave_nothing(arm):
    def add_and_remove(times):
        for _ in range(times):
            arm.add_articulation(
                srmp.data_path("arm7.urdf"),
                srmp.data_path("arm7.srdf"),
                name="b",
                end_effector="arm7_hand",
                base_pose=srmp.Pose(p=[5, 0, 0]),
            )
            arm.make_planner("b", {"planner_id": "auto"})
            arm.collision_checker("b")
            arm.remove_articulation("b")
        return resident()

    before = add_and_remove(20)
    assert add_and_remove(60) - before < 6e6  # 0.25 MB each before
