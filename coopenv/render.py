"""Pictures of a transition: who applies what, and which part of it goes nowhere."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import cos, isfinite, sin
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, positive, whole
from coopenv.body import Body
from coopenv.canvas import (
    Canvas,
    Color,
    Pen,
    Picture,
    Window,
    around,
    arrow,
    bent_arrow,
    text_width,
)
from coopenv.errors import InvalidInput, MissingExtra, UnknownName
from coopenv.scene import Scene
from coopenv.transition import Transition

MODES = ("human", "rgb_array")

PAGE: Color = (255, 255, 255)
FLOOR: Color = (248, 247, 243)
GRID: Color = (236, 234, 227)
WALL: Color = (94, 104, 118)
SHADOW: Color = (60, 66, 76)
BODY: Color = (198, 206, 216)
EDGE: Color = (74, 84, 98)
TEXT: Color = (74, 82, 94)
APPLIED: Color = (38, 44, 54)
INTERNAL: Color = (255, 92, 62)
ARRIVED: Color = (0, 158, 115)
AGENTS: tuple[Color, ...] = (  # after Okabe & Ito: they stay apart for the colour-blind
    (0, 114, 178),
    (240, 170, 20),
    (204, 121, 167),
    (0, 158, 115),
    (86, 180, 233),
    (150, 120, 70),
)

_TALLEST = 1.5  # of a room's picture, per width
_READOUTS = (  # and a number for which there is to be room
    ("t {:.2f} s", 88.88),
    ("γ {:.2f}", 8.88),
    ("F_I {:.1f} N", 88.8),
    ("T_I {:.1f} N·m", 88.8),
)
_LEGEND = ("applied", "internal", "goal")
_SHAFT, _CORE = 5.0, 2.4  # widths of an arrow and of the internal one in it, in units
_TURN = 1.5 * np.pi  # [rad] of a bent arrow that stands for the torque limit
_BAR = (-0.25, 1.25)  # load shares that a bar spans; it stops there, the number does not


class Renderer:
    """Draws one world: room, goal, body and, at every grip, applied and internal wrench.

    Dark arrows are what the agents apply, as forces and, round the grip, torques; the bright core
    in them is the internal part. Beneath: time, γ, F_I, T_I and each agent's share of the load.
    The goal is a ghost of the body, its grips in the agents' colours too.

    Parameters
    ----------
    bodies, scenes
        One a world, as `coopenv.Transport` has them.
    mode
        ``"rgb_array"`` returns pictures and needs no display; ``"human"`` shows them in a window.
    world
        The one that is drawn.
    width
        Of the picture [px]; its height follows from the room.
    fps
        Pictures a second to which a window is held.

    Raises
    ------
    UnknownName, InvalidInput, MissingExtra
        If the mode is not known, a value breaks its rule, or pygame is not installed.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        *,
        mode: str = "rgb_array",
        world: int = 0,
        width: int = 640,
        fps: float = 20,
    ):
        if mode not in MODES:
            raise UnknownName("mode", mode, MODES)
        self.mode, self.world = mode, whole(world, "world", at_least=0)
        if self.world >= len(bodies):
            raise InvalidInput(
                f"world must be less than the {len(bodies)} worlds there are, got {world}; "
                "worlds are counted from 0"
            )
        self.body, self.scene = bodies[self.world], scenes[self.world]
        width = whole(width, "width", at_least=160)
        self._window = Window("coopenv", positive(fps, "fps")) if mode == "human" else None
        self._lay_out(width)
        self._paint_background()

    @property
    def is_open(self) -> bool:
        """Whether a window shows; false in ``"rgb_array"`` mode and once closed by hand."""
        return self._window is not None and self._window.is_open

    def draw(self, transition: Transition) -> Picture | None:
        """Draw the end of a step: ``(height, width, 3)`` uint8; ``None`` in ``"human"`` mode.

        Wrenches are held in the object frame, so they appear turned with the body.
        """
        self._canvas.pixels[:] = self._background
        self._draw_goal(transition)
        self._draw_body(transition)
        self._draw_wrenches(transition)
        self._write(transition)
        if self._window is None:
            return self._canvas.pixels.copy()
        self._window.show(self._canvas.pixels)
        return None

    def held_keys(self) -> frozenset[str]:
        """Names of the keys held down in the window (``"w"``, ``"left"``, ...), to play by."""
        return frozenset() if self._window is None else self._window.held_keys()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _lay_out(self, width: int) -> None:
        """Fix what goes where: the room first, the lines of text beneath it."""
        self._unit = unit = min(max(width / 640, 0.6), 3.0)  # [px] a line that is just well visible
        self._frame = frame = round(12 * unit)
        across, up = self.scene.size
        self._scale = min((width - 2 * frame) / across, _TALLEST * width / up)  # [px/m]
        self._center = np.array([width / 2, frame + up * self._scale / 2])
        self._font_size = size = max(12, round(17 * unit))
        gap, line, row = round(14 * unit), round(1.4 * size), width - 2 * frame
        self._key, self._bar = round(32 * unit), round(60 * unit)
        readouts = [text_width(text.format(widest), size) for text, widest in _READOUTS]
        keys = [self._key + text_width(name, size) for name in _LEGEND]
        places, first = _flow(readouts + keys, gap, row)
        if first == 1:  # there is room: the legend goes to the right
            spare = row - places[-1][0] - keys[-1]
            places[len(readouts) :] = [(x + spare, 0) for x, _ in places[len(readouts) :]]
        label = text_width("load share", size) + gap // 2
        share = round(12 * unit) + self._bar + text_width(" −8.88", size)
        shares, second = _flow([share] * self.body.num_agents, gap, row - label)
        self._bottom = round(up * self._scale) + 2 * frame
        top = self._bottom + round(0.75 * line)
        places = [(frame + x, top + line * k) for x, k in places]
        self._readouts, self._legend = places[: len(readouts)], places[len(readouts) :]
        self._label = (frame, top + line * first)
        self._shares = [(frame + label + x, top + line * (first + k)) for x, k in shares]
        height = top + line * (first + second) - round(0.25 * line)
        self._canvas = Canvas(width, height + height % 2)  # video codecs want it even

    def _paint_background(self) -> None:
        canvas, unit = self._canvas, self._unit
        height, width, _ = canvas.pixels.shape
        canvas.fill((0, 0, width, height), PAGE)
        half = np.array(self.scene.size) / 2
        (left, bottom), (right, top) = self._pixels(-half), self._pixels(half)
        canvas.fill(around([self._pixels(-half), self._pixels(half)], self._frame), WALL)
        canvas.fill((left, top, right, bottom), FLOOR)
        for metre in range(-int(max(half)), int(max(half)) + 1):
            x, y = self._pixels((metre, metre))
            if abs(metre) < half[0]:
                canvas.fill((x, top, x + max(unit, 1), bottom), GRID)
            if abs(metre) < half[1]:
                canvas.fill((left, y, right, y + max(unit, 1)), GRID)
        for obstacle in self.scene.obstacles:
            corners = self._pixels(obstacle.vertices)
            with canvas.fine(around([corners], 5 * unit)) as pen:
                pen.polygon(corners + 2.5 * unit, SHADOW, opacity=0.18)
                pen.polygon(corners, WALL)
        with canvas.fine((0, self._bottom, width, height)) as pen:
            self._paint_legend(pen)
        self._background = canvas.pixels.copy()

    def _paint_legend(self, pen: Pen) -> None:
        unit, length = self._unit, self._key - 7 * self._unit
        for (x, y), name in zip(self._legend, _LEGEND, strict=True):
            start, along = np.array([x, y]), np.array([length, 0.0])
            if name == "goal":
                corners = np.array([[0.1, -0.2], [1, -0.2], [1, 0.2], [0.1, 0.2]])
                self._ghost(pen, start + length * corners, EDGE)
            else:
                pen.polygon(arrow(start, along, _SHAFT * unit), APPLIED)
            if name == "internal":
                pen.polygon(arrow(start, along, _CORE * unit), INTERNAL)
            pen.text(x + self._key, y, name, self._font_size, TEXT)
        pen.text(*self._label, "load share", self._font_size, TEXT)
        for agent, (x, y) in enumerate(self._shares):
            pen.disc((x + 4.5 * unit, y), 4.5 * unit, _color(agent))
            zero, one = self._share_at(x, 0.0), self._share_at(x, 1.0)
            pen.polygon(_bar(zero, one, y, 3.5 * unit), GRID)

    def _draw_goal(self, transition: Transition) -> None:
        goal = transition.next_state.goal[self.world]
        outline, grips = self._placed(self.body.outline, goal), self._placed(self.body.grips, goal)
        color = ARRIVED if transition.success[self.world] else EDGE
        with self._canvas.fine(around([outline, grips], 8 * self._unit)) as pen:
            self._ghost(pen, outline, color)
            self._chevron(pen, goal, color)
            for agent, grip in enumerate(grips):
                pen.disc(grip, 6 * self._unit, _color(agent))
                pen.disc(grip, 3.4 * self._unit, FLOOR)

    def _draw_body(self, transition: Transition) -> None:
        pose, unit = transition.next_state.pose[self.world], self._unit
        outline = self._placed(self.body.outline, pose)
        with self._canvas.fine(around([outline], 5 * unit)) as pen:
            pen.polygon(outline + 2.5 * unit, SHADOW, opacity=0.18)
            pen.polygon(outline, BODY)
            pen.line(outline, 1.6 * unit, EDGE, closed=True)
            self._chevron(pen, pose, EDGE)

    def _draw_wrenches(self, transition: Transition) -> None:
        k, unit = self.world, self._unit
        pose = transition.next_state.pose[k]
        grips = self._placed(self.body.grips, pose)
        applied, internal = transition.applied[k], transition.decomposition.internal[k]
        force_limit, torque_limit = transition.team.limits[k].max(axis=0)
        longest = max(0.8 * self.body.reach, 0.12 * min(self.scene.size))  # [m] at the limit
        to_pixels = self._scale * longest / force_limit * _turn(pose[2]).T * (1, -1)  # [px/N]
        frames = transition.team.frame[k]
        outwards = pose[2] + np.arctan2(-frames[:, 1], -frames[:, 0])  # away from the centre
        for agent, grip in enumerate(grips):
            dark, bright = (
                self._arrows(
                    grip,
                    wrench[agent, :2] @ to_pixels,
                    float(outwards[agent]),
                    _TURN * float(np.clip(wrench[agent, 2] / torque_limit, -1.2, 1.2)),
                    width * unit,
                )
                for wrench, width in ((applied, _SHAFT), (internal, _CORE))
            )
            with self._canvas.fine(around([grip, *dark, *bright], 10 * unit)) as pen:
                for shape in dark:
                    pen.line(shape, 2 * unit, FLOOR, closed=True)
                for shape in dark:
                    pen.polygon(shape, APPLIED)
                for shape in bright:
                    pen.polygon(shape, INTERNAL)
                for radius, color in ((8, EDGE), (6.8, PAGE), (5.4, _color(agent))):
                    pen.disc(grip, radius * unit, color)

    def _arrows(
        self, grip: FloatArray, force: FloatArray, outwards: float, turn: float, width: float
    ) -> list[FloatArray]:
        """Outlines of a force [px] and a torque, drawn as a turn [rad]; none if negligible."""
        shapes, length = [], float(np.hypot(*force))
        if abs(turn) > 0.15:
            shapes.append(bent_arrow(grip, 16 * self._unit, outwards, turn, 0.75 * width))
        if length > 2 * self._unit:
            shapes.append(arrow(grip + 8.5 * self._unit / length * force, force, width))
        return shapes

    def _write(self, transition: Transition) -> None:
        """Time, levels and load shares."""
        decomposition, k = transition.decomposition, self.world
        unit, size = self._unit, self._font_size
        values = (
            transition.next_state.time,
            decomposition.relative_cost,
            decomposition.internal_force_level,
            decomposition.internal_torque_level,
        )
        height, width, _ = self._canvas.pixels.shape
        with self._canvas.fine((0, self._bottom, width, height)) as pen:
            for place, (text, _), value in zip(self._readouts, _READOUTS, values, strict=True):
                pen.text(*place, text.format(value[k]), size, TEXT)
            for agent, (x, y) in enumerate(self._shares):
                share = float(decomposition.load_share.force[k, agent])
                if isfinite(share):
                    ends = self._share_at(x, 0.0), self._share_at(x, share)
                    pen.polygon(_bar(*ends, y, 3.5 * unit), _color(agent))
                for edge in (self._share_at(x, 0.0), self._share_at(x, 1.0)):
                    pen.polygon(_bar(edge, edge + unit, y, 5 * unit), TEXT)
                text = f"{share:.2f}".replace("-", "−") if isfinite(share) else "–"
                pen.text(x + 12 * unit + self._bar, y, " " + text, size, TEXT)

    def _share_at(self, x: float, share: float) -> float:
        """Where in the bar at ``x`` a load share lies; the bar shows a little beyond 0 and 1."""
        low, high = _BAR
        part = (min(max(share, low), high) - low) / (high - low)
        return x + 12 * self._unit + self._bar * part

    def _ghost(self, pen: Pen, outline: FloatArray, color: Color) -> None:
        pen.polygon(outline, color, opacity=0.16)
        pen.line(outline, 1.2 * self._unit, _faded(color), closed=True)

    def _chevron(self, pen: Pen, pose: FloatArray, color: Color) -> None:
        """A small mark at the centre of mass that points along the object's x."""
        size = 3.2 * self._unit / self._scale  # [m]
        tip = size * np.array([(-0.6, 1.0), (0.6, 0.0), (-0.6, -1.0)])
        pen.line(self._placed(tip, pose), 1.6 * self._unit, color)

    def _placed(self, points: npt.ArrayLike, pose: FloatArray) -> FloatArray:
        """Points of the object frame [m] in the picture [px]."""
        return self._pixels(np.asarray(points) @ _turn(pose[2]).T + pose[:2])

    def _pixels(self, points: npt.ArrayLike) -> FloatArray:
        """Points of the world frame [m] in the picture [px]."""
        return self._center + self._scale * np.asarray(points, dtype=np.float64) * (1, -1)


