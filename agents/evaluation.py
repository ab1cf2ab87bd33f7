"""Evaluations: means over held-out episodes with intervals, their printed table, their files."""

import csv
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from math import isnan, nan, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import Self

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import document, plain, written
from coopenv.info import COST

from .episodes import Episodes

if TYPE_CHECKING:
    from rich.table import Table

NORMAL_95 = 1.959964  # two-sided 95 % quantile of the normal distribution
COLUMNS = (  # of the printed table, with units
    ("success", "%"),
    ("95 %", "%"),
    ("sample", "%"),
    ("time", "s"),
    ("γ", ""),
    ("F_I", "N"),
    ("T_I", "N·m"),
    ("share", "force"),
    ("skew", "0-1"),
)
COST_COLUMN = ("cost", "sum")  # instead of the last, where there is one


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """Means over exactly ``episodes`` held-out episodes, each counted once whatever its length.

    Levels and shares are means over the steps of an episode first.
    """

    policy: str  # what it is called in the table
    episodes: int
    seed: int  # number of the evaluation; see `coopenv.agents.seeds`
    success_rate: float
    success_interval: tuple[float, float]  # 95 %, Wilson
    sampled_success_rate: float  # with sampled actions; NaN for a policy with one way of acting
    sampled_success_interval: tuple[float, float]
    success_time: float  # [s], of the successful episodes; NaN where there is none
    reward: float  # return of an episode, undiscounted, mean over the team
    relative_cost: float  # γ
    wasted_cost: float  # J(h) − J(h_M) [N]
    internal_force_level: float  # F_I [N]
    internal_torque_level: float  # T_I [N·m]
    force_load_share: tuple[float, ...]  # one an agent
    torque_load_share: tuple[float, ...]
    load_imbalance: float  # of force; 0: all carry alike in every step, 1: one carries all
    contact_impulse: float  # [N·s] an episode
    cost: float = nan  # of an episode, undiscounted, mean over the team; NaN without one

    @classmethod
    def of(
        cls,
        seen: Episodes,
        *,
        dt: float,
        policy: str = "",
        seed: int = 0,
        sampled: Episodes | None = None,
    ) -> Self:
        """Summarise episodes of control step ``dt`` [s]; ``sampled``: with sampled actions."""
        rate, interval = success_of(seen)
        sampled_rate, sampled_interval = success_of(sampled) if sampled else (nan, (nan, nan))
        times = dt * seen.length[seen.success]  # [s]
        return cls(
            policy=policy,
            episodes=len(seen.length),
            seed=seed,
            success_rate=rate,
            success_interval=interval,
            sampled_success_rate=sampled_rate,
            sampled_success_interval=sampled_interval,
            success_time=float(times.mean()) if len(times) else nan,
            reward=float(seen.reward.mean()),
            relative_cost=float(seen.relative_cost.mean()),
            wasted_cost=float(seen.wasted_cost.mean()),
            internal_force_level=float(seen.internal_force_level.mean()),
            internal_torque_level=float(seen.internal_torque_level.mean()),
            force_load_share=_defined_means(seen.force_load_share),
            torque_load_share=_defined_means(seen.torque_load_share),
            load_imbalance=_defined_means(seen.load_imbalance[:, None])[0],
            contact_impulse=float(seen.contact_impulse.mean()),
            cost=float(seen.costs[COST].mean()) if COST in seen.costs else nan,
        )

    @classmethod
    def from_dict(cls, given: Any) -> Self:
        """What `plain` wrote.

        Raises
        ------
        InvalidInput
            If it is something else.
        """
        try:
            known = {entry.name: entry for entry in fields(cls)}
            values = {name: _revived(value) for name, value in given.items() if name in known}
            made = cls(**values)
            for name in ("success_rate", "success_time", "relative_cost"):
                float(getattr(made, name))
            low, high = made.success_interval
            if not 0 <= low <= made.success_rate <= high <= 1:
                raise ValueError("success is outside of its interval")
        except (AttributeError, TypeError, ValueError) as error:
            raise InvalidInput(
                f"evaluation must be one as a policy's file has it, got {given!r:.60} ({error}); "
                "copy the file again"
            ) from error
        return made

    def plain(self) -> dict[str, Any]:
        """As JSON can hold it: NaN as None."""
        return plain(self)


