"""Antialiased drawing on NumPy pictures, and a window. THE ONLY FILE THAT IMPORTS PYGAME.

Knows pixels (x right, y down) and colours; what is drawn with them is `coopenv.render`'s matter.
Only the window initialises a display.
"""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import cache
from math import ceil, floor
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra

Color: TypeAlias = tuple[int, int, int]
Picture: TypeAlias = npt.NDArray[np.uint8]  # (height, width, 3)
Rectangle: TypeAlias = tuple[float, float, float, float]  # left, top, right, bottom [px]

# Fourfold, for 16 levels of coverage. A power of two, so that enlarging and shrinking a region
# gives back the same bits where nothing was drawn.
_FINE = 4


def load_pygame() -> Any:
    """The pygame module, without its greeting on standard output."""
    try:
        with redirect_stdout(None):
            import pygame
    except ImportError as error:
        raise MissingExtra("coopenv.render", "render") from error
    return pygame


class Canvas:
    """A picture to draw on, and the pens to do it with."""

    def __init__(self, width: int, height: int):
        self._pygame = load_pygame()
        self.pixels: Picture = np.zeros((height, width, 3), dtype=np.uint8)
        self._surface = self._pygame.image.frombuffer(self.pixels, (width, height), "RGB")  # shared

    def fill(self, rectangle: Rectangle, color: Color) -> None:
        """Fill a rectangle, to the nearest pixel."""
        left, top, right, bottom = (round(edge) for edge in rectangle)
        self._surface.fill(color, (left, top, right - left, bottom - top))

    @contextmanager
    def fine(self, rectangle: Rectangle) -> Iterator["Pen"]:
        """Draw antialiased within a rectangle; what reaches beyond it is cut off."""
        left, top, right, bottom = rectangle
        box = self._pygame.Rect(floor(left), floor(top), 0, 0)
        box.size = (ceil(right) - box.left, ceil(bottom) - box.top)
        box = box.clip(self._surface.get_rect())
        fine_size = (_FINE * box.width, _FINE * box.height)
        enlarged = self._pygame.transform.scale(self._surface.subsurface(box), fine_size)
        yield Pen(self._pygame, enlarged, np.array(box.topleft))
        if box.width and box.height:
            self._surface.blit(self._pygame.transform.smoothscale(enlarged, box.size), box)


class Pen:
    """Draws shapes given in the pixels of the whole picture."""

    def __init__(self, pygame: Any, surface: Any, corner: npt.NDArray):
        self._pygame, self._surface, self._corner = pygame, surface, corner

    def polygon(self, points: npt.ArrayLike, color: Color, *, opacity: float = 1.0) -> None:
        """Fill a polygon ``(v, 2)``, convex or not."""
        vertices = self._fine(points)
        if opacity >= 1.0:
            self._pygame.draw.polygon(self._surface, color, vertices.tolist())
            return
        low = vertices.min(axis=0)
        size = (vertices.max(axis=0) - low + 1).tolist()
        layer = self._pygame.Surface(size, self._pygame.SRCALPHA, 32)
        shape = (vertices - low).tolist()
        self._pygame.draw.polygon(layer, (*color, round(255 * opacity)), shape)
        self._surface.blit(layer, low.tolist())

    def disc(self, center: npt.ArrayLike, radius: float, color: Color) -> None:
        """Fill a circle."""
        self._pygame.draw.circle(
            self._surface, color, self._fine(center).tolist(), round(_FINE * radius)
        )

    def line(
        self, points: npt.ArrayLike, width: float, color: Color, *, closed: bool = False
    ) -> None:
        """Draw a line through ``(v, 2)`` with round joints and ends."""
        line = np.asarray(points, dtype=np.float64)
        start, end = (
            line if closed else line[:-1],
            np.roll(line, -1, axis=0)[: None if closed else -1],
        )
        along = end - start
        length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)[:, None]
        side = width / 2 * _turned(along) / length
        quads = np.stack([start + side, end + side, end - side, start - side], axis=1)
        for quad in self._fine(quads).tolist():
            self._pygame.draw.polygon(self._surface, color, quad)
        for joint in self._fine(line).tolist():
            self._pygame.draw.circle(self._surface, color, joint, round(_FINE * width / 2))

    def text(self, x: float, y: float, text: str, size: int, color: Color) -> None:
        """Write from ``x`` on, centred on ``y``; ``_`` lowers the character after it."""
        left, top = self._fine((x, y - 0.35 * size)).tolist()
        for part, font, drop in _typeset(self._pygame, text, size):
            self._surface.blit(font.render(part, True, color), (left, top + drop))
            left += font.size(part)[0]

    def _fine(self, points: npt.ArrayLike) -> npt.NDArray[np.int64]:
        return np.rint(_FINE * (np.asarray(points) - self._corner)).astype(np.int64)


