"""What messages, documents and programs say of installing works in a checkout: on PyPI, `srmp` is another package."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import srmp

REPOSITORY = Path(__file__).parents[2]
PACKAGE = Path(srmp.__file__).parent
PYPROJECT = (REPOSITORY / "pyproject.toml").read_text()
WORDS = ("to", "and", "builds", "in")  # of the sentence after a hint


def texts():
    """Every text of the repository that may hold a hint, by path; but not this one."""
    directories = ("bench", "cmake", "docs", "examples", "include", "python", "src", "tests", ".ci")
    files = [REPOSITORY / name for name in ("README.md", "CMakeLists.txt", "pyproject.toml")]
    for directory in directories:
        files += sorted((REPOSITORY / directory).rglob("*"))
    for path in files:
        if path.is_file() and path != Path(__file__) and path.suffix not in (".png", ".pyc", ".so", ".stl"):
            yield path.relative_to(REPOSITORY), path.read_text(errors="ignore")


def extras():
    section = PYPROJECT.split("[project.optional-dependencies]")[1].split("\n[")[0]
    return set(re.findall(r"^(\w+) = \[", section, re.MULTILINE))


def packages():
    """The names of all packages that this one depends on in any way."""
    return set(re.findall(r'^  "([A-Za-z0-9_.-]+)|\["([A-Za-z0-9_.-]+)', PYPROJECT, re.MULTILINE)) - {("", "")}


def test_no_hint_names_the_package_of_pypi():
    """Neither srmp, which is another one, nor srmp-cpp, which is not published yet."""
    for path, text in texts():
        if path.name == "pyproject.toml":
            text = text.replace('dev = ["srmp-cpp[', "")
        for found in re.finditer(r"\bsrmp(-cpp)?\[[a-z{]|pip install (--\S+ )*[\"'`]?srmp\b", text):
            raise AssertionError(f"{path}: {text[found.start() : found.end() + 30]}")


def test_every_extra_of_a_hint_exists():
    for path, text in texts():
        for names in re.findall(r"[\"'`]\.\[([a-z, ]+)\]", text):
            assert set(re.split(r", ?", names)) <= extras(), f"{path}: .[{names}]"


def test_every_package_of_a_hint_is_one_that_this_package_uses():
    known = {name for pair in packages() for name in pair} | {"pip", "torch"}
    for path, text in texts():
        for names in re.findall(r"pip install\s+((?:[a-z][a-z0-9_-]+ ?)+)", text):
            for name in names.split():
                if name in WORDS:
                    break
                assert name in known, f"{path}: pip install {names}"


@pytest.mark.parametrize("theirs", ["srmp-0.2.1.dist-info/METADATA", "srmp/planner_interface.py"])
def test_beside_the_package_of_pypi_the_import_says_what_is_wrong(tmp_path, theirs):
    shutil.copytree(PACKAGE, tmp_path / "srmp")
    (tmp_path / theirs).parent.mkdir(exist_ok=True)
    (tmp_path / theirs).write_text("")
    code = "try:\n    import srmp\nexcept ImportError as error:\n    print(error)"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, env=environment)
    (line,) = printed.stdout.splitlines()
    assert "two packages, this one (srmp-cpp) and another of the same import name (srmp" in line
    assert "pip uninstall" in line and "pip install ." in line
    assert len(line) < 500