def success_of(seen: Episodes) -> tuple[float, tuple[float, float]]:
    """Success rate and its 95 % interval."""
    count, successes = len(seen.length), int(seen.success.sum())
    return successes / count, wilson_interval(successes, count)


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """95 % interval of a success rate (Wilson 1927): honest at 0 and 1, unlike ±1.96 σ."""
    rate, square = successes / count, NORMAL_95**2
    middle = rate + square / (2 * count)
    spread = NORMAL_95 * sqrt(rate * (1 - rate) / count + square / (4 * count**2))
    scale = 1 + square / count
    low, high = (middle - spread) / scale, (middle + spread) / scale
    return low if successes else 0.0, high if successes < count else 1.0


def table(evaluations: Sequence[Evaluation], title: str | None = None) -> "Table":
    """The evaluations as a rich table, one row a policy."""
    try:
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
        from rich.text import Text
    except ImportError as error:
        raise MissingExtra("the table", "train") from error
    made = Table(
        title=title and Text(title, "table.title"),  # brackets and colons in it are no markup
        title_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        padding=0,  # so that names of policies stay whole in 80 letters
    )
    made.add_column("policy", min_width=11, overflow="fold")
    has_cost = any(not isnan(seen.cost) for seen in evaluations)
    for name, unit in (*COLUMNS[:-1], COST_COLUMN if has_cost else COLUMNS[-1]):
        wide = name == "share"  # only the shares of a large team may go on in a second line
        made.add_column(f"{name}\n{unit}", justify="right", no_wrap=not wide, overflow="fold")
    for seen in evaluations:
        low, high = seen.success_interval
        made.add_row(
            Text(seen.policy),
            f"{100 * seen.success_rate:.1f}",
            f"{100 * low:.0f}-{100 * high:.0f}",
            "-" if isnan(seen.sampled_success_rate) else f"{100 * seen.sampled_success_rate:.1f}",
            "-" if seen.success_rate == 0 else f"{seen.success_time:.2f}",
            f"{seen.relative_cost:.3f}",
            f"{seen.internal_force_level:.2f}",
            f"{seen.internal_torque_level:.2f}",
            ":".join(f"{share:.2f}" for share in seen.force_load_share),
            f"{seen.cost:.3g}" if has_cost else f"{seen.load_imbalance:.2f}",
        )
    return made


def save(evaluations: Sequence[Evaluation], path: str | os.PathLike) -> None:
    """Write the evaluations to a ``.json`` or ``.csv`` file (there, one column an agent)."""
    kind = table_format(path)
    with written(path) as part:
        if kind == ".json":
            part.write_text(document(evaluations) + "\n")
            return
        flat = [_flat(asdict(seen)) for seen in evaluations]
        with part.open("w", newline="") as file:
            names = dict.fromkeys(name for row in flat for name in row)  # teams differ in size
            writer = csv.DictWriter(file, list(names))
            writer.writeheader()
            writer.writerows(flat)


def table_format(path: str | os.PathLike) -> str:
    """The suffix of a table's file; raise `InvalidInput` unless `save` writes such a file."""
    kind = Path(path).suffix
    if kind not in (".json", ".csv"):
        raise InvalidInput(f"path must end in .json or .csv, got {os.fspath(path)!r}; rename it")
    return kind


def _defined_means(values: FloatArray) -> tuple[float, ...]:
    """Mean of each column over the rows in which it is not NaN."""
    defined = ~np.isnan(values)
    means = np.nansum(values, axis=0) / np.maximum(defined.sum(axis=0), 1)
    return tuple(np.where(defined.any(axis=0), means, nan).tolist())


def _revived(value: Any) -> Any:
    """What was written as JSON."""
    if isinstance(value, list):
        return tuple(map(_revived, value))
    return nan if value is None else value


def _flat(row: dict) -> dict:
    flat = {}
    for name, value in row.items():
        if isinstance(value, tuple):
            flat.update({f"{name}_{i}": entry for i, entry in enumerate(value)})
        else:
            flat[name] = value
    return flat
