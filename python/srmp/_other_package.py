"""On PyPI, `srmp` is another package. It has the same import name, and its files replace those of this one.

The import of this module raises ImportError when both are installed in the same directory.
"""

from pathlib import Path

_PACKAGE = Path(__file__).parent
_THEIRS = "planner_interface.py"  # a module of the other package that this one does not have


def _require_alone() -> None:
    metadata = next(_PACKAGE.parent.glob("srmp-[0-9]*.dist-info"), None)
    if metadata is None and not (_PACKAGE / _THEIRS).exists():
        return
    theirs = metadata.name.removesuffix(".dist-info").replace("-", " ") if metadata else "srmp"
    raise ImportError(
        f"{_PACKAGE} holds files of two packages, this one (srmp-cpp) and another of the same import name ({theirs} of "
        "PyPI): run `pip uninstall --yes srmp srmp-cpp`, then `pip install .` in the checkout of this one",
        name="srmp",
    )


_require_alone()
