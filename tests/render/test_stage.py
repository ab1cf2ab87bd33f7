"""Pictures of a recorded trial: the object where its pose says, its wrenches at its grips."""

import numpy as np
import pytest

pytest.importorskip("pygame")

from coopenv.errors import InvalidInput
from coopenv.render.look import APPLIED, BODY, FLOOR, GRID, INTERNAL
from coopenv.render.stage import Stage

BAR = np.array([(-0.5, 0.0), (0.5, 0.0)])
POSE = np.array([(-1.0, -0.5, 0.0), (1.0, 0.5, np.pi / 2), (np.nan, 0.0, 0.0)])
PUSH = np.array([(10.0, 0.0, 0.0), (0.0, 0.0, 0.0)])


def stage(applied=None, internal=None, grips=BAR, pose=POSE) -> Stage:
    nothing = np.zeros((len(pose), len(grips), 3))
    return Stage(
        pose,
        grips,
        nothing if applied is None else applied,
        nothing if internal is None else internal,
        width=320,
    )


def middle(picture, color) -> np.ndarray:
    """Mean place of a colour, (x, y) [px]; the legend left out."""
    rows, columns = np.nonzero((picture[:-50] == color).all(axis=-1))
    return np.array([columns.mean(), rows.mean()])


def extent(picture, color) -> np.ndarray:
    rows, columns = np.nonzero((picture[:-50] == color).all(axis=-1))
    return np.array([np.ptp(columns), np.ptp(rows)])


def test_the_object_lies_where_its_pose_says_y_up():
    drawn = stage()
    first, second = (drawn.picture(row) for row in (0, 1))
    step = middle(second, BODY) - middle(first, BODY)
    metre = step[0] / 2.0  # [px]
    assert step[1] == pytest.approx(-metre, abs=3)
    assert extent(first, BODY)[0] > 3 * extent(first, BODY)[1]
    assert extent(second, BODY)[1] > 3 * extent(second, BODY)[0]


def test_of_a_row_without_pose_the_floor_alone_is_drawn():
    lost = stage().picture(2)
    assert not (lost[:-50] == BODY).all(axis=-1).any()
    with pytest.raises(InvalidInput, match="pose must be finite in some rows"):
        stage(pose=POSE[2:])


def test_arrows_turn_with_the_object_and_the_internal_one_is_in_the_applied():
    applied = np.broadcast_to(PUSH, (3, 2, 3))
    drawn = stage(applied, applied)
    flat, upright = (extent(drawn.picture(row), INTERNAL) for row in (0, 1))
    assert flat[0] > 3 * flat[1]
    assert upright[1] > 3 * upright[0]
    assert not (stage(applied).picture(0)[:-50] == INTERNAL).all(axis=-1).any()
    assert extent(stage(applied).picture(0), APPLIED)[0] > 20


def test_wrenches_of_a_bad_row_are_not_drawn():
    applied = np.full((3, 2, 3), np.nan)
    applied[1] = PUSH
    drawn = stage(applied, applied)
    assert not (drawn.picture(0)[:-50] == APPLIED).all(axis=-1).any()
    assert (drawn.picture(0)[:-50] == BODY).all(axis=-1).any()
    assert (drawn.picture(1)[:-50] == APPLIED).all(axis=-1).any()


@pytest.mark.parametrize("num_effectors", [1, 2, 3, 5])
def test_any_number_of_grips_makes_an_object(num_effectors):
    turns = np.arange(num_effectors) * 2 * np.pi / num_effectors
    grips = np.stack([np.cos(turns), np.sin(turns)], axis=-1)[::-1]
    assert (stage(grips=grips).picture(0)[:-50] == BODY).all(axis=-1).sum() > 100


def test_the_order_of_the_grips_does_not_change_the_object():
    square = np.array([(-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4)])
    for order in ((0, 2, 1, 3), (1, 0, 2, 3), (3, 0, 2, 1)):
        given, sorted_ = (stage(grips=each).picture(1) for each in (square[list(order)], square))
        assert (given != sorted_).mean() < 0.005  # but for what smooths the outline


def test_two_grips_beside_the_centre_of_mass_are_joined_through_it():
    flat = np.array([(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    drawn = stage(grips=BAR + np.array([0.0, 0.4]), pose=flat)
    first, second = (drawn.picture(row) for row in (0, 1))
    metre = (middle(second, BODY) - middle(first, BODY))[0] / 2.0  # [px]
    assert extent(first, BODY)[1] > 0.4 * metre


@pytest.mark.parametrize("place", [(0.0, 0.0), (3.0, -2.0)])
def test_lines_of_the_grid_lie_evenly_from_edge_to_edge_both_ways(place):
    picture = stage(pose=np.array([(*place, 0.0), (np.nan, 0.0, 0.0)])).picture(1)
    floor = picture[(picture == FLOOR).all(axis=-1).any(axis=1).nonzero()[0].min() :][:300]
    is_grid = (floor == GRID).all(axis=-1)
    for axis in (0, 1):
        (lines,) = np.nonzero(is_grid.mean(axis=axis) > 0.9)
        apart = np.diff(lines)
        assert np.ptp(apart) <= 1
        assert lines[0] <= apart.max()
        assert is_grid.shape[1 - axis] - lines[-1] <= apart.max()


def test_grips_at_the_centre_of_mass_make_an_object_too():
    drawn = stage(grips=np.zeros((1, 2)), pose=POSE[:1])
    assert (drawn.picture(0)[:-50] == BODY).all(axis=-1).any()
