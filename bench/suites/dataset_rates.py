"""Makes a data set of Panda motions in six kinds of scenes and measures rate, size, success, memory, and its audit.

    python bench/suites/dataset_rates.py --data DIR [--records 100000] [--workers 2] [--directory DIR]
        [--out dataset_rates.json]

DIR holds MotionBenchMaker as for `srmp bench mbm`: the Panda with its exact meshes, and the problem whose scene is
varied. Rates are by the CPU time of driver and workers, so that a machine that others use too gives the same figures;
memory is what /proc says of each process after every 1000 records, so that this needs Linux. The result file is written
again after every 5000 records: a run that is ended has figures too, and the same command goes on with the records that
are missing, and measures those. Without --directory the data set is made in a temporary one. Needs ".[datasets]".
"""

from __future__ import annotations

import argparse
import collections
import multiprocessing
import os
import resource
import statistics
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import srmp
from srmp import datasets
from srmp._files import write_json
from srmp._table import format_table
from srmp.bench import mbm

KINDS = ("table", "shelf", "bin", "cage", "clutter")
SAMPLED, WRITTEN = 1000, 5000  # records between two samples of memory, and between two writes of the result file


def read_spec(data: Path, records: int, per_shard: int) -> datasets.Spec:
    """The Panda in the library's kinds of scenes, and in variations of a problem of MotionBenchMaker."""
    files = mbm.robot_files(data, "panda", "urdf")
    robot = {"name": "panda", "urdf": str(files.urdf), "srdf": str(files.srdf), "group": mbm.GROUPS["panda"]}
    robot |= {"end_effector": mbm.END_EFFECTORS["panda"], "tool_length": 0.1034}
    with mbm.open_problems(files.directory, "panda", ["table_pick"], {1}) as (problem,):
        varied = {"kind": "variations", "scene": str(problem.scene), "request": str(problem.request)}
        scenes = [{"kind": kind} for kind in KINDS] + [varied]
        return datasets.read_spec(
            {"count": records, "records_per_shard": per_shard, "robots": [robot], "scenes": scenes}
        )


class Meter:
    """Samples CPU time and memory while records are made."""

    def __init__(self, out: Path, about: Mapping[str, Any]) -> None:
        self._out, self._about = out, about
        self._began, self._cpu = time.monotonic(), cpu_seconds()
        self._first = 0
        self.samples: list[dict[str, Any]] = []

    def progress(self, done: int, total: int) -> None:
        """For datasets.generate."""
        if not self.samples:
            self._first = done
        last = self.samples[-1]["records"] if self.samples else -SAMPLED
        if done - last >= SAMPLED or done == total:
            self.samples.append(self._sample(done))
            if done // WRITTEN != last // WRITTEN:
                write_json(self._out, self.result())

    def _sample(self, done: int) -> dict[str, Any]:
        workers = {process.pid: memory_bytes(process.pid) for process in multiprocessing.active_children()}
        return {
            "records": done,
            "seconds": time.monotonic() - self._began,
            "cpu_seconds": cpu_seconds() - self._cpu + sum(map(cpu_seconds, workers)),
            "driver_bytes": memory_bytes(os.getpid()),
            "worker_bytes": sorted(workers.values()),
        }

    def result(self) -> dict[str, Any]:
        """What was measured so far; CPU time counts with all that workers need to begin."""
        last = self.samples[-1]
        made = last["records"] - self._first
        return {
            **self._about,
            "records": made,
            "seconds": last["seconds"],
            "cpu_seconds": last["cpu_seconds"],
            "records_per_core_second": made / last["cpu_seconds"] if made else None,
            "driver_bytes": growth([sample["driver_bytes"] for sample in self.samples]),
            "worker_bytes": growth([max(sample["worker_bytes"], default=0) for sample in self.samples]),
            "samples": self.samples,
        }


