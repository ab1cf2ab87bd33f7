"""What an agent is told, in every world its own, through sensors that err and are late."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import BLOCKS, Block, Sensor, Transport
from coopenv.observation.observation import Observation
from tests.helpers import OPEN_ROOM, TRIO

TOLD = np.array([  # (world, agent, place or angle)
    [[1, 1], [1, 0], [0, 1]],
    [[0, 0], [1, 1], [1, 0]],
], dtype=bool)  # fmt: skip
SENSORS = {
    "truth": "goal",
    "exact": Sensor("goal"),
    "noise": Sensor("goal", noise=0.5),
    "bias": Sensor("goal", bias=0.5),
    "all": Sensor("goal", noise=(0.1, 0.2, 0.3, 0.4), bias=0.2, delay=1),
}


def read(entry, told=TOLD, steps=3):
    """What is seen ``(step, world, agent, feature)`` where ``told`` holds."""
    core = Transport(num_worlds=2, body=TRIO, scene=OPEN_ROOM, observe=(entry,))
    core.reset(seed=0)
    observation = Observation((entry,), 3, 2)
    seen = []
    for _ in range(steps):
        assert core.transition is not None
        conditions = replace(core.transition.conditions, told=told)
        seen.append(observation(replace(core.transition, conditions=conditions)))
        core.step(np.full((2, 3, 3), 0.3))
    return np.array(seen)


@pytest.mark.parametrize("name", SENSORS)
def test_place_and_angle_are_each_zero_for_those_who_are_not_told_and_for_nobody_else(name):
    seen = read(SENSORS[name])
    known = np.broadcast_to(TOLD[..., [0, 0, 1, 1]], seen.shape)
    assert not seen[~known].any()
    assert seen[known].all()


def test_who_is_told_reads_the_same_whoever_else_is():
    seen, of_all = (read(SENSORS["all"], told) for told in (TOLD, np.ones_like(TOLD)))
    known = np.broadcast_to(TOLD[..., [0, 0, 1, 1]], seen.shape)
    np.testing.assert_array_equal(seen[known], of_all[known])


def test_a_block_of_ones_own_says_which_features_need_to_be_told():
    def ones(transition):
        return np.ones((*transition.applied.shape[:2], 3))

    mine = Block(name="mine", size=3, describe="ones", read=ones, needs_told=(1, -1, 0))
    seen = read(Sensor(mine, noise=0.1))
    known = np.stack([TOLD[..., 1], np.ones_like(TOLD[..., 0]), TOLD[..., 0]], axis=-1)
    known = np.broadcast_to(known, seen.shape)
    assert not seen[~known].any()
    assert seen[known].all()
    free = replace(mine, needs_told=())
    assert read(Sensor(free, noise=0.1)).all()


def test_the_known_block_says_what_is_told_of_place_and_angle():
    assert BLOCKS["known"].size == 2
    np.testing.assert_array_equal(read("known")[0], TOLD)
