"""Decomposition of a trial by the methods that are compared, and how each is drawn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput, UnknownName
from coopenv.wrench import METHODS, Decomposer, Decomposition, Settings


@dataclass(frozen=True, slots=True)
class Look:
    """How a method is named and drawn, alike in all figures."""

    label: str
    color: str  # after Okabe & Ito
    line: str
    width: float  # [pt]; what is drawn first is wider, so that lines that agree can both be seen


LOOKS: Mapping[str, Look] = {
    "optimal": Look("ours (optimal)", "#0072B2", "-", 4.0),
    "prioritized_torque": Look("ours (pTtTC)", "#56B4E9", "-", 2.6),
    "point_mass": Look("point mass", "#CC79A7", "--", 1.8),
    "moore_penrose": Look("Moore-Penrose G†", "#D55E00", "-", 1.3),
    "nonsqueezing": Look("nonsqueezing G_Δ⁺", "#009E73", "-.", 1.3),
    "parametrized": Look("parametrized G_M⁺", "#F0C000", ":", 1.6),
    "virtual_linkage": Look("virtual linkage", "#000000", ":", 1.6),
}

COMPARED = (
    "optimal",
    "prioritized_torque",
    "point_mass",
    "moore_penrose",
    "nonsqueezing",
    "virtual_linkage",
)
"""Of two effectors on a line through the centre of mass, forces and torques.

Left out are what needs further inputs (constraint violation), what is defined for forces only, and
``parametrized``, which at unit virtual masses and grips at ±1 m is Moore-Penrose.
"""


def decompose_by_methods(
    applied: npt.ArrayLike,
    grips: npt.ArrayLike,
    methods: Sequence[str] | Mapping[str, Settings] = COMPARED,
) -> dict[str, Decomposition]:
    """Decompose a trial's applied wrenches with several methods.

    Parameters
    ----------
    applied
        ``(time, 2, 3)`` or any batch ``(..., n, 3)``, object frame [N, N·m].
    grips
        ``(n, 2)``, or one set a sample [m].
    methods
        Names, or a mapping from the name in tables to full `Settings`.

    Returns
    -------
    By name: `Decomposition`, whose ``internal_force_level``, ``internal_torque_level`` and
    ``relative_cost`` are F_I [N], T_I [N·m] and γ, one a sample.

    Raises
    ------
    UnknownName
        If a method does not exist.
    InvalidInput
        If a method is not defined for these grips, or an array has a wrong shape or number.
    """
    if not isinstance(methods, Mapping):
        for name in methods:
            if name not in METHODS:
                raise UnknownName("method", name, METHODS)
        methods = {name: Settings(method=name) for name in methods}
    wrenches = finite_array(applied, "applied")
    if wrenches.ndim < 3:
        raise InvalidInput(
            f"applied must be (time, effector, 3), got shape {wrenches.shape}; "
            "put the samples of a trial in the first axis"
        )
    return {name: Decomposer(grips, settings)(wrenches) for name, settings in methods.items()}


def largest(level: FloatArray, where: npt.NDArray[np.bool_] | None = None) -> float:
    """Largest magnitude among the samples that ``where`` marks; NaN where it marks none."""
    chosen = np.abs(level if where is None else level[where])
    return float(chosen.max()) if chosen.size else float("nan")


def smallest(level: FloatArray, where: npt.NDArray[np.bool_] | None = None) -> float:
    """Smallest magnitude among the samples that ``where`` marks; NaN where it marks none."""
    chosen = np.abs(level if where is None else level[where])
    return float(chosen.min()) if chosen.size else float("nan")
