"""Directories of data sets: whole files or none, also where nothing can be written, and those that are none."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from data_sets import files_of, spec_of, write_spec

import srmp

pytest.importorskip("pyarrow", reason="data sets need pyarrow: pip install '.[datasets]'")
pytest.importorskip("yaml", reason="specs need PyYAML: pip install '.[datasets]'")

from srmp import datasets
from srmp.datasets.generation import generate
from srmp.datasets.spec import read_spec

_LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), -1))
import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from srmp.cli import main; main(sys.argv[1:])
"""


def test_a_file_that_is_too_large_is_not_half_written(small_data_set, tmp_path):
    """As a full disk or a quota: a write fails in the middle of a file."""
    spec = write_spec(tmp_path / "spec.yaml", spec_of())
    generate(spec, tmp_path / "set", workers=1, order=lambda numbers: numbers[:2])
    kept = files_of(tmp_path / "set")
    limited = [sys.executable, "-c", _LIMITED, "8000", "generate", str(spec), "-o", str(tmp_path / "set")]
    result = subprocess.run([*limited, "--workers", "1"], capture_output=True, text=True)
    assert result.returncode == 2
    assert re.fullmatch(
        r"error: \S+ cannot be written after 2 of 6 shards: File too large; .* goes on from them\.\n", result.stderr
    )
    assert {name: kept[name] for name in kept if name != "index.json"} == {
        name: data for name, data in files_of(tmp_path / "set").items() if name != "index.json"
    }
    generate(spec, tmp_path / "set", workers=1)
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 300 kB; needs root."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(place)], capture_output=True)
    if mount.returncode:
        pytest.skip("a small file system cannot be mounted here")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


def test_a_full_disk(small_disk, tmp_path):
    with pytest.raises(
        srmp.FileError, match=r"cannot be written after \d+ of 60 shards: No space left on device; .* goes on"
    ):
        generate(spec_of(count=120), small_disk / "set", workers=1)
    there = list((small_disk / "set").glob("shard-*"))
    assert there
    assert not list((small_disk / "set").rglob("*.part"))
    subprocess.run(["mount", "-o", "remount,size=20m", str(small_disk)], check=True)
    went_on = generate(spec_of(count=120), small_disk / "set", workers=1)
    assert went_on.made == 120 - 2 * len(there)
    assert went_on.sha256 == generate(spec_of(count=120), tmp_path / "set", workers=2).sha256


def test_a_directory_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "set", Path("/proc/set")):
        with pytest.raises(srmp.FileError, match="cannot be written"):
            generate(spec_of(), place, workers=1)


def test_a_directory_that_cannot_be_written_any_more(small_disk, small_data_set):
    """Read-only: nothing changes; writable again: the same command goes on."""
    subprocess.run(["mount", "-o", "remount,size=20m", str(small_disk)], check=True)
    generate(spec_of(), small_disk / "set", workers=1, order=lambda numbers: numbers[:2])
    kept = files_of(small_disk / "set")
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    for place in (small_disk / "set", small_disk / "other"):
        with pytest.raises(srmp.FileError, match=r"cannot be written: Read-only file system\.$"):
            generate(spec_of(), place, workers=1)
    assert files_of(small_disk / "set") == kept
    subprocess.run(["mount", "-o", "remount,rw", str(small_disk)], check=True)
    assert generate(spec_of(), small_disk / "set", workers=1).made == 8
    assert files_of(small_disk / "set") == files_of(small_data_set.directory)


def test_directories_of_others_are_left_alone(small_data_set, tmp_path, monkeypatch):
    from srmp.datasets.schema import versions

    before = files_of(small_data_set.directory)
    with pytest.raises(srmp.FileError, match=r"another spec \(different: seed\)"):
        generate(spec_of(seed=5), small_data_set.directory, workers=1)
    with pytest.raises(srmp.FileError, match="more than the 1 shards"):
        generate(spec_of(count=2), small_data_set.directory, workers=1)
    monkeypatch.setattr("srmp.datasets.store.versions", lambda: {**versions(), "math": "0"})
    with pytest.raises(srmp.FileError, match=r'made by other versions \(.*"math": "\w{8}".*choose another directory'):
        generate(spec_of(), small_data_set.directory, workers=1)
    monkeypatch.undo()
    assert files_of(small_data_set.directory) == before
    (tmp_path / "shard-000000-00000000000000000000000000000000.parquet").write_text("")
    with pytest.raises(srmp.FileError, match="holds shards but no index"):
        generate(spec_of(), tmp_path, workers=1)


def test_a_directory_in_use(small_data_set, tmp_path):
    from srmp.datasets.store import Store

    with Store(tmp_path / "set", read_spec(spec_of())), pytest.raises(srmp.FileError, match="in use by another run"):
        generate(spec_of(), tmp_path / "set", workers=1)


def test_a_damaged_shard_is_made_again(small_data_set, tmp_path):
    generate(spec_of(), tmp_path / "set", workers=1)
    shard = next((tmp_path / "set").glob("shard-000002-*"))
    shard.write_bytes(shard.read_bytes()[:-1] + b"x")
    assert generate(spec_of(), tmp_path / "set", workers=1).made == 2
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


def test_directories_that_are_no_data_sets(tmp_path):
    with pytest.raises(srmp.FileError, match=r"it has no index\.json"):
        datasets.open(tmp_path)
    (tmp_path / "index.json").write_text("{")
    with pytest.raises(srmp.FileError, match="cannot be read"):
        datasets.open(tmp_path)
    (tmp_path / "index.json").write_text("{}")
    with pytest.raises(srmp.FileError, match="not the index of a data set"):
        datasets.open(tmp_path)
    (tmp_path / "index.json").write_text('{"format": "srmp data set", "format_version": 99}')
    with pytest.raises(srmp.FileError, match="format version 99"):
        datasets.open(tmp_path)
    (tmp_path / "index.json").write_text('{"format": "srmp data set", "format_version": 1}')
    with pytest.raises(srmp.FileError, match="has no 'records'"):
        datasets.open(tmp_path)


@pytest.mark.parametrize(
    "place",
    [
        *("identity", "sha256", "records", "versions", "spec", "shards", "spec.count", "spec.robots", "spec.robots.0"),
        *(
            "spec.robots.0.name",
            "spec.robots.0.base",
            "spec.scenes",
            "spec.scenes.0.start",
            "spec.scenes.0.goal.states",
        ),
        *("spec.files", "spec.planner", "spec.skip", "shards.0", "shards.0.number"),
    ],
)
def test_an_index_of_wrong_types_is_refused(place, small_data_set, tmp_path):
    """By all that read it, in one sentence."""
    index = json.loads((small_data_set.directory / "index.json").read_text())
    inner = index
    *path, last = [int(key) if key.isdigit() else key for key in place.split(".")]
    for key in path:
        inner = inner[key]
    inner[last] = 3.5
    (tmp_path / "index.json").write_text(json.dumps(index))
    for read in (datasets.open, datasets.audit, lambda directory: generate(spec_of(), directory, workers=1)):
        with pytest.raises(srmp.FileError, match=r"index\.json is not as it is written: .*3\.5"):
            read(tmp_path)
