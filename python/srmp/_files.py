"""Files written completely or not at all, and JSON results."""

import contextlib
import json
import math
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from srmp import _srmp


def plain(value: Any) -> Any:
    """`value` with NumPy converted to Python, and NaN and infinity to None: JSON has neither."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return value


def write_json(path: str | Path, value: Any) -> None:
    """Writes `value` as JSON. Lists of numbers stay on one line; numbers read back bit for bit. Raises FileError."""
    write_text(path, _encode(plain(value)) + "\n")


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Writes a temporary file beside `path` and renames it, as the library does. Raises FileError."""
    _srmp._write_file(path, text)


def write_bytes(path: Path, data: bytes) -> None:
    """Writes a whole file and brings it to the disk, its name too. Raises OSError."""
    with whole(path) as part, part.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    with contextlib.suppress(OSError):  # some file systems cannot do this for directories
        directory = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """`path` with ".part", where the block makes a file or a directory: it is renamed to `path` when the block ends.

    What a killed run left there is removed at first, and what the block has made when it raises.
    """
    part = path.with_name(path.name + ".part")
    _remove(part)
    try:
        yield part
        part.rename(path)
    except BaseException:
        _remove(part)
        raise


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def _encode(value: Any, indent: str = "") -> str:
    deeper = indent + "  "
    if isinstance(value, dict) and value:
        items = (f"{deeper}{json.dumps(key)}: {_encode(item, deeper)}" for key, item in value.items())
        return "{\n" + ",\n".join(items) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
        return "[\n" + ",\n".join(deeper + _encode(item, deeper) for item in value) + f"\n{indent}]"
    return json.dumps(value, allow_nan=False, ensure_ascii=False)
