"""Experiments that are killed at random moments, twenty times, and started again."""

import os
import random
import signal
from pathlib import Path

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents.experiments import conduct
from coopenv.agents.experiments.cell import RESULT
from tests.agents.experiments.cases import TRAINING, files, here, small

KILLS = 20
AT_MOST = 4  # of one experiment, before it may come to its end
GRID = {"algorithm": ["ppo", "random", "scripted"]}
LEARNING = {**TRAINING, "hidden": [8], "checkpoint_every": 1}


def run(out: Path) -> None:
    outcome = conduct(small(out, grid=GRID, training=LEARNING, seeds=2), launch=here, workers=1)
    assert outcome.failures == {}


def forked(out: Path, seconds: float) -> tuple[bool, float]:
    """Run in a child that ends after some processor seconds; whether it was killed, and its time.

    The system ends it at whatever it does, as SIGKILL would: nobody handles SIGPROF. 0: never.
    """
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.setitimer(signal.ITIMER_PROF, seconds)
            run(out)
            code = 0
        finally:
            os._exit(code)
    _, status, used = os.wait4(child, 0)
    killed = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF
    assert killed or os.waitstatus_to_exitcode(status) == 0
    return killed, used.ru_utime + used.ru_stime


def cells(out: Path) -> dict[str, bytes]:
    """What the report is made of, and what was learned on the way."""
    paths = [*out.glob(f"cells/*/*/{RESULT}"), *out.glob("cells/*/*/curves.csv")]
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in paths}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="children are forked")
def test_an_experiment_that_is_killed_twenty_times_comes_to_the_same_report(tmp_path):
    run(tmp_path / "warm")  # imports and kernels, once for all children
    whole = tmp_path / "whole"
    _, seconds = forked(whole, 0)
    rng = random.Random(18)
    kills = experiments = 0
    while kills < KILLS:
        out = tmp_path / str(experiments)
        experiments += 1
        for _ in range(AT_MOST):
            killed, _ = forked(out, rng.uniform(0.005, 0.8) * seconds)
            kills += killed
            if not killed:
                break
        forked(out, 0)
        assert files(out) == files(whole), f"experiment {experiments} after {kills} kills"
        assert cells(out) == cells(whole)
    assert len(cells(whole)) == 6 + 2  # of which two learn
    print(f"{kills} kills of {experiments} experiments of {seconds:.1f} processor seconds each")
