"""Data sets: the same bytes however they are made, and whatever is killed meanwhile."""

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
from data_sets import files_of, spec_of, write_spec

import srmp

pytest.importorskip("pyarrow", reason="data sets need pyarrow: pip install '.[datasets]'")
pytest.importorskip("yaml", reason="specs need PyYAML: pip install '.[datasets]'")

from srmp import datasets
from srmp.datasets.generation import generate
from srmp.datasets.recorder import Recorder, random_numbers
from srmp.datasets.spec import Spec, read_spec

# --- the same bytes


def test_same_bytes_in_reversed_order(small_data_set, tmp_path):
    other = generate(spec_of(), tmp_path / "set", workers=1, order=lambda numbers: numbers[::-1])
    assert other.sha256 == small_data_set.sha256
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


@pytest.mark.parametrize("workers", [2, 4])
def test_same_bytes_by_processes(small_data_set, tmp_path, workers):
    generate(spec_of(), tmp_path / "set", workers=workers)
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


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


def test_a_record_does_not_depend_on_those_before(small_data_set):
    dataset = datasets.open(small_data_set.directory)
    recorder = Recorder(dataset.spec, small_data_set.directory)
    for index in (7, 2, 7):
        assert recorder.record(index)["robots"][0]["positions"].tolist() == list(
            dataset[index].values["robots"][0]["positions"]
        )


def test_growth_keeps_whole_shards(small_data_set, tmp_path):
    generate(spec_of(count=5), tmp_path / "set", workers=1)
    assert generate(spec_of(count=12), tmp_path / "set", workers=1).made == 8  # one shard was not full
    assert files_of(tmp_path / "set") == files_of(small_data_set.directory)


def test_another_place_and_another_seed(small_data_set, tmp_path):
    assert read_spec(spec_of(seed=1)).identity != read_spec(spec_of()).identity
    assert read_spec(spec_of(count=99, per_shard=7)).identity == read_spec(spec_of()).identity
    spec = datasets.open(small_data_set.directory).spec
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


def test_a_worker_does_not_grow_with_its_records(small_data_set):
    """After the same record, so that the scene that is there is the same too."""
    recorder = Recorder(read_spec(spec_of(count=1000, per_shard=60, scenes=ALL_KINDS)), small_data_set.directory)
    after = []
    for number in range(1, 5):
        recorder.shard(number)
        recorder.record(0)
        after.append(allocated_bytes())
    # Of 120 records and more, beside other threads; a scene has some 100 000.
    assert after[-1] - min(after[:2]) < 60_000


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


def test_a_worker_that_is_killed_before_it_begins(small_data_set, tmp_path, monkeypatch):
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
    assert generate(large, tmp_path / "set", workers=2).solved == small_data_set.solved
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
