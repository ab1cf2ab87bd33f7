"""Lines of TOML keys: every key that the parser finds has the line on which it stands."""

from collections.abc import Iterator

import pytest

from coopenv.agents.experiments.lines import Source
from coopenv.errors import InvalidInput
from coopenv.files import toml

TEXT = (
    """\
top = "a # no comment [nor table]"
"quoted key" = 'it"""
    + "'"
    + '''
[a]  # comment = 1
b.c.d = 1.5e-3
b.e = { x = 1, "y" = { z = [1, 2, { deep = true }] } }
long = """
not.a.key = 1
[not.a.table]
"""
raw = \'\'\'
x = "\'\'\'
list = [
  1,   # one
  "two",
  { three = 3 },
]
[a.b2]
large = [1_000, 2_000.5]
f = 1979-05-27T07:32:00Z
[[items]]
name = "first"
[items.inner]
k = 0
[[items]]
name = "second \\" = ["
inner = { k = 1 }
'''
)


def places(value, above=()) -> Iterator[tuple]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inside in pairs:
        yield (*above, key)
        if isinstance(inside, dict | list):
            yield from places(inside, (*above, key))


def test_every_key_has_its_line():
    text = TEXT.replace("'it'", "'it'")
    source, lines = Source.of("f.toml", text), text.splitlines()
    found = [place for place in places(toml.loads(text)) if isinstance(place[-1], str)]
    assert len(found) > 20
    for place in found:
        line = lines[source.lines[place] - 1]
        assert place[-1] in line, place


def test_the_entries_of_an_array_have_theirs():
    source = Source.of("f.toml", TEXT)
    lines = TEXT.splitlines()
    assert lines[source.lines["a", "list", 1] - 1] == '  "two",'
    assert lines[source.lines["a", "list", 2, "three"] - 1] == "  { three = 3 },"
    assert lines[source.lines["items", 1, "name"] - 1].startswith('name = "second')
    assert lines[source.lines["items", 0, "inner", "k"] - 1] == "k = 0"
    assert lines[source.lines["items", 1, "inner", "k"] - 1] == "inner = { k = 1 }"


def test_an_error_gets_the_line_of_the_nearest_key_once():
    source = Source.of("f.toml", TEXT)
    with (
        pytest.raises(InvalidInput, match=r"^no \(f\.toml, line 3\)$"),
        source.at(("a", "nothing")),
        source.at(("a", "missing", "deep")),
    ):
        raise InvalidInput("no")


def test_without_a_file_an_error_says_the_keys():
    with (
        pytest.raises(InvalidInput, match=r"^no \(grid\.reward\)$"),
        Source().at(("grid", "reward")),
    ):
        raise InvalidInput("no")
