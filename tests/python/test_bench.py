"""The benchmarks run, at a small size, and their tables say what was measured."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

MICRO = Path(__file__).parents[2] / "bench" / "micro"


@pytest.fixture(autouse=True)
def programs_import_each_other(monkeypatch):
    monkeypatch.syspath_prepend(str(MICRO))


def load(name):
    spec = importlib.util.spec_from_file_location(f"bench_{name}", MICRO / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(name, *arguments):
    command = [sys.executable, str(MICRO / f"{name}.py"), *map(str, arguments)]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout


def test_rates_are_counts_by_times():
    checks = load("checks")
    plain = {"certified_not_free": 0, "free_not_certified": 3}
    exact = {"random_states_s": 4e-3, "free_states_s": 1e-3, "all_s": 1e-2, "free_s": 5e-3}
    row = {
        "robot": "panda",
        "geometry": "urdf",
        "problem": "box/0001",
        "motions": 100,
        "free_motions": 50,
        "contenders": {
            "boxes": {**plain, "all_s": 0.4, "free_s": 0.3},
            "tree": {**plain, "all_s": 0.5, "free_s": 0.2},
            "portable": {**exact, "certified_not_free": 0, "free_not_certified": 0},
        },
    }
    (entry,) = checks.summary([row])
    assert entry["backend"] == "portable"
    assert entry["disagreements"] == 0
    assert entry["median"] == pytest.approx(
        {
            "free_configurations": 1e5,
            "random_configurations": 2.5e4,
            "free_motions": 1e4,
            "motions": 1e4,
            "coal_motions": 250,
            "times_coal": 40,
            "times_coal_free": 40,
        }
    )
    header = {"cpu": "a CPU", "versions": {"srmp": "0"}, "options": {"problems": "1", "motions": 100}}
    table = checks.table({"header": header, "rows": [row], "summary": [entry]})
    assert "| panda, meshes | portable | 0.10 M | 0.03 M | 10.0 k | 10.0 k | 0.2 k | 40.0 (40.0 to 40.0) |" in table


def test_points_lie_on_the_surface():
    pytest.importorskip("yaml", reason="the benchmark needs PyYAML: pip install '.[test]'")
    cloud = load("cloud")
    rng = np.random.default_rng(0)
    box = cloud.on_box([0.2, 0.4, 0.6], 2000, rng) / [0.1, 0.2, 0.3]
    np.testing.assert_allclose(np.abs(box).max(axis=1), 1)
    cylinder = cloud.on_cylinder([0.5, 0.1], 2000, rng)  # height, radius
    radius = np.linalg.norm(cylinder[:, :2], axis=1)
    np.testing.assert_allclose(np.maximum(np.abs(cylinder[:, 2]) / 0.25, radius / 0.1), 1)
    sphere = cloud.on_sphere([0.3], 2000, rng)
    np.testing.assert_allclose(np.linalg.norm(sphere, axis=1), 0.3)
    for points in (box, cylinder, sphere):
        assert np.all(np.abs(points.mean(axis=0)) < 0.1 * np.abs(points).max())


def test_clouds_are_measured_against_boxes(mbm_dir, tmp_path):
    pytest.importorskip("yaml", reason="the benchmark needs PyYAML: pip install '.[test]'")
    out = tmp_path / "cloud.json"
    text = run("cloud", "--data", mbm_dir, "--points", 2000, "--motions", 10, "--repeats", 1, "--out", out)
    rows = json.loads(out.read_text())["rows"]
    assert len(rows) == 7
    for row in rows:
        assert row["points"] == pytest.approx(2000, abs=20)
        assert row["motions"] == 10
        assert row["ratio"] == pytest.approx(row["cloud_motion_s"] / row["boxes_motion_s"])
    assert text == run("cloud", "--table", out)


def test_covers_are_built_once_and_loaded(tmp_path):
    covers = load("covers")
    shape = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    urdf = tmp_path / "cube.urdf"
    urdf.write_text(f'<robot name="cube"><link name="base">{shape}</link></robot>')
    row = covers.measure_in_process(urdf, [])
    assert row["built_s"] > row["loaded_s"] > 0
    assert 1 <= row["coarse"]["spheres"] <= 160
    assert f"| cube | {row['coarse']['spheres']} (" in covers.table({"rows": [{"robot": "cube", **row}]})


def test_the_slowest_check_of_each_kind_of_robots():
    slowest = load("slowest_check")
    rows = [
        {"robot": "panda, meshes", "scenario": "box", "checks": 1200, "seconds": 1e-4},
        {"robot": "panda, meshes", "scenario": "cage", "checks": 800, "seconds": 4.59e-3},
        {"robot": "several", "scenario": "ring", "checks": 5, "seconds": 1e-3},
    ]
    _, _, panda, several = slowest.table({"rows": rows}).splitlines()
    assert panda.split() == ["panda,", "meshes", "2", "2,000", "4.59", "ms", "cage"]
    assert several.split() == ["several", "1", "5", "1.00", "ms", "ring"]
