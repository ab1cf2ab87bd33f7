"""Snapshot: the state of worlds between two steps, kept outside the core that steps them."""

import pickle
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import IntArray, plain_array
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput

Rows: TypeAlias = Any  # dicts of rows, down to arrays and lists with one entry a world

VERSION = 4  # of what a snapshot holds; another one is refused


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Snapshot:
    """All that decides how some worlds go on, as `coopenv.Transport.get_state` hands it out.

    It shares no memory with a core and no core changes it, so it may be put back as often as is
    wanted, into worlds of any core of an equal configuration. Pickles and copies are as good as it
    is. ``len(snapshot)`` is how many worlds it is of. `docs/state.md` says what comes back to
    the bit.

    Attributes
    ----------
    config
        Of the core it was taken from: ``Transport(num_worlds=..., config=snapshot.config)`` makes
        another that takes it.
    version
        Of the form of ``parts``.
    parts
        What is remembered: dicts, down to arrays and lists with one entry a world. Which there are
        may change with the version.
    """

    config: TransportConfig
    version: int
    parts: dict[str, Rows]

    def __len__(self) -> int:
        return len(self.parts["obs"])

    def __repr__(self) -> str:
        return f"<Snapshot of {len(self)} worlds, version {self.version}>"

    def take(self, worlds: Sequence[int] | IntArray) -> "Snapshot":
        """Only these of its worlds, in this order; one may be taken several times.

        Raises
        ------
        InvalidInput
            If it has no world of that number.
        """
        chosen = chosen_worlds(worlds, len(self))
        return replace(self, parts=take_rows(self.parts, chosen))

    def with_part(self, name: str, rows: Rows) -> "Snapshot":
        """A copy with something more to remember, one row a world."""
        return replace(self, parts={**self.parts, name: rows})

    def part_for(self, name: str, num_worlds: int) -> Rows | None:
        """What a view remembers under ``name`` as so many worlds are to; ``None`` if nothing.

        That of a single world is repeated for all of them.
        """
        rows = self.parts.get(name)
        if rows is None or len(self) == num_worlds:
            return rows
        return take_rows(rows, np.zeros(num_worlds, dtype=np.int64))


def fitting(
    state: Any, config: TransportConfig, worlds: IntArray
) -> tuple[IntArray, dict[str, Rows]]:
    """The worlds in ascending order, and a copy of what each is to remember, in the same order.

    A state of one world is repeated for all of them.

    Raises
    ------
    InvalidInput
        If it is no snapshot, of another version or configuration, or of another number of worlds.
    """
    if not isinstance(state, Snapshot):
        raise InvalidInput(
            f"state must be what get_state returned, got a {type(state).__name__}; pass that object"
        )
    if state.version != VERSION:
        raise InvalidInput(
            f"state must be of version {VERSION}, got {state.version}; go on from it with the "
            "coopenv that took it"
        )
    other = differing_fields(state.config, config)
    if other:
        raise InvalidInput(
            "state must be of a core with the same configuration, got one with another "
            f"{', '.join(other)}; make a core by Transport(config=state.config)"
        )
    if len(state) not in (1, len(worlds)):
        raise InvalidInput(
            f"state must be of 1 or {len(worlds)} worlds, as many as it is put into, got "
            f"{len(state)}; take some of them with state.take, or name other worlds"
        )
    order = np.argsort(worlds)
    source = order if len(state) == len(worlds) else np.zeros_like(order)
    return worlds[order], take_rows(state.parts, source)


def differing_fields(one: TransportConfig, other: TransportConfig) -> list[str]:
    """Names of the fields in which two configurations differ.

    Objects of a user's class that compares by identity are the same if their pickles are.
    """
    names = [entry.name for entry in fields(one)]
    return [name for name in names if not _alike(getattr(one, name), getattr(other, name))]


def _alike(one: Any, other: Any) -> bool:
    if one is other:
        return True
    try:
        if one == other:
            return True
    except ValueError:  # arrays inside, of which no single truth is known
        pass
    try:
        return pickle.dumps(one) == pickle.dumps(other)
    except (pickle.PicklingError, AttributeError, TypeError):
        return False


def chosen_worlds(
    worlds: Sequence[int] | IntArray | None, num_worlds: int, *, different: bool = False
) -> IntArray:
    """Numbers of worlds, all of them for ``None``.

    Raises
    ------
    InvalidInput
        If they are none, or no numbers of worlds, or must be ``different`` and are not.
    """
    if worlds is None:
        return np.arange(num_worlds)
    try:
        given = plain_array(worlds, "worlds")
    except InvalidInput:  # told below, with what is wanted here
        given = np.empty(0)
    known = given.ndim == 1 and len(given) > 0 and given.dtype.kind in "iu"
    if known and given.min() >= 0 and given.max() < num_worlds:
        chosen = given.astype(np.int64)
        if not different or len(np.unique(chosen)) == len(chosen):
            return chosen
    rule = "different whole numbers" if different else "whole numbers"
    raise InvalidInput(
        f"worlds must be {rule} from 0 to {num_worlds - 1}, at least one, got {worlds!r}; "
        "of a mask give np.flatnonzero(mask)"
    )


def take_rows(rows: Rows, worlds: IntArray) -> Rows:
    """A copy of rows of the given worlds."""
    if isinstance(rows, dict):
        return {name: take_rows(entry, worlds) for name, entry in rows.items()}
    if isinstance(rows, np.ndarray):
        return rows[worlds]
    return [rows[k] for k in worlds.tolist()]


def check_rows(rows: Rows, num_worlds: int, name: str) -> None:
    """Raise `InvalidInput` unless arrays and lists of one entry a world, or dicts of such."""
    if isinstance(rows, dict):
        for key, entry in rows.items():
            check_rows(entry, num_worlds, f"{name}[{key!r}]")
        return
    if isinstance(rows, list | np.ndarray) and _count(rows) == num_worlds:
        return
    raise InvalidInput(
        f"{name} must be an array or a list of {num_worlds} entries, one a world, or a dict of "
        f"such, got {rows!r}; keep arrays (world, ...) and return rows of them"
    )


def generator_states(
    generators: Sequence[np.random.Generator | None], worlds: IntArray
) -> list[dict[str, Any]]:
    """What the generators of ``worlds`` draw next, as `put_generators` takes it."""
    states = []
    for k in worlds.tolist():
        generator = generators[k]
        assert generator is not None
        states.append(dict(generator.bit_generator.state))
    return states


def put_generators(
    generators: list[np.random.Generator | None],
    states: Sequence[dict[str, Any]],
    worlds: IntArray,
) -> None:
    """Let the generators of ``worlds`` go on from ``states``: the same objects, where they can."""
    for k, state in zip(worlds.tolist(), states, strict=True):
        generator, kind = generators[k], state["bit_generator"]
        if generator is None or type(generator.bit_generator).__name__ != kind:
            generators[k] = generator = np.random.Generator(getattr(np.random, kind)())
        generator.bit_generator.state = state  # pyright: ignore[reportAttributeAccessIssue]


def _count(rows: list[Any] | npt.NDArray[Any]) -> int:
    return len(rows) if isinstance(rows, list) or rows.ndim else -1
