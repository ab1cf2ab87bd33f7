"""Colours of all pictures stay apart for those who lack a kind of cone, and printed in grey."""

from itertools import combinations

import numpy as np
import pytest

from coopenv.agents.studies.methods import LOOKS
from coopenv.logs import figure
from coopenv.render import look
from coopenv.wrench.drawing import looks
from tests.render.vision import GREY, LACKING, apart

CLEAR, WELL = 10.0, 20.0  # ΔE; 2 is just seen
ALL = {**LACKING, "colour": GREY}


def rgb(text: str) -> list[int]:
    """Of ``#RRGGBB``."""
    return [int(text[k : k + 2], 16) for k in (1, 3, 5)]


def test_the_simulation_takes_red_for_green_and_leaves_grey_as_it_is():
    red, green, blue = (200, 80, 40), (110, 130, 30), (40, 60, 200)
    seen = {name: apart(red, green, matrix) for name, matrix in LACKING.items()}
    assert seen["middle"] < 0.4 * seen["nothing"]
    assert seen["short"] > WELL
    assert apart(red, blue, LACKING["middle"]) > WELL
    for matrix in ALL.values():
        white_to_black = apart((255, 255, 255), (0, 0, 0), matrix)
        assert white_to_black == pytest.approx(100, abs=0.5)
    assert np.allclose([matrix.sum(axis=1) for matrix in ALL.values()], 1, atol=1e-3)


@pytest.mark.parametrize("lacking", LACKING)
def test_agents_are_told_apart(lacking):
    for agents in (look.AGENTS, [rgb(text) for text in figure.COLOURS]):
        for one, other in combinations(agents, 2):
            assert apart(one, other, LACKING[lacking]) > CLEAR, (one, other)
    for text in figure.COLOURS[:4]:  # of sheets; beside more effectors it has panels of its own
        assert apart(rgb(text), rgb(figure.INTERNAL), LACKING[lacking]) > CLEAR


@pytest.mark.parametrize("lacking", ALL)
def test_what_is_internal_stands_out_from_what_is_applied_and_from_the_object(lacking):
    for one, other in combinations((look.INTERNAL, look.APPLIED, look.BODY), 2):
        assert apart(one, other, ALL[lacking]) > WELL, (one, other)
    assert apart(look.EDGE, look.ARRIVED, ALL[lacking]) > WELL  # the edge of who has arrived


@pytest.mark.parametrize("lacking", LACKING)
def test_parts_of_a_split_and_their_regions_are_told_apart(lacking):
    shown = (looks.APPLIED, looks.MANIPULATION, looks.INTERNAL, looks.OBJECT_WRENCH)
    edges = [rgb(each.edge) for each in shown]
    for one, other in combinations([*edges, rgb(looks.SKY)], 2):
        assert apart(one, other, LACKING[lacking]) > CLEAR, (one, other)


def test_a_split_in_grey_is_told_by_the_hollow_arrow():
    assert (looks.INTERNAL.face, looks.MANIPULATION.face) == ("white", looks.BLUE)
    assert apart((255, 255, 255), rgb(looks.BLUE), GREY) > WELL


@pytest.mark.parametrize("lacking", ALL)
def test_methods_of_studies_differ_in_colour_or_in_line(lacking):
    for one, other in combinations(LOOKS.values(), 2):
        differs = apart(rgb(one.color), rgb(other.color), ALL[lacking]) > CLEAR
        assert differs or (one.line, one.width) != (other.line, other.width), (one, other)
