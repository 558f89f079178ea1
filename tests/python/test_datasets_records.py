"""Records of data sets: of every kind of scene, of failures, and how they are read; and motions that are no records."""

import sys

import numpy as np
import pytest
from data_sets import SMALL, files_of, spec_of, write_spec

import srmp

pytest.importorskip("pyarrow", reason="data sets need pyarrow: pip install '.[datasets]'")
pytest.importorskip("yaml", reason="specs need PyYAML: pip install '.[datasets]'")

from srmp import datasets
from srmp.datasets.generation import generate
from srmp.datasets.spec import read_spec


@pytest.mark.parametrize("kind", ["table", "shelf", "bin", "cage", "clutter"])
def test_kinds(kind, tmp_path):
    parameters = {} if kind == "cage" else {"meshes": 1}
    goal = {"from": "region", "pose": True} if kind == "bin" else {"from": "region"}
    scenes = [{"kind": kind, "scale": 0.9, **parameters, "goal": goal}]
    made = generate(spec_of(count=6, per_shard=6, scenes=scenes), tmp_path / "set", workers=1)
    assert made.solved >= 5
    for record in datasets.open(tmp_path / "set"):
        assert record.scene == kind
        if record.solved:
            certificate = record.planner().verify("arm", record.trajectory(), start=record.robot()["start"])
            assert certificate.holds
            assert certificate.proved_free
            assert np.allclose(np.diff(record.trajectory().times), 0.02, atol=1e-12)


def test_variations_of_a_scene(tmp_path, arm_alone):
    arm_alone.add_box("table", [0.4, 0.8, 0.04], srmp.Pose(p=[0.6, 0, 0.1]))
    arm_alone.add_cylinder("can", 0.03, 0.12, srmp.Pose(p=[0.5, 0, 0.2]))
    arm_alone.save_scene(tmp_path / "scene.json")
    scene = {"kind": "variations", "scene": str(tmp_path / "scene.json"), "moved": ["can"]}
    generate(spec_of(count=4, scenes=[scene]), tmp_path / "set", workers=1)
    poses = {tuple(record.objects[0].pose) for record in datasets.open(tmp_path / "set")}
    assert len(poses) == 4
    assert all(record.solved for record in datasets.open(tmp_path / "set"))


def test_a_function_of_the_user(tmp_path, monkeypatch):
    module = tmp_path / "my_scenes.py"
    module.write_text(
        "from srmp.datasets import Scene\n"
        "def wall(random, distance):\n"
        "    scene = Scene()\n"
        "    scene.box('wall', [0.02, 0.5, 0.5], [distance, 0, random.uniform(0.2, 0.4)])\n"
        "    scene.region('left', [0.1, 0.1, 0.1], [0.4, 0.45, 0.4])\n"
        "    scene.region('right', [0.1, 0.1, 0.1], [0.4, -0.45, 0.4])\n"
        "    return scene\n"
    )
    scene = {
        "kind": "function",
        "function": "my_scenes:wall",
        "parameters": {"distance": 0.5},
        "start": {"from": "region", "regions": ["left"]},
        "goal": {"from": "region", "regions": ["right"]},
    }
    spec = write_spec(tmp_path / "spec.yaml", spec_of(count=4, scenes=[scene]))
    first = generate(spec, tmp_path / "set", workers=1)
    assert first.solved == 4
    assert generate(spec, tmp_path / "other", workers=2).sha256 == first.sha256
    assert (tmp_path / "set" / "functions" / "my_scenes.py").exists()
    module.write_text(module.read_text() + "\n# changed\n")
    assert read_spec(spec).identity != datasets.open(tmp_path / "set").index["identity"]


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("return 3", "failing_scenes:f returned 3; it must return a srmp.datasets.Scene."),
        ("raise KeyError('x')", "failing_scenes:f of the spec failed: KeyError: 'x'."),
        ("return Scene().box('a', [1], [0, 0, 0])", "failing_scenes:f: the size of box 'a' is"),
        ("return Scene()", "no region of the scene"),
    ],
)
def test_a_function_that_fails(body, sentence, workers, tmp_path, monkeypatch):
    """One sentence, from a worker too; nothing is left behind that the next run would not take."""
    monkeypatch.delitem(sys.modules, "failing_scenes", raising=False)
    (tmp_path / "failing_scenes.py").write_text(f"from srmp.datasets import Scene\ndef f(random):\n    {body}\n")
    monkeypatch.syspath_prepend(tmp_path)
    scene = {"kind": "function", "function": "failing_scenes:f"}
    with pytest.raises(srmp.InvalidArgument) as caught:
        generate(spec_of(scenes=[scene]), tmp_path / "set", workers=workers)
    assert sentence in str(caught.value)
    assert len(datasets.open(tmp_path / "set")) == 0


