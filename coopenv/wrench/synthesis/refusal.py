"""Messages for wishes that cannot be fulfilled: the part in the way, found by trying without it."""

import numpy as np

from coopenv.wrench.shares import load_share_kernel
from coopenv.wrench.synthesis import search
from coopenv.wrench.synthesis.wish import Wish

ROUNDING = 1e-9  # sine of an angle that counts as none


def why(wish: Wish, sample: int) -> str:
    """Message for one wish that was not fulfilled, by its number in the batch."""
    if not wish.searched[0]:
        return (
            "internal must be 0 or left out unless the grips are two planar positions, got "
            f"{wish.internal[0].tolist()} at sample {sample} for grips {wish.grips[0].tolist()}, "
            "for which none is searched; give shares only"
        )
    force, torque = wish.force_share, wish.torque_share
    free = np.full_like(force, np.nan)
    for name, shares in (
        ("torque_share", (force, free)),
        ("force_share", (free, torque)),
        ("force_share and torque_share", (free, free)),
    ):
        tried = wish._replace(force_share=shares[0], torque_share=shares[1])
        if _same(tried, wish):
            continue
        answer, failed = search.find(tried)
        if failed is None:
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


def _same(one: Wish, other: Wish) -> bool:
    return all(
        np.array_equal(a, b, equal_nan=True)
        for a, b in (
            (one.force_share, other.force_share),
            (one.torque_share, other.torque_share),
        )
    )


def _reason(wish: Wish) -> str:
    if not wish.internal.any():
        return "where forces or torques would have to cancel each other (eqs. 9-11)"
    force, resultant = wish.internal[0, 0, :2], wish.object_wrench[0, :2]
    along = force @ resultant
    across = force[0] * resultant[1] - force[1] * resultant[0]
    if abs(across) <= ROUNDING * abs(along) and 0.0 < wish.force_share[0, 0] < 1.0 and force.any():
        return (
            "where internal force along the resultant needs an effector that pulls against it, "
            "whose share is then 0 (eqs. 9, 25)"
        )
    return "where another split would be cheaper or the wanted one not plausible (eqs. 9-11, 17)"
