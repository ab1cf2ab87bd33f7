"""Tolerances of the structured solver stand in one table, each with its meaning."""

import ast
import re
from pathlib import Path

import coopenv.wrench.structured

FOLDER = Path(coopenv.wrench.structured.__file__).parent
TABLE = FOLDER / "tolerances.py"


def assigned(node):
    return [name.id for name in ast.walk(node.targets[0]) if isinstance(name, ast.Name)]


def constants(file, kind):
    """Names at the top of a module whose values contain such numbers."""
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.Assign):
            values = [n.value for n in ast.walk(node.value) if isinstance(n, ast.Constant)]
            if any(isinstance(value, kind) for value in values):
                yield from assigned(node)


def test_no_other_module_of_the_solver_has_fractions_of_its_own():
    elsewhere = [file for file in FOLDER.glob("*.py") if file != TABLE]
    assert {file.name: list(constants(file, float)) for file in elsewhere} == {
        file.name: [] for file in elsewhere
    }


def test_every_tolerance_is_explained_and_used():
    code = "".join(file.read_text() for file in FOLDER.glob("*.py") if file != TABLE)
    for name in constants(TABLE, float | int):
        assert re.search(rf"\b{name}\b", code), name
    lines = [line for line in TABLE.read_text().splitlines() if re.match(r"[A-Z_, ]+ = ", line)]
    assert [line for line in lines if "  # " not in line] == []
