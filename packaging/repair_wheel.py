"""Gives a wheel the name of the platforms on which it runs, and leaves the libraries of other wheels out of it.

    python packaging/repair_wheel.py WHEEL DIRECTORY

Writes the repaired wheel to DIRECTORY, by auditwheel on Linux and by delocate on macOS.
"""

import subprocess
import sys

# Of packages that this one depends on; libsrmp finds them beside itself (cmake/SrmpInstall.cmake).
OTHER_WHEELS = (
    "libcoal",
    "libpinocchio",
    "libassimp",
    "libqhull",
    "liboctom",
    "libtinyxml2",
    "libtoppra",
    "libyaml-cpp",
)


def main() -> None:
    wheel, directory = sys.argv[1:]
    if sys.platform == "darwin":
        words = [word for name in OTHER_WHEELS for word in ("--exclude", name)]
        command = ["delocate-wheel", "-v", *words, "-w", directory, wheel]
    else:
        words = [word for name in OTHER_WHEELS for word in ("--exclude", f"{name}*")]
        command = ["auditwheel", "repair", *words, "-w", directory, wheel]
    subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
