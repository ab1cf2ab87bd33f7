"""Defaults and constants: each is what tests/defaults.txt says, so that none changes unseen."""

import re

import pytest

from tests import defaults

SECTION = re.compile(r"^\[(.+)\]\n((?:.+\n)*)", re.MULTILINE)
KNOWN = dict(SECTION.findall(defaults.TABLE.read_text(encoding="utf-8")))
REMEDY = "run `python -m tests.defaults` and look at what changed"


@pytest.mark.parametrize("name", defaults.modules())
def test_every_default_and_constant_is_the_one_in_the_table(name):
    lines = [f"{key} = {value}" for key, value in defaults.defaults(name).items()]
    assert lines == KNOWN.get(name, "").splitlines(), REMEDY


def test_the_table_is_of_the_modules_there_are_and_not_of_others():
    assert set(KNOWN) <= set(defaults.modules()), REMEDY
    assert sum(text.count("\n") for text in KNOWN.values()) > 1000


def test_a_default_is_found_wherever_it_is_set():
    body = KNOWN["coopenv.physics.body"].splitlines()
    assert "Body.mass = 7.7" in body  # of a field
    assert "LEAST = 1e-15" in body  # of a module
    assert "Body.beam(width) = 0.1" in body  # of a method
    assert "_LOCKED = 1e-06" in KNOWN["coopenv.physics.contacts"]  # a private tolerance
    assert "ranges(num_rays) = 12" in KNOWN["coopenv.observation.ranges"]  # of a function
    assert "Task.max_obstacles = 0" in KNOWN["coopenv.tasks.base"]  # of a class
