"""The key of a table that an error is about."""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from coopenv.errors import CoopenvError

from .lines import Place


def culprit(check: Callable[[Any], object], value: Any, error: CoopenvError) -> Place:
    """Keys, from a table down, of what made a check of it fail; none where it is all of it.

    A key or a text that the error quotes is it, else what the check does without, the deepest
    first, else a key that the error names.
    """
    places = sorted(_places(value), key=lambda found: -len(found[0]))
    said = str(error)
    quoted = [
        place
        for place, inside in places
        if f"got {place[-1]!r}" in said or (isinstance(inside, str) and f"got {inside!r}" in said)
    ]
    if quoted:
        return quoted[0]
    for place, _ in places:
        try:
            check(_without(value, place))
        except CoopenvError:
            continue
        return place
    named = [place for place, _ in places if re.search(rf"\b{re.escape(str(place[-1]))}\b", said)]
    return named[0] if named else ()


def _places(value: Any, above: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Every key in nested tables, with what it stands for."""
    if isinstance(value, Mapping):
        for key, inside in value.items():
            yield (*above, key), inside
            yield from _places(inside, (*above, key))


def _without(value: Any, place: Place) -> Any:
    """Nested tables without one key."""
    key, rest = place[0], place[1:]
    if not rest:
        return {name: inside for name, inside in value.items() if name != key}
    return {**value, key: _without(value[key], rest)}
