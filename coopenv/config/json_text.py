"""Strict JSON text, laid out for people, and its reading."""

import json
from typing import Any

from coopenv.errors import InvalidInput

_WIDTH = 100  # characters of a line


def text_of(value: Any) -> str:
    """JSON text for people: what fits on a line is on one."""
    return _laid_out(value, 0, 0) + "\n"


def _laid_out(value: Any, depth: int, used: int) -> str:
    line = json.dumps(value, ensure_ascii=False, allow_nan=False)
    if not isinstance(value, dict | list) or not value or (depth and used + len(line) < _WIDTH):
        return line
    inner, outer = "\n" + "  " * (depth + 1), "\n" + "  " * depth
    if isinstance(value, list):
        parts = [_laid_out(item, depth + 1, 2 * (depth + 1)) for item in value]
        return f"[{inner}{f',{inner}'.join(parts)}{outer}]"
    parts = []
    for name, item in value.items():
        key = json.dumps(name, ensure_ascii=False) + ": "
        parts.append(key + _laid_out(item, depth + 1, 2 * (depth + 1) + len(key)))
    return f"{{{inner}{f',{inner}'.join(parts)}{outer}}}"


def parsed(text: Any) -> dict[str, Any]:
    """The object that a JSON text holds; raises `InvalidInput` where it is not strictly one."""
    try:
        if not isinstance(text, str):
            raise TypeError(f"text is needed, not {type(text).__name__}")
        value = json.loads(text, object_pairs_hook=_each_once, parse_constant=_no_constant)
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidInput(
            f"text must be JSON of a configuration, got none: {error}; pass what to_json returned"
        ) from error
    if not isinstance(value, dict):
        raise InvalidInput(f"text must hold an object, got {value!r}; pass what to_json returned")
    return value


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    given = dict(pairs)
    if len(given) < len(pairs):
        raise ValueError(f"a name comes twice in {[name for name, _ in pairs]}")
    return given


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")
