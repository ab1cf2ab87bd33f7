"""The exceptions coopenv raises; each is also the builtin one would catch."""

from collections.abc import Iterable
from difflib import get_close_matches


class CoopenvError(Exception):
    """Base of all exceptions of this package."""


class InvalidInput(CoopenvError, ValueError):
    """An argument breaks its rule; the message names it, the rule and the remedy."""


class UnknownName(CoopenvError, ValueError):
    """A method, block, preset or keyword that does not exist; the message suggests the nearest."""

    def __init__(self, what: str, name: object, known: Iterable[str]):
        names = sorted(known)
        nearest = get_close_matches(str(name), names, n=1, cutoff=0.5)
        hint = f"did you mean {nearest[0]!r}? " if nearest else ""
        super().__init__(
            f"{what} must be one of the known names, got {name!r}; {hint}known: {', '.join(names)}"
        )


class SolverError(CoopenvError, RuntimeError):
    """A solver stopped without an answer it can vouch for."""


class ResetNeeded(CoopenvError, RuntimeError):
    """A world was stepped before its first reset or after its episode ended."""


class BodyLost(CoopenvError, RuntimeError):
    """A body went through a wall: it moves too far in a substep."""


class MissingExtra(CoopenvError, ImportError):
    """An optional dependency is needed; the message says what to install."""

    def __init__(self, feature: str, extra: str):
        super().__init__(f"{feature} needs an optional package; pip install 'coopenv[{extra}]'")
