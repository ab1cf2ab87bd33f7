"""Measuring on this machine: what counts, and what is refused."""

import time

import numpy as np
import pytest

from coopenv import Transport
from coopenv.bench import full_steps, random_actions
from coopenv.bench.clock import LEAST, repeated


def test_what_a_repeat_leaves_out_counts_on_neither_clock():
    def work() -> float:
        began = time.perf_counter()
        while time.perf_counter() - began < 4e-3:
            pass
        return 1e-3  # a quarter of it

    found = repeated(work, 0.0)
    assert found.passed == 1e-3
    assert 0 < found.processor <= 1.1e-3


def test_it_is_repeated_for_so_long_and_three_times_at_least():
    done: list[float] = []

    def work() -> float:
        done.append(time.perf_counter())
        time.sleep(2e-3)
        return 2e-3

    repeated(work, 0.0)
    assert len(done) == LEAST
    repeated(work, 0.05)
    assert 0.03 < done[-1] - done[LEAST] < 0.5


@pytest.mark.parametrize("action", ["wrench", "discrete"])
def test_a_team_acts_at_random_in_whatever_actions_there_are(action):
    core = Transport(num_worlds=2, action=action, horizon=3)
    actions = random_actions(core, 4)
    assert actions.shape == (4, *core.action_shape)
    assert len(np.unique(actions)) > 4
    seconds = list(full_steps(core, actions))  # beyond the horizon: ended worlds begin anew
    assert len(seconds) == 4
    assert min(seconds) > 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--num-worlds", "0"], "num_worlds must be a whole number of at least 1, got 0"),
        (["--num-worlds", "2", "1000001"], "num_worlds must be at most 1000000, got 1000001"),
        (["--threads", "1", "1025"], "threads must be at most 1024, got 1025"),
        (["--threads", "0"], "threads must be a whole number of at least 1, got 0"),
        (["--seconds", "0"], "seconds must be"),
        (["--seconds", "61"], "seconds must be at most 60, got 61"),
    ],
)
def test_what_cannot_be_measured_is_refused_before_anything_is(arguments, says, capsys):
    pytest.importorskip("tyro")
    cli = pytest.importorskip("coopenv.cli")
    assert cli.main(["bench", *arguments]) == 1
    assert says in capsys.readouterr().err
