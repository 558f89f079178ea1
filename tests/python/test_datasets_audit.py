"""The audit of data sets: every planted fault is found, and nothing else is."""

import hashlib
import json
import shutil

import numpy as np
import pytest

import srmp

for package in ("pyarrow", "yaml", "pinocchio", "coal"):
    pytest.importorskip(package, reason=f"audits need {package}: pip install '.[datasets]'")

from srmp import datasets  # noqa: E402
from srmp.datasets import audit_report  # noqa: E402
from srmp.datasets.schema import schema, table_to_bytes  # noqa: E402
from srmp.datasets.spec import identity_of  # noqa: E402
from srmp.datasets.store import hash_of, read_shards, shard_name  # noqa: E402

SPEC = {
    "count": 6,
    "records_per_shard": 2,
    "robots": [{"name": "arm", "model": "arm7"}],
    "scenes": [
        {"kind": "table", "scale": 0.9, "objects": 3, "meshes": 1},
        {"kind": "clutter", "scale": 0.9, "objects": 3, "meshes": 0, "goal": {"from": "region", "pose": True}},
    ],
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    directory = tmp_path_factory.mktemp("audit") / "set"
    made = datasets.generate(SPEC, directory, workers=1)
    assert made.solved == made.records  # every record may get any fault
    return directory


@pytest.fixture
def copy(sound, tmp_path):
    shutil.copytree(sound, tmp_path / "set")
    return tmp_path / "set"


def write_index(directory, index):
    (directory / "index.json").write_text(json.dumps(index))


def read_index(directory):
    return json.loads((directory / "index.json").read_text())


def replace_shard(directory, number, data):
    """A shard with other content, and the index as if it had always been so: its hashes give nothing away."""
    index = read_index(directory)
    entry = index["shards"][number]
    (directory / entry["name"]).unlink()
    entry["sha256"] = hashlib.sha256(data).hexdigest()
    entry["name"] = shard_name(number, entry["sha256"])
    (directory / entry["name"]).write_bytes(data)
    index["sha256"] = hash_of(read_shards(index))
    write_index(directory, index)


def change_records(directory, change, number=1):
    """Applies `change` to the list of records of a shard."""
    import pyarrow as pa

    table = shard_table(directory, number)
    records = table.to_pylist()
    change(records)
    replace_shard(directory, number, table_to_bytes(pa.Table.from_pylist(records, table.schema)))


def shard_table(directory, number):
    import pyarrow.parquet

    return pyarrow.parquet.read_table(directory / read_index(directory)["shards"][number]["name"])


def in_arm(**changes):
    """Changes of the only robot's row of a shard's first record, each a function of the old value."""

    def change(records):
        row = records[0]["robots"][0]
        for key, new in changes.items():
            row[key] = new(row[key])

    return lambda directory: change_records(directory, change)


def in_certificate(key, value):
    def change(records):
        records[0]["robots"][0]["certificate"][key] = value

    return lambda directory: change_records(directory, change)


def in_record(key, value, number=1):
    return lambda directory: change_records(directory, lambda records: records[0].__setitem__(key, value), number)


def flip_a_byte(directory):
    path = directory / read_index(directory)["shards"][1]["name"]
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))


def truncate(directory):
    path = directory / read_index(directory)["shards"][1]["name"]
    path.write_bytes(path.read_bytes()[:-100])


def remove_shard(directory):
    (directory / read_index(directory)["shards"][1]["name"]).unlink()


def forget_shard(directory):
    index = read_index(directory)
    (directory / index["shards"].pop(1)["name"]).unlink()
    index["records"] -= 2
    index["sha256"] = hash_of(read_shards(index))
    write_index(directory, index)


def add_shard(directory):
    (directory / shard_name(7, "0" * 64)).write_bytes(b"")


def swap_shards(directory):
    first, second = ((directory / read_index(directory)["shards"][number]["name"]).read_bytes() for number in (0, 1))
    replace_shard(directory, 0, second)
    replace_shard(directory, 1, first)


