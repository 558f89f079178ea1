"""What there is to be seen of a scene, the pages that play it, pictures, and what notebooks show: without a browser."""

import base64
import json
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from support import refuses

import srmp
from srmp.cli import main
from srmp.viewer import _shapes
from srmp.viewer._drawing import make_drawing
from srmp.viewer._failure import touches_at
from srmp.viewer._motion import sample_motion, trajectories_of
from srmp.viewer._scene import frame_poses, matrix, read_scene
from srmp.viewer._urdf_bodies import find_mesh, read_bodies

ARM = srmp.data_path("arm7.urdf")
QUARTER = np.array([-0.5, 0, 0, 0, 0, 0, 0])


def arm_world():
    planner = srmp.PlannerInterface()
    planner.add_articulation(ARM, srmp.data_path("arm7.srdf"), name="arm", end_effector="arm7_hand")
    planner.add_box("table", [1.6, 1.6, 0.1], srmp.Pose(p=[0, 0, -0.051]))
    planner.add_box("post", [0.1, 0.1, 0.8], srmp.Pose(p=[0.35, 0.2, 0.4]))
    return planner


@pytest.fixture(scope="module")
def planned():
    planner = arm_world()
    ready = planner.get_group_states("arm")["ready"]
    planner.plan("arm", ready, ready + QUARTER)
    return planner


def data_of(page):
    packed = re.search(r'<script id="data" type="text/plain">(.*?)</script>', page)[1]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def numbers(text, kind):
    return np.frombuffer(base64.b64decode(text), kind).reshape(-1, 3)


# --- shapes


def volume(mesh):
    a, b, c = mesh.vertices[mesh.triangles].astype(float).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ({"kind": "box", "size": [1, 2, 3]}, 6),
        ({"kind": "sphere", "radius": 1}, 4 / 3 * np.pi),
        ({"kind": "cylinder", "radius": 1, "length": 2}, 2 * np.pi),
        ({"kind": "capsule", "radius": 1, "length": 2}, (4 / 3 + 2) * np.pi),
        ({"kind": "cone", "radius": 1, "length": 3}, np.pi),
        ({"kind": "point cloud", "points": [[0, 0, 0], [1, 1, 1]], "resolution": 0.5}, 0.25),
        ({"kind": "mesh", "convex": True, "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}, 1 / 6),
    ],
    ids=lambda value: value["kind"] if isinstance(value, dict) else "",
)
def test_shapes_are_closed_and_turned_outwards(shape, expected):
    mesh = _shapes.of_object(shape)
    assert volume(mesh) == pytest.approx(expected, rel=0.02)
    assert volume(mesh.moved(np.diag([1, -2, 1, 1.0]))) == pytest.approx(2 * volume(mesh), rel=1e-5)


def test_fine_meshes_are_simplified():
    fine = _shapes.sphere(1.0, 400)
    coarse = _shapes.simplified(fine, 5000)
    assert len(fine.triangles) > 50_000 and len(coarse.triangles) <= 5000
    assert volume(coarse) == pytest.approx(volume(fine), rel=0.05)
    assert _shapes.simplified(coarse, 5000) is coarse


def test_dense_clouds_are_drawn_as_larger_cubes():
    points = np.random.default_rng(1).uniform(0, 1, (200_000, 3))
    mesh = _shapes.voxels(points, 0.01)
    assert len(mesh.vertices) <= 8 * 10_000
    assert np.allclose([mesh.vertices.min(), mesh.vertices.max()], [0, 1], atol=0.1)


def test_an_unknown_shape_is_refused():
    refuses(lambda: _shapes.of_object({"kind": "torus"}), "'torus' cannot be drawn", srmp.NotSupported)


# --- robots


BODIES = """<robot name="r"><material name="red"><color rgba="1 0 0 1"/></material>
<link name="a"><visual><origin xyz="0 0 1"/><geometry><box size="1 1 1"/></geometry><material name="red"/></visual>
<visual><geometry><mesh filename="part.stl" scale="2 2 -2"/></geometry></visual>
<collision><geometry><sphere radius="1"/></geometry></collision></link></robot>"""
TETRAHEDRON = """solid t
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid t
"""


