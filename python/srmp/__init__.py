"""Search-based motion planning for robot arms: deterministic, with proven bounds, checked against exact geometry."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from srmp import _other_package  # noqa: F401  (first: it raises ImportError where another package has replaced files)

try:
    from srmp import _srmp
except ImportError:  # the libraries of other wheels are not beside this package: find them first, then try again
    from srmp._libraries import preload

    preload()
    from srmp import _srmp

from srmp._authors_words import explain_missing_names, missing_in_module
from srmp._errors import checked, shorten_error_texts
from srmp._names import did_you_mean
from srmp._srmp import *  # noqa: F403
from srmp._verify import verify as verify

if TYPE_CHECKING:
    from srmp import datasets as datasets
    from srmp import robots as robots
    from srmp._batch_planner import Batch as Batch
    from srmp._batch_planner import BatchPlanner as BatchPlanner
    from srmp.options import *  # noqa: F403

shorten_error_texts()
explain_missing_names()
del shorten_error_texts, explain_missing_names

_OPTIONS = tuple(_srmp.planner_info(planner_id).class_name for planner_id in _srmp.available_planners())
_BATCH = ("Batch", "BatchPlanner")
_MODULES = ("datasets", "robots")

__version__: str = _srmp.__version__


def get_cmake_dir() -> str:
    """The directory of srmpConfig.cmake: configure C++ projects with ``-Dsrmp_DIR=<this>``."""
    return str(Path(__file__).parent / "lib" / "cmake" / "srmp")


@checked
def data_path(name: str) -> str:
    """The path of a file that comes with this package, such as ``arm7.urdf``, or of their directory (``""``).

    Raises FileError when there is no such file.
    """
    directory = Path(__file__).parent / "data"
    known = [path.relative_to(directory).as_posix() for path in directory.rglob("*")]
    if name and name not in known:
        hint = did_you_mean(name, known) or "."
        raise FileError(f"'{name}' is not among the data files of srmp in {directory}{hint}")  # noqa: F405
    return str(directory / name)


def __getattr__(name: str) -> Any:
    """Loads on first use what is not always needed: import srmp stays quick."""
    if name in _OPTIONS:
        return getattr(importlib.import_module("srmp.options"), name)
    if name in _BATCH:
        return getattr(importlib.import_module("srmp._batch_planner"), name)
    if name in _MODULES:
        return importlib.import_module(f"srmp.{name}")
    missing_in_module(name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_OPTIONS, *_BATCH, *_MODULES])
