"""Films: pictures drawn one by one, scene and series side by side, written as GIF or MP4."""

import os
from collections.abc import Callable, Iterator, Sequence
from math import ceil, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray, positive
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written
from coopenv.render.canvas import Picture
from coopenv.render.look import PAGE
from coopenv.render.pictures import checked, save_gif

SUFFIXES = (".gif", ".mp4")
PAUSE = 0.8  # [s] for which the last picture stays
MOST_PICTURES = 20_000  # of a film, the pause left out
FASTEST = 50.0  # [1/s] pictures that a GIF can show

Report = Callable[[float], object]  # is told how much is done, from 0 to 1


class Frames(Sequence[Picture]):
    """Pictures that are drawn when they are asked for, so that a long film needs no memory.

    Parameters
    ----------
    draw
        Makes the picture of a row.
    rows
        Row of each picture.
    """

    def __init__(self, draw: Callable[[int], Picture], rows: Sequence[int] | IntArray):
        self._draw, self._rows = draw, [int(row) for row in rows]

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return Frames(self._draw, self._rows[index])
        return self._draw(self._rows[index])


def rows_at(time: FloatArray, *, fps: float, speed: float = 1.0, pause: float = 0.0) -> IntArray:
    """Which row each picture of a film shows: the last that is not later.

    Parameters
    ----------
    time
        ``(T,)`` [s], increasing.
    fps
        Pictures a second.
    speed
        How many times faster than life.
    pause
        Seconds for which the last picture stays.

    Raises
    ------
    InvalidInput
        If there would be more than 20,000 pictures.
    """
    step = positive(speed, "speed") / positive(fps, "fps")
    first, last = float(time[0]), float(time[-1])
    count = ceil((last - first) / step - 1e-6) + 1
    if count > MOST_PICTURES:
        raise InvalidInput(
            f"film must have at most {MOST_PICTURES} pictures, got {count:.6g}; show a shorter "
            "part, faster, or fewer pictures a second"
        )
    moments = first + step * np.arange(count)
    rows = np.searchsorted(time, moments + 1e-6 * step, side="right") - 1
    return np.concatenate([rows, np.full(round(pause * fps), len(time) - 1)])


def gif_rate(fps: float) -> float:
    """The nearest rate [1/s] that a GIF can have: it counts hundredths of a second."""
    return 100 / max(2, round(100 / fps))


def beside(left: Picture, right: Picture) -> Picture:
    """Two pictures side by side; under the lower one the page goes on."""
    height = max(len(left), len(right))
    width = left.shape[1] + right.shape[1]
    page = np.full((height, width + width % 2, 3), PAGE, dtype=np.uint8)
    page[: len(left), : left.shape[1]] = left
    page[: len(right), left.shape[1] : width] = right
    return page


def mosaic(pictures: Sequence[npt.ArrayLike], *, columns: int | None = None) -> Picture:
    """Many pictures as one, row by row: of all worlds of a batch, for example.

    Parameters
    ----------
    pictures
        ``(height, width, 3)`` uint8 each; they may differ in size.
    columns
        How many side by side; as many as below each other, or one more, if ``None``.

    Raises
    ------
    InvalidInput
        If there are none, one is no picture, or ``columns`` is below 1.

    >>> mosaic([np.zeros((4, 6, 3), dtype=np.uint8)] * 3).shape
    (8, 12, 3)
    """
    tiles = [checked(picture) for picture in pictures]
    if not tiles:
        raise InvalidInput("pictures must be at least one, got none; draw some first")
    if columns is not None and columns < 1:
        raise InvalidInput(f"columns must be at least 1, got {columns}; leave it out for a square")
    across = min(columns or ceil(sqrt(len(tiles))), len(tiles))
    height, width = (max(tile.shape[axis] for tile in tiles) for axis in (0, 1))
    down = ceil(len(tiles) / across)
    page = np.full((down * height, across * width, 3), PAGE, dtype=np.uint8)
    for k, tile in enumerate(tiles):
        top, left = height * (k // across), width * (k % across)
        page[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return page


def require_film(path: Path) -> None:
    """Raise unless a film of that name could be written: its suffix, and what writes it."""
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(
            f"out must end in one of {', '.join(SUFFIXES)}, got {path.name!r}; rename it"
        )
    if path.suffix.lower() == ".mp4":
        _video_clip()


def save_film(
    path: str | os.PathLike,
    frames: Sequence[Picture],
    *,
    fps: float,
    report: Report | None = None,
) -> None:
    """Write pictures as a film, ``.gif`` or ``.mp4``; whole or not at all.

    Parameters
    ----------
    path
        Of the file; its suffix says the format.
    frames
        ``(height, width, 3)`` uint8 each, all of one size; asked for one after the other.
    fps
        Pictures a second, at most 50 in a GIF.
    report
        Told how much is done.

    Raises
    ------
    InvalidInput
        If the suffix is neither, or there is no picture.
    MissingExtra
        If the extra ``render`` is not installed.
    """
    path = Path(path)
    require_film(path)
    told = _Told(frames, report)
    if path.suffix.lower() == ".gif":
        save_gif(path, told, fps=fps)
    else:
        _save_mp4(path, told, positive(fps, "fps"))


class _Told(Sequence[Picture]):
    """Pictures that tell, each time they are gone through, how far that is."""

    def __init__(self, frames: Sequence[Picture], report: Report | None):
        self._frames, self._report = frames, report

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: Any) -> Any:
        return self._frames[index]

    def __iter__(self) -> Iterator[Picture]:
        for k in range(len(self)):
            picture = self._frames[k]
            if self._report is not None:
                self._report((k + 1) / len(self))
            yield picture


def _save_mp4(path: Path, frames: _Told, fps: float) -> None:
    """H.264, as browsers and slides show it; it wants even sizes."""
    clip_of = _video_clip()
    if not len(frames):
        raise InvalidInput("frames must hold at least one picture, got none; draw some first")
    pictures = iter(frames)
    shown: tuple[int, Picture] = (0, _even(next(pictures)))

    def at(seconds: float) -> Picture:
        nonlocal shown
        wanted = min(round(seconds * fps), len(frames) - 1)
        while shown[0] < wanted:
            shown = shown[0] + 1, _even(next(pictures))
        return shown[1]

    with written(path) as part:
        clip = clip_of(frame_function=at, duration=len(frames) / fps)
        clip.write_videofile(os.fspath(part), fps=fps, codec="libx264", audio=False, logger=None)
        clip.close()


def _even(picture: Picture) -> Picture:
    """With a line of page more where the size is odd."""
    height, width, _ = checked(picture).shape
    more = ((0, height % 2), (0, width % 2), (0, 0))
    return np.pad(picture, more, constant_values=PAGE[0])


def _video_clip() -> Any:
    try:
        from moviepy import VideoClip
    except ImportError as error:
        raise MissingExtra("films as MP4", "render") from error
    return VideoClip
