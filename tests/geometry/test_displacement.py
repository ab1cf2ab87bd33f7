"""Displacement of a step: the mean of its twist along the body's own axes."""

import numpy as np
import pytest
from scipy.integrate import quad

from coopenv.compiled import compiled
from coopenv.geometry.displacement import mean_twist


@compiled
def _mean(pose, twist, next_pose, next_twist, dt):
    return mean_twist(pose, twist, next_pose, next_twist, 0, dt)


@pytest.mark.parametrize("turn", [0.01, 0.3, 0.49, 0.499999, 0.500001, 0.8, 2.0])
def test_a_body_that_turns_and_speeds_up_evenly_has_its_exact_mean(turn):
    dt, begin, end = 0.05, np.array([0.7, -0.4]), np.array([-1.1, 0.9])
    spin = turn / dt

    def along(k, s):
        vx, vy = begin + (end - begin) * s
        c, n = np.cos(0.3 + turn * s), np.sin(0.3 + turn * s)
        return (c * vx + n * vy, -n * vx + c * vy)[k]

    moved = dt * (begin + end) / 2
    found = _mean(
        np.array([[0.0, 0.0, 0.3]]), np.array([[*begin, spin]]),
        np.array([[*moved, 0.3 + turn]]), np.array([[*end, spin]]), dt,
    )  # fmt: skip
    expected = [quad(lambda s, k=k: along(k, s), 0, 1, epsabs=1e-14)[0] for k in (0, 1)]
    np.testing.assert_allclose(found, [*expected, spin], rtol=0, atol=1e-12)
