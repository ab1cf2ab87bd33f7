"""Keys of noise: an episode's own, whatever else begins beside it."""

import numpy as np
import pytest

from coopenv.agents.noise import EpisodeKeys


def test_worlds_that_begin_get_their_keys_and_the_others_keep_theirs():
    noise = EpisodeKeys(seed=1)
    noise.seed(np.arange(4))
    before = noise._episodes.copy()
    noise.seed(np.arange(10, 14), worlds=np.array([1, 3]))
    whole = EpisodeKeys(seed=1)
    whole.seed(np.arange(10, 14))
    np.testing.assert_array_equal(noise._episodes[[0, 2]], before[[0, 2]])
    np.testing.assert_array_equal(noise._episodes[[1, 3]], whole._episodes[[1, 3]])
    assert len({*before.tolist(), *whole._episodes.tolist()}) == 8


@pytest.mark.parametrize("seeded", [True, False])
def test_every_seed_up_to_64_bits_has_keys_of_its_own(seeded):
    seeds = [*range(8), 2**32 + 1, 2**63, 2**64 - 1]
    keys = set()
    for seed in seeds:
        noise = EpisodeKeys(seed)
        if seeded:
            noise.seed(np.arange(3))
        keys |= set(noise.get_state(np.arange(3), num_worlds=3).tolist())
    assert len(keys) == 3 * len(seeds)


def test_of_a_longer_seed_the_last_64_bits_count():
    worlds = np.arange(2)
    long, short = EpisodeKeys(2**64 + 5), EpisodeKeys(5)
    np.testing.assert_array_equal(long.get_state(worlds, 2), short.get_state(worlds, 2))
