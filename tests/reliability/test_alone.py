"""The soak test's comparison of a world alone with itself in a batch."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.soak.alone import ALONE, NUDGE, check_alone, growth
from coopenv import Transport

STEPS = 30


def drifting(rate: float) -> tuple[Any, list[tuple[np.ndarray, np.ndarray]]]:
    """Steps of a world that is at rest, and where it is in a batch, farther off at every step."""
    core = SimpleNamespace(world=SimpleNamespace(pose=np.zeros((1, 3)), twist=np.zeros((1, 3))))
    return core, [(np.zeros(3), np.full(3, rate * step)) for step in range(STEPS)]


def test_a_world_that_company_changes_is_told_where_no_nudge_explains_it():
    core, among = drifting(ALONE)
    with pytest.raises(AssertionError, match=r"1: world 3 alone is 2\.0e-09 off at step 2, nudged"):
        check_alone(core, range(STEPS), among, lambda: np.full(STEPS, 1.5e-9), "1: world 3")


def test_a_nudge_is_asked_for_once_and_only_where_it_is_needed():
    asked = []

    def explained() -> np.ndarray:
        asked.append(True)
        return np.full(STEPS, 1e-6)

    for rate, times in ((0.0, 0), (ALONE, 1)):
        core, among = drifting(rate)
        check_alone(core, range(STEPS), among, explained, "")
        assert len(asked) == times


def test_nudges_bring_a_calm_world_hardly_farther_than_their_sum():
    core, twin = Transport(), Transport()
    plan = np.random.default_rng(0).uniform(-0.1, 0.1, (STEPS, 1, core.num_agents, 3))
    core.reset(seed=0)
    twin.reset(seed=0)
    most = growth(core, map(core.step, plan), twin, map(twin.step, plan))
    assert most[0] == 0.0
    assert NUDGE / 100 < most[-1] < 2 * STEPS * NUDGE
    assert (np.diff(most) >= 0.0).all()
