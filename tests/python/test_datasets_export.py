"""Exports of data sets, read back by the packages of their formats."""

import importlib.util
import io
import json
import tarfile

import numpy as np
import pytest

import srmp

for package in ("pyarrow", "yaml"):
    pytest.importorskip(package, reason=f"data sets need {package}: pip install '.[datasets]'")

from srmp import datasets  # noqa: E402

SPEC = {
    "count": 5,
    "records_per_shard": 2,
    "robots": [{"name": "arm", "model": "arm7"}],
    "scenes": [{"kind": "table", "scale": 0.9, "objects": 2, "meshes": 0}, {"kind": "cage", "scale": 0.9}],
    "planner": {"sample_period": 0.05},
}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    directory = tmp_path_factory.mktemp("export") / "set"
    assert datasets.generate(SPEC, directory, workers=1).solved == 5
    return datasets.open(directory)


def test_numpy(dataset, tmp_path):
    assert datasets.export(dataset, tmp_path / "out", "numpy") == 5
    with np.load(tmp_path / "out" / "motions-000000.npz") as arrays:
        assert arrays["joint_names"].tolist() == dataset.joint_names["arm"]
        for k, record in enumerate(dataset):
            mask = arrays["mask"][k]
            assert np.array_equal(arrays["positions"][k][mask], record.trajectory().positions)
            assert np.array_equal(arrays["positions"][k][~mask], np.repeat(arrays["goal"][k][None], (~mask).sum(), 0))


def test_hdf5(dataset, tmp_path):
    h5py = pytest.importorskip("h5py", reason="pip install '.[hdf5]'")
    assert datasets.export(dataset, tmp_path / "out.h5", "hdf5") == 5
    with h5py.File(tmp_path / "out.h5") as file:
        assert list(file.attrs["joint_names"]) == dataset.joint_names["arm"]
        assert file.attrs["sha256"] == dataset.sha256
        for k, record in enumerate(dataset):
            rows = slice(file["first_row"][k], file["first_row"][k] + file["rows"][k])
            assert np.array_equal(file["positions"][rows], record.trajectory().positions)
            assert np.array_equal(file["velocities"][rows], record.trajectory().velocities)
            assert file["scene"].asstr()[k] == record.scene


def test_webdataset(dataset, tmp_path):
    assert datasets.export(dataset.directory, tmp_path / "out", "webdataset") == 5
    with tarfile.open(tmp_path / "out" / "motions-000000.tar") as archive:
        for record in dataset:
            stem = f"{record.index:09d}"
            positions = np.load(io.BytesIO(archive.extractfile(f"{stem}.positions.npy").read()))
            assert np.array_equal(positions, record.trajectory().positions)
            about = json.load(archive.extractfile(f"{stem}.json"))
            assert about["scene"] == record.scene
            assert about["objects"] == json.loads(json.dumps(record.values["objects"]))


def test_webdataset_reads_it(dataset, tmp_path):
    webdataset = pytest.importorskip("webdataset", reason="the package webdataset is not installed")
    datasets.export(dataset, tmp_path / "out", "webdataset")
    source = webdataset.WebDataset(str(tmp_path / "out" / "motions-000000.tar"), shardshuffle=False).decode()
    found = [sample["positions.npy"] for sample in source]
    assert all(np.array_equal(a, record.trajectory().positions) for a, record in zip(found, dataset, strict=True))


def test_lerobot_by_its_documented_schema(dataset, tmp_path):
    import pyarrow.parquet as parquet

    assert datasets.export(dataset, tmp_path / "out", "lerobot") == 5
    info = json.loads((tmp_path / "out" / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", 20, 5)
    data = parquet.read_table(tmp_path / "out" / info["data_path"].format(chunk_index=0, file_index=0))
    assert set(data.column_names) == set(info["features"])
    assert data.num_rows == info["total_frames"]
    episodes = parquet.read_table(tmp_path / "out" / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    for episode, record in zip(episodes, dataset, strict=True):
        frames = data.slice(episode["dataset_from_index"], episode["length"])
        assert episode["dataset_to_index"] - episode["dataset_from_index"] == episode["length"]
        state = np.array(frames["observation.state"].to_pylist())
        assert np.allclose(state, record.trajectory().positions, atol=1e-6)
        assert np.array_equal(np.array(frames["action"].to_pylist())[:-1], state[1:])
        assert np.allclose(frames["timestamp"], np.arange(episode["length"]) / info["fps"], atol=1e-4)
        assert frames["frame_index"].to_pylist() == list(range(episode["length"]))
        assert set(frames["episode_index"].to_pylist()) == {episode["episode_index"]}
        assert episode["tasks"] == [record.scene]
        assert episode["srmp.index"] == record.index
    statistics = json.loads((tmp_path / "out" / "meta" / "stats.json").read_text())
    states = np.array(data["observation.state"].to_pylist())
    assert np.allclose(statistics["observation.state"]["mean"], states.mean(axis=0))
    assert np.allclose(statistics["observation.state"]["std"], states.std(axis=0))
    tasks = parquet.read_table(tmp_path / "out" / "meta" / "tasks.parquet")
    assert dict(zip(tasks["task"].to_pylist(), tasks["task_index"].to_pylist(), strict=True)) == {"table": 0, "cage": 1}
    assert json.loads(tasks.schema.metadata[b"pandas"])["index_columns"] == ["task"]


def test_lerobot_reads_it(dataset, tmp_path):
    if importlib.util.find_spec("lerobot") is None:
        pytest.skip("lerobot is not installed; the test before reads the files by the documented schema")
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    datasets.export(dataset, tmp_path / "out", "lerobot")
    frames = LeRobotDataset("local/out", root=tmp_path / "out")
    assert frames.num_episodes == 5
    states = np.vstack([record.trajectory().positions for record in dataset]).astype(np.float32)
    assert np.array_equal(np.stack([frame["observation.state"].numpy() for frame in frames]), states)
    assert frames[0]["task"] == dataset[0].scene
    ahead = LeRobotDataset("local/out", root=tmp_path / "out", delta_timestamps={"action": [0.0, 0.05, 0.1]})
    assert np.array_equal(ahead[0]["action"].numpy(), states[1:4])
    some = LeRobotDataset("local/out", root=tmp_path / "out", episodes=[1, 3])
    assert len(some) == sum(len(dataset[k].trajectory().times) for k in (1, 3))


def test_what_is_refused(dataset, tmp_path):
    with pytest.raises(srmp.InvalidArgument, match="target 'hdf', did you mean 'hdf5'"):
        datasets.export(dataset, tmp_path / "out", "hdf")
    (tmp_path / "out").write_text("")
    with pytest.raises(srmp.FileError, match="exists already"):
        datasets.export(dataset, tmp_path / "out", "numpy")
    for target in ("numpy", "lerobot", "webdataset"):
        with pytest.raises(srmp.FileError, match="cannot be written"):
            datasets.export(dataset, tmp_path / "out" / "inside", target)
    assert not list(tmp_path.glob("*.part"))