def save_png(path: str | Path, frame: npt.ArrayLike) -> None:
    """Write one picture ``(height, width, 3)`` uint8; whole or not at all."""
    image = _pillow().fromarray(_checked(frame))
    with _whole_file(path) as file:
        image.save(file, format="PNG", optimize=True)


def save_gif(path: str | Path, frames: Sequence[Picture], *, fps: float) -> None:
    """Write pictures as an endlessly repeated animation; whole or not at all.

    All pictures share one palette, so that what does not move costs nothing. A GIF counts
    hundredths of a second, and viewers slow down what is faster than 50 pictures a second.
    """
    images = _pillow()
    if not len(frames):
        raise InvalidInput("frames must hold at least one picture, got none; draw some first")
    hundredths = max(2, round(100 / positive(fps, "fps")))
    pictures = [_checked(frame) for frame in frames]
    if len({picture.shape for picture in pictures}) > 1:
        raise InvalidInput(
            "frames must all be of one size, got several; write one file for each renderer"
        )
    palette = _palette(pictures)
    quantized = (images.fromarray(p).quantize(palette=palette, dither=0) for p in pictures)
    with _whole_file(path) as file:
        next(quantized).save(
            file,
            format="GIF",
            save_all=True,
            append_images=quantized,
            duration=10 * hundredths,
            loop=0,
        )


