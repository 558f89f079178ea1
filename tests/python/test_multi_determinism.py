"""plan_multi: the same result every time, for every number of threads, and on every instruction set."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from multi_arms import outcome, quarter_turns, ring

import srmp

AGAIN = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
from multi_arms import outcome, ring
motion, counts = outcome(ring())
print(hashlib.sha256(motion).hexdigest(), counts)
"""


def test_the_same_bits_on_every_run_and_instruction_set():
    planner = ring()
    first = outcome(planner)
    assert first[1][0] > 4  # they are in each other's way
    assert outcome(planner) == first  # what is kept from the plan before changes nothing
    assert outcome(ring()) == first
    printed = []
    for backend in ("portable", "avx2", "avx512"):
        result = subprocess.run(
            [sys.executable, "-c", AGAIN, Path(__file__).parent],
            env={**os.environ, "SRMP_SIMD": backend},
            capture_output=True,
            text=True,
        )
        if "which this CPU does not have" not in result.stderr:
            assert result.returncode == 0, result.stderr
            printed.append(result.stdout)
    assert len(printed) >= 1
    assert set(printed) == {f"{hashlib.sha256(first[0]).hexdigest()} {first[1]}\n"}


@pytest.mark.parametrize("planner_id", ["auto", "xECBS", "prioritised"])
def test_the_same_bits_for_every_number_of_threads(planner_id):
    first = outcome(ring(planner_id=planner_id))
    for threads in (2, 4):
        assert outcome(ring(planner_id=planner_id, num_threads=threads)) == first


def test_heuristics_in_python_are_asked_from_many_threads():
    def distance(configurations, goals):
        return np.linalg.norm(configurations[:, None] - goals[None], axis=2).min(axis=1)

    planner, outcomes = ring(), []
    planner.add_heuristic("mine", distance)
    for threads in (1, 4):
        planner.make_planner(list(quarter_turns()[0]), srmp.XECBS(heuristic="mine", num_threads=threads))
        outcomes.append(outcome(planner))
    assert outcomes[0] == outcomes[1]


def test_what_a_heuristic_throws_on_another_thread_is_told():
    def broken(configurations, goals):
        raise ZeroDivisionError("no luck")

    planner = ring()
    planner.add_heuristic("mine", broken)
    planner.make_planner(list(quarter_turns()[0]), srmp.XECBS(heuristic="mine", num_threads=3))
    with pytest.raises(ZeroDivisionError, match="no luck"):
        planner.plan_multi(*quarter_turns())


def test_the_order_of_the_dictionaries_does_not_matter():
    starts, goals = quarter_turns()
    backwards = ring().plan_multi(dict(reversed(starts.items())), dict(reversed(goals.items())))
    assert backwards == ring().plan_multi(starts, goals)
