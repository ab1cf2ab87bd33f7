"""The room: where its solids are, and what it refuses."""

import numpy as np
import pytest

from coopenv import Box, Scene
from coopenv.errors import InvalidInput
from coopenv.physics.scene import WALL_THICKNESS


def inside(points, polygon):
    """Whether any of the points ``(..., 2)`` lies in a counter-clockwise convex polygon."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    away = np.asarray(points)[..., None, :] - polygon
    left = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0] >= 0
    return bool(left.all(axis=-1).any())


def test_walls_enclose_the_room_and_nothing_of_it():
    scene = Scene(size=(4.0, 3.0))
    solids = scene.solids()
    for x, y in np.random.default_rng(0).uniform(-4, 4, (2000, 2)):
        in_room = abs(x) < 2.0 and abs(y) < 1.5
        in_wall = not in_room and abs(x) < 2.0 + WALL_THICKNESS and abs(y) < 1.5 + WALL_THICKNESS
        assert any(inside((x, y), solid) for solid in solids) == in_wall


def test_walls_are_thick_enough_to_stop_a_beam_between_two_substeps():
    assert WALL_THICKNESS >= 1.0


def test_a_box_has_its_corners_where_its_angle_puts_them():
    box = Box(center=(1.0, 2.0), size=(2.0, 1.0), angle=np.pi / 2)
    np.testing.assert_allclose(
        box.vertices, [(1.5, 1.0), (1.5, 3.0), (0.5, 3.0), (0.5, 1.0)], atol=1e-15
    )


def test_a_box_keeps_its_size_at_any_angle():
    corners = Box(center=(0.3, -2.0), size=(2.0, 1.0), angle=0.7).vertices
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=-1)
    np.testing.assert_allclose(sides, [2.0, 1.0, 2.0, 1.0], rtol=1e-14)
    np.testing.assert_allclose(corners.mean(axis=0), (0.3, -2.0), atol=1e-15)


def test_obstacles_are_solids_after_the_walls():
    box = Box(center=(0.0, 0.0), size=(1.0, 1.0))
    solids = Scene(obstacles=(box,)).solids()
    assert len(solids) == 5
    np.testing.assert_array_equal(solids[-1], box.vertices)


def test_clear_means_no_overlap_at_any_angle():
    scene = Scene(obstacles=(Box(center=(0.5, -0.3), size=(1.2, 0.4), angle=0.6),))
    box = scene.obstacles[0].vertices
    generator = np.random.default_rng(1)
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.3
    seen = set()
    for x, y, angle in generator.uniform(-1.5, 1.5, (400, 3)):
        c, s = np.cos(angle), np.sin(angle)
        outline = square @ np.array([[c, s], [-s, c]]) + (x, y)
        # dense points of each polygon against the other: overlap without separating axes
        weights = generator.dirichlet(np.ones(4), 300)
        touch = inside(weights @ outline, box) or inside(weights @ box, outline)
        clear = scene.is_clear(outline)
        assert not (clear and touch)
        seen.add(clear)
    assert seen == {True, False}


def test_a_cross_overlaps_although_no_corner_is_inside():
    scene = Scene(obstacles=(Box(center=(0.0, 0.0), size=(4.0, 0.2)),))
    assert not scene.is_clear(Box(center=(0.0, 0.0), size=(0.2, 4.0)).vertices)
    assert scene.is_clear(Box(center=(2.2, 0.0), size=(0.2, 4.0)).vertices)


def test_a_point_is_free_inside_the_room_and_off_the_obstacles():
    scene = Scene(size=(4.0, 3.0), obstacles=(Box(center=(1.0, 0.5), size=(1.0, 0.2), angle=0.3),))
    assert scene.is_free(0.0, 0.0)
    assert not scene.is_free(1.0, 0.5)
    assert scene.is_free(1.0, 0.8)
    assert not scene.is_free(2.1, 0.0)
    assert not scene.is_free(0.0, -1.6)


def test_scenes_of_equal_values_are_equal_and_can_be_keys():
    box = Box(center=(1, 1), size=(1, 1))
    first, second = Scene(obstacles=(box,)), Scene(obstacles=[box])  # pyright: ignore[reportArgumentType]
    assert {first, second} == {first}


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"size": (0.0, 3.0)}, r"scene\.size must be positive"),
        ({"size": (3.0, -3.0)}, r"scene\.size must be positive"),
        ({"size": 3.0}, r"scene\.size must be two numbers"),
        ({"size": (3.0, float("nan"))}, r"scene\.size must be finite"),
        ({"friction": -1.0}, r"scene\.friction must be zero or positive"),
        ({"obstacles": ((0.0, 0.0),)}, r"scene\.obstacles must be a sequence of Box"),
        ({"obstacles": Box(center=(0, 0), size=(1, 1))}, r"scene\.obstacles must be a seq"),
    ],
)
def test_a_room_that_cannot_be_is_refused_by_the_name_of_its_fault(values, named):
    with pytest.raises(InvalidInput, match=named):
        Scene(**values)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"center": (0.0, 0.0), "size": (1.0, 0.0)}, r"obstacle\.size must be positive"),
        ({"center": (0.0,), "size": (1.0, 1.0)}, r"obstacle\.center must be two numbers"),
        ({"center": (0, 0), "size": (1, 1), "angle": float("inf")}, r"obstacle\.angle must be fin"),
        ({"center": (0, 0), "size": (1, 1), "angle": (1.0, 2.0)}, r"obstacle\.angle must be"),
    ],
)
def test_a_box_that_cannot_be_is_refused_by_the_name_of_its_fault(values, named):
    with pytest.raises(InvalidInput, match=named):
        Box(**values)
