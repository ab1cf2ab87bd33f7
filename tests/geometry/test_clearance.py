"""Distances of outlines from boxes and walls, against independent geometry."""

import numpy as np
import pymunk
import pytest

from coopenv import Body, Box, Scene
from coopenv.conditions import Load, Room
from coopenv.geometry.clearance import ways_to_boxes, ways_to_walls
from tests.helpers import CLUTTERED, corners

TRIANGLE = Body(outline=((-0.5, -0.4), (0.8, 0.0), (-0.5, 0.4)))
BODIES = {"walker": Body.walker(), "beam": Body(), "triangle": TRIANGLE}


def ways(body, poses, scenes):
    """`ways_to_boxes` and `ways_to_walls` of a body at poses ``(world, 3)``, one scene each."""
    room = Room.of(scenes, max(len(scene.obstacles) for scene in scenes))
    outline = Load.of([body] * len(poses), 4).outline
    boxes = ways_to_boxes(outline, poses, room.boxes, room.count)
    return boxes, ways_to_walls(outline, poses, room.size)


def random_poses(count, seed=0, half=3.0):
    return np.random.default_rng(seed).uniform(-1, 1, (count, 3)) * (half, half, np.pi)


def random_scenes(count, seed=1):
    generator = np.random.default_rng(seed)
    return [
        Scene(
            obstacles=tuple(
                Box(
                    center=tuple(generator.uniform(-2.5, 2.5, 2)),
                    size=tuple(generator.uniform(0.1, 1.5, 2)),
                    angle=generator.uniform(-np.pi, np.pi),
                )
                for _ in range(2)
            )
        )
        for _ in range(count)
    ]


def edges(polygon):
    return zip(polygon, np.roll(polygon, -1, axis=0), strict=True)


def _cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def distance_between(first, second):
    """Of two convex polygons, by pymunk's queries: from each corner to the other polygon."""
    nearest = np.inf
    for corner_set, polygon in ((first, second), (second, first)):
        shape = pymunk.Poly(pymunk.Body(body_type=pymunk.Body.STATIC), polygon.tolist())
        shape.cache_bb()
        nearest = min(nearest, *(shape.point_query(tuple(c)).distance for c in corner_set.tolist()))
    return nearest


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_the_distance_from_a_box_is_that_of_an_independent_query(body):
    poses, scenes = random_poses(300), random_scenes(300)
    found, _ = ways(body, poses, scenes)
    outlines = corners(poses, body)
    touching = 0
    for k, scene in enumerate(scenes):
        for j, box in enumerate(scene.obstacles):
            if not Scene(obstacles=(box,)).is_clear(outlines[k]):
                assert found[k, j, 0] == 0.0
                touching += 1
            else:
                wanted = distance_between(outlines[k], box.vertices)
                assert found[k, j, 0] == pytest.approx(wanted, abs=1e-9)
    assert touching > 20


def test_the_way_leads_from_the_outline_to_the_point_it_names():
    poses, scenes = random_poses(200), random_scenes(200)
    found, _ = ways(TRIANGLE, poses, scenes)
    for k, scene in enumerate(scenes):
        for (distance, x, y, *point), box in zip(found[k], scene.obstacles, strict=True):
            assert np.hypot(x, y) == pytest.approx(1.0)
            if distance == 0.0:
                continue
            start = np.array(point) - distance * np.array([x, y])
            for place, polygon in ((point, box.vertices), (start, corners(poses[k], TRIANGLE))):
                off = [_cross(b - a, place - a) / np.linalg.norm(b - a) for a, b in edges(polygon)]
                assert np.abs(off).min() < 1e-9


def test_a_beam_across_a_box_overlaps_it_though_no_corner_lies_in_the_other():
    cross = Scene(obstacles=(Box(center=(0.0, 0.0), size=(0.2, 3.0)),))
    found, _ = ways(Body(), np.zeros((1, 3)), [cross])
    assert found[0, 0, 0] == 0.0


def test_boxes_that_are_not_there_are_infinitely_far():
    found, _ = ways(Body(), np.zeros((2, 3)), [CLUTTERED, Scene(size=CLUTTERED.size)])
    assert np.isfinite(found[0, :, 0]).all()
    assert np.isinf(found[1, :, 0]).all()


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_walls_are_as_far_as_the_outmost_corner(body):
    poses = random_poses(100)
    _, walls = ways(body, poses, [CLUTTERED] * 100)
    outlines, half = corners(poses, body), np.array(CLUTTERED.size) / 2
    wanted = [(half - outlines.max(axis=1)), (half + outlines.min(axis=1))]
    np.testing.assert_allclose(walls[:, [0, 2]], wanted[0], atol=1e-12)
    np.testing.assert_allclose(walls[:, [1, 3]], wanted[1], atol=1e-12)
