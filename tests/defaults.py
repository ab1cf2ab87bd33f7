"""Every default and every constant of the package, one a line, as the running code has them.

python -m tests.defaults    # writes tests/defaults.txt anew: read the difference before you keep it
"""

import ast
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
TABLE = Path(__file__).with_suffix(".txt")
CONSTANT = re.compile(r"_?[A-Z][A-Z0-9_]*")
PROSE = 4  # spaces in a text from which on it is for reading, and may change as it likes
FEW = 24  # numbers in an array that is written out
ELSEWHERE = {  # filled while the program runs, or of the system or of a library
    "coopenv.agents.learned.plain.CLASSES", "coopenv.compiled.dependencies.ANYWHERE",
    "coopenv.compiled.dependencies.KERNELS", "coopenv.compiled.dependencies._PACKAGES",
    "coopenv.envs.registry._REGISTERED", "coopenv.files.ending._DUE",
    "coopenv.files.lock._HELD", "coopenv.files.lock._OPEN", "coopenv.files.temporary.NO_LINKS",
}  # fmt: skip
BESIDE = (  # of libraries that do not go with our pins
    "coopenv.agents.rllib.environment", "coopenv.agents.torchrl.benchmarl",
)  # fmt: skip


def modules() -> list[str]:
    """Names of all modules that can be imported, those of agents and rewards as of coopenv's."""
    found = []
    for folder, prefix in (("coopenv", ""), ("agents", "coopenv."), ("rewards", "coopenv.")):
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            if parts[:2] not in (("coopenv", "agents"), ("coopenv", "rewards")):
                found.append(prefix + ".".join(parts).removesuffix(".__init__"))
    return sorted(each for each in found if not each.endswith("__main__") and each not in BESIDE)


def defaults(name: str) -> dict[str, str]:
    """What a module sets: constants, and defaults of its classes and functions, as text."""
    module = import_module(name)
    tree = ast.parse(inspect.getsource(module))
    found: dict[str, str] = {}
    for node in tree.body:
        for target in _targets(node):
            value = getattr(module, target, None)
            if CONSTANT.fullmatch(target) and f"{name}.{target}" not in ELSEWHERE:
                found[target] = text(value)
        if isinstance(node, ast.ClassDef):
            found |= _of_class(node, getattr(module, node.name))
        elif isinstance(node, ast.FunctionDef):
            found |= _of_function(node.name, vars(module).get(node.name))
    return found


def text(value: Any) -> str:
    """A value as it could be written, the same on every machine."""
    match value:
        case Enum():
            return str(value)
        case str() if value.count(" ") >= PROSE:
            return "prose"
        case None | bool() | int() | float() | str() | bytes() | slice():
            return repr(value)
        case np.generic():
            return f"{type(value).__name__}({value.item()!r})"
        case np.ndarray() if value.size > FEW:
            return f"array of shape {value.shape}"
        case np.ndarray():
            return f"array({np.char.mod('%.12g', value).tolist()})"
        case re.Pattern():
            return f"pattern({value.pattern!r})"
        case Path():
            return f"Path({str(value).replace(str(ROOT), '.')!r})"
        case tuple() | list():
            return f"{type(value).__name__}({', '.join(map(text, value))})"
        case set() | frozenset():
            return f"{type(value).__name__}({', '.join(sorted(map(text, value)))})"
        case Mapping():
            pairs = (f"{text(key)}: {text(each)}" for key, each in value.items())
            return f"{type(value).__name__}({', '.join(pairs)})"
        case ModuleType():
            return value.__name__
    if is_dataclass(value) and not isinstance(value, type):
        given = (f"{each.name}={text(getattr(value, each.name))}" for each in fields(value))
        return f"{type(value).__name__}({', '.join(given)})"
    if hasattr(value, "__qualname__"):
        return f"{value.__module__}.{value.__qualname__}"
    return f"<{type(value).__name__}>"


def table() -> str:
    """All modules that set something, a heading each and a line a default."""
    parts = ((name, defaults(name)) for name in modules())
    return "\n".join(section(name, found) for name, found in parts if found)


def section(name: str, found: Mapping[str, str]) -> str:
    """The lines of one module."""
    return "\n".join((f"[{name}]", *(f"{key} = {value}" for key, value in found.items()), ""))


def _targets(node: ast.stmt) -> list[str]:
    """Names that a statement assigns, each of a tuple's too."""
    if isinstance(node, ast.AnnAssign) and node.value is not None:
        return [node.target.id] if isinstance(node.target, ast.Name) else []
    if isinstance(node, ast.Assign):
        return [each.id for target in node.targets for each in ast.walk(target)
                if isinstance(each, ast.Name)]  # fmt: skip
    return []


def _of_class(node: ast.ClassDef, kind: type) -> dict[str, str]:
    found: dict[str, str] = {}
    if is_dataclass(kind):
        for field in fields(kind):
            made = field.default_factory() if field.default_factory is not MISSING else MISSING
            value = made if field.default is MISSING else field.default
            if value is not MISSING and field.init:
                found[f"{node.name}.{field.name}"] = text(value)
    else:
        found |= {
            f"{node.name}.{target}": text(value)
            for statement in node.body
            for target in _targets(statement)
            if not callable(value := _class_value(kind, target)) and target != "__slots__"
        }
    for each in node.body:
        if isinstance(each, ast.FunctionDef):
            found |= _of_function(f"{node.name}.{each.name}", vars(kind).get(each.name))
    return found


def _class_value(kind: type, name: str) -> Any:
    if name in getattr(kind, "_field_defaults", {}):
        return kind._field_defaults[name]  # pyright: ignore[reportAttributeAccessIssue]
    return vars(kind).get(name)


def _of_function(name: str, function: Any) -> dict[str, str]:
    return {f"{name}({key})": text(value) for key, value in _parameters(function)}


def _parameters(function: Any) -> Iterator[tuple[str, Any]]:
    function = getattr(function, "__func__", function)  # of a class method
    function = getattr(function, "py_func", function)  # of a compiled one
    if not inspect.isfunction(function):
        return
    for parameter in inspect.signature(function).parameters.values():
        if parameter.default is not parameter.empty:
            yield parameter.name, parameter.default


if __name__ == "__main__":
    TABLE.write_text(table(), encoding="utf-8")
