"""Shapes, colours and numbers of a picture by hand, as they are given to the pen."""

from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Scene, Transport
from coopenv.render import Renderer, look
from coopenv.render.canvas import arrow, bent_arrow
from coopenv.render.caption import Caption
from coopenv.render.look import AGENTS, APPLIED, EDGE, INTERNAL, agent_color, chevron, wheels
from tests.render.cases import last


class Pen:
    """Remembers what it is asked to draw."""

    def __init__(self):
        self.drawn: list[tuple[Any, ...]] = []

    def polygon(self, points, color, *, opacity=1.0):
        self.drawn.append(("polygon", np.array(points), color, opacity))

    def line(self, points, width, color, *, closed=False):
        self.drawn.append(("line", np.array(points), color, width))

    def disc(self, center, radius, color):
        self.drawn.append(("disc", np.array(center), color, radius))

    def text(self, x, y, text, size, color):
        self.drawn.append(("text", text, color, (x, y)))

    def of(self, kind, color=None):
        """What was drawn of a kind, in a colour."""
        return [each for each in self.drawn if each[0] == kind and color in (None, each[2])]


class Canvas:
    """A canvas whose pens are one that remembers."""

    def __init__(self):
        self.pen = Pen()
        self.pixels = np.zeros((10, 10, 3), np.uint8)

    @contextmanager
    def fine(self, rectangle):
        yield self.pen


def test_colours_of_agents_come_round_again_after_the_sixth():
    assert [agent_color(agent) for agent in range(7)] == [*AGENTS, AGENTS[0]]


def test_a_mark_points_along_its_angle_with_y_down():
    pen = Pen()
    chevron(pen, np.array([10.0, 20.0]), 0.0, EDGE, 2.0)  # pyright: ignore[reportArgumentType]
    ((_, points, color, width),) = pen.drawn
    np.testing.assert_allclose(points, [(6, 26.4), (14, 20), (6, 13.6)])
    assert (color, width) == (EDGE, 3.2)
    up = Pen()
    chevron(up, np.array([10.0, 20.0]), np.pi / 2, EDGE, 2.0)  # pyright: ignore[reportArgumentType]
    np.testing.assert_allclose(up.drawn[0][1][1], (10, 16))


def test_wheels_stand_at_both_sides_of_the_centre():
    body = Body(outline=((-0.3, -0.4), (0.3, -0.4), (0.3, 0.4), (-0.3, 0.4)), grips=((0, 0.1),))
    right, left = wheels(body)  # its reach is 0.5 m: 0.16 m long, 0.06 m thick, inside by 0.015 m
    np.testing.assert_allclose(
        right, [(-0.08, -0.385), (0.08, -0.385), (0.08, -0.325), (-0.08, -0.325)]
    )
    np.testing.assert_allclose(left, [(x, y + 0.71) for x, y in right])


def test_a_force_begins_at_the_rim_of_its_grip_and_a_torque_goes_round_it():
    grip, force = np.array([100.0, 50.0]), np.array([30.0, -40.0])
    (only,) = look.wrench_arrows(grip, force, 1.0, 0.3, 5.0, 2.0)
    np.testing.assert_allclose(only, arrow(grip + 17 * np.array([0.6, -0.8]), force, 10.0))
    bent, straight = look.wrench_arrows(grip, force, 1.0, -0.31, 5.0, 2.0)
    np.testing.assert_allclose(bent, bent_arrow(grip, 34.0, 1.0, -0.31, 6.5))
    np.testing.assert_allclose(straight, only)
    assert look.wrench_arrows(grip, np.array([4.0, 0.0]), 0.0, 0.3, 5.0, 2.0) == []
    assert len(look.wrench_arrows(grip, np.array([4.1, 0.0]), 0.0, 0.3, 5.0, 2.0)) == 1


def test_an_arrow_is_as_long_as_its_force_and_ends_in_a_point():
    shape = arrow(np.array([10.0, 20.0]), np.array([30.0, 40.0]), 4.0)
    along = (shape - (10, 20)) @ (0.6, 0.8)
    across = (shape - (10, 20)) @ (-0.8, 0.6)
    assert along.min() == pytest.approx(0.0)
    assert along.max() == pytest.approx(50.0)
    assert across[np.argmax(along)] == pytest.approx(0.0)
    shaft = np.abs(across[np.isclose(along, 0.0)])
    np.testing.assert_allclose(shaft, 2.0)
    np.testing.assert_allclose(np.sort(across), np.sort(-across), atol=1e-12)


