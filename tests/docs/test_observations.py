"""The page on observations says what the code does."""

import numpy as np

from benchmarks import observations
from coopenv import BLOCKS, Block
from coopenv.observation.block import EachOther
from tests.docs.snippets import chains, running


def test_the_table_is_what_the_code_prints():
    # else: python -m benchmarks.observations --write
    assert observations.PAGE.read_text(encoding="utf-8") == observations.page()


def test_every_block_says_what_it_is_in_which_unit_and_fits_its_numbers():
    for name, block in BLOCKS.items():
        assert block.describe, name
        assert block.unit, name
        size = block.size
        if isinstance(size, EachOther):
            size = size.own + size.features
        assert block.unit.count(",") + 1 in (1, size), name


def test_a_bound_on_one_side_is_said():
    half = Block(name="x", size=2, describe="", read=lambda t: t.applied, low=(0.0, -np.inf))
    assert observations.bounds(half) == "[0, inf], any"


def test_what_the_blocks_of_the_page_show_is_finite_and_bounded(tmp_path):
    shown = chains(observations.PAGE)
    assert len(shown) == 5
    cores = []
    for chain in shown:
        with running(chain, tmp_path) as names:
            if "core" in names:
                cores.append(names["core"])
    for core in cores:
        obs, _ = core.reset(seed=0)
        assert np.isfinite(obs).all()
    core = cores[-1]
    assert (core.observation.low[core.observation.blocks["speed"]] == 0).all()
