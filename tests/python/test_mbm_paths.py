"""Paths on MotionBenchMaker problems, judged by programs that are not srmp: Pinocchio's and Coal's Python packages."""

import importlib.util
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from srmp.cli import main

RECHECK = Path(__file__).parents[2] / "bench" / "suites" / "recheck_mbm.py"


@pytest.fixture(scope="module")
def recheck():
    for package in ("pinocchio", "coal", "yaml"):
        pytest.importorskip(package, reason=f"the re-check needs {package}: pip install 'srmp[test]'")
    spec = importlib.util.spec_from_file_location("recheck_mbm", RECHECK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bench(mbm_dir, out, robot, problems):
    arguments = f"bench mbm --data {mbm_dir} --robot {robot} --problems {problems} --time-limit 10 --out {out}"
    outcome = CliRunner().invoke(main, arguments.split())
    assert outcome.exit_code == 0, outcome.output
    return json.loads(out.read_text())


def test_paths_are_free_for_others_too_and_the_same_twice(mbm_dir, recheck, tmp_path):
    results = bench(mbm_dir, tmp_path / "1.json", "panda", "4")
    assert len(results["rows"]) == 7
    assert sum(row["status"] == "solved" for row in results["rows"]) >= 6
    for row in results["rows"]:
        layers = [row[f"edges_{answer}_by_{layer}"] for answer in ("free", "colliding") for layer in ("balls", "coal")]
        assert sum(layers) == row["edge_checks"] > 0
        assert row["memory_bytes"] > 0
    assert recheck.recheck(results, mbm_dir) == []
    assert recheck.differing(results, bench(mbm_dir, tmp_path / "2.json", "panda", "4")) == []


def test_the_recheck_finds_collisions(mbm_dir, recheck):
    into_the_box = [[0.0, 0.4 * k, 0.0, -0.1, 0.0, 1.5, 0.8] for k in range(4)]
    row = {
        "problem": "box/0001",
        "status": "solved",
        "joint_names": [f"panda_joint{i}" for i in range(1, 8)],
        "path": into_the_box,
        "positions": into_the_box,
    }
    faults = recheck.recheck({"header": {"options": {"robot": "panda", "geometry": "urdf"}}, "rows": [row]}, mbm_dir)
    assert len(faults) == 2
    assert "touch on the path" in faults[0]
