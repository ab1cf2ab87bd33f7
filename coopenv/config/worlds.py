"""What is one for all worlds, or one a world."""

from collections.abc import Sequence
from typing import Any

from coopenv.config.keywords import built
from coopenv.errors import InvalidInput


def one_or_more(value: Any, name: str, kind: type) -> Any:
    """One of ``kind``, or a sequence of them as a tuple."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not value:
            raise InvalidInput(f"{name} must not be empty, got {value!r}; give one, or one a world")
        return tuple(built(entry, name, kind) for entry in value)
    return built(value, name, kind)


def each(value: Any) -> tuple[Any, ...]:
    """All that there are, as a tuple, of what `one_or_more` read."""
    return value if isinstance(value, tuple) else (value,)


def spread(value: Any, name: str, num_worlds: int) -> tuple[Any, ...]:
    """One for each of ``num_worlds`` worlds, of what `one_or_more` read.

    Raises
    ------
    InvalidInput
        If there are several, but not as many as worlds.
    """
    if not isinstance(value, tuple):
        return (value,) * num_worlds
    if len(value) != num_worlds:
        raise InvalidInput(
            f"{name} must be one, or one for each of the {num_worlds} worlds, got {len(value)}; "
            "repeat or drop entries"
        )
    return value
