"""What several test modules share, beside the fixtures of conftest.py."""

import time

import pytest

from srmp.robots._packages import PACKAGES

ERD = PACKAGES["example-robot-data"]()  # where the package's robots are; None where it is not installed
needs_example_robot_data = pytest.mark.skipif(ERD is None, reason="needs pip install example-robot-data")


def eventually(condition, seconds=20):
    """Waits until the condition is true, and fails when it is not after so many seconds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
