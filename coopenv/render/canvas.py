"""Antialiased drawing on NumPy pictures, and a window; no other file imports pygame.

Knows pixels (x right, y down) and colours; what is drawn with them is `coopenv.render`'s matter.
Only the window initialises a display.
"""

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import ceil, floor
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, MissingExtra

Color: TypeAlias = tuple[int, int, int]
Picture: TypeAlias = npt.NDArray[np.uint8]  # (height, width, 3)
Rectangle: TypeAlias = tuple[float, float, float, float]  # left, top, right, bottom [px]

# Fourfold, for 16 levels of coverage. A power of two, so that enlarging and shrinking a region
# gives back the same bits where nothing was drawn.
_FINE = 4
_NO_GREETING = "PYGAME_HIDE_SUPPORT_PROMPT"  # in the environment, which pygame reads


def load_pygame() -> Any:
    """The pygame module, without its greeting on standard output.

    It is asked not to greet: diverted output might never come back where a signal interrupts.
    """
    silent = _NO_GREETING in os.environ
    os.environ.setdefault(_NO_GREETING, "1")
    try:
        import pygame
    except ImportError as error:
        raise MissingExtra("coopenv.render.renderer", "render") from error
    finally:
        if not silent:
            os.environ.pop(_NO_GREETING, None)
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
        region = self._pygame.Surface(box.size, 0, 32)  # 32 bits are shrunk faster than 24
        region.blit(self._surface, (0, 0), box)
        enlarged = self._pygame.transform.scale(region, (_FINE * box.width, _FINE * box.height))
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
        path = np.concatenate([line, line[:1]]) if closed else line
        start, end = path[:-1], path[1:]
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
        names = (name for name in dir(self._pygame) if name.startswith("K_"))
        self._codes = {getattr(self._pygame, name) for name in names}

    @property
    def is_open(self) -> bool:
        """Whether it shows something: from the first picture until closed, by us or by hand."""
        return self._open

    def show(self, pixels: Picture) -> None:
        """Show a picture and wait until the next is due; does nothing once closed by hand."""
        if self._dismissed:
            return
        pygame, size = self._pygame, pixels.shape[1::-1]
        surface = self._surface(size)
        self._open = True
        surface.blit(pygame.image.frombuffer(pixels.tobytes(), size, "RGB"), (0, 0))
        pygame.display.flip()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self._dismissed = True
            self.close()
        self._clock.tick(self._fps)

    def held_keys(self) -> frozenset[str]:
        """Names of the keys that are down, as pygame names them: ``"w"``, ``"left"``, ..."""
        pygame = self._pygame
        if not self._open or not pygame.display.get_init():
            return frozenset()
        pygame.event.pump()
        down = pygame.key.get_pressed()
        return frozenset(pygame.key.name(code) for code in self._codes if down[code])

    def close(self) -> None:
        """Close it; harmless when it is not open."""
        if self._open:
            self._open = False
            self._pygame.display.quit()

    def _surface(self, size: tuple[int, int]) -> Any:
        """What the display shows, made anew if it is not there (any more) or of another size."""
        display = self._pygame.display
        surface = display.get_surface() if display.get_init() else None
        if surface is not None and surface.get_size() == size:
            return surface
        try:
            display.init()
            surface = display.set_mode(size)
        except self._pygame.error as error:
            raise InvalidInput(
                f"mode must be 'rgb_array' where no window can be opened, got 'human' ({error}); "
                "change the mode, or set DISPLAY"
            ) from error
        display.set_caption(self._title)
        return surface


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
        font = _font(pygame, round(_FINE * size * (0.7 if lowered else 1.0)))
        yield piece, font, round(0.35 * _FINE * size) if lowered else 0


_fonts: dict[int, Any] = {}  # size -> font


def _font(pygame: Any, size: int) -> Any:
    font = _fonts.get(size)
    try:
        if font is not None and font.get_height():
            return font
    except pygame.error:
        pass  # another library has called pygame.quit(), which invalidates fonts
    pygame.font.init()
    _fonts[size] = pygame.font.Font(None, size)
    return _fonts[size]
