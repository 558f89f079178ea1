"""Paths on MotionBenchMaker problems, verified with Pinocchio's and Coal's Python packages instead of srmp."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp.cli import main


@pytest.fixture(scope="module")
def recheck(suite):
    return suite("recheck_mbm")


@pytest.fixture(scope="module")
def certificates(suite):
    return suite("certificates")


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
        layers = [
            row[f"edges_{outcome}_by_{layer}"] for outcome in ("free", "colliding") for layer in ("spheres", "coal")
        ]
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


def test_certificates_hold_for_others_too(mbm_dir, certificates):
    result = certificates.run(str(mbm_dir), "panda", "urdf", "4", ["box", "table_pick"])
    assert len(result["rows"]) == 2
    for row in result["rows"]:
        assert row["status"] == "solved"
        assert row["holds"]
        assert row["proved_free"]
        assert 0 < row["clearance_proved_m"] <= row["clearance_m"]
        assert row["contradictions"] == []
    assert "2/2" in certificates.table(result).splitlines()[-1]


def test_others_find_what_is_wrong_with_a_trajectory(mbm_dir, certificates, recheck):
    world = recheck.World(mbm_dir / "panda", "panda", mbm_dir / "panda" / "panda.urdf", "box/0001")
    names, rest = [f"panda_joint{i}" for i in range(1, 8)], [0.0, -0.9, 0.0, -2.0, 0.0, 1.5, 0.8]

    def motion(change, seconds):
        q = np.array([rest, rest])
        q[1] += change
        return srmp.Trajectory(names, q, times=[0, seconds], velocities=np.zeros((2, 7)))

    turn, fall, off = (np.eye(7)[j] * by for j, by in ((6, -0.5), (1, 1.5), (3, 2.5)))
    assert certificates.contradictions(world, motion(turn, 5)) == []
    fast = certificates.contradictions(world, motion(turn, 0.25))
    assert [text.split(" is above")[0] for text in fast] == [
        "panda_joint7: velocity 3",
        "panda_joint7: acceleration 48",
    ]
    assert "touch at" in certificates.contradictions(world, motion(fall, 30))[-1]
    assert "panda_joint4: position from -2 to 0.5 leaves [-3.1416, 0.0873]" in certificates.contradictions(
        world, motion(off, 60)
    )
