"""PyBullet: grids of height fields, and hulls of meshes, which it does not tell."""

import numpy as np
import pytest

from srmp.sim.pybullet_meshes import grid_surface

pytest.importorskip("pybullet", reason="pip install '.[pybullet]' to test what is said of PyBullet")

import pybullet
from pybullet_scenes import body, collision, cuboid, read, tetrahedra, urdf_body


def grid(columns, rows, rising, seed=0, edge=None):
    """Heights at shares of the sides of a random grid, as rays would find them."""
    z = np.random.default_rng(seed).uniform(size=(rows + 1, columns + 1))
    if edge is not None:
        z[[0, -1]], z[:, [0, -1]] = edge, edge

    def heights(x, y):
        c, r = (np.minimum((fraction * n).astype(int), n - 1) for fraction, n in ((x, columns), (y, rows)))
        u, v = x * columns - c, y * rows - r
        a, b, d, e = z[r, c], z[r, c + 1], z[r + 1, c], z[r + 1, c + 1]
        if rising:
            return np.where(u > v, a + u * (b - a) + v * (e - b), a + v * (d - a) + u * (e - d))
        return np.where(u + v < 1, a + u * (b - a) + v * (d - a), e + (1 - u) * (d - e) + (1 - v) * (b - e))

    return heights, z


@pytest.mark.parametrize(
    ("columns", "rows", "edge"), [(8, 6, None), (1, 1, None), (60, 37, None), (8, 9, 0.5), (2, 3, 0)]
)
@pytest.mark.parametrize("rising", [True, False])
def test_the_grid_of_a_height_field_is_found(columns, rows, edge, rising):
    """Also where the edges are flat, and say nothing of the cells."""
    heights, z = grid(columns, rows, rising, edge=edge)
    points, triangles = grid_surface(heights, float(np.ptp(z)))
    assert len(points) == z.size
    assert len(triangles) == 2 * columns * rows
    np.testing.assert_allclose(points[:, 2], z.ravel(), atol=1e-9)
    middle = points[triangles].mean(axis=1)
    np.testing.assert_allclose(heights(middle[:, 0], middle[:, 1]), middle[:, 2], atol=1e-6)


def test_what_is_no_height_field_is_none():
    assert grid_surface(lambda x, y: np.where(x < 0.9, 1.0, np.nan), 0.0) is None
    assert grid_surface(lambda x, y: np.sin(9 * x) * np.cos(8 * y), 2.0) is None


def test_a_height_field_is_read_where_it_is(client):
    heights = np.random.default_rng(3).uniform(size=(6, 9))  # rows along y
    arguments = {"heightfieldData": heights.ravel().tolist(), "numHeightfieldRows": 9, "numHeightfieldColumns": 6}
    body(client, "hills", (pybullet.GEOM_HEIGHTFIELD, {**arguments, "meshScale": [0.1, 0.2, 0.5]}), [1, 2, 3])
    cuboid(client, "roof", [5, 5, 0.1], [1, 2, 4])  # in the way of rays
    _, world = read(client)
    hills = next(each for each in world.simulator.bodies() if each.name == "hills")
    vertices = hills.geometries[0].shape.vertices
    np.testing.assert_allclose(vertices[:9, 0], 0.1 * np.arange(9) - 0.4, atol=1e-6)
    np.testing.assert_allclose(vertices[::9, 1], 0.2 * np.arange(6) - 0.5, atol=1e-6)
    middle = (heights.min() + heights.max()) / 2  # where Bullet has the body's origin
    np.testing.assert_allclose(vertices[:, 2], 0.5 * (heights.ravel() - middle), atol=1e-5)
    assert hills.pose.p.tolist() == [1, 2, 3]

    before = hills.geometries[0].shape
    assert next(each for each in world.simulator.bodies() if each.name == "hills").geometries[0].shape is before
    pybullet.removeBody(0, physicsClientId=client)
    heights[2, 2:5] = heights[2, 2:5][::-1]  # as high, wide and long as it was, and it gets the same number
    arguments["heightfieldData"] = heights.ravel().tolist()
    assert (
        body(client, "hills", (pybullet.GEOM_HEIGHTFIELD, {**arguments, "meshScale": [0.1, 0.2, 0.5]}), [1, 2, 3]) == 0
    )
    hills = next(each for each in world.simulator.bodies() if each.name == "hills")
    np.testing.assert_allclose(hills.geometries[0].shape.vertices[:, 2], 0.5 * (heights.ravel() - middle), atol=1e-5)


def test_a_mesh_is_a_hull_for_each_object_or_a_surface(client, tmp_path):
    obj = tetrahedra(tmp_path / "two.obj")
    for name, flags in (("solid", {}), ("surface", {"concave": "yes"})):
        urdf_body(client, tmp_path, name, collision(f'<mesh filename="{obj}" scale="1 2 1"/>', **flags), [0, 0, 0])
    _, world = read(client)
    solid, surface = ([each.shape for each in body.geometries] for body in world.simulator.bodies())
    assert [mesh.triangles is None for mesh in solid] == [True, True]
    assert [len(mesh.triangles) for mesh in surface] == [8]
    np.testing.assert_allclose(np.ptp(surface[0].vertices, axis=0), [0.5, 0.6, 0.2], atol=1e-9)
    for mesh in solid:  # with Bullet's margin
        np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.2, 0.4, 0.2], atol=4e-3)
        assert np.all(np.ptp(mesh.vertices, axis=0) > np.array([0.2, 0.4, 0.2]) + 2e-3 - 1e-9)
