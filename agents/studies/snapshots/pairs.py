"""Claims of Figs. 7, 8 and 17: the lens of a pair, where w matters, and power."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import (
    cost,
    decompose,
    induced_torque,
    is_plausible,
    object_wrench,
    residuals,
    weight_matters,
    work_residuals,
)

from ..claims import Claim
from ..methods import largest, smallest
from . import examples

ZERO = 1e-9  # [N, N·m, W] what counts as zero; wrenches are about 1, rounding about 1e-15
WEIGHTS = (1e-4, 0.1, 0.3, 0.5, 0.7, 0.9, 1 - 1e-4)


def lens_claims(samples: int, seed: int) -> list[Claim]:
    """Fig. 7: both circles pass f_1 and the foot of the perpendicular; ours is the cheapest."""
    applied, grips = examples.PAIR, examples.SHORTER
    ours = decompose(applied, grips)
    first, total = applied[0, :2], applied[:, :2].sum(axis=0)
    foot = total * (first @ total) / (total @ total)
    circles = [(0.5 * first, 0.5 * first), (0.5 * (first + total), 0.5 * (total - first))]
    off = [
        np.linalg.norm(point - centre) - np.linalg.norm(radius)
        for centre, radius in circles
        for point in (first, foot)
    ]
    inside = plausible_splits(samples, seed)
    return [
        Claim.zero(
            "both circles pass f_1 and the foot of its perpendicular on f_o (largest distance)",
            "beyond the paper", largest(np.array(off)), within=ZERO, unit="N",
        ),
        Claim.zero(
            "the foot is the point mass answer f_M,1 (distance)",
            "eq. 22",
            largest(decompose(applied, grips, method="point_mass").manipulation[0, :2] - foot),
            within=ZERO, unit="N",
            why="both pull along f_o here; where one pulls against it, the answer is f_o itself",
        ),
        Claim.zero(
            "ours lies in the lens (distance from the balls of eqs. 9-11)",
            "Fig. 7, numbers ours", max(float(part) for part in ours.residuals()), within=ZERO,
            unit="N, N·m",
        ),
        Claim(
            text="no plausible split costs less than ours (least difference of J)",
            source="eqs. 17-21", measured=float((cost(inside, grips) - ours.cost).min()),
            relation="≥", bound=-ZERO, unit="N",
            why=f"{len(inside)} of {samples} random splits that balance are plausible",
        ),
    ]  # fmt: skip


def plausible_splits(samples: int, seed: int) -> FloatArray:
    """Those of random splits that balance and are plausible, as h_M ``(k, 2, 3)``.

    f_M,1 = f_1 + d and f_M,2 = f_2 − d with random d; whose pure torque has the sign of what is
    left for pure torques gives all of it.
    """
    applied, grips = examples.PAIR, examples.SHORTER
    manipulation = np.repeat(applied[None], samples, axis=0)
    moved = np.random.default_rng(seed).uniform((-3.0, -1.5), (3.0, 0.5), (samples, 2))
    manipulation[:, 0, :2] += moved
    manipulation[:, 1, :2] -= moved
    manipulation[..., 2] = 0.0
    left = (object_wrench(applied, grips) - object_wrench(manipulation, grips))[:, 2]
    manipulation[:, 0, 2], manipulation[:, 1, 2] = np.maximum(left, 0.0), np.minimum(left, 0.0)
    return manipulation[is_plausible(applied, applied - manipulation, grips)]


def weight_claims(samples: int, seed: int) -> list[Claim]:
    """Fig. 8: eq. 24, on one wrench, and on random ones."""
    grips = examples.SHORTER
    pair = np.stack([examples.WEIGHED, examples.UNWEIGHED])
    force, torque = _spread(pair, include_induced=False)
    random = np.random.default_rng(seed).normal(size=(samples, 2, 3))
    named, printed = weight_matters(random, grips), _as_printed(random)
    forces, torques = _spread(random, include_induced=False)
    induced_forces, induced_torques = _spread(random, include_induced=True)
    moved = np.maximum(forces, torques)
    wrong = int((printed & (moved <= ZERO)).sum())
    where = "eq. 24, corrected"
    return [
        Claim(
            text="torques that oppose what the forces turn: the split depends on w (Σ‖t_M‖ varies)",
            source="Fig. 8, numbers ours", measured=float(torque[0]), relation=">", bound=ZERO,
            unit="N·m", why=f"Σ‖f_M‖ by {force[0]:.3g} N",
        ),
        Claim.zero(
            "where the opposing torque outdoes them it does not (Σ‖f_M‖ and Σ‖t_M‖ vary)",
            "Fig. 8, numbers ours", float(max(force[1], torque[1])), within=ZERO, unit="N, N·m",
        ),
        Claim.zero(
            f"s = 0: w is of no account where eq. 24 says so (largest of {(~named).sum()})",
            where, largest(moved, ~named), within=ZERO, unit="N, N·m",
        ),
        Claim(
            text=f"s = 0: and one wherever it names one (smallest of {named.sum()}, Σ‖t_M‖)",
            source=where, measured=smallest(torques, named), relation=">", bound=ZERO, unit="N·m",
        ),
        Claim.zero(
            f"s = 1: the split never depends on w (largest, {samples} wrenches)",
            "section III-D", largest(np.maximum(induced_forces, induced_torques)), within=ZERO,
            unit="N, N·m",
        ),
        Claim.zero(
            f"eq. 24 as printed names no wrench at which w does not matter (of {printed.sum()})",
            "eq. 24, as printed", float(wrong), within=0.0,
            why="its minimum takes the sign along: of two negative induced torques it finds the "
            "larger one; the smaller magnitude is meant",
        ),
    ]  # fmt: skip


def _spread(applied: FloatArray, *, include_induced: bool) -> tuple[FloatArray, FloatArray]:
    """How much Σ‖f_M‖ [N] and Σ‖t_M‖ [N·m] vary over w ``(...)``."""
    found = [
        decompose(applied, examples.SHORTER, torque_weight=w, include_induced=include_induced)
        for w in WEIGHTS
    ]
    forces = [np.linalg.norm(d.manipulation[..., :2], axis=-1).sum(axis=-1) for d in found]
    torques = [np.abs(d.manipulation[..., 2]).sum(axis=-1) for d in found]
    return np.ptp(forces, axis=0), np.ptp(torques, axis=0)


def _as_printed(applied: FloatArray) -> BoolArray:
    """Eq. 24 with the signed minimum of both induced torques."""
    induced = induced_torque(applied, examples.SHORTER)[..., 0]
    torque, sign = applied[..., 2], np.sign(induced[:, 0])
    one_way = (sign != 0) & (np.sign(induced[:, 1]) == sign)
    found = np.zeros(len(applied), dtype=np.bool_)
    for k, j in ((0, 1), (1, 0)):
        order = (np.sign(torque[:, k]) == sign) & (np.sign(torque[:, j]) == -sign)
        reach = np.abs(2 * induced.min(axis=-1) + torque[:, k])
        found |= one_way & order & (reach > np.abs(torque[:, j]))
    return found


def work_claims(samples: int, seed: int) -> list[Claim]:
    """Fig. 17: a plausible manipulation wrench may be said to give power that was taken."""
    applied, grips, twist = examples.CROSSING, examples.PAIR_POINT, examples.TWIST
    internal = decompose(applied, grips, method="point_mass").internal
    rng = np.random.default_rng(seed)
    random = np.zeros((samples, 2, 3))
    random[..., :2] = rng.normal(size=(samples, 2, 2))
    moving = np.zeros((samples, 3))
    moving[:, :2] = rng.normal(size=(samples, 2))
    split = decompose(random, grips, method="point_mass").internal
    broken = work_residuals(random, split, grips, moving).linear > ZERO
    nothing = work_residuals(random, np.zeros_like(random), grips, moving)
    return [
        Claim.zero(
            "the split of a pair on a point mass is plausible (distance from the balls of eq. 9)",
            "Fig. 17, numbers ours", float(residuals(applied, internal, grips).force), within=ZERO,
            unit="N",
        ),
        Claim(
            text="and yet breaks the work constraint (excess of power)",
            source="eqs. 35-36, numbers ours",
            measured=float(work_residuals(applied, internal, grips, twist).linear),
            relation=">", bound=ZERO, unit="W",
        ),
        Claim(
            text=f"so do most of {samples} random pairs and velocities (share of them)",
            source="Appendix A", measured=float(broken.mean()), relation=">", bound=0.5,
        ),
        Claim.zero(
            "what was applied keeps both kinds of constraint: they go together (largest)",
            "Appendix A", max(largest(nothing.linear), largest(nothing.angular)), within=ZERO,
            unit="W",
        ),
    ]  # fmt: skip
