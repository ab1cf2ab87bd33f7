"""Inverse problem of the decomposition: wrenches of a wanted resultant, shares, internal wrench."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array, in_rows, number_array
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_grips, require_batch, sum_at_centre, wrench_size
from coopenv.wrench.settings import Settings
from coopenv.wrench.synthesis import refusal, search
from coopenv.wrench.synthesis.wish import Wish

ROUNDING = 1e-9  # by how much shares may miss their sum, and an internal wrench its balance


def synthesize(
    object_wrench: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    force_share: npt.ArrayLike | None = None,
    torque_share: npt.ArrayLike | None = None,
    internal: npt.ArrayLike | None = None,
    torque_weight: float = 0.5,
    include_induced: bool = False,
) -> FloatArray:
    """Applied wrenches whose resultant, load shares and internal wrench are as wanted.

    `decompose` of the result returns ``object_wrench`` and ``internal``, `load_share` the shares.

    - Without internal wrench, any number of effectors in plane and space. Forces along the
      resultant are written down. Where they do not reach the torque shares, wrenches with forces
      across it are searched.
    - With it, two planar effectors: all that an optimum allows is written down, as once the
      internal force is known every constraint is a line. Internal force along f_o needs an effector
      that pulls against f_o, whose share is then 0 (eqs. 9, 25); across f_o it goes with any force
      share where the line allows.

    Where several splits cost the same, the answer is such that `decompose` returns the wanted one.
    The first impossible sample of a batch ends the search. `docs/decomposition.md` says how many
    wishes are found and how long it takes.

    Parameters
    ----------
    object_wrench
        ``(..., 3)`` planar or ``(..., 6)`` spatial, at the centre of mass [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].
    force_share, torque_share
        α_f and α_t, ``(..., n)``, not negative, of sum 1; open where left out or NaN (as
        `load_share` returns them where the resultant vanishes).
    internal
        h_I with G h_I = 0, ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m]; 0 if left out.
    torque_weight, include_induced
        w and s of the cost (eq. 17), as they will be given to `decompose`.

    Returns
    -------
    ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m]. Among several answers that are searched, the one
    with the smallest largest component that was found.

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong, or no wrench that fulfils the wish is found; the message
        names the part of the wish that stands in the way, and what is possible without it.

    Source: posed as open in Donner, Endo & Buss 2018, section VII; the solution is our own.
    """
    settings = Settings(torque_weight=torque_weight, include_induced=include_induced)
    grips = checked_grips(grips)
    num_effectors, dimension = grips.shape[-2:]
    size = wrench_size(dimension)
    wanted = _shaped(finite_array(object_wrench, "object_wrench"), "object_wrench", (size,), grips)
    force = _checked_share(force_share, "force_share", grips)
    torque = _checked_share(torque_share, "torque_share", grips)
    inside = np.zeros((num_effectors, size))
    if internal is not None:
        shape = (num_effectors, size)
        inside = _shaped(finite_array(internal, "internal"), "internal", shape, grips)
        inside = _balanced(inside, wanted, grips)
    batches = (wanted.shape[:-1], force.shape[:-1], torque.shape[:-1], inside.shape[:-2])
    batch = _common_batch(*batches, grips.shape[:-2])
    wish = Wish(
        in_rows(wanted, batch, core=1),
        in_rows(grips, batch),
        in_rows(inside, batch),
        in_rows(force, batch, core=1),
        in_rows(torque, batch, core=1),
        settings,
    )
    _require_defined(wish)
    applied, failed = search.find(wish)
    if failed is not None:
        raise InvalidInput(refusal.why(wish.rows(np.array([failed])), failed))
    return applied.reshape(*batch, num_effectors, size)


def _shaped(array: FloatArray, name: str, core: tuple[int, ...], grips: FloatArray) -> FloatArray:
    if array.shape[array.ndim - len(core) :] != core or array.ndim < len(core):
        raise InvalidInput(
            f"{name} must be of shape (..., {', '.join(map(str, core))}) for grips of shape "
            f"{grips.shape}, got {array.shape}; give it in the object frame"
        )
    require_batch(name, array.shape[: array.ndim - len(core)], grips)
    return array


def _checked_share(share: Any, name: str, grips: FloatArray) -> FloatArray:
    """Shares ``(..., n)``; rows of NaN are open."""
    num_effectors = grips.shape[-2]
    if share is None:
        return np.full(num_effectors, np.nan)
    array = _shaped(number_array(share, name), name, (num_effectors,), grips)
    opened = np.isnan(array).all(axis=-1)
    with np.errstate(invalid="ignore"):
        good = (array >= 0.0).all(axis=-1) & (np.abs(array.sum(axis=-1) - 1.0) <= ROUNDING)
    if not (good | opened).all():
        where = tuple(int(i) for i in np.argwhere(~(good | opened))[0])
        raise InvalidInput(
            f"{name} must not be negative and sum to 1, got {array[where].tolist()}"
            f"{f' at index {where}' if where else ''}; scale it, or give NaN where it is open"
        )
    return array


def _balanced(internal: FloatArray, wanted: FloatArray, grips: FloatArray) -> FloatArray:
    """Return the internal wrench, 0 where it is rounding; raise unless it balances."""
    rest = np.abs(sum_at_centre(internal, grips)).max(axis=-1)
    own = np.abs(internal).max(axis=(-1, -2)) * (1.0 + np.abs(grips).max(axis=(-1, -2)))
    size = own + np.abs(wanted).max(axis=-1)
    if (rest > ROUNDING * own + 1e-3 * ROUNDING * size).any():
        raise InvalidInput(
            f"internal must balance, G h_I = 0, got a resultant of up to {rest.max():g}; "
            "forces must add up to 0, and torques to minus the moment of the forces"
        )
    return np.where((own > 1e-4 * ROUNDING * size)[..., None, None], internal, 0.0)


def _common_batch(*batches: tuple[int, ...]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(*batches)
    except ValueError as error:
        raise InvalidInput(
            f"object_wrench, shares, internal and grips must broadcast, got batches {batches}; "
            "give one of each per sample, or one for all"
        ) from error


def _require_defined(wish: Wish) -> None:
    dimension = wish.grips.shape[-1]
    force, torque = wish.object_wrench[:, :dimension], wish.object_wrench[:, dimension:]
    for name, resultant, share in (
        ("force", force, wish.force_share),
        ("torque", torque, wish.torque_share),
    ):
        undefined = ~resultant.any(axis=-1) & ~np.isnan(share[:, 0])
        if undefined.any():
            sample = int(undefined.argmax())
            raise InvalidInput(
                f"{name}_share must be left out where object_wrench has no {name} to share, got "
                f"{share[sample].tolist()} at sample {sample}; give NaN there"
            )
