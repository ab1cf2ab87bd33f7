"""Values of a file of options, checked against the types of the options that they stand for."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from coopenv.config.hints import as_float
from coopenv.errors import InvalidInput, UnknownName

WORDS: Mapping[type, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a text",
    Path: "the name of a place",
    NoneType: "nothing",
}
REMEDIES: Mapping[type, str] = {
    bool: "write one of them",
    int: "write one",
    float: "write one",
    str: "put it in quotes",
    Path: "put it in quotes",
}


def converted(value: Any, kind: Any, name: str) -> Any:
    """A value as its option has it.

    Parameters
    ----------
    value
        Of TOML or JSON.
    kind
        Type of the option.
    name
        Of the option, for errors.

    Raises
    ------
    InvalidInput, UnknownName
        If the value is of another type, or none of those that are known.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return converted(value, parts[0], name)
    if origin in (Union, UnionType):
        return _of_one(value, parts, name)
    if origin is Literal:
        if value not in parts:
            raise UnknownName(name, value, [str(each) for each in parts])
        return value
    if origin is tuple:
        return _sequence(value, parts, name)
    if not _is_of(value, kind):
        remedy = REMEDIES.get(kind, "leave it out")
        raise InvalidInput(f"{name} must be {WORDS[kind]}, got {value!r}; {remedy}")
    if kind is float:
        return as_float(value, name)
    return Path(value) if kind is Path else value


def _is_of(value: Any, kind: type) -> bool:
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, str if kind is Path else kind)


def _of_one(value: Any, kinds: Sequence[Any], name: str) -> Any:
    """As the first of several types that it is of; the error of the first where it is of none."""
    if value is None and NoneType in kinds:
        return None
    first: InvalidInput | UnknownName | None = None
    for kind in kinds:
        try:
            return converted(value, kind, name)
        except (InvalidInput, UnknownName) as error:
            first = first or error
    assert first is not None
    raise first


def _sequence(value: Any, parts: Sequence[Any], name: str) -> tuple[Any, ...]:
    endless = len(parts) == 2 and parts[1] is Ellipsis
    if not isinstance(value, list) or not (endless or len(value) == len(parts)):
        count = "" if endless else f" of {len(parts)}"
        raise InvalidInput(f"{name} must be a list{count}, got {value!r}; write it in brackets")
    kinds = [parts[0]] * len(value) if endless else parts
    return tuple(converted(each, kind, name) for each, kind in zip(value, kinds, strict=True))