def test_several_robots(tmp_path):
    robots = [
        {"name": name, "model": "arm7", "base": {"position": [0, y, 0]}}
        for name, y in (("left", 0.45), ("right", -0.45))
    ]
    scenes = [{"kind": "table", **SMALL, "start": {"from": "states", "states": ["ready"]}}]
    made = generate({**spec_of(count=3, scenes=scenes), "robots": robots}, tmp_path / "set", workers=1)
    assert made.solved >= 2
    for record in datasets.open(tmp_path / "set"):
        if record.solved:
            motions = {name: record.trajectory(name) for name in ("left", "right")}
            assert all(proof.holds for proof in record.planner().verify_multi(motions).values())
            with pytest.raises(srmp.InvalidArgument, match="name the robot"):
                record.trajectory()


def test_failures_are_records(tmp_path):
    scene = {"kind": "function", "function": "closed_scenes:full"}
    (tmp_path / "closed_scenes.py").write_text(
        "from srmp.datasets import Scene\n"
        "def full(random):\n"
        "    scene = Scene()\n"
        "    scene.box('block', [2, 2, 2], [0.5, 0, 0.5])\n"
        "    scene.region('inside', [0.1, 0.1, 0.1], [0.4, 0, 0.4])\n"
        "    return scene\n"
    )
    spec = spec_of(count=3, per_shard=3, scenes=[scene, {"kind": "table", **SMALL}], tries=2)
    made = generate(write_spec(tmp_path / "spec.yaml", spec), tmp_path / "set", workers=1)
    assert made.records == 3
    dataset = datasets.open(tmp_path / "set")
    failures = dataset.failures()
    assert failures.num_rows == 3 - made.solved > 0
    assert set(failures["status"].to_pylist()) == {"no_problem"}
    assert "no collision-free configuration of 'arm' was found" in failures["reason"][0].as_py()
    joined = failures.join(dataset.table(["index", "seed"]), "index")
    assert joined.num_rows == failures.num_rows
    with pytest.raises(srmp.InvalidArgument, match=r"no trajectory|no robot"):
        dataset[failures["index"][0].as_py()].trajectory("arm")


def test_random_access_and_iteration(small_data_set):
    dataset = datasets.open(small_data_set.directory)
    assert [record.index for record in dataset] == list(range(12)) == [dataset[k].index for k in range(12)]
    assert dataset[-1].index == 11
    assert dataset.complete
    assert dataset.table(["index", "status"]).num_rows == len(dataset) == 12
    for wrong in (12, -13):
        with pytest.raises(IndexError, match="the data set has 12"):
            dataset[wrong]
    with pytest.raises(srmp.InvalidArgument, match="whole number"):
        dataset["a"]
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'status'"):
        dataset.table(["statsu"])
    with pytest.raises(srmp.InvalidArgument, match="has no robot 'amr'"):
        dataset[0].robot("amr")


# --- the clock


