"""What is told of a recording that was compared with its motion, in lines."""

from dataclasses import dataclass

import numpy as np

from coopenv.logs.consistency.check import Consistency


@dataclass(frozen=True, slots=True, kw_only=True)
class Checked:
    """Result of `coopenv.logs.check_file`."""

    rows: int
    bad_rows: int
    assumed: tuple[str, ...]  # frames, signs, units and grips, as declared or by default
    done: tuple[str, ...]  # corrections
    consistency: Consistency  # whether that goes with how the object moved
    notes: tuple[str, ...] = ()  # what reading the file met: equal times, rows joined, gaps filled

    def lines(self) -> list[str]:
        """It in words."""
        bad = f", {self.bad_rows:,} of them bad" if self.bad_rows else ""
        lines = [f"{self.rows:,} rows{bad}"]
        lines += [*self.notes, *(f"assumed {line}" for line in self.assumed)]
        lines += [f"corrected {line}" for line in self.done]
        return lines + motion_lines(self.consistency)


def motion_lines(consistency: Consistency) -> list[str]:
    """How well what was assumed explains the motion, and warnings where it does not."""
    lines = [_motion(consistency)]
    if consistency.balance is not None:
        lines += consistency.balance.lines()
    return lines + [f"warning: {each}" for each in consistency.warnings]


def _motion(consistency: Consistency) -> str:
    if consistency.unchecked:
        return f"not compared with the motion: {consistency.unchecked}"
    parts = [
        f"{100 * share:.0f} % of {name}"
        for name, share in consistency.fit._asdict().items()
        if not np.isnan(share)
    ]
    return f"motion explains, as assumed, {', '.join(parts)}"