def test_urdf_geometries_have_poses_colours_and_scales(tmp_path):
    pytest.importorskip("trimesh")
    (tmp_path / "part.stl").write_text(TETRAHEDRON)
    box, mesh = read_bodies(BODIES, "visual", str(tmp_path), [])
    assert box.colour == (1, 0, 0) and box.pose[2, 3] == 1 and box.link == "a"
    assert volume(mesh.mesh) == pytest.approx(8 / 6)
    (ball,) = read_bodies(BODIES, "collision", "", [])
    assert ball.colour is None


def test_a_missing_or_broken_mesh_file_is_named(tmp_path):
    pytest.importorskip("trimesh")
    refuses(lambda: read_bodies(BODIES, "visual", str(tmp_path), []), "part.stl' was not found; tried", srmp.FileError)
    (tmp_path / "part.stl").write_text("no mesh")
    refuses(lambda: read_bodies(BODIES, "visual", str(tmp_path), []), "part.stl", srmp.FileError)


def test_meshes_are_found_where_the_library_finds_them(tmp_path, monkeypatch):
    for directory in ("robots/urdf", "robots/meshes", "ros/other/meshes"):
        (tmp_path / directory).mkdir(parents=True)
    mine, theirs = tmp_path / "robots" / "meshes" / "a.stl", tmp_path / "ros" / "other" / "meshes" / "b.stl"
    mine.touch(), theirs.touch()
    urdf = str(tmp_path / "robots" / "urdf")
    assert find_mesh("package://robots/meshes/a.stl", urdf, []) == str(mine)
    assert find_mesh("../meshes/a.stl", urdf, []) == f"{urdf}/../meshes/a.stl"
    assert find_mesh(f"file://{mine}", "", []) == find_mesh(str(mine), "", []) == str(mine)
    refuses(lambda: find_mesh("package://other/meshes/b.stl", urdf, []), "b.stl' was not found", srmp.FileError)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert find_mesh("package://other/meshes/b.stl", urdf, []) == str(theirs)


def test_without_trimesh_robots_with_meshes_are_seen_as_spheres(tmp_path, monkeypatch):
    (tmp_path / "part.stl").write_text(TETRAHEDRON)
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint><link name="b"><collision><geometry>'
        '<mesh filename="part.stl" scale="0.1 0.1 0.1"/></geometry></collision></link></robot>'
    )
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    monkeypatch.setenv("SRMP_CACHE_DIR", str(tmp_path / "cache"))
    planner = srmp.PlannerInterface()
    planner.add_articulation(str(tmp_path / "r.urdf"), name="r", end_effector="b")
    assert {body.kind for body in read_scene(planner).bodies} == {"spheres"}
    refuses(lambda: read_scene(planner, ["collision"]), r"pip install '\.\[viewer\]'", srmp.NotSupported)


# --- scenes


def test_bodies_are_where_the_planner_has_them(planned):
    scene = read_scene(planned)
    names = {body.name for body in scene.bodies}
    assert {"table", "post"} < names and any(name.startswith("arm/arm7_palm/collision") for name in names)
    for frame, pose in zip(scene.frames, scene.poses, strict=True):
        expected = planned.compute_fk("arm", planned.get_qpos("arm"), frame.removeprefix("arm/"))
        assert np.allclose(matrix(pose), expected.matrix())
    post = next(body for body in scene.bodies if body.name == "post")
    assert np.allclose(scene.placed(post).vertices.mean(axis=0), [0.35, 0.2, 0.4], atol=1e-6)


def test_held_objects_move_with_their_link():
    planner = arm_world()
    planner.add_sphere("ball", 0.02, planner.compute_fk("arm", planner.get_qpos("arm")))
    planner.attach_object("ball", "arm", "arm7_hand")
    ball = next(body for body in read_scene(planner).bodies if body.name == "ball")
    assert (ball.kind, ball.frame, ball.robot, ball.label) == ("held", "arm/arm7_hand", "arm", "ball")
    planner.set_qpos("arm", planner.get_group_states("arm")["ready"])
    scene = read_scene(planner)
    ball = next(body for body in scene.bodies if body.name == "ball")
    assert np.allclose(scene.placed(ball).vertices.mean(axis=0), planner.get_object_pose("ball").p, atol=1e-6)


def test_all_kinds_of_robots_and_wrong_ones(planned):
    kinds = [body.kind for body in read_scene(planned, ["collision", "spheres"]).bodies]
    assert kinds.count("collision") > 10 and kinds.count("spheres") >= 8
    refuses(lambda: read_scene(planned, ["colision"]), "not 'colision', did you mean 'collision'")