class Window:
    """A window that shows pictures. There is one display in a process, and so one window."""

    def __init__(self, title: str, fps: float):
        self._pygame = load_pygame()
        self._title, self._fps = title, fps
        self._clock = self._pygame.time.Clock()
        self._open = self._dismissed = False

    @property
    def is_open(self) -> bool:
        """Whether it shows something: from the first picture until closed, by us or by hand."""
        return self._open

    def show(self, pixels: Picture) -> None:
        """Show a picture and wait until the next is due; does nothing once closed by hand."""
        if self._dismissed:
            return
        pygame, size = self._pygame, pixels.shape[1::-1]
        surface = pygame.display.get_surface() if pygame.display.get_init() else None
        if surface is None or surface.get_size() != size:
            pygame.display.init()
            surface = pygame.display.set_mode(size)
        pygame.display.set_caption(self._title)
        self._open = True
        surface.blit(pygame.image.frombuffer(pixels.tobytes(), size, "RGB"), (0, 0))
        pygame.display.flip()
        if pygame.event.get(pygame.QUIT):
            self._dismissed = True
            self.close()
        pygame.event.pump()
        self._clock.tick(self._fps)

    def held_keys(self) -> frozenset[str]:
        """Names of the keys that are down, as pygame names them: ``"w"``, ``"left"``, ..."""
        if not self._open:
            return frozenset()
        self._pygame.event.pump()
        state, pygame = self._pygame.key.get_pressed(), self._pygame
        codes = (getattr(pygame, name) for name in dir(pygame) if name.startswith("K_"))
        return frozenset(pygame.key.name(code) for code in codes if state[code])

    def close(self) -> None:
        """Close it; harmless when it is not open."""
        if self._open:
            self._open = False
            self._pygame.display.quit()


def text_width(text: str, size: int) -> int:
    """How far a text reaches [px]."""
    parts = _typeset(load_pygame(), text, size)
    return ceil(sum(font.size(part)[0] for part, font, _ in parts) / _FINE)


def arrow(start: FloatArray, vector: FloatArray, width: float) -> FloatArray:
    """Outline ``(7, 2)`` of a straight arrow; a short one is drawn thinner, not blunter."""
    length = float(np.hypot(*vector))
    width = min(width, length / 3)
    along, side = vector / length, width * _turned(vector) / length
    tip, neck = start + vector, start + (length - 3 * width) * along
    head = [neck + 1.6 * side, tip, neck - 1.6 * side]
    return np.array([start + side / 2, neck + side / 2, *head, neck - side / 2, start - side / 2])


def bent_arrow(
    center: FloatArray, radius: float, start: float, sweep: float, width: float
) -> FloatArray:
    """Outline of an arrow round ``center``, its angles counter-clockwise as seen."""
    width = min(width, radius * abs(sweep) / 3)
    neck = start + sweep - np.sign(sweep) * 3 * width / radius
    angles = np.linspace(start, neck, 2 + ceil(5 * abs(sweep)))
    shaft = [(angle, radius + width / 2) for angle in angles]
    shaft_back = [(angle, radius - width / 2) for angle in angles[::-1]]
    head = [(neck, radius + 1.6 * width), (start + sweep, radius), (neck, radius - 1.6 * width)]
    polar = np.array(shaft + head + shaft_back)
    spokes = np.stack([np.cos(polar[:, 0]), -np.sin(polar[:, 0])], axis=-1)
    return center + polar[:, 1:] * spokes


def around(points: Sequence[FloatArray], margin: float) -> Rectangle:
    """The rectangle round all points, ``margin`` wider on every side."""
    every = np.concatenate([np.atleast_2d(some) for some in points])
    (left, top), (right, bottom) = every.min(axis=0) - margin, every.max(axis=0) + margin
    return float(left), float(top), float(right), float(bottom)


def _turned(vector: FloatArray) -> FloatArray:
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def _typeset(pygame: Any, text: str, size: int) -> Iterator[tuple[str, Any, int]]:
    """Pieces of a text, each with its font and how far it is lowered [fine px].

    The fonts are pygame's own, so that a picture is the same everywhere.
    """
    for k, piece in enumerate(re.split(r"_(.)", text)):
        lowered = k % 2 == 1
        yield piece, _font(pygame, size, lowered), round(0.35 * _FINE * size) if lowered else 0


@cache
def _font(pygame: Any, size: int, lowered: bool) -> Any:
    pygame.font.init()
    return pygame.font.Font(None, round(_FINE * size * (0.7 if lowered else 1.0)))
