"""Places and changes: one span each, every kind of fault, and what is left out."""

import ast

import pytest

from benchmarks.mutants.places import is_another_program, places
from benchmarks.mutants.source import Source
from tests.benchmarks.mutants.cases import edited
from tests.sources import ROOT


def test_an_operator_changes_in_its_place_and_nothing_else():
    found = edited("d = (a  # first\n     ) * (b - c)\n")
    assert ("arithmetic", "d = (a  # first\n     ) / (b - c)") in found
    assert ("arithmetic", "d = (a  # first\n     ) * (b + c)") in found
    assert len(found) == 2


@pytest.mark.parametrize(
    ("text", "operator", "changed"),
    [
        ("a = b < c\n", "comparison", "a = b <= c"),
        ("a = b is not None\n", "comparison", "a = b is None"),
        ("a = b not in c\n", "comparison", "a = b in c"),
        ("a = b and c\n", "and, or", "a = b or c"),
        ("a = -b\n", "sign", "a = b"),
        ("a = 3\n", "constant", "a = 4"),
        ("a = 0.25\n", "constant", "a = (-0.25)"),
        ("a = 1e-9\n", "constant", "a = 1e-06"),
        ("a = b[:, -1]\n", "index", "a = b[:, 0]"),
        ("a = b[1:]\n", "slice", "a = b[:]"),
        ("a = b(c, axis=-1)\n", "axis", "a = b(c, axis=(-2))"),
        ("a = b(c, axis=-1)\n", "keyword", "a = b(c)"),
        ("a = b(é, c)\n", "swapped", "a = b(c, é)"),
        ("a = np.maximum(b, c)\n", "twin", "a = np.minimum(b, c)"),
        ("a = b if c else d\n", "condition", "a = b if True else d"),
        ("def f(a=True): ...\n", "default", "def f(a=False): ..."),
        ("def f(a):\n    a = g(a)\n    return a\n", "dropped", "def f(a):\n    pass\n    return a"),
        ("def f(a):\n    a += b\n", "arithmetic", "def f(a):\n    a -= b"),
    ],
)
def test_each_kind_of_fault_is_made(text: str, operator: str, changed: str):
    assert (operator, changed) in edited(text)


def test_a_length_that_numpy_fills_in_does_not_become_another_negative_one():
    assert edited("a = b.reshape(-1, n)\n") == {
        ("constant", "a = b.reshape(1, n)"),
        ("swapped", "a = b.reshape(n, -1)"),
    }


@pytest.mark.parametrize(
    "text",
    [
        '"""At most 3."""\n',
        "__all__ = ['a', 'b']\n",
        "from a import b\n",
        "def f(a: Literal[1, 2]) -> tuple[int, ...]: ...\n",
        "a: dict[str, int | None]\n",
        "@dataclass(frozen=True)\nclass A: ...\n",
        "raise InvalidInput('a must be 1, got ' + str(2))\n",
        "a = warn('at most ' + str(3), stacklevel=2)\n",
        "a = f'{b + 1} of 3'\n",
        "a = b(describe='at most 3')\n",
        "if TYPE_CHECKING:\n    a = 1\n",
        "Kind = Callable[[int], str] | None\n",
        "assert a == 1\n",
    ],
)
def test_what_is_no_behaviour_is_left_out(text: str):
    assert not edited(text)


@pytest.mark.parametrize("file", ["coopenv/wrench/pair/lens.py", "rewards/terms.py"])
def test_every_mutant_is_a_program_that_differs_in_one_span(file: str):
    made = Source(file, (ROOT / file).read_bytes())
    changes = [change for found in places(made) for change in found][::7]
    assert len(changes) > 25
    for change in changes:
        text = change.applied(made.text)
        assert text[: change.start] == made.text[: change.start]
        assert text.endswith(made.text[change.end :])
        if is_another_program(made, change):
            ast.parse(text)
