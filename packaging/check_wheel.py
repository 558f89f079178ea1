"""Tries an installed package where it is installed: needs the package and its extra `demo`, and no compiler.

    python packaging/check_wheel.py

Plans, runs `srmp demo`, and, where there are cmake and a C++ compiler, builds and runs examples/cpp_consumer.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import srmp

REPOSITORY = Path(__file__).parents[1]


def plan() -> None:
    """The README's program, without a certificate of which nothing may be said."""
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7", name="arm")
    planner.add_box("post", size=[0.1, 0.1, 0.8], pose=srmp.Pose(p=[0.35, 0.2, 0.4]))
    start = planner.get_group_states("arm")["ready"]
    trajectory = planner.plan(start, srmp.Pose(p=[0.1, 0.45, 0.4], q=[0, 1, 0, 0]))
    assert trajectory.certificate.holds, trajectory.certificate
    print(f"plan: {len(trajectory)} samples, {trajectory.duration:.3f} s")


def demo(directory: str) -> None:
    program = shutil.which("srmp", path=str(Path(sys.executable).parent))
    assert program, "the program srmp is not installed"
    subprocess.run([program, "demo"], check=True, cwd=directory)
    assert {"demo.json", "demo.png"} <= {file.name for file in Path(directory).iterdir()}


def cpp_consumer(directory: str) -> None:
    cmake = shutil.which("cmake")
    if cmake is None or not any(map(shutil.which, ("c++", "g++", "clang++"))):
        print("C++: not tried, there is no cmake or no compiler")
        return
    source = REPOSITORY / "examples" / "cpp_consumer"
    build = Path(directory) / "cpp_consumer"
    configure = [cmake, "-S", source, "-B", build, f"-Dsrmp_DIR={srmp.get_cmake_dir()}"]
    subprocess.run(configure, check=True)
    subprocess.run([cmake, "--build", build], check=True)
    subprocess.run([build / "cpp_consumer"], check=True)


def main() -> None:
    print(f"srmp {srmp.__version__}, Python {sys.version.split()[0]}, {srmp.__file__}")
    plan()
    with tempfile.TemporaryDirectory() as directory:
        demo(directory)
        cpp_consumer(directory)


if __name__ == "__main__":
    main()