def test_a_bent_arrow_keeps_to_its_circle_and_turns_the_way_it_says():
    for turn in (1.0, -1.0):
        shape = bent_arrow(np.array([0.0, 0.0]), 30.0, 0.5, turn, 4.0)
        radius, angle = np.hypot(*shape.T), np.arctan2(-shape[:, 1], shape[:, 0])
        assert 20 < radius.min() < 30 < radius.max() < 40
        off = turn * (angle - 0.5)  # pictures have y down
        assert off.min() == pytest.approx(0.0, abs=0.02)
        assert 0.9 < off.max() < 1.1


def drawn(applied, internal, pose=(0.0, 0.0, 0.0), limits=((10.0, 5.0), (20.0, 4.0)), body=None):
    """What is drawn of two agents' wrenches in a room of 6 m, 640 pixels wide."""
    forces, torques = zip(*limits, strict=True)
    core = Transport(body=body or Body(), force_limit=forces, torque_limit=torques)
    core.reset(seed=0, pose=pose, goal=(0, 2, 0))
    step = replace(last(core), applied=np.array([applied], float))
    split = SimpleNamespace(internal=np.array([internal], float))
    step._own.append(split)  # pyright: ignore[reportArgumentType]
    renderer = Renderer(core.bodies, core.scenes)
    canvas = Canvas()
    renderer._canvas = canvas  # pyright: ignore[reportAttributeAccessIssue]
    renderer._draw_wrenches(step)
    return canvas.pen


SCALE, MIDDLE = 616 / 6, np.array([320.0, 320.0])  # [px/m], [px]


def test_the_strongest_agents_limit_is_as_long_as_most_of_the_body():
    force = [(0, -20, 0), (0, 0, 0)]
    (tip,) = drawn(force, np.zeros((2, 3))).of("polygon", APPLIED)
    longest = 0.8 * np.hypot(1, 0.05) * SCALE  # [px] at 20 N
    start = MIDDLE + np.array([-0.9 * SCALE, 8.5])
    np.testing.assert_allclose(tip[1][:, 1].max(), start[1] + longest, rtol=1e-9)
    np.testing.assert_allclose(tip[1][:, 0].mean(), start[0], atol=2)
    half = drawn([(0, -10, 0), (0, 0, 0)], np.zeros((2, 3))).of("polygon", APPLIED)[0][1]
    np.testing.assert_allclose(half[:, 1].max(), start[1] + longest / 2, rtol=1e-9)


def test_forces_turn_with_the_body_and_the_internal_part_is_the_bright_core():
    pen = drawn([(0, 0, 0), (10, 0, 0)], [(0, 0, 0), (5, 0, 0)], pose=(0, 0, np.pi / 2))
    (dark,), (bright,) = pen.of("polygon", APPLIED), pen.of("polygon", INTERNAL)
    grip = MIDDLE - (0, 0.9 * SCALE)  # the beam points up
    for shape, part in ((dark[1], 0.5), (bright[1], 0.25)):
        length = part * 0.8 * np.hypot(1, 0.05) * SCALE
        assert shape[:, 1].min() == pytest.approx(grip[1] - 8.5 - length)
        np.testing.assert_allclose(shape[:, 0].mean(), grip[0], atol=1)
    assert np.ptp(bright[1][:, 0]) < np.ptp(dark[1][:, 0])


@pytest.mark.parametrize(
    ("torque", "turn"), [(2.5, 0.75 * np.pi), (-5.0, -1.5 * np.pi), (9.0, 1.8 * np.pi)]
)
def test_the_torque_limit_is_three_quarters_of_a_turn(torque, turn):
    (shape,) = drawn([(0, 0, torque), (0, 0, 0)], np.zeros((2, 3))).of("polygon", APPLIED)
    grip = MIDDLE - (0.9 * SCALE, 0)  # looks away from the centre, to the left
    np.testing.assert_allclose(shape[1], bent_arrow(grip, 17.0, np.pi, turn, 3.25), rtol=1e-9)


def test_grips_are_discs_in_their_agents_colours():
    pen = drawn(np.zeros((2, 3)), np.zeros((2, 3)))
    for agent, x in ((0, -0.9), (1, 0.9)):
        (disc,) = pen.of("disc", AGENTS[agent])
        np.testing.assert_allclose(disc[1], MIDDLE + np.array([x * SCALE, 0]))
        assert disc[3] == 5.4


