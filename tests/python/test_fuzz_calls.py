"""Hundreds of cases of each door of calls.py; tests/fuzz/run takes longer."""

import subprocess
import sys
from pathlib import Path

CALLS = Path(__file__).parents[1] / "fuzz" / "calls.py"


def test_sequences_of_hostile_calls_raise_nothing_but_our_errors():
    done = subprocess.run([sys.executable, CALLS], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
