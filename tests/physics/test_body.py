"""The carried object: inertia of its outline, and what it refuses."""

import numpy as np
import pytest

from coopenv import Body
from coopenv.errors import InvalidInput


def test_the_default_is_the_papers_beam_held_off_the_tie_at_one_metre():
    body = Body()
    assert (body.mass, body.num_agents) == (7.7, 2)
    np.testing.assert_array_equal(body.grips, [(-0.9, 0.0), (0.9, 0.0)])
    assert np.ptp(np.array(body.outline), axis=0) == pytest.approx([2.0, 0.1])


@pytest.mark.parametrize(
    ("length", "width", "mass"), [(2.0, 0.1, 7.7), (0.5, 0.5, 1.0), (3, 1, 40)]
)
def test_a_beams_inertia_is_the_textbooks(length, width, mass):
    body = Body.beam(length=length, width=width, mass=mass)
    assert body.inertia == pytest.approx(mass * (length**2 + width**2) / 12, rel=1e-14)


def test_a_regular_polygon_with_many_corners_has_the_inertia_of_a_disc():
    angle = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    body = Body(mass=2.0, outline=tuple(zip(np.cos(angle), np.sin(angle), strict=True)))
    assert body.inertia == pytest.approx(2.0 / 2, rel=1e-4)


def test_the_inertia_of_a_triangle_about_its_centroid_is_the_textbooks():
    side = 1.3
    height = side * np.sqrt(3) / 2
    outline = ((-side / 2, -height / 3), (side / 2, -height / 3), (0.0, 2 * height / 3))
    assert Body(mass=3.0, outline=outline).inertia == pytest.approx(3.0 * side**2 / 12, rel=1e-14)


def test_a_clockwise_outline_is_the_same_body():
    forward = Body()
    backward = Body(outline=forward.outline[::-1])
    assert backward.inertia == pytest.approx(forward.inertia, rel=1e-15)
    assert backward.reach == forward.reach


def test_a_given_inertia_is_taken_as_it_is():
    assert Body(inertia=0.123).inertia == 0.123


def test_reach_is_the_farthest_corner():
    assert Body().reach == pytest.approx(np.hypot(1.0, 0.05))
    assert Body(outline=((-3, -1), (1, -1), (0, 2))).reach == pytest.approx(np.hypot(3, 1))


def test_a_beam_is_held_a_twentieth_of_its_length_inside_its_ends_unless_told_otherwise():
    np.testing.assert_allclose(Body.beam(length=3.0).grips, [(-1.35, 0.0), (1.35, 0.0)])
    assert Body.beam(length=3.0, grips=((0.0, 0.0),)).num_agents == 1


def test_bodies_of_equal_values_are_equal_and_can_be_keys():
    assert {Body(mass=3), Body(mass=3.0), Body()} == {Body(mass=3.0), Body()}


def test_lists_and_arrays_are_read_as_points():
    grips = [[-0.5, 0.0], [0.5, 0.0], [0.0, 0.04]]
    assert Body(grips=grips) == Body(grips=np.array(grips))  # pyright: ignore[reportArgumentType]


PENTAGRAM = tuple(
    (float(np.cos(angle)), float(np.sin(angle))) for angle in 4 * np.pi / 5 * np.arange(5)
)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"mass": 0.0}, r"body\.mass must be positive"),
        ({"mass": -1.0}, r"body\.mass must be positive"),
        ({"mass": float("nan")}, r"body\.mass must be finite"),
        ({"mass": float("inf")}, r"body\.mass must be finite"),
        ({"mass": "heavy"}, r"body\.mass must be a number"),
        ({"mass": True}, r"body\.mass must be a number"),
        ({"inertia": 0.0}, r"body\.inertia must be positive"),
        ({"linear_drag": -0.1}, r"body\.linear_drag must be zero or positive"),
        ({"angular_drag": -0.1}, r"body\.angular_drag must be zero or positive"),
        ({"friction": -0.1}, r"body\.friction must be zero or positive"),
        ({"grips": ()}, r"body\.grips must be at least 1 points"),
        ({"grips": ((0.0, 0.0, 0.0),)}, r"body\.grips must be at least 1 points"),
        ({"grips": ((0.0, float("nan")),)}, r"body\.grips must be finite"),
        ({"grips": ((0.0,), (0.0, 1.0))}, r"body\.grips must be an array of numbers"),
        ({"outline": ((0, 0), (1, 1))}, r"body\.outline must be at least 3 points"),
        ({"outline": ((1, 1), (2, 1), (2, 2))}, r"body\.outline must be a convex polygon around"),
        ({"outline": ((-1, -1), (0, -0.2), (1, -1), (0, 2))}, r"body\.outline must be a convex"),
        ({"outline": ((-1, 0), (1, 0), (0, 2))}, r"body\.outline must be a convex polygon around"),
        ({"outline": PENTAGRAM}, r"body\.outline must be a convex polygon"),
    ],
)
def test_a_body_that_cannot_be_is_refused_by_the_name_of_its_fault(values, named):
    with pytest.raises(InvalidInput, match=named):
        Body(**values)


