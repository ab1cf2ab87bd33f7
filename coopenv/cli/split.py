"""A split of one wrench: its table, and what there is to say of it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from coopenv.arrays import FloatArray

if TYPE_CHECKING:
    from rich.table import Table

    from coopenv.wrench import Decomposition

COMPONENTS = {
    3: ("fx [N]", "fy [N]", "tz [N·m]"),
    6: ("fx [N]", "fy [N]", "fz [N]", "tx [N·m]", "ty [N·m]", "tz [N·m]"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A split with its costs, and whether it is plausible."""

    split: "Decomposition"  # whose applied wrench, grips and load shares it has
    internal: FloatArray  # (n, 3) or (n, 6), of the split or of one's own [N, N·m]
    torque_weight: float
    include_induced: bool
    manipulation_cost: float  # J(h_M) [N]
    plausible: bool
    residuals: Any  # of balance and eqs. 9-11

    def lines(self) -> Iterator[str]:
        """Costs, shares, and whether it is plausible, for people."""
        split, left, share = self.split, self.residuals, self.split.load_share
        yield (
            f"J(h) = {split.applied_cost:.4g} N, J(h_M) = {self.manipulation_cost:.4g} N (w = "
            f"{self.torque_weight:g}, s = {int(self.include_induced)})"
        )
        yield f"load share: force {_numbers(share.force)}, torque {_numbers(share.torque)}"
        yield (
            f"{'plausible and balanced' if self.plausible else 'NOT plausible'}: off balance by "
            f"{left.balance:.1e} N or N·m, beyond eqs. 9-11 by {left.force:.1e} N, "
            f"{left.induced_torque:.1e} and {left.torque:.1e} N·m"
        )

    def document(self) -> dict[str, Any]:
        """All of it for programs."""
        split, share = self.split, self.split.load_share
        return {
            "grips": split.grips,
            "applied": split.applied,
            "manipulation": split.applied - self.internal,
            "internal": self.internal,
            "torque_weight": self.torque_weight,
            "include_induced": self.include_induced,
            "applied_cost": split.applied_cost,
            "manipulation_cost": self.manipulation_cost,
            "force_load_share": share.force,
            "torque_load_share": share.torque,
            "plausible": self.plausible,
            "residuals": self.residuals,
        }


def judge(
    split: "Decomposition", internal: FloatArray, *, torque_weight: float, include_induced: bool
) -> Judged:
    """A split, its internal wrench as it is or one's own, beside what decides about it."""
    from coopenv.wrench import cost, is_plausible, residuals

    weights: dict[str, Any] = {"torque_weight": torque_weight, "include_induced": include_induced}
    return Judged(
        split=split,
        internal=internal,
        manipulation_cost=float(cost(split.applied - internal, split.grips, **weights)),
        plausible=bool(is_plausible(split.applied, internal, split.grips)),
        residuals=residuals(split.applied, internal, split.grips),
        **weights,
    )


def split_table(applied: FloatArray, internal: FloatArray, title: str) -> "Table":
    """Applied, manipulation and internal wrench of each effector, as a rich table."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), title_justify="left", box=SIMPLE_HEAD, show_edge=False)
    table.add_column("effector", justify="right")
    table.add_column("wrench")
    for name in COMPONENTS[applied.shape[1]]:
        table.add_column(Text(name), justify="right")
    parts = (("applied", applied), ("manipulation", applied - internal), ("internal", internal))
    for i in range(len(applied)):
        for name, wrench in parts:
            cells = [f"{value + 0.0:.4g}" for value in np.round(wrench[i], 12)]
            table.add_row(str(i + 1) if name == "applied" else "", name, *cells)
    return table


def _numbers(values: FloatArray) -> str:
    return "/".join("undefined" if np.isnan(each) else f"{each + 0.0:.3g}" for each in values)
