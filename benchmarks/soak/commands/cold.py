"""First start of coopenv, with an empty cache: a process that compiles all that it imports."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.soak.commands.server import ROOT
from coopenv import wrench

APPLIED = ((3.0, 1.0, 0.5), (-1.0, 2.0, 0.0))  # [N, N, N·m] of two effectors
GRIPS = ((-0.9, 0.0), (0.9, 0.0))  # [m]
LONGEST = 20.0  # [s] after which it is killed at the latest
CODE = f"""
from coopenv import wrench
print(repr(float(wrench.decompose({APPLIED}, {GRIPS}).cost)))
"""


def kill(folder: Path, rng: np.random.Generator) -> bool:
    """Start it with its cache in ``folder`` and kill it; whether it had not ended."""
    process = _started(folder)
    due = time.monotonic() + rng.uniform(0.0, LONGEST)
    while process.poll() is None and time.monotonic() < due:
        time.sleep(0.01)
    process.kill()
    process.communicate()
    return process.returncode != 0


def check(folder: Path) -> None:
    """Raise unless it starts, and decomposes as this process does."""
    process = _started(folder)
    out, err = process.communicate()
    wanted = repr(float(wrench.decompose(np.array(APPLIED), np.array(GRIPS)).cost))
    assert process.returncode == 0, f"after a kill it does not start: {err[-2000:]}"
    assert out.strip() == wanted, f"after a kill it says {out!r} instead of {wanted}"
    assert not err, f"after a kill it complains: {err[-2000:]}"


def _started(folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CODE],
        cwd=ROOT,
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
