"""Data sets: the same bytes however they are made, whole files or none, one sentence for everything that is wrong."""

import contextlib
import ctypes
import dataclasses
import fcntl
import gc
import json
import os
import pty
import random
import re
import signal
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

import numpy as np
import pytest

import srmp

pytest.importorskip("pyarrow", reason="data sets need pyarrow: pip install '.[datasets]'")
pytest.importorskip("yaml", reason="specs need PyYAML: pip install '.[datasets]'")

from srmp import datasets
from srmp.datasets.generation import generate
from srmp.datasets.recorder import Recorder, random_numbers
from srmp.datasets.scene import Scene
from srmp.datasets.spec import Spec, read_spec

ROBOT = {"name": "arm", "model": "arm7", "tool_length": 0.0}
SMALL = {"scale": 0.9, "objects": 2, "meshes": 0}


def spec_of(count=12, per_shard=2, scenes=None, **more):
    return {
        "count": count,
        "records_per_shard": per_shard,
        "robots": [ROBOT],
        "scenes": scenes or [{"kind": "table", **SMALL}, {"kind": "shelf", **SMALL}],
        **more,
    }


def files_of(directory):
    """Everything but what says when and where it was made."""
    left_out = {"runs.jsonl", ".lock"}
    return {
        str(path.relative_to(directory)): path.read_bytes()
        for path in sorted(Path(directory).rglob("*"))
        if path.is_file() and path.name not in left_out
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    directory = tmp_path_factory.mktemp("datasets") / "one"
    return generate(spec_of(), directory, workers=1)


# --- the same bytes


def test_same_bytes_in_reversed_order(made, tmp_path):
    other = generate(spec_of(), tmp_path / "set", workers=1, order=lambda numbers: numbers[::-1])
    assert other.sha256 == made.sha256
    assert files_of(tmp_path / "set") == files_of(made.directory)


@pytest.mark.parametrize("workers", [2, 4])
def test_same_bytes_by_processes(made, tmp_path, workers):
    generate(spec_of(), tmp_path / "set", workers=workers)
    assert files_of(tmp_path / "set") == files_of(made.directory)


ALL_KINDS = [
    {"kind": kind, "scale": 0.9, **({} if kind == "cage" else {"meshes": 1})}
    for kind in ("table", "shelf", "bin", "cage", "clutter")
]
LESS_CAPABLE = {
    "portable": {"SRMP_SIMD": "portable"},
    "AVX2": {"SRMP_SIMD": "avx2"},
    "AVX-512": {"SRMP_SIMD": "avx512"},
    "NumPy without": {"NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F"},
    "Arrow without": {"ARROW_USER_SIMD_LEVEL": "NONE"},
    "libraries without AVX-512": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW"},
    "libraries without FMA": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW,-AVX2,-FMA,-FMA4"},
}
"""What the environment can take away from this processor: the library's own kernels, and those of what it uses."""
MADE_ELSEWHERE = """
import json, sys
from srmp import datasets
from srmp.datasets.schema import math_version
made = datasets.generate(json.loads(sys.argv[1]), sys.argv[2], workers=1)
print(made.sha256, made.solved, math_version())
"""


@pytest.fixture(scope="module")
def made_with(tmp_path_factory):
    """Hash, motions and math of a small data set of every kind of scene, by a process with these variables."""

    def make(variables):
        arguments = [json.dumps(spec_of(count=10, scenes=ALL_KINDS)), str(tmp_path_factory.mktemp("set") / "set")]
        command = [sys.executable, "-c", MADE_ELSEWHERE, *arguments]
        done = subprocess.run(command, env={**os.environ, **variables}, capture_output=True, text=True)
        if "which this CPU does not have" in done.stderr:
            pytest.skip("this processor does not have these instructions")
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    return make


@pytest.fixture(scope="module")
def made_by_default(made_with):
    return made_with({})


@pytest.mark.parametrize("variables", LESS_CAPABLE.values(), ids=LESS_CAPABLE)
def test_same_bytes_on_every_instruction_set(made_with, made_by_default, variables):
    """Or other versions: where the C library has other last bits, the version of its math says so."""
    made = made_with(variables)
    assert int(made[1]) >= 8
    assert (made[0] == made_by_default[0]) == (made[2] == made_by_default[2])
    if "GLIBC_TUNABLES" not in variables:
        assert made == made_by_default


def test_workers_of_other_versions_are_refused():
    from srmp.datasets.schema import versions
    from srmp.datasets.workers import require_same_versions

    require_same_versions(versions())
    with pytest.raises(srmp.Error, match=r"other versions than the driver: numpy \S+ \(1\.0\); all must have the same"):
        require_same_versions({**versions(), "numpy": "1.0"})


def test_a_record_does_not_depend_on_those_before(made):
    dataset = datasets.open(made.directory)
    recorder = Recorder(dataset.spec, made.directory)
    for index in (7, 2, 7):
        assert recorder.record(index)["robots"][0]["positions"].tolist() == list(
            dataset[index].values["robots"][0]["positions"]
        )


def test_growth_keeps_whole_shards(made, tmp_path):
    generate(spec_of(count=5), tmp_path / "set", workers=1)
    assert generate(spec_of(count=12), tmp_path / "set", workers=1).made == 8  # one shard was not full
    assert files_of(tmp_path / "set") == files_of(made.directory)


def test_another_place_and_another_seed(made, tmp_path):
    assert read_spec(spec_of(seed=1)).identity != read_spec(spec_of()).identity
    assert read_spec(spec_of(count=99, per_shard=7)).identity == read_spec(spec_of()).identity
    spec = datasets.open(made.directory).spec
    assert Spec.from_dict(json.loads(json.dumps(spec.to_dict())), spec.files).identity == spec.identity
    a, b = (random_numbers(spec.identity, index).random(4) for index in (3, 4))
    assert not np.any(a == b)


class _Allocated(ctypes.Structure):
    """struct mallinfo2 of glibc."""

    names = ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")
    _fields_ = [(name, ctypes.c_size_t) for name in names]


def allocated_bytes():
    """What this process has allocated; not what the allocator keeps."""
    gc.collect()
    ask = getattr(ctypes.CDLL(None), "mallinfo2", None) or pytest.skip("needs mallinfo2 (glibc 2.33)")
    ask.restype = _Allocated
    found = ask()
    return found.uordblks + found.hblkhd


def test_a_worker_does_not_grow_with_its_records(made):
    """After the same record, so that the scene that is there is the same too."""
    recorder = Recorder(read_spec(spec_of(count=1000, per_shard=60, scenes=ALL_KINDS)), made.directory)
    after = []
    for number in range(1, 5):
        recorder.shard(number)
        recorder.record(0)
        after.append(allocated_bytes())
    # Of 120 records and more, beside other threads; a scene has some 100 000.
    assert after[-1] - min(after[:2]) < 60_000


# --- the clock


def test_a_record_that_reaches_the_time_limit_is_none(made, tmp_path):
    """Nothing is stored, the run says so, and with a larger limit the same data set is made."""
    hurried = spec_of(planner={"time_limit": 1e-6})
    with pytest.raises(
        srmp.Error, match=r"12 records \(0, 1, .*…\) reached planner\.time_limit, 1e-06 s.*0 of 6 shards"
    ):
        generate(hurried, tmp_path / "set", workers=1)
    assert len(datasets.open(tmp_path / "set")) == 0
    assert generate(spec_of(), tmp_path / "set", workers=1).sha256 == made.sha256


def test_a_motion_that_is_not_found_is_a_record(tmp_path, monkeypatch):
    """By counted work, so that it is the same record everywhere; those that are found do not depend on the budget."""
    spec = spec_of(count=24, per_shard=8, scenes=[{"kind": "cage", "scale": 0.9}])
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
    spec = spec_of(count=24, per_shard=8, scenes=[{"kind": "cage", "scale": 0.9}], planner={"max_expansions": 1})
    one = generate(spec, tmp_path / "one", workers=1)
    assert set(datasets.open(tmp_path / "one").failures()["status"].to_pylist()) == {"timed_out"}
    assert generate(spec, tmp_path / "two", workers=2).sha256 == one.sha256


def test_the_shards_without_such_a_record_are_kept(made, tmp_path, monkeypatch):
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
    assert files_of(tmp_path / "set") == files_of(made.directory)


def test_records_that_the_spec_skips(made, tmp_path):
    """The other records stay as they are, in a new data set and in one that was begun without."""
    generate(spec_of(), tmp_path / "set", workers=1)
    assert generate(spec_of(skip=[4]), tmp_path / "set", workers=1).made == 2
    generate(spec_of(skip=[4, 4]), tmp_path / "new", workers=1)
    assert files_of(tmp_path / "set") == files_of(tmp_path / "new")
    dataset = datasets.open(tmp_path / "set")
    assert dataset.failures().to_pylist()[0]["status"] == dataset[4].status == "skipped"
    assert datasets.audit(tmp_path / "set", sample=0).passed
    assert dataset[5].values == datasets.open(made.directory)[5].values
    generate(spec_of(), tmp_path / "set", workers=1)
    assert files_of(tmp_path / "set") == files_of(made.directory)


# --- work that is lost


def command(spec, directory, *more):
    code = "import sys; from srmp.cli import main; main(sys.argv[1:])"
    return [sys.executable, "-c", code, "generate", str(spec), "-o", str(directory), *more]


def children_of(pid):
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += [int(child) for child in task.read_text().split()]
    return found


def workers_of(pid):
    """Processes of the pool; not multiprocessing's own resource tracker."""
    found = []
    for child in children_of(pid):
        with contextlib.suppress(OSError):
            if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(child)
    return found


def write_spec(path, spec):
    import yaml

    path.write_text(yaml.safe_dump(spec))
    return path


KILLS = int(os.environ.get("SRMP_KILLS", "4"))
"""Of the driver and of workers; data sets are told to survive any number of them."""


def shards_in(directory):
    return len(list(Path(directory).glob("shard-*.parquet")))


def has_come_to(driver, directory, shards):
    """Waits until the directory holds this many shards; False when the driver ended first."""
    while driver.poll() is None:
        if shards_in(directory) >= shards:
            return True
        time.sleep(0.001)
    return False


def test_same_bytes_after_kills(tmp_path):
    """Each kill waits for a drawn number of new shards, so that all of them hit a run that is at work."""
    step, per_shard = 5, 4  # a run of one shard takes longer than it takes to see that it is there
    spec = write_spec(tmp_path / "spec.yaml", spec_of(count=per_shard * step * (KILLS + 2), per_shard=per_shard))
    generate(spec, tmp_path / "whole", workers=1)
    draw, kills, orphans = random.Random(0), 0, []
    for _ in range(KILLS + 1):
        driver = subprocess.Popen(command(spec, tmp_path / "set", "--workers", "2"), stderr=subprocess.PIPE)
        while kills < KILLS and has_come_to(
            driver, tmp_path / "set", shards_in(tmp_path / "set") + draw.randrange(step)
        ):
            workers = workers_of(driver.pid)
            if kills % 2 == 0 and not workers:
                continue  # they are about to begin
            orphans += workers
            os.kill(driver.pid if kills % 2 else draw.choice(workers), signal.SIGKILL)
            kills += 1
        errors = driver.communicate()[1]
        if driver.returncode == 0:
            break
        assert driver.returncode == -signal.SIGKILL, errors.decode()
    assert kills == KILLS
    assert files_of(tmp_path / "set") == files_of(tmp_path / "whole")
    time.sleep(1.0)
    assert not [pid for pid in orphans if Path(f"/proc/{pid}/cmdline").exists() and "zombie" not in state_of(pid)]


def test_a_worker_that_is_killed_while_it_hands_over_a_shard(tmp_path, monkeypatch):
    """The driver has half of the shard, and goes on with another worker."""
    (tmp_path / "torn_scenes.py").write_text(
        "import multiprocessing.connection, os, signal\n"
        "from pathlib import Path\n"
        "from srmp.datasets import Scene\n"
        "def half(connection, data, *_):\n"
        "    os.write(connection.fileno(), bytes(data)[: len(data) // 2])\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        "def f(random, marker):\n"
        "    if not Path(marker).exists():\n"
        "        Path(marker).write_text('')\n"
        "        multiprocessing.connection.Connection._send = half\n"
        "    scene = Scene()\n"
        "    scene.region('all', [0.2, 0.2, 0.2], [0.4, 0.2, 0.4])\n"
        "    return scene\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    marker = tmp_path / "killed"
    scene = {"kind": "function", "function": "torn_scenes:f", "parameters": {"marker": str(marker)}}
    made = generate(spec_of(scenes=[scene]), tmp_path / "set", workers=2)
    assert marker.exists()
    assert made.sha256 == generate(spec_of(scenes=[scene]), tmp_path / "whole", workers=1).sha256


def test_a_worker_that_is_killed_before_it_begins(made, tmp_path, monkeypatch):
    """Nor does the driver wait for it when it has much to tell it."""
    import multiprocessing.util

    begin, killed = multiprocessing.util.spawnv_passfds, []

    def kill_the_first(path, arguments, descriptors):
        pid = begin(path, arguments, descriptors)
        if not killed and any("spawn_main" in os.fsdecode(argument) for argument in arguments):
            os.kill(pid, signal.SIGKILL)
            killed.append(pid)
        return pid

    monkeypatch.setattr(multiprocessing.util, "spawnv_passfds", kill_the_first)
    spec = read_spec(spec_of())
    large = dataclasses.replace(spec, files={**spec.files, "functions/large.txt": bytes(10_000_000)})
    assert generate(large, tmp_path / "set", workers=2).solved == made.solved
    assert killed


def state_of(pid):
    try:
        return Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return "zombie"


def test_the_command_shows_records_rate_and_time_left(tmp_path):
    """On a terminal; not where stderr is a file or a pipe."""
    spec = write_spec(tmp_path / "spec.yaml", spec_of())
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    process = subprocess.Popen(
        command(spec, tmp_path / "set", "--workers", "1"),
        stdout=subprocess.PIPE,
        stderr=theirs,
        text=True,
        env={**os.environ, "TQDM_MININTERVAL": "0"},  # every record, however quick
    )
    os.close(theirs)
    shown = b""
    with contextlib.suppress(OSError):  # the end of a terminal
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    assert re.fullmatch(
        r"made 12 records, \d+ of them solved, in [\d.]+ s \([\d.]+/s\)\n\S+: 12 records, SHA-256 \w{64}\n",
        process.communicate()[0],
    )
    assert process.returncode == 0
    bar = rb"\b6/12 \[\d\d:\d\d<\d\d:\d\d, +[\d.]+(motion/s|s/motion)\]"  # records, time elapsed < left, rate
    assert re.search(bar, shown), shown
    again = subprocess.run(command(spec, tmp_path / "set"), capture_output=True, text=True)
    assert (again.returncode, again.stderr) == (0, "")
    assert "made" not in again.stdout


def test_ctrl_c_keeps_what_is_there(tmp_path):
    spec = write_spec(tmp_path / "spec.yaml", spec_of(count=2000, per_shard=1))
    directory = tmp_path / "set"
    driver = subprocess.Popen(
        command(spec, directory, "--workers", "2"),
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline and len(list(directory.glob("shard-*.parquet"))) < 3:
        time.sleep(0.05)
    driver.send_signal(signal.SIGINT)
    began = time.monotonic()
    errors = driver.communicate(timeout=20)[1]
    assert time.monotonic() - began < 5
    assert driver.returncode == 1
    assert "Traceback" not in errors
    dataset = datasets.open(directory)
    assert not dataset.complete
    assert len(dataset) == len(list(directory.glob("shard-*.parquet"))) >= 3
    assert [record.index for record in dataset][:3] == [shard.number for shard in dataset.shards][:3]
    assert not list(directory.rglob("*.part"))


# --- places that cannot be written

_LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)), -1))
import signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from srmp.cli import main; main(sys.argv[1:])
"""


def test_a_file_that_is_too_large_is_not_half_written(made, tmp_path):
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
    assert files_of(tmp_path / "set") == files_of(made.directory)


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


def test_a_directory_that_cannot_be_written_any_more(small_disk, made):
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
    assert files_of(small_disk / "set") == files_of(made.directory)


def test_directories_of_others_are_left_alone(made, tmp_path, monkeypatch):
    from srmp.datasets.schema import versions

    before = files_of(made.directory)
    with pytest.raises(srmp.FileError, match=r"another spec \(different: seed\)"):
        generate(spec_of(seed=5), made.directory, workers=1)
    with pytest.raises(srmp.FileError, match="more than the 1 shards"):
        generate(spec_of(count=2), made.directory, workers=1)
    monkeypatch.setattr("srmp.datasets.store.versions", lambda: {**versions(), "math": "0"})
    with pytest.raises(srmp.FileError, match=r'made by other versions \(.*"math": "\w{8}".*choose another directory'):
        generate(spec_of(), made.directory, workers=1)
    monkeypatch.undo()
    assert files_of(made.directory) == before
    (tmp_path / "shard-000000-00000000000000000000000000000000.parquet").write_text("")
    with pytest.raises(srmp.FileError, match="holds shards but no index"):
        generate(spec_of(), tmp_path, workers=1)


def test_a_directory_in_use(made, tmp_path):
    from srmp.datasets.store import Store

    with Store(tmp_path / "set", read_spec(spec_of())), pytest.raises(srmp.FileError, match="in use by another run"):
        generate(spec_of(), tmp_path / "set", workers=1)


def test_a_damaged_shard_is_made_again(made, tmp_path):
    generate(spec_of(), tmp_path / "set", workers=1)
    shard = next((tmp_path / "set").glob("shard-000002-*"))
    shard.write_bytes(shard.read_bytes()[:-1] + b"x")
    assert generate(spec_of(), tmp_path / "set", workers=1).made == 2
    assert files_of(tmp_path / "set") == files_of(made.directory)


# --- specs

BROKEN = [
    ({"count": 0}, "count is 0; it must be a whole number of at least 1."),
    ({"count": "many"}, "count is 'many'"),
    ({"records_per_shard": 0}, "records_per_shard is 0; it must be a whole number from 1 to 100000."),
    ({"seed": -1}, "seed is -1"),
    ({"clearance": -0.1}, "clearance is -0.1; it must be a number from 0 to 1."),
    ({"clearance": float("nan")}, "clearance is nan"),
    ({"tries": 1.5}, "tries is 1.5; it must be a whole number"),
    ({"skip": 3}, "skip is 3; it must be a list of whole numbers of at least 0."),
    ({"skip": [1.5]}, "skip is [1.5]"),
    ({"skip": [-1]}, "skip is [-1]"),
    ({"skip": "12"}, "skip is '12'"),
    ({"cuont": 3}, "the spec has an unknown field 'cuont', did you mean 'count'?"),
    ({"robots": []}, "robots is []; it must be a list of at least one mapping."),
    ({"robots": [3]}, "robots[0] is 3; it must be a mapping"),
    ({"robots": [{"model": "arm7"}]}, "robots[0] has no 'name'."),
    ({"robots": [{**ROBOT, "name": "a/b"}]}, "robots[0].name is 'a/b'"),
    ({"robots": [{**ROBOT, "name": "a" * 99}]}, "it must be made of at most 60 letters"),
    ({"count": 10**400}, "it must be at most 10000000 times records_per_shard, 2."),
    ({"clearance": 10**400}, "it must be a number from 0 to 1."),
    ({"planner": {"time_limit": 10**400}}, "planner: "),
    ({"start": "x\ny"}, "start is 'x\\ny'; it must be a mapping"),
    ({"scenes": [{"kind": "variations", "scene": "x" * 5000}]}, "it must be a file that exists."),
    (
        {"robots": [{**ROBOT, "model": "arm8"}]},
        "robots[0].model is 'arm8'; it must be one of arm7, did you mean 'arm7'?",
    ),
    ({"robots": [{"name": "arm", "urdf": "none.urdf", "end_effector": "x"}]}, "it must be a file that exists."),
    ({"robots": [{**ROBOT, "srdf": "none.srdf"}]}, "robots[0] has an unknown field 'srdf'"),
    ({"robots": [{**ROBOT, "end_effector": "arm7_hnad"}]}, "did you mean 'arm7_hand'?"),
    ({"robots": [{**ROBOT, "group": "legs"}]}, "robots[0]: "),
    ({"robots": [{**ROBOT, "fixed_joints": {"x": "y"}}]}, "fixed_joints.x is 'y'; it must be a number."),
    (
        {"robots": [{**ROBOT, "base": {"position": [0, 0]}}]},
        "base.position is [0, 0]; it must be 3 finite numbers.",
    ),
    ({"robots": [{**ROBOT, "base": {"rpy": "up"}}]}, "robots[0].base.rpy is 'up'"),
    ({"robots": [{**ROBOT, "base": {"yaw": 1}}]}, "robots[0].base has an unknown field 'yaw'"),
    ({"robots": [{**ROBOT, "tool_length": -1}]}, "robots[0].tool_length is -1"),
    ({"robots": [{**ROBOT, "package_dirs": "x"}]}, "robots[0] has an unknown field 'package_dirs'"),
    ({"robots": [ROBOT, ROBOT]}, "two robots have the name 'arm'."),
    ({"scenes": []}, "scenes is []"),
    ({"scenes": [{"kind": "tabel"}]}, "scenes[0].kind is 'tabel'; it must be one of table, shelf"),
    ({"scenes": [{"kind": "table", "weight": 0}]}, "scenes[0].weight is 0"),
    (
        {"scenes": [{"kind": "table", "objects": -1}]},
        "[0].objects is -1; it must be a whole number from 0 to 500.",
    ),
    ({"scenes": [{"kind": "table", "scale": 0}]}, "scenes[0].scale is 0"),
    ({"scenes": [{"kind": "table", "bars": 3}]}, "scenes[0] has an unknown field 'bars'"),
    ({"scenes": [{"kind": "table"}, {"kind": "table"}]}, "two scenes have the name 'table'"),
    ({"scenes": [{"kind": "table", "start": {"from": "regoin"}}]}, "did you mean 'region'?"),
    ({"scenes": [{"kind": "table", "goal": {"from": "region", "pose": 1}}]}, "scenes[0].goal.pose is 1"),
    (
        {"start": {"from": "states", "states": ["raedy"]}},
        "states[0] is 'raedy'; it must be a state of 'arm': ready",
    ),
    ({"start": {"from": "states", "states": [[1, 2]]}}, "start.states[0] is [1, 2]; it must be 7 finite numbers."),
    ({"start": {"from": "states", "states": []}}, "start.states is []"),
    ({"goal": {"from": "configuration", "regions": ["x"]}}, "goal has an unknown field 'regions'"),
    ({"scenes": [{"kind": "function", "function": "no"}]}, "scenes[0].function is 'no'; it must be module:function."),
    ({"scenes": [{"kind": "function", "function": "no_module:f"}]}, "in a module that is one file"),
    ({"scenes": [{"kind": "variations", "scene": "none.yaml"}]}, "none.yaml'; it must be a file that exists."),
    ({"scenes": [{"kind": "variations"}]}, "scenes[0] has no 'scene'."),
    ({"planner": {"planner_id": "autto"}}, "planner: "),
    ({"planner": {"time_limit": -1}}, "planner: "),
    ({"planner": {"certify": False}}, "planner.certify is False; in data sets it must be True."),
    ({"planner": {"improve_time": 0.5}}, "planner.improve_time is 0.5"),
    (
        {"planner": {"planner_id": "ARAstar"}},
        "planner.planner_id is 'ARAstar', which improves its path until the clock",
    ),
    ({"planner": {"planner_id": "AMRAstar"}}, "planner.planner_id is 'AMRAstar'"),
    ({"planner": {"timing": "none"}}, "planner.timing is 'none'"),
    ({"planner": []}, "planner is []; it must be a mapping"),
    ({"planner": {"sample_period": -1}}, "planner: option 'sample_period' is -1; it must be above 0"),
    (
        {"planner": {"sample_rate": 50}},
        "planner.sample_rate is 50; in data sets rows are a planner.sample_period apart.",
    ),
    ({"planner": {"heuristic": "shortest"}}, "planner: option 'heuristic' is 'shortest'; known are 'joint_euclidean'"),
    ({"planner": {"mprim_path": "mine.yaml"}}, "planner.mprim_path is 'mine.yaml'; in data sets it must be empty"),
    ({"planner": {"mprim_path_arm": "mine.yaml"}}, "planner.mprim_path_arm is 'mine.yaml'"),
    (
        {"planner": {"planner_id": "CBS"}},
        "planner.planner_id is 'CBS', which plans for many robots only; there is one.",
    ),
]


@pytest.mark.parametrize(("change", "sentence"), BROKEN, ids=[str(change)[:60] for change, _ in BROKEN])
def test_a_broken_spec_is_one_sentence(change, sentence, tmp_path):
    with pytest.raises(srmp.Error) as caught:
        generate({**spec_of(), **change}, tmp_path / "set", workers=1)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "set").exists()


def whole_spec(directory):
    """A spec with every field that there is."""
    (directory / "scene.json").write_text(
        json.dumps({"scene": {"objects": [an_object(shape={"kind": "box", "size": [0.1, 0.1, 0.1]})]}})
    )
    (directory / "request.yaml").write_text(A_REQUEST)
    (directory / "whole_scenes.py").write_text("def f(random):\n    return None\n")
    robot = {
        **{"name": "arm", "urdf": srmp.data_path("arm7.urdf"), "srdf": srmp.data_path("arm7.srdf"), "package_dirs": []},
        **{"end_effector": "arm7_hand", "group": "arm", "fixed_joints": {}, "tool_length": 0.1},
        "base": {"position": [0, 0, 0], "rpy": [0, 0, 0]},
    }
    region = {"from": "region", "regions": ["*"], "pose": True}
    scenes = [
        {"kind": "table", "name": "one", "weight": 1, "scale": 0.9, "objects": 2, "meshes": 0, "start": region},
        {"kind": "shelf", "scale": 0.9, "levels": 2, "objects": 2, "meshes": 0, "goal": region},
        {"kind": "bin", "scale": 0.9, "bins": 2, "objects": 2, "meshes": 0},
        {"kind": "cage", "scale": 0.9, "bars": 3},
        {"kind": "clutter", "scale": 0.9, "objects": 2, "meshes": 0},
        {
            **{"kind": "variations", "scene": "scene.json", "request": "request.yaml", "moved": ["*"]},
            **{"shift": 0.05, "turn": 0.1, "object_shift": 0.03, "object_turn": 0.3},
        },
        {"kind": "function", "function": "whole_scenes:f", "parameters": {"x": 1}},
    ]
    return {
        **{"count": 3, "records_per_shard": 2, "seed": 0, "robots": [robot], "scenes": scenes, "clearance": 0.005},
        **{"planner": {"planner_id": "auto", "time_limit": 60.0, "sample_period": 0.02}, "tries": 20, "skip": [1]},
        **{"start": {"from": "states", "states": ["ready"], "pose": False}, "goal": {"from": "configuration"}},
    }


def an_object(**changes):
    return {"name": "a", "pose": [0.6, 0, 0.1, 0, 0, 0, 1], **changes}


A_REQUEST = """
start_state:
  joint_state:
    name: [{names}]
    position: [{zeros}]
