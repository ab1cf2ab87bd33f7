"""Columns of a file are told apart by their names."""

import pytest

from coopenv.errors import InvalidInput
from coopenv.logs import Layout
from coopenv.logs.plan.matching import find

NAMES = ["time", "f1x", "note", "f1x", "note"]


def test_of_names_that_are_there_twice_the_first_is_told():
    with pytest.raises(
        InvalidInput, match=r"^a: columns must differ, got 'f1x' twice; rename one$"
    ):
        find("a", NAMES, Layout(), ())
    assert find("a", NAMES[:3], Layout(), ()) == {"time": "time", "f1x": "f1x"}
