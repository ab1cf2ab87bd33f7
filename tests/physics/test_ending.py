"""Worlds that nobody lets go of before their process ends."""

import subprocess
import sys

HELD = """
import gymnasium, numba.core.compiler_machinery, pymunk
import coopenv

def held():
    return env

numba.core.compiler_machinery.PassManager.held = held  # and so this module's names
env = gymnasium.make("coopenv/WalkerAvoid-v0")
env.reset(seed=0)
env.step(env.action_space.sample())
"""


def test_a_process_ends_well_though_a_library_holds_its_environment():
    ended = subprocess.run([sys.executable, "-c", HELD], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
