"""What is computed for several configurations at once builds for ARM and gives the same bits there."""

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    "tests/arm/same_bits.cpp",
    *(
        f"src/srmp/collision/batch/{name}.cpp"
        for name in ("batch_checker", "batch_model", "batch_robot", "kernel_portable")
    ),
    *(f"src/srmp/robot/damped_least_squares{name}.cpp" for name in ("", "_portable")),
    *(f"src/srmp/search/{name}.cpp" for name in ("configuration_tree", "nearest", "nearest_portable")),
    *(f"src/srmp/core/{name}.cpp" for name in ("error", "simd_backend", "utf8")),
]
ROWS = 2000


def eigen():
    directory = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/include/eigen3"
    if not directory.is_dir():
        pytest.skip("Eigen's headers (cmeel-eigen) are not installed")
    return directory


def build(compiler, program, extra=()):
    includes = [f"-I{directory}" for directory in (ROOT / "src", ROOT / "include", eigen())]
    flags = ["-std=c++20", "-O2", "-ffp-contract=off", "-DSRMP_PORTABLE_ONLY", *includes]
    files = [str(ROOT / source) for source in SOURCES]
    subprocess.run([compiler, *flags, *extra, *files, "-o", str(program)], check=True)
    return program


@pytest.fixture(scope="module")
def of_this_machine(tmp_path_factory):
    if not shutil.which("c++"):
        pytest.skip("needs a C++ compiler named c++")
    return subprocess.run(
        [build("c++", tmp_path_factory.mktemp("host") / "bits")], check=True, capture_output=True
    ).stdout


def test_the_portable_sources_need_no_library_but_eigen(of_this_machine):
    assert of_this_machine.count(b"\n") == ROWS


def test_arm_gives_the_same_bits(of_this_machine, tmp_path):
    compiler, emulator = shutil.which("aarch64-linux-gnu-g++"), shutil.which("qemu-aarch64-static")
    if not compiler or not emulator:
        pytest.skip(
            "needs aarch64-linux-gnu-g++ and qemu-aarch64-static (Debian: g++-aarch64-linux-gnu, qemu-user-static)"
        )
    program = build(compiler, tmp_path / "bits", ["-static"])
    assert subprocess.run([emulator, str(program)], check=True, capture_output=True).stdout == of_this_machine
