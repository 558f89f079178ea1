"""Include directions: nothing lower in the house includes anything higher (docs/architecture.md)."""

import re
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "srmp"

MAY_INCLUDE = {
    "core": set(),
    "robot": {"core"},
    "scene": {"core", "robot"},
    "collision": {"core", "robot", "scene"},
    "search": {"core"},
    "multi": {"core", "search"},
    "lattice": {"core", "robot", "search"},
    "heuristic": {"core", "robot", "scene"},
    "trajectory": {"core", "robot", "collision"},
    "io": {"core", "robot", "scene", "lattice", "trajectory"},
    "planner": {"core", "robot", "scene", "collision", "search", "multi", "lattice", "heuristic", "trajectory", "io"},
}


@pytest.mark.parametrize("module", sorted(p.name for p in SOURCE.iterdir() if p.is_dir()))
def test_module_includes_only_what_lies_below_it(module):
    for file in (SOURCE / module).rglob("*.[hc]pp"):
        included = set(re.findall(r'#include "srmp/(\w+)/', file.read_text()))
        assert included <= MAY_INCLUDE[module] | {module}, f"{file.relative_to(SOURCE)} includes {sorted(included)}"


def test_headers_keep_pinocchio_and_coal_out():
    for file in SOURCE.rglob("*.hpp"):
        public = "#include <pinocchio" not in file.read_text() and "#include <coal" not in file.read_text()
        assert public, f"{file.relative_to(SOURCE)} would force its users to have Pinocchio or Coal"