goal_constraints:
  - joint_constraints: [{goals}]
""".format(
    names=", ".join(f"arm7_joint{k}" for k in range(1, 8)),
    zeros=", ".join(["0.1"] * 7),
    goals=", ".join(f"{{joint_name: arm7_joint{k}, position: 0.2}}" for k in range(1, 8)),
)


def places_in(value, path=()):
    """Every field of a spec, and every mapping that must not have others."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*path, key)
        yield from places_in(inner, (*path, key))


def with_value(value, path, new):
    """A copy with another value at a path."""
    if not path:
        return new
    copy = value.copy()
    copy[path[0]] = with_value(value[path[0]] if len(path) > 1 else None, path[1:], new)
    return copy


def name_of(path):
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path).lstrip(".")


def test_every_field_is_refused_when_it_is_wrong(tmp_path, monkeypatch):
    """By one sentence that names it; NaN is nothing that any field may be. And every mapping knows its fields."""
    monkeypatch.chdir(tmp_path)
    spec = whole_spec(tmp_path)
    read_spec(spec)
    places = [path for path in places_in(spec) if "package_dirs" not in path[:-1]]
    assert {"count", "robots[0].base.rpy", "scenes[5].object_turn", "start.states[0]"} <= set(map(name_of, places))
    for path in places:
        with pytest.raises(srmp.Error) as caught:
            generate(with_value(spec, path, float("nan")), tmp_path / "set", workers=1)
        sentence = str(caught.value)
        names = [f"{name_of(path)} is nan; it must be "]
        if isinstance(path[-1], int) or "parameters" in path[:-1]:  # a list of numbers or names is one field
            names.append(f"{name_of(path[:-1])} is ")
        if "planner" in path[:-1]:
            names.append(f"planner: option '{path[-1]}' ")
        assert sentence.startswith(tuple(names)), (names, sentence)
        assert "\n" not in sentence
    for path in [(), *places]:
        inner = spec
        for key in path:
            inner = inner[key]
        if isinstance(inner, dict) and path[-1:] not in (("fixed_joints",), ("parameters",)):
            with pytest.raises(srmp.Error, match=r"unknown|has no option"):
                generate(with_value(spec, path, {**inner, "colour": 1}), tmp_path / "set", workers=1)
    assert not (tmp_path / "set").exists()


