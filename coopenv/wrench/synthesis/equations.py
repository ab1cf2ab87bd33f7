"""Equations of load shares without internal wrench, and their derivatives; `twist` derives them.

Of every effector three parts count: forces along the lever (C = A − B), forces (B) and torque (T).
Each is a factor, at least 0, times a linear function of the twist. All parts add up to the wish,
and each effector's parts along f_o and t_o are its shares. Where a share is 0, less may be, and the
others make up for it: a slack for each, and an excess that the others share, are further factors.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.grasp import grasp_matrix

LEAST_AMOUNT = 1e-2  # shares below which an effector's equations are not scaled up any more


class TwistWish(NamedTuple):
    """Wishes ``(batch, ...)`` in units of the resultant and of the longest lever."""

    wrench: FloatArray  # (batch, k)
    amount: FloatArray  # (batch, n), the unit of each effector's equations and factors
    parts: FloatArray  # (batch, n, 3, k, k), of a twist: what C, B and T = 1 make at the centre
    direction: FloatArray  # (batch, 2, k), of f_o and of t_o; 0 where the shares are open
    share: FloatArray  # (batch, 2, n), in units of amount, 0 where open
    none: FloatArray  # (batch, 2, n), 1 where a share is 0 and less may be

    def rows(self, which: BoolArray) -> "TwistWish":
        """Some of the wishes."""
        return TwistWish(*(part[which] for part in self))


class State(NamedTuple):
    """Where each system is, by how much it misses, and the derivatives."""

    twist: FloatArray  # (batch, k)
    factors: FloatArray  # (batch, 5n + 2): C, B, T; slack of shares that are 0; excess of others
    residual: FloatArray  # (batch, k + 2n)
    slope: FloatArray  # (batch, k + 2n, k + 5n + 2)

    def rows(self, which: BoolArray) -> "State":
        """State of some of the systems."""
        return State(*(part[which] for part in self))


def set_up(
    wrench: FloatArray, grips: FloatArray, force_share: FloatArray, torque_share: FloatArray
) -> TwistWish:
    """Wishes in the form of their equations; arguments ``(batch, ...)`` in units of `TwistWish`."""
    dimension = grips.shape[-1]
    share = np.stack([force_share, torque_share], axis=1)
    asked = ~np.isnan(share)
    known = np.where(asked, share, 0.0)
    amount = np.where(asked.any(axis=1), known.max(axis=1), 1.0 / grips.shape[-2])
    amount = np.where(amount > 0.0, np.maximum(amount, LEAST_AMOUNT), 1.0)
    direction = np.zeros((len(wrench), 2, wrench.shape[-1]))
    direction[:, 0, :dimension] = wrench[:, :dimension]
    direction[:, 1, dimension:] = wrench[:, dimension:]
    length = np.linalg.norm(direction, axis=-1, keepdims=True)
    direction *= asked[..., :1] / np.where(length > 0.0, length, 1.0)
    known = known / amount[:, None]
    return TwistWish(wrench, amount, _parts(grips), direction, known, (share == 0.0) * 1.0)


def _parts(grips: FloatArray) -> FloatArray:
    """Wrenches at the centre ``(batch, n, 3, k, k)`` that C, B and T make of each twist."""
    batch, num_effectors, dimension = grips.shape
    size = 3 * dimension - 3
    length = np.linalg.norm(grips, axis=-1, keepdims=True)
    lever = grips / np.where(length > 0.0, length, 1.0)
    to_centre = grasp_matrix(grips).reshape(batch, size, num_effectors, size)
    to_centre = to_centre.swapaxes(1, 2)[..., :dimension]  # a force as a wrench at the centre
    moving = to_centre.swapaxes(-1, -2)  # a twist as a velocity at the grip (batch, n, d, k)
    along = lever[..., None] * (lever[..., None, :] @ moving)
    turning = np.arange(dimension, size)
    parts = np.zeros((batch, num_effectors, 3, size, size))
    parts[:, :, 0] = to_centre @ along
    parts[:, :, 1] = to_centre @ moving
    parts[:, :, 2, turning, turning] = 1.0
    return parts


def state(wish: TwistWish, twist: FloatArray, factors: FloatArray) -> State:
    """By how much twists and factors miss wishes, and the derivatives."""
    batch, _, num_effectors = wish.share.shape
    size = twist.shape[-1]
    own = factors[:, : 3 * num_effectors].reshape(batch, num_effectors, 3)
    by_factor = np.einsum("bijkl,bl->bijk", wish.parts, twist)
    by_twist = np.einsum("bijkl,bij->bikl", wish.parts, own)
    at_centre = np.einsum("bijk,bij->bik", by_factor, own)  # in units of amount
    residual = np.zeros((batch, size + 2 * num_effectors))
    slope = np.zeros((batch, residual.shape[-1], size + factors.shape[-1]))
    residual[:, :size] = np.einsum("bi,bik->bk", wish.amount, at_centre) - wish.wrench
    slope[:, :size, :size] = np.einsum("bi,bikl->bkl", wish.amount, by_twist)
    columns = np.einsum("bi,bijk->bkij", wish.amount, by_factor)
    slope[:, :size, size : size + 3 * num_effectors] = columns.reshape(
        batch, size, 3 * num_effectors
    )
    result = State(twist, factors, residual, slope)
    for kind in range(2):
        _share_equations(wish, result, kind, (at_centre, by_twist, by_factor))
    return result


def _share_equations(
    wish: TwistWish, state: State, kind: int, parts: tuple[FloatArray, FloatArray, FloatArray]
) -> None:
    """Write by how much the parts along f_o (kind 0) or t_o miss the shares, to the state.

    ``parts`` are the effectors' wrenches at the centre, and their derivatives.
    """
    at_centre, by_twist, by_factor = parts
    num_effectors, size = at_centre.shape[1:]
    direction, share, none = (part[:, kind] for part in (wish.direction, wish.share, wish.none))
    whole = np.einsum("bk,bk->b", direction, wish.wrench)
    surplus = -share * none.any(axis=-1, keepdims=True)
    each = np.arange(num_effectors)
    rows = size + kind * num_effectors + each
    slack, excess = (3 + kind) * num_effectors + each, 5 * num_effectors + kind
    state.residual[:, rows] = (
        np.einsum("bik,bk->bi", at_centre, direction)
        - share * whole[:, None]
        + none * state.factors[:, slack]
        + surplus * state.factors[:, excess, None]
    )
    state.slope[:, rows, :size] = np.einsum("bikl,bk->bil", by_twist, direction)
    along = np.einsum("bijk,bk->bij", by_factor, direction)
    for factor in range(3):
        state.slope[:, rows, size + 3 * each + factor] = along[..., factor]
    state.slope[:, rows, size + slack] = none
    state.slope[:, rows, size + excess] = surplus