def test_a_record_that_reaches_the_time_limit_is_none(small_data_set, tmp_path):
    """Nothing is stored, the run says so, and with a larger limit the same data set is made."""
    hurried = spec_of(planner={"time_limit": 1e-6})
    with pytest.raises(
        srmp.Error, match=r"12 records \(0, 1, .*…\) reached planner\.time_limit, 1e-06 s.*0 of 6 shards"
    ):
        generate(hurried, tmp_path / "set", workers=1)
    assert len(datasets.open(tmp_path / "set")) == 0
    assert generate(spec_of(), tmp_path / "set", workers=1).sha256 == small_data_set.sha256


def test_a_motion_that_is_not_found_is_a_record(tmp_path, monkeypatch):
    """By counted work, so that it is the same record everywhere; those that are found do not depend on the budget."""
    spec = spec_of(count=24, per_shard=8, scenes=[{"kind": "cage", "scale": 0.71}])
    found = generate(spec, tmp_path / "found", workers=1)
    assert found.solved == 24
    monkeypatch.setattr("srmp.datasets.spec.MAX_EXPANSIONS", 1)
    few = generate(spec, tmp_path / "few", workers=1)
    assert few.sha256 == generate(spec, tmp_path / "again", workers=1, order=lambda numbers: numbers[::-1]).sha256
    slow = {**spec, "planner": {"time_limit": 90}}
    assert few.sha256 == generate(slow, tmp_path / "slow", workers=1).sha256  # no record names the time limit
    assert 0 < few.solved < 24
    for record, whole in zip(datasets.open(tmp_path / "few"), datasets.open(tmp_path / "found"), strict=True):
        if record.solved:
            assert record.values == whole.values
        else:
            assert record.status == "timed_out"
            assert record.values["reason"].startswith("no path within max_expansions, 1 (")
    assert datasets.audit(tmp_path / "few", sample=0).passed


def test_a_budget_of_the_spec(tmp_path):
    spec = spec_of(count=24, per_shard=8, scenes=[{"kind": "cage", "scale": 0.71}], planner={"max_expansions": 1})
    one = generate(spec, tmp_path / "one", workers=1)
    assert set(datasets.open(tmp_path / "one").failures()["status"].to_pylist()) == {"timed_out"}
    assert generate(spec, tmp_path / "two", workers=2).sha256 == one.sha256


def test_the_shards_without_such_a_record_are_kept(small_data_set, tmp_path, monkeypatch):
    stats = srmp.PlannerInterface.get_planning_stats
    plans = iter(range(100))
    monkeypatch.setattr(
        srmp.PlannerInterface,
        "get_planning_stats",
        lambda planner: {**stats(planner), "total_time_s": 60.0 if next(plans) == 4 else 0.1},
    )
    with pytest.raises(srmp.Error, match=r"^record 4 reached planner\.time_limit, 60 s.*5 of 6 shards are there"):
        generate(spec_of(), tmp_path / "set", workers=1)
    assert [shard.number for shard in datasets.open(tmp_path / "set").shards] == [0, 1, 3, 4, 5]
    monkeypatch.undo()
    assert generate(spec_of(planner={"time_limit": 90}), tmp_path / "set", workers=1).made == 2
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


def test_records_that_the_spec_skips(small_data_set, tmp_path):
    """The other records stay as they are, in a new data set and in one that was begun without."""
    generate(spec_of(), tmp_path / "set", workers=1)
    assert generate(spec_of(skip=[4]), tmp_path / "set", workers=1).made == 2
    generate(spec_of(skip=[4, 4]), tmp_path / "new", workers=1)
    assert files_of(tmp_path / "set") == files_of(tmp_path / "new")
    dataset = datasets.open(tmp_path / "set")
    assert dataset.failures().to_pylist()[0]["status"] == dataset[4].status == "skipped"
    assert datasets.audit(tmp_path / "set", sample=0).passed
    assert dataset[5].values == datasets.open(small_data_set.directory)[5].values
    generate(spec_of(), tmp_path / "set", workers=1)
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)