def _palette(pictures: Sequence[Picture]) -> Any:
    """A paletted image with the colours of the pictures, rare ones given their due."""
    chosen = [pictures[k] for k in np.linspace(0, len(pictures) - 1, 12).round().astype(int)]
    colors, counts = np.unique(
        np.concatenate([picture.reshape(-1, 3) for picture in chosen]), axis=0, return_counts=True
    )
    weighted = np.repeat(colors, np.ceil(counts**0.4).astype(int), axis=0)
    return _pillow().fromarray(weighted[None]).quantize(128)


@contextmanager
def _whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """A file that takes its name only once it is written."""
    target = Path(path)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with temporary.open("wb") as file:
            yield file
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def _checked(frame: npt.ArrayLike) -> Picture:
    picture = np.asarray(frame)
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise InvalidInput(
            f"frame must be (height, width, 3) uint8, got {picture.dtype} of shape "
            f"{picture.shape}; pass what Renderer.draw returns in rgb_array mode"
        )
    return picture


def _pillow() -> Any:
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtra("saving pictures", "render") from error
    return Image


def _flow(widths: Sequence[int], gap: int, room: int) -> tuple[list[tuple[int, int]], int]:
    """Set items of the given widths in rows: ``(x, row)`` of each, and how many rows there are."""
    places, x, row = [], 0, 0
    for width in widths:
        if x and x + width > room:
            x, row = 0, row + 1
        places.append((x, row))
        x += width + gap
    return places, row + 1


def _bar(left: float, right: float, y: float, half: float) -> FloatArray:
    return np.array([(left, y - half), (right, y - half), (right, y + half), (left, y + half)])


def _turn(angle: float) -> FloatArray:
    return np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])


def _color(agent: int) -> Color:
    return AGENTS[agent % len(AGENTS)]


def _faded(color: Color) -> Color:
    red, green, blue = (round((c + f) / 2) for c, f in zip(color, FLOOR, strict=True))
    return red, green, blue
