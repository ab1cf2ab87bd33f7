"""Outlines in the plane, lens and tubes in space, scales: without Matplotlib."""

import numpy as np
import pytest

from coopenv.wrench.drawing import shapes, space
from coopenv.wrench.drawing.scene import Scene, across, round_number


def test_an_arrow_begins_and_ends_where_it_should_however_short():
    start, vector = np.array([1.0, 2.0]), np.array([0.3, -0.4])
    for width in (0.01, 10.0):  # the wide one is made thinner
        corners = shapes.arrow(start, vector, width)
        np.testing.assert_allclose(corners[3], start + vector)
        np.testing.assert_allclose((corners[0] + corners[-1]) / 2, start)
        neck = (corners[1] + corners[-2]) / 2 - start
        assert 0.0 < neck @ vector < vector @ vector


@pytest.mark.parametrize("vector", [(1.0, 0.0), (0.0, -2.0), (0.3, -0.4)])
def test_an_arrow_is_as_wide_as_it_should_be_across_its_way(vector):
    start, width = np.array([1.0, 2.0]), 0.01
    corners = shapes.arrow(start, np.array(vector), width)
    for left, right, wide in ((0, 6, width), (1, 5, width), (2, 4, 2 * shapes.SPREAD * width)):
        over = corners[left] - corners[right]
        assert np.linalg.norm(over) == pytest.approx(wide)
        assert over @ vector == pytest.approx(0.0, abs=1e-12)
        assert vector[0] * over[1] - vector[1] * over[0] > 0.0  # to the left


@pytest.mark.parametrize("sweep", [0.4, -2.0, 4.5])
def test_a_round_arrow_ends_after_its_sweep_on_its_circle(sweep):
    centre = np.array([1.0, -1.0])
    corners = shapes.round_arrow(centre, 0.5, 0.3, sweep, 0.05)
    end = centre + 0.5 * np.array([np.cos(0.3 + sweep), np.sin(0.3 + sweep)])
    assert np.linalg.norm(corners - end, axis=-1).min() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("sweep", [0.06, 0.4, -2.0])
def test_a_round_arrow_has_a_head_of_its_length_and_a_shaft_that_is_round(sweep):
    width, radius = 0.05, 0.5
    corners = shapes.round_arrow(np.zeros(2), radius, 0.0, sweep, width)
    angles = np.arctan2(corners[:, 1], corners[:, 0])
    tip = int(np.abs(angles).argmax())
    head = min(shapes.HEAD * width / radius, shapes.MOST * abs(sweep))
    assert np.abs(angles[[tip - 1, tip + 1]] - sweep) == pytest.approx(head)
    assert np.abs(np.diff(angles[: tip - 1])).max() <= 0.05 + 1e-12


def excess(points, diameter_from, diameter_to):
    """How far points lie outside a ball with that diameter."""
    centre, radius = (diameter_from + diameter_to) / 2, np.linalg.norm(diameter_to - diameter_from)
    return np.linalg.norm(points - centre, axis=-1) - radius / 2


@pytest.mark.parametrize("seed", range(5))
def test_the_lens_in_space_lies_in_both_balls_and_its_rim_on_both(seed):
    first, second = np.random.default_rng(seed).normal(size=(2, 3))
    rim, *meridians = space.lens(first, first + second)
    ends = (np.zeros(3), first), (first, first + second)
    for low, high in ends:
        np.testing.assert_allclose(excess(rim, low, high), 0.0, atol=1e-12)
        for line in meridians:
            assert excess(line, low, high).max() <= 1e-12
    on_one = [min(np.abs(excess(line, *end)).max() for end in ends) for line in meridians]
    assert max(on_one) <= 1e-12
    np.testing.assert_allclose(np.linalg.norm(rim - first, axis=-1).min(), 0.0, atol=0.1)


def test_forces_that_agree_leave_no_lens_and_opposed_ones_a_whole_ball():
    first = np.array([1.0, 2.0, 0.5])
    assert space.lens(first, 3 * first) == []
    ball = np.concatenate(space.lens(first, np.zeros(3)))
    np.testing.assert_allclose(excess(ball, np.zeros(3), first), 0.0, atol=1e-12)
    nearly = np.concatenate(space.lens(first, 1e-15 * np.ones(3)))  # as rounding leaves it
    np.testing.assert_allclose(nearly, ball, atol=1e-12)


def test_who_gives_no_force_leaves_no_lens():
    force, nothing = np.array([1.0, 2.0, 0.5]), np.zeros(3)
    for first, total in ((nothing, nothing), (nothing, force), (force, force)):
        assert space.lens(first, total) == []


def test_across_is_a_unit_vector_at_a_right_angle():
    for vector in ([3.0, -4.0], [0.0, 2.0], [1.0, 2.0, 3.0], [0.0, 0.0, -1.0]):
        found = across(np.array(vector))
        assert found @ vector == pytest.approx(0.0, abs=1e-15)
        assert np.linalg.norm(found) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("limit", "number"), [(3.0, 2.0), (10.0, 10.0), (9.99, 5.0), (0.07, 0.05), (1.2e-7, 1e-7)]
)
def test_scale_bars_are_of_round_numbers(limit, number):
    assert round_number(limit) == pytest.approx(number)


def test_forces_beside_torques_that_are_rounding_have_no_arcs_and_the_other_way_round():
    grips = np.array([(-1.0, 0.0), (1.0, 0.0)])
    for applied, force, torque in (
        ([(1.0, 0.0, 1e-12), (-1.0, 0.0, 0.0)], 1.0, 0.0),
        ([(1e-12, 0.0, 1.0), (0.0, 0.0, 0.0)], 0.0, 1.0),
    ):
        wrench = np.array(applied)
        scene = Scene(wrench, wrench, np.zeros((2, 3)), grips)
        assert (scene.largest_force, scene.largest_torque) == pytest.approx((force, torque))
