"""The examples run, and the C++ ones print the same as their Python twins, to the last digit of every number."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import srmp

REPOSITORY = Path(__file__).parents[2]
EXAMPLES = sorted((REPOSITORY / "examples").glob("[0-9][0-9]_*.py"))
PAGES = {page.stem: page for page in [REPOSITORY / "README.md", *(REPOSITORY / "docs").glob("*.md")]}
PROGRAMS = {
    name: program
    for name, page in PAGES.items()
    for program in re.findall(r"^```cpp\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    if "int main(" in program
}


def run(*command):
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """All C++ examples, and the programs of the documents, built against the installed package."""
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("no cmake on this machine")
    directory = tmp_path_factory.mktemp("examples")
    lines = [
        "cmake_minimum_required(VERSION 3.26)",
        "project(documents LANGUAGES CXX)",
        "find_package(srmp CONFIG REQUIRED)",
        f'add_subdirectory("{REPOSITORY / "examples"}" examples)',
    ]
    for name, program in PROGRAMS.items():
        (directory / f"{name}.cpp").write_text(program)
        lines.append(f"add_executable({name} {name}.cpp)")
        lines.append(f"target_link_libraries({name} PRIVATE srmp::srmp)")
        if '#include "srmp/search/' in program:  # whoever adds a search works in the repository
            lines.append(f'target_include_directories({name} PRIVATE "{REPOSITORY / "src"}")')
        lines.append(f'target_compile_definitions({name} PRIVATE SRMP_DATA_DIR="${{srmp_DATA_DIR}}")')
    (directory / "CMakeLists.txt").write_text("\n".join(lines) + "\n")
    # Without optimisation: quick to build, and what is computed is computed in the library.
    run(
        cmake, "-S", directory, "-B", directory / "build", f"-Dsrmp_DIR={srmp.get_cmake_dir()}", "-DCMAKE_CXX_FLAGS=-O0"
    )
    run(cmake, "--build", directory / "build", "--parallel", "2")
    return directory / "build"


def test_every_example_has_a_twin():
    assert EXAMPLES
    twins = sorted((REPOSITORY / "examples").glob("[0-9][0-9]_*.cpp"))
    assert [path.stem for path in EXAMPLES] == [path.stem for path in twins]


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_cpp_and_python_print_the_same(example, built):
    in_python = run(sys.executable, example)
    assert in_python.count("\n") > 2
    assert run(built / "examples" / example.stem) == in_python


def test_pictures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib", reason="pictures need matplotlib: pip install '.[demo]'")
    run(sys.executable, REPOSITORY / "examples" / "figures.py", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"two-arms-swap.png", "four-arms-over-bins.png"}


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_programs_of_the_documents_run(name, built):
    assert run(built / name).strip()
    assert len(re.findall(r"^```cpp$", PAGES[name].read_text(), re.MULTILINE)) == 1, "only the first block is built"