def test_every_documented_field_is_in_the_whole_spec(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "datasets.md").read_text()
    rows = re.findall(r"^\| (`.*?) \|", text.split("| field | default | meaning |")[1].split("\n\n")[0], re.MULTILINE)
    documented = [name.split(".")[-1].removesuffix("[]") for row in rows for name in re.findall(r"`([\w.\[\]]+)`", row)]
    kinds = text.split("| kind | scene | parameters (default) |")[1].split("\n\n")[0]
    for row in kinds.splitlines()[2:]:
        documented += re.findall(r"`(\w+)`", row.split("|")[3])
    assert len(documented) > 40
    spec = whole_spec(tmp_path)
    fields = {path[-1] for path in places_in(spec)} | {"model"}  # instead of urdf; it is among the broken ones above
    assert not set(documented) - fields


OBJECTS = [
    ([3], "is not a scene file"),
    ([an_object(pose="x")], "could not convert string to float"),
    ([an_object(pose=[0, 0])], "pose quaternion must be 4 numbers"),
    ([an_object(pose=[0] * 7)], "pose quaternion is zero"),
    ([an_object(shape={"kind": "box", "size": [1]})], "size of box 'a' must be 3 numbers"),
    ([an_object(shape={"kind": "box", "size": [-1, 1, 1]})], "box size of object 'a' is -1"),
    ([an_object(shape={"kind": "box", "size": ["x", 1, 1]})], "could not convert string to float"),
    ([an_object(shape={"kind": [], "size": [1]})], "is not a scene file"),
    ([an_object(), an_object()], "object name 'a' is taken"),
]


