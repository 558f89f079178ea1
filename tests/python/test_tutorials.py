"""The tutorials: each notebook runs from its first cell to its last, and is kept without outputs; the site builds."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
NOTEBOOKS = sorted((REPOSITORY / "docs" / "tutorials").glob("*.ipynb"))


def cells_of(notebook, kind):
    cells = json.loads(notebook.read_text())["cells"]
    return [cell for cell in cells if cell["cell_type"] == kind]


def test_there_are_eight():
    assert [notebook.stem[0] for notebook in NOTEBOOKS] == list("12345678")


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs(notebook, tmp_path, monkeypatch):
    if "simulators" in notebook.stem:
        pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": "__main__"}
    for number, cell in enumerate(cells_of(notebook, "code"), 1):
        exec(compile("".join(cell["source"]), f"{notebook.name}, cell {number}", "exec"), namespace)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_has_a_picture_and_no_outputs(notebook):
    assert "![" in "".join("".join(cell["source"]) for cell in cells_of(notebook, "markdown"))
    assert not any(cell["outputs"] or cell["execution_count"] for cell in cells_of(notebook, "code"))


def test_the_site_builds_without_a_broken_link(tmp_path):
    if importlib.util.find_spec("material") is None:
        pytest.skip('needs pip install ".[docs]"')
    site = tmp_path / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(site)]
    result = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    for page in ("index", "changelog", "api-python", "tutorials/1_first_plan"):
        assert (site / f"{page}.html").is_file()
    shutil.rmtree(site)
