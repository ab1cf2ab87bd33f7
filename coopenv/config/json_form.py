"""JSON of a configuration's parts: objects to plain values, and back.

An object is ``{"kind": its public name, field: value, …}`` with all its fields, a tuple an array.
What is no coopenv class has ``module:name`` for its kind, the hash of its source and its fields.
A field of a coopenv class that is called ``trust`` is never written: the reader says it.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, is_dataclass
from inspect import signature
from math import isfinite
from typing import Any

import numpy as np

from coopenv.config.hints import fitted, leaves_of
from coopenv.config.kinds import FUNCTIONS, SUM, find_kind, kind_name
from coopenv.config.own_code import Trust, frozen, read_name, written_name
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.observation import BLOCKS, Block, RangeReading, ranges
from coopenv.rewards import RewardSum

_NOT_FINITE = ("inf", "-inf")
_TRUST = "trust"  # field of a kind


def written(value: Any, part: str) -> Any:
    """``value`` as JSON has it; ``part`` is its name for errors.

    Raises
    ------
    InvalidInput
        If it, or something in it, cannot be written.
    """
    if value is None or type(value) in (bool, int, str):
        return value
    if isinstance(value, np.bool_ | np.integer | np.str_):
        return value.item()
    if isinstance(value, float) and not np.isnan(value):
        number = float(value)
        return number if isfinite(number) else {"kind": "float", "value": str(number)}
    if type(value) is tuple or type(value) is list:
        items = [written(item, f"{part}[{k}]") for k, item in enumerate(value)]
        return items if type(value) is tuple else {"kind": "list", "items": items}
    if type(value) is RewardSum:
        terms = [{"name": name, "term": written(value[name], f"{part}.{name}")} for name in value]
        return {"kind": SUM, "terms": terms}
    if type(value) is Block:
        return _written_block(value, part)
    if is_dataclass(value) and not isinstance(value, type):
        return _written_fields(value, part)
    if callable(value) and not isinstance(value, type):
        ours = next((name for name, known in FUNCTIONS.items() if known is value), None)
        named = {"name": ours} if ours else written_name(value, part)
        return {"kind": "function", **named}
    raise InvalidInput(
        f"{part} must be made of numbers, text, tuples, functions and frozen dataclasses to be "
        f"written, got {value!r}; put it into one of these, numbers as Python's own"
    )


def _written_block(block: Block, part: str) -> Any:
    """The call of `ranges` that makes it, the name of one of our others, else all its fields."""
    read = block.read
    if isinstance(read, RangeReading) and ranges(**asdict(read), name=block.name) == block:
        ours = {name: written(value, part) for name, value in asdict(read).items()}
        return {"kind": "coopenv.observation.ranges", **ours, "name": block.name}
    return block.name if block == BLOCKS.get(block.name) else _written_fields(block, part)


def _written_fields(value: Any, part: str) -> dict[str, Any]:
    ours = kind_name(type(value))
    given = {entry.name: getattr(value, entry.name) for entry in fields(value) if entry.init}
    if ours:
        leaves = leaves_of(type(value))
        given.pop(_TRUST, None)
        given = {name: fitted(v, leaves[name], f"{part}.{name}") for name, v in given.items()}
    inside = {name: written(item, f"{part}.{name}") for name, item in given.items()}
    if ours:
        return {"kind": ours, **inside}
    named = written_name(frozen(type(value), part), part)
    return {"kind": named["name"], "sha256": named["sha256"], "fields": inside}


def read(value: Any, part: str, trust: Trust) -> Any:
    """What `written` wrote; ``part`` is its name for errors.

    Raises
    ------
    InvalidInput, UnknownName
        If a kind or field is not known, a value does not fit, or code is not trusted.
    """
    if isinstance(value, list):
        return tuple(read(item, f"{part}[{k}]", trust) for k, item in enumerate(value))
    if isinstance(value, float) and not isfinite(value):
        raise InvalidInput(f"{part} must be finite, got {value}; write an ordinary number")
    if not isinstance(value, dict):
        return value
    kind = value.get("kind")
    if not isinstance(kind, str):
        raise InvalidInput(f"{part} must say its kind, got {value!r}; add for example {_EXAMPLE}")
    rest = {name: item for name, item in value.items() if name != "kind"}
    if kind in _READERS:
        return _READERS[kind](rest, part, trust)
    if ":" in kind:
        return _read_own(kind, rest, part, trust)
    maker = find_kind(kind, f"kind of {part}")
    known = list(signature(maker).parameters)
    given = _values(rest, [name for name in known if name != _TRUST], part, trust)
    leaves = leaves_of(maker)
    fitting = {name: fitted(v, leaves[name], f"{part}.{name}") for name, v in given.items()}
    if _TRUST in known:
        fitting[_TRUST] = trust is True
    return _made(maker, fitting, part)


_EXAMPLE = '"kind": "coopenv.Body"'


def _read_own(kind: str, rest: dict[str, Any], part: str, trust: Trust) -> Any:
    digest, inside = _exactly(rest, ("sha256", "fields"), part)
    cls = frozen(read_name(kind, digest, part, trust), part)
    known = [entry.name for entry in fields(cls) if entry.init]
    return _made(cls, _values(inside, known, part, trust), part)


def _read_sum(rest: dict[str, Any], part: str, trust: Trust) -> RewardSum:
    (entries,) = _exactly(rest, ("terms",), part)
    terms = {}
    for k, entry in enumerate(entries if isinstance(entries, list) else [entries]):
        name, term = _exactly(entry, ("name", "term"), f"{part}.terms[{k}]")
        if not isinstance(name, str) or name in terms:
            raise InvalidInput(f"{part} must name each term once, got {name!r}; mend that name")
        terms[name] = read(term, f"{part}.{name}", trust)
    return RewardSum(terms)


def _read_function(rest: dict[str, Any], part: str, trust: Trust) -> Any:
    name = rest.get("name")
    if not isinstance(name, str) or ":" not in name:
        _exactly(rest, ("name",), part)
        if not isinstance(name, str) or name not in FUNCTIONS:
            raise UnknownName(f"function of {part}", name, FUNCTIONS)
        return FUNCTIONS[name]
    _, digest = _exactly(rest, ("name", "sha256"), part)
    found = read_name(name, digest, part, trust)
    if not callable(found) or isinstance(found, type):
        raise InvalidInput(f"{part} must be a function, got {found!r}; mend the name in the text")
    return found


def _read_list(rest: dict[str, Any], part: str, trust: Trust) -> list[Any]:
    (items,) = _exactly(rest, ("items",), part)
    if not isinstance(items, list):
        raise InvalidInput(f"items of {part} must be an array, got {items!r}; put [ ] round it")
    return list(read(items, part, trust))


def _read_float(rest: dict[str, Any], part: str, trust: Trust) -> float:
    (value,) = _exactly(rest, ("value",), part)
    if value not in _NOT_FINITE:
        raise UnknownName(f"value of {part}", value, _NOT_FINITE)
    return float(value)


_READERS: dict[str, Callable[[dict[str, Any], str, Trust], Any]] = {
    SUM: _read_sum,
    "function": _read_function,
    "list": _read_list,
    "float": _read_float,
}


def _exactly(given: Any, known: tuple[str, ...], part: str) -> list[Any]:
    if not isinstance(given, dict) or set(given) != set(known):
        raise InvalidInput(
            f"{part} must have exactly {', '.join(known)} beside its kind, got {given!r}; mend it"
        )
    return [given[name] for name in known]


def _values(given: Any, known: list[str], part: str, trust: Trust) -> dict[str, Any]:
    if not isinstance(given, dict):
        raise InvalidInput(f"fields of {part} must be an object, got {given!r}; write {{}}")
    for name in given:
        if name not in known:
            raise UnknownName(f"field of {part}", name, known)
    return {name: read(item, f"{part}.{name}", trust) for name, item in given.items()}


def _made(maker: Callable[..., Any], given: Mapping[str, Any], part: str) -> Any:
    try:
        return maker(**given)
    except CoopenvError:
        raise
    except Exception as error:
        raise InvalidInput(
            f"{part} must be what {maker.__qualname__} takes, got {dict(given)!r}: "
            f"{error}; change it"
        ) from error


def shown(value: Any, part: str) -> Any:
    """A keyword's value as JSON has it, for `revived`; what has code from elsewhere stays as it is.

    Mappings and sequences are the forms in which users, too, give objects.
    """
    if isinstance(value, Mapping) and not isinstance(value, RewardSum):
        return {name: shown(item, f"{part}.{name}") for name, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [shown(item, part) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    try:
        found = written(value, part)
        read(found, part, trust=False)
        return found
    except CoopenvError:
        return value


def revived(value: Any, part: str) -> Any:
    """A keyword's value, in which JSON may have left objects of this package that say their kind.

    Anything else stays as it is, so code from elsewhere is never imported.
    """
    if isinstance(value, dict):
        if isinstance(value.get("kind"), str):
            return read(value, part, trust=False)
        return {name: revived(item, f"{part}.{name}") for name, item in value.items()}
    if type(value) in (list, tuple):
        return type(value)(revived(item, part) for item in value)
    return value
