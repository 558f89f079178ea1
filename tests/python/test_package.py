"""The installed package: what lies in it, how it loads, and whether C++ projects can use it."""

import importlib.metadata
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


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True, **options).stdout


def test_version_is_the_same_everywhere():
    declared = re.search(r'^version = "(.+)"', (REPOSITORY / "pyproject.toml").read_text(), re.MULTILINE)[1]
    assert srmp.__version__ == importlib.metadata.version("srmp-cpp") == declared
    assert f"## {declared}" in (REPOSITORY / "CHANGELOG.md").read_text()


def test_build_requirements_are_listed_twice_alike():
    """[build-system] cannot refer to a dependency group, so the group repeats it."""
    text = re.sub(r"#.*", "", (REPOSITORY / "pyproject.toml").read_text())
    isolated = re.findall(r'"(.+?)"', re.search(r"requires = \[(.+?)\n\]", text, re.DOTALL)[1])
    group = re.findall(r'"(.+?)"', re.search(r"\nbuild = \[(.+?)\n\]", text, re.DOTALL)[1])
    assert set(isolated) <= set(group)


def test_wheels_are_built_for_the_declared_pythons():
    """The classifiers, requires-python, cibuildwheel's list and build_wheels.py name the same versions."""
    text = (REPOSITORY / "pyproject.toml").read_text()
    declared = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    assert re.search(r'^requires-python = ">=(.+)"$', text, re.MULTILINE)[1] == declared[0]
    for_servers = re.search(r"^\[tool\.cibuildwheel\]\n(.+?)\n\n", text, re.MULTILINE | re.DOTALL)[1]
    assert re.findall(r'"cp3(\d+)-\*"', for_servers) == [version.removeprefix("3.") for version in declared]
    here = (REPOSITORY / "packaging" / "build_wheels.py").read_text()
    assert re.findall(r'"python(3\.\d+)"', re.search(r"^PYTHONS = .+$", here, re.MULTILINE)[0]) == declared
    for script in re.findall(r"\{project\}/([\w/.]+)", for_servers):
        assert (REPOSITORY / script).is_file()


def test_the_workflow_of_the_wheels_runs_cibuildwheel():
    yaml = pytest.importorskip("yaml")
    workflow = yaml.safe_load((REPOSITORY / ".github" / "workflows" / "wheels.yml").read_text())
    (job,) = workflow["jobs"].values()
    assert {runner.split("-")[0] for runner in job["strategy"]["matrix"]["runner"]} == {"ubuntu", "macos"}
    assert any("cibuildwheel --output-dir" in step.get("run", "") for step in job["steps"])


@pytest.mark.parametrize(
    "file",
    ["lib/libsrmp.so", "include/srmp/core/pose.hpp", "lib/cmake/srmp/srmpConfig.cmake", "_srmp.pyi", "py.typed"],
)
def test_wheel_holds(file):
    assert (PACKAGE / file).is_file()


def test_stubs_know_the_public_names():
    stubs = (PACKAGE / "_srmp.pyi").read_text()
    for name in ("Pose", "PlannerInterface", "Trajectory", "GoalConstraint", "Status"):
        assert f"class {name}" in stubs


def test_no_path_of_the_build_is_left():
    readelf = shutil.which("readelf")
    if readelf is None:
        pytest.skip("no readelf on this machine")
    for library in [PACKAGE / "lib" / "libsrmp.so", *PACKAGE.glob("_srmp*.so")]:
        (path,) = re.findall(r"(?:RPATH|RUNPATH).*\[(.*)\]", run(readelf, "-d", library))
        assert all(entry.startswith("$ORIGIN/") for entry in path.split(":"))
        assert b"cmeel.prefix/include" not in library.read_bytes()


IMPORT_ORDERS = [
    "import srmp, pinocchio, coal",
    "import pinocchio, coal, srmp",
    "import coal, srmp, pinocchio",
]


@pytest.mark.parametrize("imports", IMPORT_ORDERS)
def test_lives_with_pinocchio_and_coal_in_one_process(imports):
    pytest.importorskip("pinocchio")
    urdf = srmp.data_path("arm7.urdf")
    code = f"""
{imports}
import numpy as np
planner = srmp.PlannerInterface()
planner.add_articulation(urdf_path={urdf!r}, name="arm", end_effector="arm7_hand")
model = pinocchio.buildModelFromUrdf({urdf!r})
data = model.createData()
q = np.linspace(-0.5, 0.5, model.nq)
pinocchio.framesForwardKinematics(model, data, q)
theirs = data.oMf[model.getFrameId(planner.get_end_effector("arm"))].translation
assert np.allclose(theirs, planner.compute_fk("arm", q).p, atol=1e-12)
assert coal.Sphere(0.1).radius == 0.1
"""
    run(sys.executable, "-c", code)


def test_import_is_quick():
    """Under 0.3 s in a process of its own, without the interpreter's start; the best of five: machines are shared."""
    code = "import time; t = time.perf_counter(); import srmp; print(time.perf_counter() - t)"
    assert min(float(run(sys.executable, "-c", code)) for _ in range(5)) < 0.3


def test_import_loads_only_what_it_needs():
    code = "import srmp, sys; print(*sys.modules)"
    loaded = set(run(sys.executable, "-c", code).split())
    assert not loaded & {"numpy", "click", "tqdm", "matplotlib", "srmp.cli", "srmp.plot"}


def test_finds_libraries_that_were_installed_elsewhere(tmp_path):
    """As with --system-site-packages: no cmeel.prefix beside the package, but one elsewhere on sys.path."""
    shutil.copytree(PACKAGE, tmp_path / "srmp")
    code = "import srmp; print(srmp.__file__, srmp.Pose().p)"
    printed = run(sys.executable, "-c", code, env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert printed.startswith(str(tmp_path))


def test_cpp_project_builds_against_the_package(tmp_path):
    """examples/cpp_consumer finds srmp and Eigen with nothing but the directory that `srmp cmake-dir` prints."""
    cmake = shutil.which("cmake")
    if cmake is None:
        pytest.skip("no cmake on this machine")
    printed = run(sys.executable, "-m", "srmp", "cmake-dir").strip()
    assert printed == srmp.get_cmake_dir()
    source = REPOSITORY / "examples" / "cpp_consumer"
    # An Eigen of the system, or any other path of this machine, is not what is tested.
    configure = [cmake, "-S", source, f"-Dsrmp_DIR={printed}", "-DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF"]
    outcomes = []
    # Eigen lays out its objects by instruction set, unless the target says otherwise.
    for flags in ("-O1 -Wall -Wextra -Werror", "-O1 -march=native"):
        build = tmp_path / f"build{len(outcomes)}"
        run(*configure, "-B", build, f"-DCMAKE_CXX_FLAGS={flags}")
        assert "pinocchio" not in (build / "CMakeCache.txt").read_text().lower()
        run(cmake, "--build", build)
        outcomes.append(run(build / "cpp_consumer"))
    assert f"srmp {srmp.__version__}" in outcomes[0]
    assert "solved: " in outcomes[0]
    assert outcomes[0] == outcomes[1]
