"""Data sets on a Ray cluster of two nodes on this machine: the same bytes, also when workers are killed."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

ray = pytest.importorskip("ray", reason="a cluster needs Ray: pip install '.[ray]'")
for package in ("pyarrow", "yaml"):
    pytest.importorskip(package, reason=f"data sets need {package}: pip install '.[datasets]'")

from srmp import datasets  # noqa: E402

SPEC = {
    "count": 24,
    "records_per_shard": 2,
    "robots": [{"name": "arm", "model": "arm7"}],
    "scenes": [{"kind": "table", "scale": 0.9, "objects": 2, "meshes": 0}, {"kind": "cage", "scale": 0.9}],
}


@pytest.fixture(scope="module")
def cluster():
    from ray.cluster_utils import Cluster

    # Workers import what this process does.
    os.environ["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 80_000_000})
    cluster.add_node(num_cpus=1, object_store_memory=80_000_000)
    yield cluster.address
    cluster.shutdown()


def test_same_bytes_on_a_cluster(cluster, tmp_path):
    here = datasets.generate(SPEC, tmp_path / "here", workers=1)
    there = datasets.generate(SPEC, tmp_path / "there", ray=cluster)
    assert there.made == 24
    assert there.sha256 == here.sha256


def test_same_bytes_when_a_worker_is_killed(cluster, tmp_path):
    spec = {**SPEC, "count": 200}
    killed = []

    def kill_one():
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and len(killed) < 2:
            time.sleep(0.2)
            for pid in [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]:
                if pid not in killed and _is_worker(pid):
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)
                    time.sleep(1.0)
                    break

    thread = threading.Thread(target=kill_one)

    def begin(done, total):
        if done and not thread.ident:
            thread.start()

    there = datasets.generate(spec, tmp_path / "there", ray=cluster, progress=begin)
    thread.join()
    assert killed
    assert there.sha256 == datasets.generate(spec, tmp_path / "here", workers=1).sha256


def _is_worker(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().startswith(b"ray::_RayWorker")
    except OSError:
        return False