def count_wrong(directory):
    index = read_index(directory)
    write_index(directory, {**index, "records": 7})


def change_spec(directory):
    index = read_index(directory)
    index["spec"]["clearance"] = 0.5
    write_index(directory, index)


def change_limit(directory):
    """The robot's file says that a joint is slower; the spec is changed to match, so that only motions give it away."""
    path = directory / "robots" / "arm" / "robot.urdf"
    text = path.read_text()
    path.write_text(text.replace('velocity="2.2"', 'velocity="0.2"'))
    assert path.read_text() != text
    index = read_index(directory)
    index["spec"]["files"]["robots/arm/robot.urdf"] = hashlib.sha256(path.read_bytes()).hexdigest()
    index["identity"] = identity_of(index["spec"])
    write_index(directory, index)


def change_robot(directory):
    path = directory / "robots" / "arm" / "robot.urdf"
    path.write_text(path.read_text() + "<!-- -->")


def other_columns(directory):
    table = shard_table(directory, 1).drop_columns(["attempts"])
    import io

    import pyarrow.parquet

    out = io.BytesIO()
    pyarrow.parquet.write_table(table, out)
    replace_shard(directory, 1, out.getvalue())


def other_version(directory):
    table = shard_table(directory, 1)
    about = {**table.schema.metadata, b"srmp.schema_version": b"99"}
    replace_shard(directory, 1, table_to_bytes(table.replace_schema_metadata(about)))