@pytest.mark.parametrize(("objects", "sentence"), OBJECTS)
def test_a_broken_scene_of_variations(objects, sentence, tmp_path):
    shape = {"kind": "box", "size": [0.1, 0.1, 0.1]}
    items = [{"shape": shape, **item} if isinstance(item, dict) else item for item in objects]
    (tmp_path / "scene.json").write_text(json.dumps({"scene": {"objects": items}}))
    with pytest.raises(srmp.Error, match=r"scene\.json") as caught:
        read_spec(spec_of(scenes=[{"kind": "variations", "scene": str(tmp_path / "scene.json")}]))
    assert sentence in str(caught.value)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"world: 3", b"world: [", b"", b"world: \x00"])
def test_a_broken_moveit_scene_of_variations(content, tmp_path):
    """Named as the user knows it, and not as the copy that is read."""
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    with pytest.raises(srmp.FileError, match=re.escape(str(path))):
        read_spec(spec_of(scenes=[{"kind": "variations", "scene": str(path)}]))


@pytest.mark.parametrize(
    ("content", "sentence"), [("def f(:", "SyntaxError"), ("raise KeyError('x')", "(KeyError: 'x').")]
)
def test_a_module_that_cannot_be_imported(content, sentence, tmp_path, monkeypatch):
    (tmp_path / "torn_module.py").write_text(content)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(srmp.InvalidArgument, match="it must be in a module that can be imported") as caught:
        read_spec(spec_of(scenes=[{"kind": "function", "function": "torn_module:f"}]))
    assert sentence in str(caught.value)


