"""Evaluations of the package's policies against those that their files say."""

from collections.abc import Mapping

from ..evaluation import Evaluation
from .catalogue import row_of
from .naming import is_name


def told(seen: Mapping[str, Evaluation]) -> list[str]:
    """Lines on which of the policies succeed as their rows say, by name; none without a row.

    A success rate agrees with a row if one of the two is in the 95 % interval of the other: the
    same episodes give the same rate, fewer ones a wider interval.
    """
    rows = {name: row for name in seen if is_name(name) and (row := row_of(name)) is not None}
    others = [name for name, row in rows.items() if not agree(seen[name], row)]
    if not rows:
        return []
    lines = [f"{len(rows) - len(others)} of {len(rows)} succeed as their files say"]
    return lines + [
        f"{name}: {_said(seen[name])}, its file says {_said(rows[name])}" for name in others
    ]


def agree(one: Evaluation, other: Evaluation) -> bool:
    """Whether one of two success rates is in the interval of the other."""
    return _holds(one, other.success_rate) or _holds(other, one.success_rate)


def _holds(seen: Evaluation, rate: float) -> bool:
    low, high = seen.success_interval
    return low <= rate <= high


def _said(seen: Evaluation) -> str:
    low, high = seen.success_interval
    return f"{100 * seen.success_rate:.1f} % ({100 * low:.1f} to {100 * high:.1f})"
