"""Loads the shared libraries of other wheels when this package was installed into another directory than they were.

Normally the run path inside libsrmp.so finds them in ../../cmeel.prefix. That fails for example in a virtual
environment with --system-site-packages whose Pinocchio is the system's. The loader also accepts libraries that are
already in the process.
"""

import ctypes
import sys
from pathlib import Path

# Those that libsrmp.so names itself, lowest first; each finds its own needs beside it.
_LIBRARIES = (
    "libcoal.so",
    "libpinocchio_default.so",
    "libpinocchio_collision.so",
    "libpinocchio_parsers.so",
    "libtinyxml2.so.11",
    "libtoppra.so",
    "libyaml-cpp.so.0.8",
)


def preload() -> None:
    """Loads each library from the first cmeel.prefix on sys.path that has it; missing ones are left to the loader."""
    directories = [directory for entry in sys.path if (directory := Path(entry) / "cmeel.prefix" / "lib").is_dir()]
    for name in _LIBRARIES:
        for directory in directories:
            if (directory / name).exists():
                ctypes.CDLL(str(directory / name))
                break
