"""Analysis of a recording: every row decomposed, as a table of wrenches and measures."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, effector_names, wrench_names
from coopenv.logs.formats.chunks import Column
from coopenv.logs.recording import Recording
from coopenv.wrench import Decomposer, Decomposition, Settings

if TYPE_CHECKING:
    import pandas

RESULTS = (  # name, unit, meaning
    ("`manipulation_f1x` …", "N, N·m", "manipulation wrench h_M of each effector (eq. 5)"),
    ("`internal_f1x` …", "N, N·m", "internal wrench h_I of each effector (eq. 5)"),
    ("`internal_force_level`", "N", "F_I = ½ Σ‖f_I,i‖ (eq. 28)"),
    ("`internal_torque_level`", "N·m", "T_I = ½ Σ‖r_i × f_I,i + t_I,i‖ (eq. 28)"),
    ("`relative_cost`", "", "γ = 1 − J(h_M)/J(h): the part that was compensated (eq. 29)"),
    ("`wasted_cost`", "N", "J(h) − J(h_M): the cost that was compensated"),
    ("`force_load_share_1` …", "", "part of the resultant force that each supplies (eq. 25)"),
    ("`torque_load_share_1` …", "", "the same of the torque (eq. 25)"),
    ("`energy_share_1` …", "", "part of the object's power that each supplies (eq. 26)"),
    ("`linear_energy_share_1` …", "", "the same of the power of translation (eq. 27)"),
    ("`angular_energy_share_1` …", "", "the same of the power of rotation (eq. 27)"),
    ("`internal_power`", "W", "power passed between effectors, ½(Σ|Ė_i| − |ΣĖ_i|)"),
    ("`cost`", "N", "J(h_M) (eq. 17)"),
    ("`applied_cost`", "N", "J(h) (eq. 17)"),
    ("`gap`", "N", "bound on how far the cost is from the optimum"),
)
"""What the table adds to a recording, for the page on recordings."""


class Worst(NamedTuple):
    """The largest residual of all rows, of each kind; see `coopenv.wrench.Residuals`."""

    balance: float = 0.0  # [N or N·m]
    force: float = 0.0  # [N]
    induced_torque: float = 0.0  # [N·m]
    torque: float = 0.0  # [N·m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Analysis:
    """A recording and its decomposition as columns of equal length.

    The recording's own columns are there in SI units and the object frame, so that the table is a
    recording itself. What is undefined, and every result of a bad row, is NaN.
    """

    columns: dict[str, Column]  # (T,) each
    results: tuple[str, ...]  # those that were computed
    worst: Worst
    gap: float  # the largest of all rows [N]
    fallbacks: int  # rows for which the solver had to ask another one
    solver: str

    def __getitem__(self, name: str) -> Column:
        return self.columns[name]

    def frame(self) -> "pandas.DataFrame":
        """The table as a pandas data frame."""
        try:
            import pandas
        except ImportError as error:
            raise MissingExtra("a data frame", "analysis") from error
        return pandas.DataFrame(self.columns)


def analyse(recording: Recording, settings: Settings | None = None) -> Analysis:
    """Decompose every good row of a recording and take all measures.

    Parameters
    ----------
    recording
        As `coopenv.logs.read` returns it, whole or in parts.
    settings
        Which definition of internal wrench, which cost, which solver.

    Raises
    ------
    InvalidInput
        If the method does not go with the recording, such as one for forces only with torques.
    """
    good = recording.good
    used = recording if good.all() else recording.take(good)
    if not len(used):
        used = _nothing(recording)
    split = Decomposer(_grips(used), settings)(np.ascontiguousarray(used.applied))
    results = _results(split, used.twist)
    columns = _recorded(recording)
    for name, values in results.items():
        columns[name] = values if used is recording else _scattered(values, good)
    residuals = split.residuals()
    return Analysis(
        columns=columns,
        results=tuple(results),
        worst=Worst(*(float(part.max()) for part in residuals)),
        gap=float(np.max(split.gap)),
        fallbacks=int(split.fell_back.sum()),
        solver=split.solver,
    )


def _recorded(recording: Recording) -> dict[str, Column]:
    """What was recorded, under the documented names; what is carried first."""
    dimension = recording.grips.shape[-1]
    rows, count = len(recording), recording.num_effectors
    columns: dict[str, Column] = {}
    if recording.time is not None:
        columns["time"] = recording.time
    columns.update(recording.carried)
    orientation = recording.orientation
    if orientation is not None and orientation.ndim == 1:
        orientation = orientation[:, None]
    for names, values in (
        (POSITION[dimension], recording.position),
        (ORIENTATION[dimension], orientation),
        (TWIST[dimension], recording.twist),
    ):
        if values is not None:
            columns.update({name: values[:, j] for j, name in enumerate(names)})
    grips = np.broadcast_to(recording.grips, (rows, count, dimension)).reshape(rows, -1)
    names = [name for group in effector_names("r", count, dimension) for name in group]
    columns.update(zip(names, grips.T, strict=True))
    return columns | _wrench("", recording.applied)


def _results(split: Decomposition, twist: FloatArray | None) -> dict[str, Column]:
    columns = _wrench("manipulation_", split.manipulation) | _wrench("internal_", split.internal)
    columns["internal_force_level"] = split.internal_force_level
    columns["internal_torque_level"] = split.internal_torque_level
    columns["relative_cost"] = split.relative_cost
    columns["wasted_cost"] = split.wasted_cost
    shares = {
        "force_load_share": split.load_share.force,
        "torque_load_share": split.load_share.torque,
    }
    energy = None if twist is None else split.energy_share(twist)
    if energy is not None:
        shares["energy_share"] = energy.total
        shares["linear_energy_share"] = energy.linear
        shares["angular_energy_share"] = energy.angular
    for name, share in shares.items():
        columns |= {f"{name}_{i + 1}": share[:, i] for i in range(share.shape[1])}
    if energy is not None:
        columns["internal_power"] = energy.internal_power
    columns["cost"], columns["applied_cost"] = split.cost, split.applied_cost
    columns["gap"] = split.gap
    return columns


def _wrench(prefix: str, wrench: FloatArray) -> dict[str, Column]:
    """One column a component of wrenches ``(T, n, 3 or 6)``."""
    rows, count, size = wrench.shape
    names = wrench_names(count, 2 if size == 3 else 3)
    flat = wrench.reshape(rows, count * size)
    return {f"{prefix}{name}": flat[:, j] for j, name in enumerate(names)}


def _grips(recording: Recording) -> FloatArray:
    """One set of grips where they are the same in all rows: solvers prepare it once."""
    grips = recording.grips
    return grips[0] if grips.ndim == 3 and (grips == grips[:1]).all() else grips


def _scattered(values: npt.NDArray[Any], good: npt.NDArray[np.bool_]) -> Column:
    spread = np.full(len(good), np.nan)
    spread[good] = values[: good.sum()]
    return spread


def _nothing(recording: Recording) -> Recording:
    """One row without any wrench, to learn the names of the results where no row is good."""
    one = recording.take(np.zeros(1, dtype=np.int64))
    one.applied[:] = 0.0
    if one.twist is not None:
        one.twist[:] = 0.0
    if one.grips.ndim == 3:
        one.grips[:] = np.arange(one.grips.shape[1])[:, None]
    return one
