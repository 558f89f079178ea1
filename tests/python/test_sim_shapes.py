"""How the shapes of simulators become shapes of the planner. No simulator is needed."""

import numpy as np
import pytest

import srmp
from srmp.sim import shapes
from srmp.sim.simulator import Articulation, Body, Geometry, Joint
from srmp.sim.urdf import to_urdf


def distance(shape, point, pose=None):
    """Of a small sphere from the shape, as the planner sees it [m]."""
    planner = srmp.PlannerInterface()
    sphere = '<collision><geometry><sphere radius="0.001"/></geometry></collision>'
    limit = '<limit lower="-1" upper="1" velocity="1"/>'
    planner.add_articulation(
        urdf_text=f"""<robot name="sphere"><link name="base"/><link name="sphere">{sphere}</link>
        <joint name="slide" type="prismatic"><parent link="base"/><child link="sphere"/>{limit}</joint></robot>""",
        base_pose=srmp.Pose(p=point),
    )
    shapes.add_object(planner, "it", shape, pose or srmp.Pose())
    return planner.distance_to_collision("sphere", [0.0]) + 0.001


def test_an_ellipsoid_is_held_and_not_by_much():
    axes = np.array([0.1, 0.2, 0.3])
    for direction in np.random.default_rng(0).normal(size=(30, 3)):
        direction /= np.linalg.norm(direction)
        normal = direction / axes  # of the surface at axes * direction
        normal /= np.linalg.norm(normal)
        away = distance(shapes.Ellipsoid(axes), axes * direction + 0.05 * normal)
        assert 0.05 - shapes.ELLIPSOID_TOLERANCE * 0.3 <= away <= 0.05 + 1e-6


def test_a_plane_is_solid_below_and_ends_at_its_height():
    plane, tilted = shapes.Plane(), srmp.Pose.from_rpy([0, 0, 0.2], [0, 0.3, 0])
    assert distance(plane, [3, -2, 0.25]) == pytest.approx(0.25, abs=1e-9)
    assert distance(plane, [3, -2, -2.0]) < 0
    assert distance(plane, tilted @ np.array([1, 1, 0.3]), tilted) == pytest.approx(0.3, abs=1e-6)


def test_a_height_field_is_its_surface_and_filled():
    heights = np.zeros((3, 5))
    heights[2, 4] = 0.2  # at x = 0.4, y = 0.1
    field = shapes.HeightField(heights, (0.2, 0.1), bottom=-0.5)
    assert distance(field, [0.4, 0.1, 0.25]) == pytest.approx(0.05, abs=1e-6)
    assert distance(field, [-0.3, 0.0, 0.1]) == pytest.approx(0.1, abs=1e-6)
    for depth in np.arange(0.02, 0.48, 0.01):  # no link of 4 cm hides in it
        assert distance(field, [-0.3, 0.0, -depth]) <= shapes.LAYER_DEPTH / 2 + 1e-6
    assert distance(field, [-0.3, 0.0, -0.6]) == pytest.approx(0.1, abs=1e-6)
    assert distance(field, [-0.5, 0.0, -0.02]) == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize(("rising", "at_centre"), [(True, 0.0), (False, 0.1)])
def test_a_cell_of_a_height_field_is_cut_along_its_diagonal(rising, at_centre):
    heights = np.array([[0.0, 0.1], [0.1, 0.0]])
    field = shapes.HeightField(heights, (0.1, 0.1), bottom=-0.1, rising=rising)
    assert distance(field, [0, 0, at_centre + 0.0005]) <= 0.0005 + 1e-9
    mesh = shapes.as_mesh(field)
    assert mesh.triangles.max() < len(mesh.vertices)


def test_shapes_are_compared_by_what_they_are():
    mesh = shapes.Mesh(np.eye(3), None)
    assert shapes.same_shape(mesh, shapes.Mesh(np.eye(3), None))
    assert not shapes.same_shape(mesh, shapes.Mesh(2 * np.eye(3), None))
    assert not shapes.same_shape(shapes.Sphere(0.1), shapes.Cylinder(0.1, 0.1))


