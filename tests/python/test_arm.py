"""The batch checker builds for ARM and gives the same bits there."""

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    "tests/arm/batch_bits.cpp",
    "src/srmp/collision/batch/batch_checker.cpp",
    "src/srmp/collision/batch/kernel_portable.cpp",
    "src/srmp/core/error.cpp",
]


def eigen():
    directory = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/include/eigen3"
    if not directory.is_dir():
        pytest.skip("Eigen's headers (cmeel-eigen) are not installed")
    return directory


def build(compiler, program, extra=()):
    flags = ["-std=c++20", "-O2", "-ffp-contract=off", "-DSRMP_PORTABLE_ONLY", f"-I{ROOT / 'src'}", f"-I{eigen()}"]
    files = [str(ROOT / source) for source in SOURCES]
    subprocess.run([compiler, *flags, *extra, *files, "-o", str(program)], check=True)
    return program


def test_the_batch_checker_gives_the_same_bits_on_arm(tmp_path):
    compiler, emulator = shutil.which("aarch64-linux-gnu-g++"), shutil.which("qemu-aarch64-static")
    if not compiler or not emulator:
        pytest.skip(
            "needs aarch64-linux-gnu-g++ and qemu-aarch64-static (Debian: g++-aarch64-linux-gnu, qemu-user-static)"
        )
    host = subprocess.run([build("c++", tmp_path / "host")], check=True, capture_output=True).stdout
    arm = subprocess.run(
        [emulator, str(build(compiler, tmp_path / "arm", ["-static"]))], check=True, capture_output=True
    ).stdout
    assert host.count(b"\n") == 2000
    assert host == arm