@pytest.mark.parametrize(("size", "named"), [("length", "length"), ("width", "width")])
def test_a_beam_without_extent_is_refused(size, named):
    with pytest.raises(InvalidInput, match=rf"body\.{named} must be positive"):
        Body.beam(**{size: 0.0})


@pytest.mark.parametrize("count", [1, 2, 3, 4, 8, 13])
@pytest.mark.parametrize(
    "shape", [{}, {"radius": 0.4, "sides": 5}, {"radius": 2.0, "sides": 3}, {"size": (1.2, 0.7)}]
)
def test_a_plate_is_held_evenly_round_its_rim(count, shape):
    plate = Body.plate(count, **shape)
    assert plate.num_agents == count
    rim, grips = np.array(plate.outline), np.array(plate.grips) / 0.9
    edges = np.roll(rim, -1, axis=0) - rim
    lengths = np.linalg.norm(edges, axis=1)
    walked = []
    for grip in grips:  # how far along the rim each grip is
        along = ((grip - rim) * edges).sum(axis=1) / lengths
        off = np.abs(edges[:, 0] * (grip - rim)[:, 1] - edges[:, 1] * (grip - rim)[:, 0]) / lengths
        on = (off < 1e-9) & (along > -1e-9) & (along < lengths + 1e-9)
        edge = int(np.flatnonzero(on)[0])
        walked.append(lengths[:edge].sum() + along[edge])
    assert grips[0, 0] > 0
    assert grips[0, 1] == pytest.approx(0.0, abs=1e-9)
    around = lengths.sum()
    gaps = (np.roll(walked, -1) - walked) % around
    np.testing.assert_allclose(gaps, around / count if count > 1 else 0.0, atol=1e-9)


def test_a_plate_takes_the_other_fields_and_grips_of_its_own():
    plate = Body.plate(3, radius=0.5, mass=2.0, grips=((0.1, 0.0), (0.0, 0.1)))
    assert (plate.mass, plate.num_agents) == (2.0, 2)
    disc = Body.plate(2, radius=0.5, sides=200, mass=2.0)
    assert disc.inertia == pytest.approx(2.0 * 0.5**2 / 2, rel=1e-3)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"num_agents": 0}, "num_agents must be a whole number of at least 1"),
        ({"radius": -1.0}, "radius must be positive"),
        ({"sides": 2}, "sides must be a whole number of at least 3"),
        ({"size": (1.0, 0.0)}, "size must be two positive numbers"),
        ({"size": (1.0, 1.0), "radius": 1.0}, "radius must be left out beside size"),
    ],
)
def test_a_plate_that_cannot_be_is_refused(values, named):
    with pytest.raises(InvalidInput, match=named):
        Body.plate(**values)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_body_that_others_hold_is_the_plate_of_as_many(count):
    plate = Body.plate(3, mass=5.0)
    assert plate.held_by(count) == Body.plate(count, mass=5.0)
    assert Body.plate(4, size=(1.0, 2.0)).held_by(count) == Body.plate(count, size=(1.0, 2.0))


def test_a_beam_is_held_at_its_ends_by_two_and_a_clockwise_outline_alike():
    assert set(Body().held_by(2).grips) == set(Body().grips)
    backwards = Body(outline=Body().outline[::-1])
    assert backwards.held_by(4).grips == Body().held_by(4).grips
    triangle = Body(outline=((-0.5, -0.6), (1.0, 0.0), (-0.5, 0.6)))
    assert triangle.held_by(1).grips == ((0.9, 0.0),)


@pytest.mark.parametrize("count", [0, -1, 2.5, 1001, "many"])
def test_a_body_is_held_by_a_whole_number_of_agents(count):
    with pytest.raises(InvalidInput, match="num_agents must be"):
        Body().held_by(count)
