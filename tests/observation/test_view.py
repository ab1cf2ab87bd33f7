"""The table of the agents' view, and what follows from it."""

import numpy as np
import pytest

from coopenv import BLOCKS, Body, Transport
from coopenv.observation import DEFAULT_BLOCKS
from coopenv.observation.view import VIEW, VIEW_PARTS
from tests.helpers import TRIO


@pytest.mark.parametrize("body", [Body(), TRIO])
def test_blocks_lie_side_by_side_and_fill_the_row(body):
    core = Transport(num_worlds=2, body=body, observe=VIEW_PARTS)
    seen, _ = core.reset(seed=0)
    slices = core.observation.blocks
    assert tuple(slices) == VIEW_PARTS
    ends = [0, *(part.stop for part in slices.values())]
    assert [part.start for part in slices.values()] == ends[:-1]
    assert seen.shape == (2, body.num_agents, ends[-1])


def test_every_block_without_a_reader_is_part_of_the_view():
    assert [block for block in BLOCKS.values() if block.read is None] == list(VIEW)
    assert DEFAULT_BLOCKS == VIEW_PARTS


def test_own_and_other_wrenches_stand_where_the_table_says():
    core = Transport(num_worlds=1, body=TRIO, observe=VIEW_PARTS)
    core.reset(seed=0)
    (seen,), *_ = core.step(np.random.default_rng(0).uniform(-1, 1, (1, 3, 3)))
    assert core.transition is not None
    slices, torques = core.observation.blocks, core.transition.applied[0, :, 2]
    for i in range(3):
        own, others = seen[i, slices["own_wrench"]], seen[i, slices["partner_wrench"]]
        np.testing.assert_array_equal(
            [own[2], others[2], others[5]], np.roll(torques, -i).astype(np.float32)
        )
