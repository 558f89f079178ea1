"""The examples with simulators run, each where its simulator is installed, and draw where it can."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "simulators").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_example_runs(example, tmp_path):
    simulator = example.stem.rpartition("_")[2]
    pytest.importorskip(simulator, reason=f"pip install '.[{simulator}]' to run {example.name}")
    figure = tmp_path / "figure.png"
    arguments = [str(figure)] if can_draw(simulator) else []
    result = subprocess.run([sys.executable, str(example), *arguments], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.count("\n") > 2
    if arguments:
        assert figure.stat().st_size > 5000


def can_draw(simulator: str) -> bool:
    """On a machine without a screen, and without a GPU."""
    if simulator == "pybullet":
        return True
    if simulator != "mujoco":
        return False
    os.environ.setdefault("MUJOCO_GL", "egl")
    program = "import mujoco; mujoco.Renderer(mujoco.MjModel.from_xml_string('<mujoco/>'))"
    return subprocess.run([sys.executable, "-c", program], capture_output=True).returncode == 0
