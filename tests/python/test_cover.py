"""srmp.cover and `srmp cover`."""

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp._urdf import link_poses_at_zero
from srmp.cli import main

ARM = srmp.data_path("arm7.urdf")
ROUGH = {"accuracy": 0.04, "coarse_accuracy": 0.06}  # quick to compute


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_every_link_with_geometry_is_covered(cache):
    cover = srmp.cover(ARM, **ROUGH)
    links = [link.get("name") for link in ElementTree.parse(ARM).getroot().findall("link") if link.find("collision")]
    assert [link.link for link in cover.links] == links
    assert sum(len(link.coarse) for link in cover.links) <= 160
    for link in cover.links:
        assert link.coarse.shape[1] == link.fine.shape[1] == link.inner.shape[1] == 4
        assert len(link.children) == len(link.coarse)
        assert {child for children in link.children for child in children} <= set(range(len(link.fine)))
        assert 0 <= link.mean_fine_inflation <= link.fine_inflation + 1e-12
        assert link.fine_inflation <= 0.04 * 1.0001
        assert link.coarse_inflation <= 0.06 * 1.0001


def test_spheres_contain_primitives(cache):
    """Points of the boxes of the URDF are in coarse and in fine spheres of their link."""
    random = np.random.default_rng(1)
    cover = {link.link: link for link in srmp.cover(ARM, **ROUGH).links}
    checked = 0
    for link in ElementTree.parse(ARM).getroot().findall("link"):
        for collision in link.findall("collision"):
            box = collision.find("geometry/box")
            origin = collision.find("origin")
            if box is None or (origin is not None and any(map(float, (origin.get("rpy") or "0 0 0").split()))):
                continue
            centre = np.array((origin.get("xyz") if origin is not None else "0 0 0").split(), dtype=float)
            points = centre + np.array(box.get("size").split(), dtype=float) * (random.random((200, 3)) - 0.5)
            for spheres in (cover[link.get("name")].coarse, cover[link.get("name")].fine):
                distance = np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]
                assert np.all(distance.min(axis=1) <= 0)
            checked += 1
    assert checked > 0


def test_loaded_covers_are_equal_bit_for_bit(cache):
    computed, loaded = srmp.cover(ARM, **ROUGH), srmp.cover(ARM, **ROUGH)
    assert not computed.from_cache
    assert loaded.from_cache
    assert not srmp.cover(ARM, **ROUGH, cache=False).from_cache
    for a, b in zip(computed.links, loaded.links, strict=True):
        assert np.array_equal(a.coarse, b.coarse)
        assert np.array_equal(a.fine, b.fine)
        assert np.array_equal(a.inner, b.inner)
        assert a.children == b.children


def test_an_empty_cache_variable_disables_the_cache(monkeypatch):
    monkeypatch.setenv("SRMP_CACHE_DIR", "")
    for _ in range(2):
        assert not srmp.cover(ARM, **ROUGH).from_cache


def test_progress_is_reported_and_may_stop_the_computation(cache):
    seen = []
    srmp.cover(ARM, **ROUGH, progress=lambda done, total: seen.append((done, total)))
    assert seen == sorted(seen)
    assert seen[-1][0] == seen[-1][1] > 0

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        srmp.cover(ARM, **ROUGH, cache=False, progress=stop)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"accuracy": 0}, "fine inflation"),
        ({"accuracy": float("nan")}, "fine inflation"),
        ({"coarse_accuracy": -1}, "coarse inflation"),
        ({"accuracy": 0.02}, "must not exceed"),
        ({"max_coarse": -1}, "max_coarse must not be negative"),
    ],
)
def test_invalid_arguments_are_rejected(arguments, text):
    with pytest.raises(srmp.InvalidArgument, match=text):
        srmp.cover(ARM, **arguments)


def test_errors_name_missing_meshes(tmp_path):
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(
        "<robot name='r'><link name='a'><collision><geometry><mesh filename='package://x/nothing.stl'/></geometry>"
        "</collision></link></robot>"
    )
    with pytest.raises(srmp.FileError, match=r"nothing\.stl"):
        srmp.cover(str(urdf))


def test_the_command_prints_writes_and_plots(cache, tmp_path):
    pytest.importorskip("matplotlib")
    output, figure = tmp_path / "cover.json", tmp_path / "cover.png"
    arguments = ["cover", ARM, "--accuracy", "40", "--coarse", "60", "-o", str(output), "--figure", str(figure)]
    first = CliRunner().invoke(main, arguments)
    assert first.exit_code == 0, first.output
    assert "built in" in first.output
    assert "arm7_hand" in first.output
    assert "read from the cache in" in CliRunner().invoke(main, arguments).output
    assert figure.read_bytes().startswith(b"\x89PNG")
    cover = json.loads(output.read_text())
    assert cover["statistics"]["coarse"]["spheres"] == sum(len(link["coarse"]) for link in cover["links"].values())
    unknown = CliRunner().invoke(main, [*arguments[:-1], str(tmp_path / "cover.unknown")])
    assert unknown.exit_code == 2
    assert "Traceback" not in unknown.output


def test_link_poses_agree_with_the_library(arm):
    poses = link_poses_at_zero(ARM)
    names = arm.get_joint_names("arm")
    end_effector = np.asarray(arm.compute_fk("arm", [0.0] * len(names)).matrix())
    assert np.allclose(poses["arm7_hand"], end_effector, atol=1e-9)
