"""Steps of the interior-point method stay in their cones, whatever rounding does."""

from fractions import Fraction

import numpy as np
from numba import njit

from coopenv.compiled.lanes.memory import four_at
from coopenv.wrench.structured.cones import (
    CONE,
    DET_S,
    DET_Z,
    DS,
    DZ,
    INNER,
    SQUARE,
    Q,
    S,
    W,
    Z,
    inner,
    longest_step,
    scale,
    write_corrector,
)

TRIALS = 2000


@njit(error_model="numpy")
def _longest_steps(address):
    """Write the longest steps of four cones where the det stood."""
    cone = four_at(address)
    cone[DET_Z] = longest_step(cone, Z, DZ, cone[DET_Z])


@njit(error_model="numpy")
def _inner_products(address):
    """Write the inner products of four pairs of points where the det of s stood."""
    cone = four_at(address)
    cone[DET_S] = inner(cone)


@njit(error_model="numpy")
def _correctors(address, target):
    """Write the right-hand sides of the corrector; a cone is there where dz has a positive head."""
    cone = four_at(address)
    scale(cone)
    write_corrector(cone, target, cone[DZ] > 0.0)


def _longest(z, dz):
    """Longest steps ``(4,)`` of the four points z along dz ``(4, 4)``, one a row."""
    cone = np.zeros((CONE, 4))
    cone[Z : Z + 4], cone[DZ : DZ + 4] = z.T, dz.T
    length = np.linalg.norm(z[:, 1:], axis=-1)
    cone[DET_Z] = (z[:, 0] - length) * (z[:, 0] + length)
    _longest_steps(cone.ctypes.data)
    return cone[DET_Z]


def _inside(rng, apart):
    """Four points in the cone, ``apart`` of their size from its boundary."""
    tail = rng.normal(size=(4, 3))
    head = np.linalg.norm(tail, axis=-1, keepdims=True) * (1.0 + apart)
    return np.concatenate([head, tail], axis=-1) * 10.0 ** rng.uniform(-8.0, 8.0, (4, 1))


def test_a_step_ends_on_the_boundary():
    rng = np.random.default_rng(0)
    for _ in range(TRIALS):
        z, dz = _inside(rng, 1.0), rng.normal(size=(4, 4))
        dz *= z[:, :1]
        dz[:, 0] = -np.abs(dz[:, 0]) - 0.1 * z[:, 0]
        end = z + _longest(z, dz)[:, None] * dz
        outside = np.linalg.norm(end[:, 1:], axis=-1) - end[:, 0]
        assert (np.abs(outside) <= 1e-13 * z[:, 0]).all()


def test_a_step_along_a_ray_of_the_cone_never_ends():
    rng = np.random.default_rng(1)
    z = _inside(rng, 0.1)
    np.testing.assert_array_equal(_longest(z, z), np.inf)


def test_no_step_leads_through_the_apex_however_near_the_boundary_it_begins():
    # behind it -z is in the cone, and det z as positive as before
    rng = np.random.default_rng(2)
    for _ in range(TRIALS):
        apart, off = 10.0 ** rng.uniform(-16.0, 0.0, 2)
        z = _inside(rng, apart)
        factor = rng.uniform(0.5, 3.0, (4, 1))
        dz = -factor * (z + off * z[:, :1] * rng.normal(size=(4, 4)))
        step, towards = _longest(z, dz), dz[:, 0] < 0.0
        assert (z[towards, 0] + step[towards] * dz[towards, 0] >= -1e-15 * z[towards, 0]).all()


def _exactly(a, b, signs=(1, 1, 1, 1)):
    return sum(n * Fraction(x) * Fraction(y) for n, x, y in zip(signs, a, b, strict=True))


def test_the_product_of_nearly_opposite_points_keeps_its_digits():
    rng = np.random.default_rng(4)
    for apart in (1.0, 1e-4, 1e-8, 1e-12):
        s = _inside(rng, apart)
        z = s * [1.0, -1.0, -1.0, -1.0] * 10.0 ** rng.uniform(-3, 3, (4, 1))
        z[:, 1:] *= 1.0 + apart * rng.normal(size=(4, 3))
        z[:, 0] = np.linalg.norm(z[:, 1:], axis=-1) * (1.0 + apart)
        cone = np.zeros((CONE, 4))
        cone[S : S + 4], cone[Z : Z + 4] = s.T, z.T
        for place, point in ((DET_S, s), (DET_Z, z)):
            cone[place] = [float(_exactly(one, one, (1, -1, -1, -1))) for one in point]
        expected = [float(_exactly(a, b)) for a, b in zip(s, z, strict=True)]
        _inner_products(cone.ctypes.data)
        np.testing.assert_allclose(cone[DET_S], expected, rtol=1e-3 * apart**0.5 + 1e-11)


def _arrow(x):
    """The matrix of the product ∘ with x."""
    return np.block([[x[:1], x[1:]], [x[1:, None], x[0] * np.eye(3)]])


def test_a_corrector_is_that_of_its_formula_and_nothing_where_there_is_no_cone():
    rng, target, mirror = np.random.default_rng(5), 0.3, np.array([1.0, -1.0, -1.0, -1.0])
    cone, there = np.zeros((CONE, 4)), np.array([True, False, True, False])
    s, z = (_inside(rng, 0.5) for _ in range(2))
    s, z = s / s[:, :1], z / z[:, :1]
    cone[S : S + 4], cone[Z : Z + 4], cone[DZ] = s.T, z.T, there
    cone[DS : DS + 4] = 0.1 * rng.normal(size=(4, 4))
    cone[DET_S], cone[DET_Z], cone[INNER] = s**2 @ mirror, z**2 @ mirror, (s * z).sum(axis=1)
    _correctors(cone.ctypes.data, target)
    np.testing.assert_array_equal(cone[Q : Q + 4, ~there], 0.0)
    for k in np.flatnonzero(there):
        w = cone[W : W + 4, k]
        scaling = _arrow(w)
        scaling[1:, 1:] = np.eye(3) + np.outer(w[1:], w[1:]) / (1 + w[0])
        scaling /= np.sqrt(cone[SQUARE, k])
        scaled = scaling @ z[k]
        np.testing.assert_allclose(scaled, np.linalg.solve(scaling, s[k]), rtol=1e-10)
        u = np.linalg.solve(scaling, cone[DS : DS + 4, k])
        second = np.linalg.solve(_arrow(scaled), _arrow(u) @ u)
        inverse = mirror * s[k] / (s[k] ** 2 @ mirror)
        expected = -z[k] + target * inverse + np.linalg.solve(scaling, u + second)
        np.testing.assert_allclose(cone[Q : Q + 4, k], expected, rtol=1e-10, atol=1e-12)
