"""Campaign of processes and threads: forks, spawned workers, and threads in one core or in many.

Each trial runs one of `benchmarks.soak.company` in an interpreter of its own, since what goes wrong
here ends or hangs the interpreter.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

from benchmarks.soak.company import KINDS

NAME = "processes"
SHARE = 0.1
PATIENCE = 180.0  # [s] for something that takes some seconds
SIZES = (1, 40, 300, 600)  # worlds: one pymunk space, or several and their threads
LINES = 6  # of what it said last


def trial(seed: int, folder: Path) -> dict[str, int]:
    """One kind of company of one size."""
    rng = np.random.default_rng([4, seed])
    kind, num_worlds = str(rng.choice(list(KINDS))), int(rng.choice(SIZES))
    command = [sys.executable, "-m", "benchmarks.soak.company", kind, str(num_worlds), str(seed)]
    place = " ".join(command[1:])
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired as error:
        raise AssertionError(f"{place} hangs") from error
    said = "\n".join(done.stderr.strip().splitlines()[-LINES:])
    assert done.returncode == 0, f"{place} ended with {done.returncode}\n{said}"
    return {kind.replace("-", "_"): 1}
