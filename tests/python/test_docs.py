"""The documents: every block of code runs, every link leads somewhere, every option is listed as it is."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import srmp

REPOSITORY = Path(__file__).parents[2]
PAGES = [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").glob("*.md"))]
IDS = [page.name for page in PAGES]


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def write_files(page, directory):
    """YAML blocks whose first line is `# file: NAME`, and the examples that pages refer to."""
    for text in blocks(page, "yaml"):
        if name := re.match(r"# file: (\S+)\n", text):
            (directory / name[1]).write_text(text)
    shutil.copytree(REPOSITORY / "examples", directory / "examples")


def simulators_of(code):
    """Packages that `pip install ".[test]"` does not bring everywhere."""
    return re.findall(r"^import (mujoco|sapien|pybullet|genesis)\b", code, re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_python_blocks_run(page, tmp_path, monkeypatch):
    """One namespace a page."""
    write_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": "__main__"}
    for number, code in enumerate(blocks(page, "python"), 1):
        if any(importlib.util.find_spec(name) is None for name in simulators_of(code)):
            continue
        exec(compile(code, f"{page.name}, block {number}", "exec"), namespace)


@pytest.mark.parametrize("page", PAGES[1:], ids=IDS[1:])
def test_shell_blocks_run(page, tmp_path):
    """Not the README's: those build everything."""
    if not (codes := blocks(page, "sh")):
        return
    write_files(page, tmp_path)
    path = os.pathsep.join([sysconfig.get_path("scripts"), str(Path(sys.executable).parent), os.environ["PATH"]])
    for code in codes:
        result = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", code],
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
        )
        assert result.returncode == 0, code + result.stdout + result.stderr


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_links_lead_somewhere(page):
    prose = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)]+)\)", prose):
        if "://" not in target:
            assert (page.parent / target.split("#")[0]).exists(), target


def test_planners_and_options_are_listed_with_their_defaults():
    text = (REPOSITORY / "docs" / "planners.md").read_text()
    common = set.intersection(*(set(srmp.planner_options({"planner_id": id_})) for id_ in srmp.available_planners()))

    def rows(section):
        table = re.findall(r"^\| (.+?) \|$", section, re.MULTILINE)
        return {cells[0].strip("`"): cells[1] for cells in (row.split(" | ") for row in table)}

    def as_text(value):
        if isinstance(value, str):
            return value or '""'
        return str(value).replace("'", '"').replace("True", "true").replace("False", "false")

    shared = rows(text.split("## Options of every planner")[1].split("## ")[0])
    own = re.split(r"^\| \*\*`(\w+)`\*\* .*$", text.split("## Options of one planner")[1], flags=re.MULTILINE)
    for id_ in srmp.available_planners():
        assert f"| `{id_}` |" in text
        listed = {**shared, **rows(own[own.index(id_) + 1])} if id_ in own else shared
        for key, value in srmp.planner_options({"planner_id": id_}).items():
            if key == "planner_id":
                continue
            assert key in listed, f"{id_}: {key}"
            # C++ hands whole numbers back as floats
            assert listed[key] in (as_text(value), as_text(value).removesuffix(".0")), f"{id_}: {key}"
    assert {key for key in shared if key not in ("option", "---")} == common - {"planner_id"}


def test_every_statistic_is_explained():
    text = (REPOSITORY / "docs" / "planners.md").read_text()
    for field in srmp.PlannerInterface().get_planning_stats():
        assert f"`{field}`" in text, field


def test_every_command_is_explained():
    from srmp.cli import main

    text = (REPOSITORY / "docs" / "cli.md").read_text()
    for command in main.commands:
        assert re.search(rf"^## {command}\b", text, re.MULTILINE), command
