"""Keys of noise: an episode's own, whatever else begins beside it."""

import numpy as np

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
