"""One result for a request, bit for bit: on every run, for every number of threads and every instruction set.

The full test (20 repeats, and the exact meshes) is `python bench/suites/determinism.py --data DIR`.
"""

import importlib.util
from pathlib import Path

import pytest

SUITE = Path(__file__).parents[2] / "bench" / "suites" / "determinism.py"


@pytest.fixture(scope="module")
def determinism():
    spec = importlib.util.spec_from_file_location("determinism", SUITE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("geometry", "scenarios", "problems", "repeats", "requests"),
    [("spheres", "", "1-5", 4, 35 + 3), ("urdf", "box,bookshelf_thin,table_pick", "1", 2, 3 + 1)],
)
def test_one_hash_each(mbm_dir, determinism, geometry, scenarios, problems, repeats, requests):
    result = determinism.run(str(mbm_dir), geometry=geometry, scenarios=scenarios, problems=problems, repeats=repeats)
    assert result["header"]["instruction_sets"][0] == "portable"
    assert len(result["hashes"]) == requests
    assert result["differing"] == []
    different = {outcomes[0] for name, outcomes in result["hashes"].items() if name.startswith("auto")}
    assert len(different) == sum(name.startswith("auto") for name in result["hashes"])


def test_differing_results_are_reported(determinism):
    found = determinism.merge({"portable": {"a": ["1"], "b": ["2"]}, "avx2": {"a": ["1"], "b": ["3"]}})
    assert found == {"a": ["1"], "b": ["2", "3"]}
