"""Who enters a platform first, and how narrow a body can be made."""

import numpy as np
import pytest

from coopenv import Body
from coopenv.errors import InvalidInput
from coopenv.tasks.passage import entry_times, first_to_enter, grips_in_world, narrowest

PLATFORM = ((1.0, -1.0), (3.0, 1.0))


def driven(poses):
    """Grips of the default beam ``(step, agent, 2)`` along poses."""
    return grips_in_world(np.array(poses, dtype=float), Body().grips)


def test_the_agent_ahead_enters_first():
    along = np.linspace(-1, 2, 50)
    ahead = driven([(x, 0, 0) for x in along])
    assert first_to_enter(ahead, PLATFORM) == 1
    assert first_to_enter(driven([(x, 0, np.pi) for x in along]), PLATFORM) == 0
    times = entry_times(ahead, PLATFORM, dt=0.1)
    wanted = (np.array([1.9, 0.1]) + 1) / 3 * 49 * 0.1  # x = 1 ± 0.9 of the centre
    np.testing.assert_allclose(times, wanted, atol=1e-9)


def test_nobody_has_entered_where_nobody_was_on_it():
    away = driven([(x, 0, 0) for x in np.linspace(-3, 0, 9)])
    assert first_to_enter(away, PLATFORM) == -1
    assert np.isinf(entry_times(away, PLATFORM)).all()


def test_agents_that_enter_within_one_step_are_told_apart():
    path = np.array([[[0.5, 0.0], [0.8, 0.2]], [[1.1, 0.0], [1.1, 0.2]]])
    assert first_to_enter(path, PLATFORM) == 1
    np.testing.assert_allclose(entry_times(path, PLATFORM), [5 / 6, 2 / 3])


def test_leaving_again_changes_nothing_and_a_start_on_it_counts_from_zero():
    path = np.array([[[2.0, 0], [0, 0]], [[0, 0], [2.0, 0]], [[0, 0], [2.0, 0]]])
    np.testing.assert_allclose(entry_times(path, PLATFORM), [0.0, 0.5])
    assert first_to_enter(path, PLATFORM) == 0


def test_many_worlds_are_answered_at_once():
    along = np.linspace(-1, 2, 30)
    poses = np.stack(
        [np.stack([along, 0 * along, 0 * along + angle], axis=-1) for angle in (0, np.pi)], axis=1
    )
    assert first_to_enter(grips_in_world(poses, Body().grips), PLATFORM).tolist() == [1, 0]


def test_wrong_shapes_are_refused():
    with pytest.raises(InvalidInput, match=r"grips must have shape \(step"):
        entry_times(np.zeros((4, 2)), PLATFORM)
    with pytest.raises(InvalidInput, match="platform must be two corners"):
        entry_times(np.zeros((4, 2, 2)), (1.0, 2.0))


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
