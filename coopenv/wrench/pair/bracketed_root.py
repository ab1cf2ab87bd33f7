"""Root of a compiled function in a bracket, by Chandrupatla's method."""

from collections.abc import Callable
from typing import Any

from coopenv.compiled import TINY, compiled

MAX_STEPS = 200  # a smooth function needs about 8, one that jumps 60, more at a fine resolution


def root_of(function: Callable[[float, Any], float]) -> Callable[..., float]:
    """Compile ``root(a, value_a, b, value_b, case, resolution)`` of ``function(x, case)``.

    Its values at a and b differ in sign. Inverse quadratic interpolation where that can be trusted,
    bisection elsewhere; to two units in the last place, or ``resolution``.

    Parameters
    ----------
    function
        Compiled by ``@compiled``; ``case`` is whatever it needs beside x.

    Source: Chandrupatla 1997.
    """

    @compiled
    def root(a, value_a, b, value_b, case, resolution):
        c, value_c = a, value_a
        best, step = a, 0.5
        for _ in range(MAX_STEPS):
            x = a + step * (b - a)
            value = function(x, case)
            if (value > 0.0) == (value_a > 0.0):
                c, value_c = a, value_a
            else:
                c, value_c, b, value_b = b, value_b, a, value_a
            a, value_a = x, value
            best = a if abs(value_a) < abs(value_b) else b
            tolerance = (2e-16 * abs(best) + resolution) / max(abs(b - a), TINY)
            if tolerance > 0.5 or value == 0.0:
                return best
            xi = (a - b) / (c - b)
            phi = (value_a - value_b) / (value_c - value_b)
            step = 0.5
            curved = value_c - value_a
            curved = curved if curved != 0.0 else 1.0
            if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
                step = value_a / (value_b - value_a) * value_c / (value_b - value_c)
                step += (c - a) / (b - a) * value_a / curved * value_b / (value_c - value_b)
            step = min(max(step, tolerance), 1.0 - tolerance)
        return best

    return root