def test_an_unchanged_shape_is_the_same_mesh(planned):
    meshes = [{body.name: body.mesh for body in read_scene(planned).bodies} for _ in range(2)]
    assert all(mesh is meshes[1][name] for name, mesh in meshes[0].items())


# --- motions


def test_a_motion_shows_the_links_as_they_move(planned):
    (one,) = trajectories_of(planned, None).values()
    motion = sample_motion(planned, {"arm": one})
    assert motion.duration == one.duration and len(motion.times) == pytest.approx(30 * one.duration, abs=2)
    k = len(motion.times) // 2
    assert np.allclose(motion.poses[k], frame_poses(planned, {"arm": one.sample(motion.times[k])}))


def test_paths_without_times_and_other_orders_of_joints(planned):
    one = planned.last_result.trajectory
    turned = srmp.Trajectory(one.joint_names[::-1], one.positions[:, ::-1], one.times)
    assert np.array_equal(trajectories_of(planned, turned)["arm"].positions, one.positions)
    path = trajectories_of(planned, srmp.Trajectory(one.joint_names, one.waypoints))["arm"]
    assert path.duration == pytest.approx(path.length, rel=1e-3)


def test_wrong_trajectories_are_refused(planned):
    one = planned.last_result.trajectory
    refuses(lambda: planned.to_html(trajectory=5), "trajectory must be a Trajectory.*but is 5")
    refuses(lambda: planned.to_html(trajectory={"arn": one}), "no robot 'arn', did you mean 'arm'")
    refuses(lambda: planned.to_html(trajectory={"arm": 3}), "of 'arm' must be a Trajectory, but is 3")
    other = srmp.Trajectory(["a"], [[0], [1]])
    refuses(lambda: planned.to_html(trajectory={"arm": other}), "moves a, but the robot's joints are arm7_joint1")


# --- pages


def test_a_page_holds_everything_and_asks_for_nothing(planned, tmp_path):
    assert planned.to_html(tmp_path / "motion.html", title="<Reach> & back") is None
    page = (tmp_path / "motion.html").read_text()
    assert "<title>&lt;Reach&gt; &amp; back</title>" in page
    assert not re.search(r"https?:|\bsrc=|@import|\burl\(", page)
    data = data_of(page)
    scene, one = read_scene(planned), planned.last_result.trajectory
    assert len(data["bodies"]) == len(scene.bodies) and data["frames"] == len(scene.frames)
    poses = np.frombuffer(base64.b64decode(data["poses"]), "<f4").reshape(len(data["times"]), data["frames"], 7)
    hand = scene.frames.index("arm/arm7_hand")
    assert np.allclose(poses[-1, hand, :3], one.end_effector_path()[-1], atol=1e-6)
    titles = [plot["title"].split(",")[0] for plot in data["plots"]]
    assert titles == ["velocity", "acceleration", "jerk", "position [rad", "clearance [mm]"]
    smallest = min(data["plots"][-1]["series"][0]["values"])
    assert smallest >= 1e3 * one.certificate.clearance_proved
    assert "proved free" in data["notes"][0][0]


def test_meshes_in_a_page_are_exact_to_their_grid(planned):
    data = data_of(planned.to_html())
    scene = read_scene(planned)
    for item, body in zip(data["bodies"], scene.bodies, strict=True):
        mesh = data["meshes"][item["mesh"]]
        corners = numbers(mesh["corners"], "<u2") / 65535
        assert np.allclose(mesh["origin"] + corners * mesh["size"], body.mesh.vertices, atol=max(mesh["size"]) / 6e4)
        assert np.array_equal(
            np.frombuffer(base64.b64decode(mesh["indices"]), "<u4").reshape(-1, 3), body.mesh.triangles
        )


def test_a_page_of_a_scene_alone():
    data = data_of(arm_world().to_html())
    assert data["times"] == [0.0] and not data["plots"] and not data["switches"]
    assert data_of(srmp.PlannerInterface().to_html())["bodies"] == []


def test_kinds_have_switches_and_the_first_is_on(planned):
    data = data_of(planned.to_html(kinds=["spheres", "collision"]))
    assert data["switches"] == [["spheres", True], ["collision", False]]


def test_a_page_that_cannot_be_written(planned, tmp_path):
    refuses(lambda: planned.to_html(tmp_path / "no" / "m.html"), "m.html", srmp.FileError)
    refuses(lambda: planned.to_html(title=3), "title must be a string, but is 3")
    refuses(lambda: planned.to_html(kinds=["wire"]), "not 'wire'")
    refuses(lambda: srmp.viewer.to_html("scene.json"), "planner must be a PlannerInterface")


