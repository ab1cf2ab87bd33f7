"""What a recurrent policy remembers goes with the worlds, whatever rows each of them has."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from coopenv.agents.learned.memory import EpisodeMemory

LAYERS, UNITS = 2, 4


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_world_is_taken_and_put_elsewhere_with_all_of_its_rows(rows):
    memory, other = EpisodeMemory(), EpisodeMemory()
    kept = np.arange(2 * LAYERS * rows * UNITS, dtype=float).reshape(LAYERS, 2 * rows, UNITS) + 1
    memory.forget(np.array([True, True]))
    memory.keep((kept, -kept))
    other.set_state(memory.get_state(np.array([1]), 2), np.array([0]), 3)
    found, fresh = other.recall(3 * rows)
    assert found is not None
    for layers, wanted in zip(found, (kept, -kept), strict=True):
        np.testing.assert_array_equal(layers[:, :rows], wanted[:, rows:])
        assert not layers[:, rows:].any()
    assert fresh.tolist() == [False] * rows + [True] * 2 * rows
