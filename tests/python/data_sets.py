"""Specs of small data sets, and the files of what was made."""

from pathlib import Path

ROBOT = {"name": "arm", "model": "arm7", "tool_length": 0.0}
SMALL = {"scale": 0.9, "objects": 2, "meshes": 0}


def spec_of(count=12, per_shard=2, scenes=None, **more):
    """Of motions of the package's own arm among few objects."""
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


def write_spec(path, spec):
    import yaml

    path.write_text(yaml.safe_dump(spec))
    return path
