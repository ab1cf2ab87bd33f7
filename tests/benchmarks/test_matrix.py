"""What the matrix pins: floors of pyproject.toml, versions of constraints.txt, the page's table."""

import json
import re

import pytest

pytest.importorskip("tyro")

from benchmarks.matrix import CORNERS, PINS, ROOT, SHOWN, VIEWS, WRENCH, interpreter, pins, row
from coopenv.files import toml
from tests.helpers import CASE_NAMES

PROJECT = toml.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FLOOR = re.compile(r"([\w.-]+)>=([\d.]+)")


def of_constraints() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return {name.lower(): version for name, _, version in (line.partition("==") for line in lines)}


def found(requirement: str) -> tuple[str, ...]:
    match = FLOOR.match(requirement)
    assert match is not None
    return match.groups()


def test_every_corner_has_its_pins_and_no_others_have():
    assert {path.stem for path in PINS.glob("*.txt")} == set(CORNERS)


@pytest.mark.parametrize("requirement", PROJECT["dependencies"])
def test_every_floor_is_what_the_oldest_corner_has(requirement):
    name, floor = found(requirement)
    version = pins("oldest")[name]
    assert version == floor or re.fullmatch(r"(\.0)+", version.removeprefix(floor))


def test_the_oldest_python_is_the_one_that_pyproject_asks_for():
    assert PROJECT["requires-python"] == f">={CORNERS['oldest'].python}"
    assert CORNERS["wrench"].python == CORNERS["oldest"].python


def test_the_newest_corner_has_the_versions_of_our_own_set_up():
    wanted = of_constraints()
    assert {name: pins("newest")[name] for name in SHOWN} == {name: wanted[name] for name in SHOWN}


def test_the_corner_of_wrenches_has_nothing_that_simulates():
    assert not {"gymnasium", "pettingzoo", "pymunk"} & set(pins("wrench"))


@pytest.mark.parametrize("test", [*WRENCH, *VIEWS])
def test_what_a_corner_runs_is_there(test):
    path, _, name = test.partition("::")
    function, _, case = name.rstrip("]").partition("[")
    assert f"def {function}" in (ROOT / path).read_text(encoding="utf-8")
    assert not case or case in CASE_NAMES


def test_the_page_shows_the_pins_of_every_corner(tmp_path):
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    table = page.split("<!-- matrix -->")[1]  # else: python -m benchmarks.matrix --write
    for name in CORNERS:
        assert f"| {' | '.join(row(name, tmp_path)[:-1])} | " in table


def test_a_result_counts_as_long_as_the_pins_are_those_it_came_from(tmp_path):
    result = tmp_path / "result.json"
    result.write_text(json.dumps({"pins": pins("oldest"), "told": "7 passed"}))
    assert row("oldest", tmp_path)[-1] == "7 passed"
    assert row("newest", tmp_path)[-1] == "not run"


def test_an_interpreter_that_is_not_at_hand_is_none():
    assert interpreter("2.99") is None