def test_what_cannot_be_is_refused():
    planner = srmp.PlannerInterface()
    with pytest.raises(srmp.NotSupported, match="a soft body cannot be read"):
        shapes.add_object(planner, "it", shapes.Unreadable("a soft body"), srmp.Pose())
    with pytest.raises(srmp.InvalidArgument, match="1 x 3 heights; it needs at least 2 x 2"):
        shapes.add_object(planner, "it", shapes.HeightField(np.zeros((1, 3)), (1, 1), 0), srmp.Pose())
    assert planner.object_names == []


def one_joint(kind, *geometries):
    links = (Body("base", srmp.Pose(), ()), Body("arm", srmp.Pose(), geometries))
    joint = Joint(
        "turn", kind, "base", "arm", srmp.Pose.from_rpy([1, 2, 3], [0.1, np.pi / 2, 0.3]), np.array([0, 0, 1.0])
    )
    return Articulation("robot", links, (joint,))


def test_a_urdf_has_every_shape_where_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", str(tmp_path))
    place = srmp.Pose.from_rpy([0.1, 0.2, 0.3], [0.4, 0.5, 0.6])
    every = (
        shapes.Box(np.array([0.1, 0.2, 0.3])),
        shapes.Sphere(0.1),
        shapes.Cylinder(0.1, 0.2),
        shapes.Capsule(0.1, 0.2),
        shapes.Ellipsoid(np.array([0.1, 0.2, 0.3])),
        shapes.Mesh(np.vstack([np.zeros(3), np.eye(3)]), None),
    )
    articulation = one_joint("continuous", *(Geometry("", shape, place, k) for k, shape in enumerate(every)))
    names = {"base": "base", "arm": "arm"}
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=to_urdf(articulation, names, {"turn": "turn"}))
    assert len(list((tmp_path / "meshes").iterdir())) == 2
    frame = planner.compute_fk("robot", [0.7])
    expected = articulation.joints[0].origin @ srmp.Pose.from_rpy([0, 0, 0], [0, 0, 0.7])
    np.testing.assert_allclose(frame.matrix(), expected.matrix(), atol=1e-9)


def test_joints_and_planes_that_urdfs_do_not_have():
    names = {"base": "base", "arm": "arm"}
    with pytest.raises(srmp.NotSupported, match="joint 'turn' of articulation 'robot' has more than one degree"):
        to_urdf(one_joint("ball"), names, {"turn": "turn"})
    with pytest.raises(srmp.NotSupported, match="link 'arm' has a plane, which is endless"):
        to_urdf(one_joint("revolute", Geometry("", shapes.Plane(), srmp.Pose(), 0)), names, {"turn": "turn"})


def test_the_hull_of_points():
    corners, triangles = srmp.convex_hull(np.vstack([np.zeros(3), np.eye(3), [[0.1, 0.1, 0.1]]]))
    assert len(corners) == 4
    assert len(triangles) == 4
    with pytest.raises(srmp.InvalidArgument, match="no volume"):
        srmp.convex_hull(np.eye(3))
    with pytest.raises(srmp.InvalidArgument, match="points of a convex hull"):
        srmp.convex_hull([[0, 1]])


def test_what_may_touch_and_how_far_joints_go(arm):
    assert arm.allowed_collision("arm7_base", "arm7_shoulder")  # neighbours
    assert not arm.allowed_collision("table", "arm7_hand")
    arm.set_allowed_collision("table", "arm")
    assert arm.allowed_collision("table", "arm7_hand")
    with pytest.raises(srmp.InvalidArgument, match="tabel"):
        arm.allowed_collision("tabel", "arm")
    limits = arm.get_all_joint_limits("arm")
    assert list(limits) == sorted(arm.get_joint_names("arm"))
    assert limits["arm7_joint2"] == (-1.9, 1.9)
