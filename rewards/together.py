"""Terms of which each is one number a world: written and added up in one pass over the worlds."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.transition import Transition

from .energy import InternalPower
from .shaping import PotentialShaping, Progress, closeness
from .terms import Contact, RelativeCost, Success, TimeCost, TrackingError, WastedCost, decomposed

_GAIN, _OUTCOME, _CONSTANT, _SCALED, _SCALED_BY_TIME = range(5)  # kinds of rows
_FINITE, _INFINITE, _UNFIT = range(3)  # what came of it


class Row(NamedTuple):
    """What a term does, to the bits of calling it."""

    kind: int
    factor: float  # its weight with its sign; of outcomes and gains, as it is
    discount: float = 1.0  # of gains
    read: Callable[[Transition], FloatArray] | None = None  # number of each world that is scaled


def _gain(term: PotentialShaping) -> Row | None:
    if term.potential is not closeness:
        return None
    return Row(_GAIN, term.weight, term.discount)


def _relative_cost(term: RelativeCost) -> Row:
    return Row(_SCALED, -term.weight, read=lambda step: decomposed(step, term).relative_cost)


def _wasted_cost(term: WastedCost) -> Row:
    factor = -term.weight / term.scale
    return Row(_SCALED, factor, read=lambda step: decomposed(step, term).wasted_cost)


def _internal_power(term: InternalPower) -> Row:
    return Row(_SCALED, -term.weight / term.scale, read=lambda step: step.power.internal)


# By the class itself: one that inherits from it may do something else.
_ROWS: dict[type, Callable[[Any], Row | None]] = {
    Progress: _gain,
    PotentialShaping: _gain,
    Success: lambda term: Row(_OUTCOME, term.weight),
    TimeCost: lambda term: Row(_CONSTANT, -term.weight),
    Contact: lambda term: Row(_SCALED, -term.weight, read=lambda step: step.contact_impulse),
    TrackingError: lambda term: Row(
        _SCALED_BY_TIME, -term.weight, read=lambda step: step.next_state.distance
    ),
    RelativeCost: _relative_cost,
    WastedCost: _wasted_cost,
    InternalPower: _internal_power,
}


class Together:
    """The first terms of a sum, as many as can be written in one pass.

    Parameters
    ----------
    terms
        Of the sum, by name.
    """

    def __init__(self, terms: Mapping[str, Any]):
        rows: list[Row] = []
        for term in terms.values():
            row = _row(term)
            if row is None:
                break
            rows.append(row)
        self.names = tuple(terms)[: len(rows)]
        self._kinds = np.array([row.kind for row in rows], dtype=np.int64)
        self._numbers = np.array(
            [(row.factor, row.discount) for row in rows], dtype=np.float64
        ).reshape(-1, 2)
        self._reads = [(t, row.read) for t, row in enumerate(rows) if row.read is not None]

    def __call__(
        self, transition: Transition
    ) -> tuple[FloatArray, dict[str, FloatArray], bool] | None:
        """Their total ``(world, agent)``, each by name, and whether the total is finite.

        ``None`` where a task measured or judged another number of worlds.
        """
        shape = transition.applied.shape[:2]
        parts: FloatArray = np.empty((len(self.names), *shape))
        total: FloatArray = np.empty(shape)
        for t, read in self._reads:  # as they come, to be scaled in place
            parts[t, :, 0] = read(transition)
        found = _write(
            *sharing_rows(shape[0]), self._kinds, self._numbers, transition.state.distance,
            transition.next_state.distance, transition.success, transition.terminated,
            transition.dt, parts, total,
        )  # fmt: skip
        if found == _UNFIT:
            return None
        return total, dict(zip(self.names, parts, strict=True)), found == _FINITE


def _row(term: Any) -> Row | None:
    made = _ROWS.get(type(term))
    plain = all(
        type(getattr(term, name, 1.0)) in (float, int) for name in ("weight", "discount", "scale")
    )  # products of NumPy's numbers round otherwise
    return made(term) if made is not None and plain else None


@compiled
def _write(board, parts, kinds, numbers, before, after, success, terminated, dt, terms, total):
    """Write ``terms`` ``(term, world, agent)`` and their sum, from zero on and in order.

    What is to be scaled is in ``terms`` already, at agent 0.
    """
    count = len(total)
    fit = len(before) == count and len(after) == count
    if not (fit and len(success) == count and len(terminated) == count):
        return _UNFIT
    arguments = (kinds, numbers, before, after, success, terminated, dt, terms, total)
    spread(board, parts, count, _write_part, arguments)
    finite = True
    for k in range(count):
        for i in range(total.shape[1]):
            finite &= np.isfinite(total[k, i])
    return _FINITE if finite else _INFINITE


@compiled
def _write_part(start, stop, kinds, numbers, before, after, success, terminated, dt, parts, total):
    num_agents = total.shape[1]
    for k in range(start, stop):
        for i in range(num_agents):
            total[k, i] = 0.0
        for t in range(len(kinds)):
            kind, factor, value = kinds[t], numbers[t, 0], 0.0
            if kind == _GAIN:
                later = 0.0 if success[k] else numbers[t, 1] * -after[k]
                value = factor * (later - -before[k])
            elif kind == _OUTCOME:
                if success[k]:
                    value = factor
                elif terminated[k]:
                    value = -factor
            elif kind == _CONSTANT:
                value = factor * dt
            elif kind == _SCALED:
                value = factor * parts[t, k, 0]
            else:
                value = factor * dt * parts[t, k, 0]
            for i in range(num_agents):
                parts[t, k, i] = value
                total[k, i] += value