def obstacle_in_the_way(directory):
    """Moves an obstacle to where the robot's hand passes in the middle of the motion."""
    dataset = datasets.open(directory)
    planner = dataset.robots()

    def change(records):
        row = records[0]["robots"][0]
        middle = np.reshape(row["positions"], (-1, 7))[len(row["times"]) // 2]
        box = next(item for item in records[0]["objects"] if item["name"] == "object_0")
        box["pose"] = list(planner.compute_fk("arm", middle))

    change_records(directory, change)


def shift(values, amount, rows=slice(None)):
    table = np.reshape(values, (-1, 7)).copy()
    table[rows] += amount
    return table.ravel().tolist()


def with_nan(values):
    return [float("nan"), *values[1:]]


FAULTS = {
    "flipped byte": (flip_a_byte, "its content is not what its hash says"),
    "truncated shard": (truncate, "its content is not what its hash says"),
    "missing shard": (remove_shard, "the shard is missing"),
    "forgotten shard": (forget_shard, "shard 1 of 3 is not in the index"),
    "extra shard": (add_shard, "the index does not list this file"),
    "swapped shards": (swap_shards, "record 2 is where record 0 belongs"),
    "wrong count": (count_wrong, "number of records is not that of its shards"),
    "changed spec": (change_spec, "the spec was changed"),
    "wrong limit": (change_limit, "is faster than its limit"),
    "changed robot": (change_robot, "its content is not what the index says"),
    "other columns": (other_columns, "its columns are not those of the schema"),
    "other schema version": (other_version, "its schema has version 99"),
    "shifted obstacle": (obstacle_in_the_way, "touch at"),
    "missed start": (in_arm(start=lambda q: [q[0] + 0.01, *q[1:]]), "misses its start"),
    "missed joint goal": (
        in_arm(goal_type=lambda _: "JOINTS", goal=lambda _: [0.123] * 7),
        "misses its goal by",
    ),
    "missed pose": (
        in_arm(goal_type=lambda _: "POSE", goal=lambda _: [0.3, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]),
        "rad.",
    ),
    "not a number": (in_arm(positions=with_nan), "not finite"),
    "time that stands": (in_arm(times=lambda t: [t[0], t[0], *t[2:]]), "do not increase"),
    "time that jumps": (in_arm(times=lambda t: [*t[:-2], t[-2] + 0.005, t[-1]]), "s apart from 0 on"),
    "faster clock": (in_arm(times=lambda t: [0.5 * x for x in t], velocities=lambda v: [2 * x for x in v]), "limit"),
    "position outside": (in_arm(positions=lambda q: shift(q, [0, 0, 0, 0, 0, 0, 9], 3)), "leaves its position limits"),
    "moves at its end": (in_arm(velocities=lambda v: shift(v, 0.1, -1)), "is not at rest"),
    "rows are missing": (in_arm(velocities=lambda v: v[:-7]), "do not fit together"),
    "no certificate": (in_arm(certificate=lambda _: None), "no whole trajectory with its certificate"),
    "certificate does not hold": (in_certificate("holds", False), "does not hold"),
    "certificate leaves parts": (in_certificate("proved_free", False), "does not hold, or leaves parts"),
    "too much proved": (in_certificate("clearance_proved", 9.0), "proves more clearance than it found"),
    "clearance overstated": (in_certificate("clearance", 0.5), "m apart where the certificate"),
    "bodies that are not there": (in_certificate("body_b", "ghost"), "bodies that are not there"),
    "solved with a reason": (in_record("reason", "because."), "solved and gives a reason"),
    "failed without a reason": (in_record("status", "exhausted"), "failed without a reason"),
    "unknown status": (in_record("status", "sovled"), "is none that there is"),
    "skipped by nobody": (in_record("status", "skipped"), "is not one that the spec skips"),
    "another scene": (in_record("scene", "kitchen"), "is none of the spec"),
    "another seed": (in_record("seed", "0" * 32), "its seed is not that of the spec"),
    "other versions": (in_record("versions", "{}"), "its versions are not those of the index"),
    "record twice": (in_record("index", 3), "record 3 is where record 2 belongs"),
    "robot is missing": (in_record("robots", []), "its robots are not arm"),
}


def test_a_sound_data_set_has_no_faults(sound):
    found = datasets.audit(sound, sample=None)
    assert found.passed, found.faults
    assert found.records == found.checked == 6
    assert all(len(values) == 6 for values in found.figures.values())
    assert datasets.audit(sound, sample=2).checked == 2
    quick = datasets.audit(sound, sample=0)
    assert quick.checked == 0
    assert quick.figures == found.figures


def test_limits_are_checked_without_a_sample(copy):
    change_limit(copy)
    assert any("is faster than its limit" in fault.text for fault in datasets.audit(copy, sample=0).faults)


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults_are_found(fault, copy):
    plant, sentence = FAULTS[fault]
    plant(copy)
    found = datasets.audit(copy, sample=None)
    assert any(sentence in str(one) for one in found.faults), [str(one) for one in found.faults]


def test_what_plants_faults_plants_none_itself(copy):
    change_records(copy, lambda records: None)
    assert datasets.audit(copy, sample=None).passed


def test_report(copy, tmp_path):
    flip_a_byte(copy)
    found = datasets.audit(copy)
    audit_report.write(found, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "its content is not what its hash says" in page
    assert "<td>table</td>" in page
    assert 'alt="Histograms of lengths, durations, clearances; success by scene" src="data:image/png;base64,' in page
    text = audit_report.summary(found)
    assert "success" in text
    assert text.endswith("fault") or text.endswith("faults")


def test_command_line(sound, copy, tmp_path):
    from click.testing import CliRunner

    from srmp.cli import main

    run = CliRunner().invoke
    passed = run(main, ["audit", str(sound), "--all", "--report", str(tmp_path / "report.html")])
    assert passed.exit_code == 0
    assert "6 records, collisions of 6 checked: no faults" in passed.output
    remove_shard(copy)
    failed = run(main, ["audit", str(copy)])
    assert failed.exit_code == 1
    assert "the shard is missing" in failed.output
    assert run(main, ["audit", str(tmp_path)]).exit_code == 2
    assert run(main, ["audit", str(sound), "--report", str(tmp_path / "no" / "x.html")]).exit_code == 2


def test_arguments(sound):
    with pytest.raises(srmp.InvalidArgument, match="sample -1"):
        datasets.audit(sound, sample=-1)


def test_schema_is_as_documented(sound):
    assert shard_table(sound, 0).schema.remove_metadata() == schema()