@pytest.mark.parametrize(("key", "content"), [("urdf", "<a/>"), ("urdf", "<robot"), ("srdf", "<robot")])
def test_a_broken_robot_file_is_named_as_the_user_knows_it(key, content, tmp_path):
    path = tmp_path / f"broken.{key}"
    path.write_text(content)
    robot = {"name": "arm", "urdf": srmp.data_path("arm7.urdf"), "end_effector": "arm7_hand", key: str(path)}
    with pytest.raises(srmp.Error, match=re.escape(str(path))):
        read_spec({**spec_of(), "robots": [robot]})


def test_files_that_are_no_specs(tmp_path):
    (tmp_path / "torn.yaml").write_text("count: [1,")
    with pytest.raises(srmp.FileError, match="is not YAML"):
        read_spec(tmp_path / "torn.yaml")
    with pytest.raises(srmp.FileError, match="cannot be read"):
        read_spec(tmp_path / "none.yaml")
    (tmp_path / "list.yaml").write_text("- 1")
    with pytest.raises(srmp.InvalidArgument, match="the spec is"):
        read_spec(tmp_path / "list.yaml")
    with pytest.raises(srmp.InvalidArgument, match="workers 0"):
        generate(spec_of(), tmp_path / "set", workers=0)


# --- what records are


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


