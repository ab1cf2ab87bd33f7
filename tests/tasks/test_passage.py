"""How narrow a body can be made."""

import numpy as np
import pytest

from coopenv import Body
from coopenv.tasks.passage import narrowest


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_the_least_width_of_a_turned_rectangle_is_its_shorter_side(angle):
    c, s = np.cos(angle), np.sin(angle)
    outline = tuple((c * x - s * y, s * x + c * y) for x, y in Body().outline)
    shape = narrowest(outline)
    assert shape.width == pytest.approx(0.1)
    assert shape.ahead == pytest.approx(1.0)
    assert np.sin(shape.along - angle) == pytest.approx(0.0, abs=1e-9)


def test_the_least_width_agrees_with_a_search_over_all_angles():
    outline = ((-0.5, -0.3), (1.0, 0.0), (0.2, 0.6), (-0.4, 0.5))
    angles = np.linspace(0, np.pi, 20001)
    across = np.array(outline) @ np.stack([np.cos(angles), np.sin(angles)])
    assert narrowest(outline).width == pytest.approx(np.ptp(across, axis=0).min(), rel=1e-3)
