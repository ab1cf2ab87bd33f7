"""Shortest ways round boxes."""

from itertools import pairwise

import numpy as np
import pytest

from coopenv import Box, Scene
from coopenv.conditions import Room
from coopenv.geometry.routes import next_stops


def way(start, goal, *boxes, radius=0.5, size=(10.0, 10.0)):
    """Corners of the whole way ``(corner, 2)``, found leg by leg, and its length as first told."""
    room = Room.of([Scene(size=size, obstacles=boxes)], len(boxes))
    here, end, stops, told = np.array([start]), np.array([goal]), [np.array(start)], []
    while not np.array_equal(here, end):
        here, length = next_stops(here, end, room.boxes, room.count, room.size, np.array([radius]))
        stops.append(here[0])
        told.append(length[0, 0])
        assert len(stops) < 10
    return np.array(stops), told[0]


def total(stops):
    return np.linalg.norm(np.diff(stops, axis=0), axis=1).sum()


def test_nothing_in_between_means_straight_on():
    stops, length = way((-3.0, 0.0), (3.0, 0.0), Box(center=(0.0, 2.0), size=(1.0, 1.0)))
    np.testing.assert_array_equal(stops, [(-3.0, 0.0), (3.0, 0.0)])
    assert length == 6.0


def test_a_box_is_passed_on_its_nearer_side_at_the_discs_radius():
    box = Box(center=(0.0, 0.1), size=(1.0, 1.0))
    stops, length = way((-3.0, 0.0), (3.0, 0.0), box)
    assert (stops[1:-1, 1] < 0).all()
    np.testing.assert_allclose(stops[1:-1], [(-1.02, -0.92), (1.02, -0.92)], atol=1e-12)
    assert length == pytest.approx(total(stops))


def test_where_the_near_side_is_blocked_by_the_wall_the_far_one_is_taken():
    box = Box(center=(0.0, -0.6), size=(1.0, 1.0))
    stops, _ = way((-3.0, -0.6), (3.0, -0.7), box, size=(10.0, 4.0))
    assert (stops[1:-1, 1] > 0).all()


def test_where_no_way_leads_round_the_length_is_infinite():
    fence = Box(center=(0.0, 0.0), size=(0.2, 9.5))
    stops, length = way((-3.0, 0.0), (3.0, 0.0), fence)
    assert np.isinf(length)
    np.testing.assert_array_equal(stops[1], (3.0, 0.0))


def test_a_disc_that_starts_too_near_a_box_may_leave_it():
    box = Box(center=(0.0, 0.0), size=(1.0, 1.0))
    stops, length = way((-0.6, 0.0), (3.0, 0.0), box)
    assert np.isfinite(length)
    assert abs(stops[1, 1]) > 0.5


def test_the_turns_and_the_last_direction_are_those_of_the_corners():
    box = Box(center=(0.0, 0.1), size=(1.0, 1.0))
    stops, _ = way((-3.0, 0.0), (3.0, 0.0), box)
    room = Room.of([Scene(size=(10.0, 10.0), obstacles=(box,))], 1)
    _, told = next_stops(stops[:1], stops[-1:], room.boxes, room.count, room.size, np.array([0.5]))
    legs = np.diff(stops, axis=0)
    angles = np.arctan2(legs[:, 1], legs[:, 0])
    np.testing.assert_allclose(told[0, 1:], [np.abs(np.diff(angles)).sum(), angles[-1]], atol=1e-12)


def test_no_leg_comes_nearer_to_a_box_than_the_radius():
    generator = np.random.default_rng(0)
    bent = 0
    for _ in range(200):
        boxes = [
            Box(
                center=tuple(generator.uniform(-2, 2, 2)),
                size=tuple(generator.uniform(0.3, 1.2, 2)),
                angle=generator.uniform(0, np.pi),
            )
            for _ in range(3)
        ]
        stops, length = way((-4.0, 0.0), (4.0, generator.uniform(-2, 2)), *boxes)
        if np.isinf(length):
            continue
        bent += len(stops) > 2
        assert length == pytest.approx(total(stops))
        points = np.concatenate(
            [a + np.linspace(0, 1, 50)[:, None] * (b - a) for a, b in pairwise(stops)]
        )
        for box in boxes:
            c, s = np.cos(box.angle), np.sin(box.angle)
            inside = np.abs((points - box.center) @ np.array([[c, -s], [s, c]]))
            away = np.linalg.norm(np.maximum(inside - np.array(box.size) / 2, 0.0), axis=1)
            assert away.min() >= 0.5 - 1e-9
    assert bent > 50
