"""Measures of an evaluation that reports compare: names, units, and which way is better."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of `coopenv.agents.evaluate.Evaluation`."""

    name: str
    label: str
    unit: str
    higher: bool  # whether more is better

    @property
    def title(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


MEASURES: Mapping[str, Measure] = {
    measure.name: measure
    for measure in (
        Measure("success_rate", "success", "", True),
        Measure("success_time", "time", "s", False),
        Measure("relative_cost", "γ", "", False),
        Measure("wasted_cost", "wasted cost", "N", False),
        Measure("internal_force_level", "F_I", "N", False),
        Measure("internal_torque_level", "T_I", "N·m", False),
        Measure("load_imbalance", "imbalance", "", False),
    )
}
SUCCESS, TIME, DISAGREEMENT = "success_rate", "success_time", "wasted_cost"
