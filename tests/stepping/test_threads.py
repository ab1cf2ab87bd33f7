"""How many threads step a core changes no bit of what comes out."""

import copy

import numpy as np
import pytest

from coopenv import Transport
from coopenv.compiled.parallel import cores
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import IDS, actions, assert_same

COUNT = 600  # worlds; in three shards, of which one is smaller


@pytest.mark.parametrize(  # hands move the worlds of every id alike
    ("view", "action"), [*((view, "wrench") for view in IDS), (IDS[0], "motion")]
)
def test_one_thread_and_many_give_the_same_bits(view, action):
    config = find_config(view, {"action": action, "horizon": 7})
    one, two, many = (Transport(num_worlds=COUNT, config=config, threads=n) for n in (1, 2, 3))
    first = one.reset(seed=0)
    for other in (two, many):
        assert_same(first, other.reset(seed=0))
    for given in actions(0, 10, *one.action_shape):
        assert one.transition is not None
        again = one.transition.truncated | one.transition.terminated
        step = one.step(given, restart=again)
        for other in (two, many):
            assert_same(step, other.step(given, restart=again))


def test_a_batch_that_is_too_small_to_gain_is_stepped_by_one_thread():
    assert Transport(num_worlds=1).threads == 1
    assert Transport(num_worlds=256).threads == 1
    assert Transport(num_worlds=4096).threads == cores()


def test_a_copy_has_as_many_threads():
    assert copy.deepcopy(Transport(num_worlds=2, threads=5)).threads == 5


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2", 10**6])
def test_a_number_of_threads_that_makes_no_sense_is_refused(threads):
    with pytest.raises(InvalidInput, match="threads must be"):
        Transport(threads=threads)


def test_threads_are_no_part_of_a_state():
    one, many = (Transport(num_worlds=COUNT, threads=n) for n in (1, 2))
    one.reset(seed=4)
    many.set_state(one.get_state())
    given = np.zeros(one.action_shape)
    assert_same(one.step(given), many.step(given))