def cpu_seconds(pid: int | None = None) -> float:
    """CPU time of a process; without one, of this process and of the children that it has waited for."""
    if pid is None:
        usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(usage.ru_utime + usage.ru_stime for usage in usages)
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_bytes(pid: int | None) -> int:
    """The resident memory of a process."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def growth(values: list[int]) -> dict[str, float]:
    """Medians of the second and of the last tenth of a run, and the largest value; the first tenth warms up."""
    tenth = max(1, len(values) // 10)
    return {
        "second_tenth": statistics.median(values[tenth : 2 * tenth] or values),
        "last_tenth": statistics.median(values[-tenth:]),
        "largest": max(values),
    }


def content(directory: Path) -> dict[str, Any]:
    """Size of the shards, success by kind, lengths of motions; of all records that are there."""
    dataset = datasets.open(directory)
    table = dataset.table(["kind", "status"]).to_pydict()
    counts: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    for kind, status in zip(table["kind"], table["status"], strict=True):
        counts[kind][status] += 1
    size = sum((directory / shard.name).stat().st_size for shard in dataset.shards)
    solved = sum(count["solved"] for count in counts.values())
    return {
        "sha256": dataset.sha256,
        "records_there": len(dataset),
        "solved": solved,
        "bytes": size,
        "bytes_per_motion": size / max(1, solved),
        "kinds": {kind: dict(count) for kind, count in sorted(counts.items())},
        "failures": dataset.failures().to_pylist(),
    }


def audited(directory: Path, sample: int) -> dict[str, Any]:
    """Times of the audit, once of the records alone, once with collisions of a sample."""
    times = {}
    for key, motions in (("records", 0), ("records_and_collisions", sample)):
        began = time.process_time()
        found = datasets.audit(directory, sample=motions)
        times[f"cpu_seconds_{key}"] = time.process_time() - began
    return {**times, "sample": sample, "faults": [str(fault) for fault in found.faults]}


def show(result: Mapping[str, Any]) -> None:
    """Prints what the documentation says."""
    print(f"{result['records']} records: {result['records_per_core_second']:.1f} a core-second")
    print(f"{result['content']['bytes_per_motion'] / 1000:.2f} kB a motion, SHA-256 {result['content']['sha256']}")
    for who in ("driver", "worker"):
        memory = result[f"{who}_bytes"]
        print(who, ", ".join(f"{key} {value / 1e6:.0f} MB" for key, value in memory.items()))
    rows = [
        [kind, str(sum(count.values())), f"{100 * count.get('solved', 0) / sum(count.values()):.2f} %"]
        for kind, count in result["content"]["kinds"].items()
    ]
    print(format_table(["kind", "records", "solved"], rows))
    print("audit:", result["audit"])


def main() -> None:
    """Runs the suite."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("SRMP_MBM_DIR"))
    parser.add_argument("--records", type=int, default=100_000)
    parser.add_argument("--per-shard", type=int, default=500)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--directory", type=Path)
    parser.add_argument("--audit", type=int, default=1000, help="motions whose collisions the audit checks")
    parser.add_argument("--out", type=Path, default=Path("dataset_rates.json"))
    arguments = parser.parse_args()
    if arguments.data is None:
        parser.error("--data DIR is needed, or SRMP_MBM_DIR.")
    spec = read_spec(arguments.data, arguments.records, arguments.per_shard)
    meter = Meter(arguments.out, {"cpu": mbm.cpu_name(), "versions": mbm.versions(), "workers": arguments.workers})
    with tempfile.TemporaryDirectory(prefix="srmp-") as temporary:
        directory = arguments.directory or Path(temporary) / "motions"
        try:
            datasets.generate(spec, directory, workers=arguments.workers, progress=meter.progress)
        except srmp.Error as error:  # records that reached the time limit: all other shards are there
            if not meter.samples or not meter.samples[-1]["records"]:
                raise
            print(f"not complete: {error}")
        result = {**meter.result(), "content": content(directory)}
        write_json(arguments.out, result)
        result["audit"] = audited(directory, arguments.audit)
    write_json(arguments.out, result)
    show(result)


if __name__ == "__main__":
    main()
