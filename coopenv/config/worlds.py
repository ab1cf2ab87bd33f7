"""What is one for all worlds, or one a world."""

from typing import Any

from coopenv.errors import InvalidInput


def each(value: Any) -> tuple[Any, ...]:
    """All that there are, as a tuple, of what `coopenv.config.keywords.one_or_more` read."""
    return value if isinstance(value, tuple) else (value,)


def spread(value: Any, name: str, num_worlds: int) -> tuple[Any, ...]:
    """One for each of ``num_worlds`` worlds, of what `coopenv.config.keywords.one_or_more` read.

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