# --- failures


def failed(start_or_goal):
    planner = arm_world()
    ready = planner.get_group_states("arm")["ready"]
    into = srmp.Pose(p=[0.35, 0.2, 0.3], q=[0, 1, 0, 0])
    start, goal = (planner.compute_ik("arm", into, ready)[0], ready) if start_or_goal == "start" else (ready, into)
    with pytest.raises(srmp.PlanningError):
        planner.plan("arm", start, goal)
    return planner


@pytest.mark.parametrize("which", ["start", "goal"])
def test_a_failure_is_drawn_with_what_touches(which):
    planner = failed(which)
    drawing = make_drawing(planner)
    assert drawing.failure.status == f"{which}_invalid"
    touch = next(touch for touch in drawing.failure.touches if "post" in touch.bodies)
    assert re.match(r"arm7_\w+ – post: [\d.]+ mm deep", touch.text)
    data = data_of(planner.to_html())
    red = [body for body in data["bodies"] if body["colour"][:3] == [0.86, 0.12, 0.12]]
    assert len(red) >= 3 and data["notes"][0][1] and data["labels"][0]["text"] == drawing.failure.touches[0].text


def test_a_limit_that_is_left_is_drawn_at_its_link():
    planner = arm_world()
    ready = planner.get_group_states("arm")["ready"]
    beyond = ready + 9 * np.eye(7)[3]
    (touch,) = [touch for touch in touches_at(planner, {"arm": beyond}) if "outside" in touch.text]
    assert touch.text.startswith("arm7_joint4:") and touch.bodies == ("arm/arm7_forearm",)
    assert np.array_equal(planner.get_qpos("arm"), arm_world().get_qpos("arm"))


# --- pictures


def test_plot_returns_a_figure_and_needs_no_path(planned, tmp_path):
    figures = pytest.importorskip("matplotlib.figure")
    assert isinstance(planned.last_result.trajectory.plot(), figures.Figure)
    assert isinstance(planned.plot(title="a title"), figures.Figure)
    assert isinstance(srmp.PlannerInterface().plot(tmp_path / "p.svg"), figures.Figure)
    failed("start").plot(tmp_path / "p.png", kinds=["collision"])
    assert (tmp_path / "p.png").stat().st_size > 20_000 and (tmp_path / "p.svg").exists()


def test_pictures_have_the_colours_of_their_bodies(tmp_path):
    pytest.importorskip("matplotlib")
    from matplotlib.image import imread

    planner = arm_world()
    planner.plot(tmp_path / "p.png")
    pixels = imread(tmp_path / "p.png")[..., :3]
    orange = (pixels[..., 0] > pixels[..., 2] + 0.35).mean()
    assert 0.01 < orange < 0.5  # the arm, not sticks


def test_wrong_pictures_are_refused(planned, tmp_path):
    pytest.importorskip("matplotlib")
    refuses(lambda: planned.plot(tmp_path / "p.xyz"), "p.xyz.*xyz")
    refuses(lambda: planned.plot(tmp_path / "no" / "p.png"), "cannot be written", srmp.FileError)
    refuses(lambda: planned.plot(title=1), "title must be a string")


# --- notebooks


def test_notebooks_show_players_and_tables(planned):
    result, request = planned.last_result, planned.last_request
    assert "<iframe" in planned._repr_html_() and "<iframe" in result.trajectory._repr_html_()
    assert "<b" in result._repr_html_() and "solved" in result._repr_html_()
    assert "JOINTS" in request._repr_html_()
    assert "holds, proved free" in result.trajectory.certificate._repr_html_()
    unknown = srmp.Trajectory.from_dict(result.trajectory.to_dict())
    assert "<svg" in unknown._repr_html_() and "<iframe" not in unknown._repr_html_()


def test_notebooks_show_several_robots():
    planner = srmp.PlannerInterface()
    for name, y in (("left", -0.6), ("right", 0.6)):
        planner.add_articulation(
            ARM, srmp.data_path("arm7.srdf"), name=name, end_effector="arm7_hand", base_pose=srmp.Pose(p=[0, y, 0])
        )
    ready = planner.get_group_states("left")["ready"]
    both = planner.plan_multi({"left": ready, "right": ready}, {"left": ready + QUARTER})
    assert "<iframe" in both._repr_html_() and "left" in planner.last_request._repr_html_()
    assert "holds still" in planner.last_request._repr_html_()
    assert "solved" in planner.last_result._repr_html_()
    data = data_of(planner.to_html())
    assert [series["name"] for series in data["plots"][0]["series"]] == ["left", "right"]


