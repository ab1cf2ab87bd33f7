"""The inverse problem: wrenches that have a wanted resultant, shares and internal wrench."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, finite_array, number_array
from coopenv.errors import InvalidInput
from coopenv.wrench import pair, synthesis_pair, synthesis_shares
from coopenv.wrench.grasp import checked_grips, require_batch, sum_at_centre, wrench_size
from coopenv.wrench.measure_kernels import load_share_kernel
from coopenv.wrench.settings import Settings

FOUND = 1e-7  # by how much the shares of an answer may miss what is wanted
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

    - Without internal wrench, any number of effectors in plane and space. Only wrenches of one form
      are searched: forces along the resultant, pure torques along what the forces leave over. Then
      nothing can be internal. Wishes that need a pair of forces across the resultant besides are
      refused though some wrench fulfils them, unless the grips are as follows.
    - With it, two planar effectors on a line through the centre of mass: every wish that any
      wrench fulfils. Internal force along f_o needs an effector that pulls against f_o, whose
      share is then 0 (eqs. 9, 25); across f_o it goes with any force share where the line allows.

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
    ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m]. Among several answers for a pair, the one with
    the smallest largest component that was found.

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong, or no wrench of the form that is searched fulfils the
        wish; the message names the wish that stands in the way, for a pair on a line also how far
        one gets without it.

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
    wish = _Wish(
        _flat(wanted, batch, 1),
        _flat(grips, batch, 2),
        _flat(inside, batch, 2),
        _flat(force, batch, 1),
        _flat(torque, batch, 1),
        (settings.torque_weight, float(settings.include_induced)),
    )
    _require_defined(wish)
    return _solve(wish).reshape(*batch, num_effectors, size)


class _Wish(NamedTuple):
    """What is wanted, one sample a row; shares are NaN where open."""

    object_wrench: FloatArray  # (batch, k) [N, N·m]
    grips: FloatArray  # (batch, n, d) [m]
    internal: FloatArray  # (batch, n, k) [N, N·m]
    force_share: FloatArray  # (batch, n)
    torque_share: FloatArray  # (batch, n)
    weights: tuple[float, float]  # w, s

    def rows(self, which: BoolArray) -> "_Wish":
        return _Wish(*(part[which] for part in self[:-1]), self.weights)  # pyright: ignore

    def as_pair(self, force_share: FloatArray, torque_share: FloatArray) -> FloatArray:
        return synthesis_pair.find(
            self.object_wrench,
            self.grips,
            self.internal,
            force_share[:, 0],
            torque_share[:, 0],
            self.weights,
        )


def _solve(wish: _Wish) -> FloatArray:
    """Answers of samples in a row: by shares alone where that will do, else as a pair."""
    shares = (wish.force_share, wish.torque_share)
    applied = synthesis_shares.find(wish.object_wrench, wish.grips, *shares)
    missing = np.asarray(wish.internal.any(axis=(-1, -2)) | np.isnan(applied).any(axis=(-1, -2)))
    found = load_share_kernel(np.nan_to_num(applied), wish.grips)
    for reached, wanted in zip(found, shares, strict=True):
        missing |= ((np.abs(reached - wanted) > FOUND) & ~np.isnan(wanted)).any(axis=-1)
    if not missing.any():
        return applied
    rest = wish.rows(missing)
    off_axis = np.asarray(~pair.applies(rest.grips))
    if off_axis.any():
        raise InvalidInput(_limit(rest.rows(off_axis)))
    applied[missing] = rest.as_pair(rest.force_share, rest.torque_share)
    failed = np.isnan(applied[:, 0, 0])
    if failed.any():
        raise InvalidInput(_obstacle(wish.rows(failed), int(failed.argmax())))
    return applied


def _obstacle(wishes: _Wish, sample: int) -> str:
    """Say which wish of a pair stands in the way, by leaving one after the other out."""
    wish = wishes.rows(np.arange(len(wishes.internal)) == 0)
    force, torque, free = wish.force_share, wish.torque_share, np.full((1, 2), np.nan)
    for name, shares in (
        ("torque_share", (force, free)),
        ("force_share", (free, torque)),
        ("force_share and torque_share", (free, free)),
    ):
        answer = wish.as_pair(*shares)
        if not np.isnan(answer).any():
            found = load_share_kernel(answer, wish.grips)
            return (
                f"{name} must go with the rest of the wish, got force_share {force[0].tolist()} "
                f"and torque_share {torque[0].tolist()} at sample {sample}, {_reason(wish)}; leave "
                f"out {name}: possible are {found[0][0].tolist()} and {found[1][0].tolist()}"
            )
    return (
        "internal must be what this object_wrench can leave over, got "
        f"{wish.internal[0].tolist()} with {wish.object_wrench[0].tolist()} at sample {sample}, "
        "where trading it for other forces and torques would cost less (eq. 17); make its forces "
        "smaller across the line, or its torques proportional to what remains to be supplied"
    )


def _reason(wish: _Wish) -> str:
    force, resultant = wish.internal[0, 0, :2], wish.object_wrench[0, :2]
    along = force @ resultant
    across = force[0] * resultant[1] - force[1] * resultant[0]
    if abs(across) <= ROUNDING * abs(along) and 0.0 < wish.force_share[0, 0] < 1.0 and force.any():
        return (
            "where internal force along the resultant needs an effector that pulls against it, "
            "whose share is then 0 (eqs. 9, 25)"
        )
    if not wish.internal.any():
        return "where forces or torques would have to cancel each other (eqs. 9-11)"
    return "where another split would be cheaper or the wanted one not plausible (eqs. 9-11, 17)"


def _limit(wish: _Wish) -> str:
    """Say why a wish for anything but a pair on an axis was not fulfilled by the form searched."""
    if wish.internal[0].any():
        return (
            "internal must be 0 or left out unless the grips are two planar positions on one line "
            f"through the centre of mass, got {wish.internal[0].tolist()} for grips "
            f"{wish.grips[0].tolist()}, for which none is searched; give shares only"
        )
    return (
        "torque_share must be reached by forces along the resultant and pure torques that do not "
        f"cancel each other, got {wish.torque_share[0].tolist()} with force_share "
        f"{wish.force_share[0].tolist()}, which no wrench of this form has (one with forces across "
        "the resultant may; they are not searched); change either, or leave one out"
    )


def _flat(array: FloatArray, batch: tuple[int, ...], core: int) -> FloatArray:
    shape = array.shape[array.ndim - core :]
    return np.broadcast_to(array, (*batch, *shape)).reshape(-1, *shape)


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


def _require_defined(wish: _Wish) -> None:
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
