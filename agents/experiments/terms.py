"""Reward terms from tables: the class of a term by its name, and its fields."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from typing import Any

from coopenv import rewards
from coopenv.arrays import number
from coopenv.errors import CoopenvError, InvalidInput, UnknownName, likely
from coopenv.rewards import RewardSum, Term
from coopenv.wrench import Settings

# Name -> class. Shaping by a potential of one's own needs a function, which a file cannot say.
TERMS: Mapping[str, type] = {
    name: kind
    for name, kind in vars(rewards).items()
    if name in rewards.__all__
    and isinstance(kind, type)
    and "weight" in getattr(kind, "__dataclass_fields__", {})
    and "potential" not in getattr(kind, "__dataclass_fields__", {})
}

SMALL: Mapping[str, str] = {
    re.sub(r"(?<!^)(?=[A-Z])", "_", kind).lower(): kind for kind in TERMS
}  # wasted_cost -> WastedCost


def with_terms(reward: RewardSum, tables: Mapping[str, Any]) -> RewardSum:
    """The reward with the terms that tables describe; one of the same name is replaced.

    Parameters
    ----------
    reward
        Of which environment whatsoever.
    tables
        Name of the term -> its table, of which ``kind`` is a name in `TERMS`.

    Raises
    ------
    InvalidInput, UnknownName
        If a kind or a field does not exist, or a value breaks its rule.
    """
    return RewardSum({**reward, **{name: term_of(table) for name, table in tables.items()}})


def term_of(table: Any) -> Term:
    """The term of a table such as ``{kind = "InternalForce", weight = 0.02}``.

    ``settings`` is a table of the fields of `coopenv.wrench.Settings`.
    """
    if isinstance(table, Mapping) and "kind" not in table:
        for name in table:
            if likely(str(name), ("kind",)):
                raise UnknownName("key of a term", name, ("kind",))
    if not isinstance(table, Mapping) or "kind" not in table:
        raise InvalidInput(
            f"term must be a table with a kind, got {table!r}; write "
            '{ kind = "InternalForce", weight = 0.02 }'
        )
    kind = table["kind"]
    if not isinstance(kind, str) or kind not in TERMS:
        raise UnknownName("kind of reward term", kind, TERMS)
    values = {name: value for name, value in table.items() if name != "kind"}
    if isinstance(values.get("settings"), Mapping):
        values["settings"] = _built(Settings, values["settings"], "settings")
    term: Any = _built(TERMS[kind], values, kind)
    number(term.weight, "weight")
    return term


def kind_named(name: str) -> str | None:
    """The name in `TERMS` that is ``name`` in small letters: ``WastedCost`` of ``wasted_cost``."""
    return SMALL.get(name)


def _built(kind: type, values: Mapping[str, Any], what: str) -> Any:
    known = [entry.name for entry in fields(kind)]
    for name in values:
        if name not in known:
            raise UnknownName(f"field of {what}", name, known)
    given = {
        name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
    }
    with _said(what):
        return kind(**given)


@contextmanager
def _said(what: str) -> Iterator[None]:
    """Make an error of ours of whatever a class says against a value of another kind."""
    try:
        yield
    except CoopenvError:
        raise
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{what} must have fields of the kinds that it documents, got another one ({error}); "
            "change it"
        ) from error