def written(share, **numbers):
    """What a caption writes of a world with these numbers."""
    canvas = Canvas()
    count = len(share)
    caption = Caption(left=12, right=628, top=640, num_agents=count, unit=1.0)
    known = {"relative_cost": 0.125, "internal_force_level": 3.14, "internal_torque_level": 2.71}
    values = {name: np.array([9.0, value]) for name, value in {**known, **numbers}.items()}
    force = np.array([[0.5] * count, share])
    step = SimpleNamespace(
        decomposition=SimpleNamespace(**values),
        load_share=SimpleNamespace(force=force),
        next_state=SimpleNamespace(time=np.array([9.0, 1.25])),
    )
    caption.write(canvas, step, 1)  # pyright: ignore[reportArgumentType]
    return canvas.pen


def test_the_caption_writes_the_worlds_own_numbers_in_their_order():
    pen = written([0.75, 0.25])
    texts = [text for _, text, *_ in pen.of("text")]
    assert texts == ["t 1.25 s", "γ 0.12", "F_I 3.1 N", "T_I 2.7 N·m", "0.75", "0.25"]


def bar(share, agent=0):
    """From where to where the bar of an agent's share goes [px]."""
    shape = written(share).of("polygon", AGENTS[agent])[0][1]
    return shape[:, 0].min(), shape[:, 0].max()


def length(share, agent=0):
    start, end = bar(share, agent)
    return end - start


def test_a_share_is_a_bar_from_nothing_in_its_agents_colour_and_stops_at_the_end_of_its_scale():
    whole = length([1.0, 0.0])
    assert length([0.25, 0.75]) == pytest.approx(whole / 4)
    assert length([0.25, 0.75], 1) == pytest.approx(whole * 3 / 4)
    assert length([9.0, 0.0]) == pytest.approx(1.25 * whole)
    assert length([-9.0, 0.0]) == pytest.approx(0.25 * whole)
    assert bar([0.5, 0.5])[0] == bar([1.0, 0.0])[0]  # they begin at the same place
    assert bar([-0.5, 0.0])[1] == pytest.approx(bar([1.0, 0.0])[0])


def test_the_scale_of_shares_takes_the_room_it_was_given():
    caption = Caption(left=12, right=628, top=640, num_agents=2, unit=1.0)
    assert caption._at(100.0, -0.25) == 112.0
    assert caption._at(100.0, 1.25) == pytest.approx(112.0 + caption._bar)
    assert caption._at(100.0, 0.5) == pytest.approx(112.0 + caption._bar / 2)


def test_a_short_arrow_is_drawn_thinner():
    shape = arrow(np.zeros(2), np.array([6.0, 0.0]), 4.0)
    assert shape[:, 1].max() == pytest.approx(1.6 * 2)
    np.testing.assert_allclose(np.abs(shape[[0, 1, 5, 6], 1]), 1.0)
    bent = bent_arrow(np.zeros(2), 30.0, 0.0, 0.2, 4.0)
    assert np.hypot(*bent.T).max() == pytest.approx(30 + 1.6 * 2)


def test_a_torque_at_a_grip_off_the_axis_goes_round_from_its_far_side():
    body = Body(grips=((-0.9, 0.04), (0.9, 0.0)))
    (shape,) = drawn([(0, 0, 5.0), (0, 0, 0)], np.zeros((2, 3)), body=body).of("polygon", APPLIED)
    grip = MIDDLE + SCALE * np.array([-0.9, -0.04])
    outwards = np.arctan2(0.04, -0.9)
    np.testing.assert_allclose(shape[1], bent_arrow(grip, 17.0, outwards, 1.5 * np.pi, 3.25))


def test_a_share_that_is_none_is_a_dash_and_a_negative_one_has_a_minus():
    texts = [text for _, text, *_ in written([np.nan, -0.5]).of("text")]
    assert texts[4:] == ["–", "−0.50"]
    assert not written([np.nan, np.nan]).of("polygon", AGENTS[0])


def test_the_room_is_as_wide_as_the_picture_and_its_caption_beneath_it():
    core = Transport(scene=Scene(size=(8.0, 4.0)))
    core.reset(seed=0)
    frame = Renderer(core.bodies, core.scenes).picture(last(core))
    wall, floor = np.array(look.WALL), np.array(look.FLOOR)
    height = round(4 * 616 / 8)
    assert (frame[0, 0] == wall).all()
    assert (frame[11, 300] == wall).all()
    assert (frame[13, 13] == floor).all()
    assert (frame[12 + height - 1, 626] == floor).all()
    assert (frame[12 + height + 1, 300] == wall).all()
    assert (frame[30 + height, 2] == look.PAGE).all()