def test_scenes_refuse_what_is_wrong():
    scene = Scene()
    with pytest.raises(srmp.InvalidArgument, match="the size of box 'a' is"):
        scene.box("a", [1, 2], [0, 0, 0])
    with pytest.raises(srmp.InvalidArgument, match=r"'donw', did you mean 'down'\?"):
        scene.region("r", [0, 0, 0], [0, 0, 0], "donw")
    with pytest.raises(srmp.InvalidArgument, match="below 0"):
        scene.region("r", [0, 0, -1], [0, 0, 0])


# --- reading


def test_random_access_and_iteration(made):
    dataset = datasets.open(made.directory)
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
def test_an_index_of_wrong_types_is_refused(place, made, tmp_path):
    """By all that read it, in one sentence."""
    index = json.loads((made.directory / "index.json").read_text())
    inner = index
    *path, last = [int(key) if key.isdigit() else key for key in place.split(".")]
    for key in path:
        inner = inner[key]
    inner[last] = 3.5
    (tmp_path / "index.json").write_text(json.dumps(index))
    for read in (datasets.open, datasets.audit, lambda directory: generate(spec_of(), directory, workers=1)):
        with pytest.raises(srmp.FileError, match=r"index\.json is not as it is written: .*3\.5"):
            read(tmp_path)