def test_notebooks_show_failures_and_escape_names():
    planner = failed("start")
    assert "start_invalid" in planner.last_result._repr_html_()
    planner.add_box("<b>", [0.1] * 3, srmp.Pose(p=[2, 0, 0]))
    assert srmp.Trajectory(["<i>"], [[0], [1]])._repr_html_().count("<i>") == 0
    bad = srmp.Trajectory(planner.get_joint_names("arm"), [[0] * 7, [0.9] * 7], [0, 0.1])
    assert "velocity_limit" in planner.verify("arm", bad)._repr_html_()


def test_everything_has_a_repr():
    """Python's own says an address."""
    bare = [
        name
        for name, cls in vars(srmp._srmp).items()
        if isinstance(cls, type) and not issubclass(cls, BaseException) and "__repr__" not in vars(cls)
    ]
    assert not bare


def test_reprs_say_what_there_is(planned):
    assert repr(planned) == "PlannerInterface(1 robot, 2 objects)"
    assert repr(srmp.PlannerInterface()) == "PlannerInterface(0 robots, 0 objects)"
    q = planned.get_qpos("arm")
    checker = planned.collision_checker("arm", "coal")
    assert repr(checker) == "CollisionChecker(7 joints)"
    assert repr(planned.timed_collision_checker("arm", {}, "coal")) == "TimedCollisionChecker(7 joints)"
    assert repr(checker.certify_motion(q, q)) == "MotionCertificate(proved)"
    (into,) = planned.compute_ik("arm", srmp.Pose(p=[0.35, 0.2, 0.3], q=[0, 1, 0, 0]), max_solutions=1)
    assert repr(checker.certify_motion(q, into)).startswith("MotionCertificate(not proved: arm7_")
    example = Path(__file__).parents[2] / "examples" / "moveit" / "request.yaml"
    assert repr(srmp.load_moveit_request(str(example))) == f"MoveItRequest('{example}', group 'arm')"


# --- srmp view


def view(*arguments):
    return CliRunner().invoke(main, ["view", *map(str, arguments)])


def test_view_opens_files_of_every_kind(planned, tmp_path):
    planned.save(tmp_path / "problem.srmp.json")
    planned.save_scene(tmp_path / "scene.srmp.json")
    planned.last_result.trajectory.save(tmp_path / "motion.srmp.json")
    yaml = Path(__file__).parents[2] / "examples" / "moveit" / "scene.yaml"
    robot = ("--srdf", srmp.data_path("arm7.srdf"), "--end-effector", "arm7_hand")
    moving = {
        ("problem.srmp.json",): True,
        ("scene.srmp.json",): False,
        ("motion.srmp.json", "--scene", tmp_path / "problem.srmp.json"): True,
        ("motion.srmp.json", "--urdf", ARM, *robot): True,
        (ARM, *robot): False,
        (yaml, "--urdf", ARM, *robot): False,
    }
    for (file, *options), moves in moving.items():
        result = view(tmp_path / file, *options, "--html", tmp_path / "page.html", "--as", "collision")
        assert result.exit_code == 0, result.output
        data = data_of((tmp_path / "page.html").read_text())
        assert (len(data["times"]) > 1) == moves, file
        assert len(data["bodies"]) > 10


def test_view_says_what_is_missing(planned, tmp_path):
    planned.last_result.trajectory.save(tmp_path / "motion.srmp.json")
    (tmp_path / "other.json").write_text("{}")
    (tmp_path / "scene.yaml").write_text("")
    for arguments, words in [
        (("motion.srmp.json",), "say with --scene or --urdf what its robot is"),
        (("other.json",), "other.json"),
        (("scene.yaml",), "a MoveIt scene needs its robot too: --urdf"),
        ((ARM, "--urdf", ARM), "but .* is one itself"),
        ((ARM, "--as", "wire", "--html", tmp_path / "p.html"), "not 'wire'"),
    ]:
        result = view(tmp_path / arguments[0], *arguments[1:], "--no-browser")
        assert result.exit_code == 2 and re.search(words, result.output), result.output
