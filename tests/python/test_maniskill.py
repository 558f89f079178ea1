"""ManiSkill's solvers for its Panda, unmodified, on srmp.compat.mplib: physics on the CPU, nothing is drawn."""

import subprocess
import sys
from importlib.util import find_spec

import pytest

if find_spec("mani_skill") is None:
    pytest.skip("ManiSkill, the package mani_skill, is not installed", allow_module_level=True)

PROGRAM = """
import sys

import sapien.pysapien.render
import srmp.compat.mplib

sys.modules["mplib"] = srmp.compat.mplib


class NoMaterial:  # materials need a graphics device, though nothing is drawn
    def __init__(self, *_, **__): pass
    def set_base_color(self, *_): pass


for module in (sapien.render, sapien.pysapien.render):
    module.RenderMaterial = module.RenderTexture2D = NoMaterial

import gymnasium
import mani_skill.envs
from mani_skill.examples.motionplanning.panda.run import MP_SOLUTIONS

task = sys.argv[1]
env = gymnasium.make(
    task,
    obs_mode="none",
    control_mode="pd_joint_pos",
    reward_mode="none",
    sim_backend="physx_cpu",
    render_backend="none",
)
solved = 0
for seed in range(5):
    result = MP_SOLUTIONS[task](env, seed=seed, debug=False, vis=False)
    solved += result != -1 and bool(result[-1]["success"])
print("solved", solved)
"""


@pytest.mark.parametrize(
    ("task", "solved"),
    [("PickCube-v1", 5), ("StackCube-v1", 5), ("PegInsertionSide-v1", 5), ("LiftPegUpright-v1", 5), ("PushCube-v1", 4)],
)
def test_a_solver_does_its_task(task, solved):
    """Each in a process of its own: the name mplib is taken in it."""
    command = [sys.executable, "-W", "ignore", "-c", PROGRAM, task]
    result = subprocess.run(command, capture_output=True, text=True, timeout=900)
    assert result.returncode == 0, result.stderr[-2000:]
    assert int(result.stdout.split("solved ")[-1]) >= solved
