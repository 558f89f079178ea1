"""The schema of shards, which docs/datasets.md describes, and shards as bytes: the same records, the same bytes."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import io
import json
import math
from collections.abc import Sequence
from typing import Any

import srmp

SCHEMA_VERSION = 1
ROW_GROUP = 64
"""Records that are read together."""
STATISTICS = (
    *("expansions", "generated", "states", "samples", "edge_checks"),
    *("search_cost_rad", "path_cost_rad", "bound", "goal_index", "found_by", "bound_graph"),
)
"""Those of get_planning_stats that are the same in every run: no times, nothing that depends on caches."""
CERTIFICATE = (
    *("holds", "proved_free", "clearance", "clearance_time", "body_a", "body_b", "clearance_proved", "deviation"),
    "goal_error",
)
LIMIT_USES = ("position", "velocity", "acceleration")


def need_pyarrow() -> Any:
    """The module pyarrow. Raises Error where it is not installed."""
    try:
        import pyarrow
        import pyarrow.compute
        import pyarrow.parquet
    except ModuleNotFoundError as error:
        raise srmp.Error(
            'data sets need pyarrow: pip install ".[datasets]" in a checkout (or pip install pyarrow).'
        ) from error
    return pyarrow


@functools.cache
def schema() -> Any:
    """The Arrow schema of shards, without metadata."""
    pa = need_pyarrow()
    numbers = pa.list_(pa.float64())
    item = pa.struct(
        {
            "name": pa.string(),
            "type": pa.string(),
            "size": numbers,
            "pose": numbers,
            "vertices": numbers,
            "triangles": pa.list_(pa.int32()),
        }
    )
    texts = ("body_a", "body_b")
    flags = ("holds", "proved_free")
    certificate = pa.struct(
        {
            **{k: pa.string() if k in texts else pa.bool_() if k in flags else pa.float64() for k in CERTIFICATE},
            **{f"{key}_fraction": pa.float64() for key in LIMIT_USES},
        }
    )
    arrays = dict.fromkeys(("times", "positions", "velocities", "waypoints"), numbers)
    robot = pa.struct(
        {
            "name": pa.string(),
            "start": numbers,
            "goal_type": pa.string(),
            "goal": numbers,
            "goal_pose": numbers,
            **arrays,
            "certificate": certificate,
        }
    )
    reals, words = ("search_cost_rad", "path_cost_rad", "bound"), ("found_by", "bound_graph")
    statistics = pa.struct(
        {k: pa.float64() if k in reals else pa.string() if k in words else pa.int64() for k in STATISTICS}
    )
    return pa.schema(
        {
            "index": pa.int64(),
            "seed": pa.string(),
            "versions": pa.string(),
            "scene": pa.string(),
            "kind": pa.string(),
            "status": pa.string(),
            "reason": pa.string(),
            "attempts": pa.int32(),
            "objects": pa.list_(item),
            "robots": pa.list_(robot),
            "statistics": statistics,
        }
    )


@functools.cache
def versions() -> dict[str, str]:
    """The versions that decide the bytes of records, and of the files that hold them."""
    found = {"schema": str(SCHEMA_VERSION), "srmp": srmp.__version__, "math": math_version()}
    for name in ("numpy", "pyarrow", "libpinocchio", "libcoal"):
        found[name] = importlib.metadata.version(name)
    return found


def math_version() -> str:
    """What the C library makes of sines, powers and the like, as a hash.

    Their last bits are not the same everywhere: they depend on the C library and on whether the processor has fused
    multiply-add, and motions depend on them.
    """
    functions = (math.sin, math.cos, math.tan, math.asin, math.acos, math.atan, math.exp, math.log)
    digest = hashlib.sha256()
    for k in range(1, 4001):
        x = k / 4001
        values = [function(x) for function in functions] + [math.sin(9 * x), math.cos(9 * x)]
        digest.update(" ".join(value.hex() for value in [*values, math.atan2(x, 1 - x), x**2.4]).encode())
    return digest.hexdigest()[:8]


def versions_text() -> str:
    """`versions` as records hold them."""
    return json.dumps(versions(), sort_keys=True)


def certificate_row(certificate: srmp.Certificate | None) -> dict[str, Any] | None:
    """What records hold of a certificate: everything but its computing time and the limits, which are the robot's."""
    if certificate is None:
        return None
    row = {name: getattr(certificate, name) for name in CERTIFICATE}
    return row | {f"{name}_fraction": getattr(certificate, name).fraction for name in LIMIT_USES}


def to_bytes(records: Sequence[dict[str, Any]], identity: str, number: int) -> bytes:
    """A shard as a Parquet file."""
    pa = need_pyarrow()
    rows = [{**record, "versions": versions_text()} for record in records]
    about = {"srmp.schema_version": str(SCHEMA_VERSION), "srmp.spec": identity, "srmp.shard": str(number)}
    return table_to_bytes(pa.Table.from_pylist(rows, schema=schema().with_metadata(about)))


def table_to_bytes(table: Any) -> bytes:
    """A table as a Parquet file, by settings that never change within a schema version."""
    pa = need_pyarrow()
    smooth = [f"robots.list.element.{key}.list.element" for key in ("times", "positions", "velocities", "waypoints")]
    repeated = ["seed", "versions", "scene", "kind", "status", "robots.list.element.name", "objects.list.element.type"]
    out = io.BytesIO()
    pa.parquet.write_table(
        table,
        out,
        row_group_size=ROW_GROUP,
        version="2.6",
        data_page_version="1.0",
        compression="zstd",
        compression_level=3,
        use_dictionary=repeated,
        column_encoding=dict.fromkeys(smooth, "BYTE_STREAM_SPLIT"),
        write_statistics=["index"],
        store_schema=True,
    )
    return out.getvalue()
