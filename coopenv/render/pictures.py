"""Pictures on disk: one as PNG, many as an animated GIF."""

import os
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import positive
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written
from coopenv.render.canvas import Picture


def save_png(path: str | os.PathLike, frame: npt.ArrayLike) -> None:
    """Write one picture ``(height, width, 3)`` uint8; whole or not at all."""
    image = _pillow().fromarray(checked(frame))
    with written(path) as part, part.open("wb") as file:
        image.save(file, format="PNG", optimize=True)


def save_gif(path: str | os.PathLike, frames: Sequence[Picture], *, fps: float) -> None:
    """Write pictures as an endlessly repeated animation; whole or not at all.

    All pictures share one palette, so that what does not move costs nothing. They are asked for one
    after the other, after a dozen for the palette: they need not all be in memory. A GIF counts
    hundredths of a second, and viewers slow down what is faster than 50 pictures a second.
    """
    images = _pillow()
    if not len(frames):
        raise InvalidInput("frames must hold at least one picture, got none; draw some first")
    hundredths = max(2, round(100 / positive(fps, "fps")))
    palette = _palette(frames)
    pictures = _of_one_size(frames)
    quantized = (images.fromarray(p).quantize(palette=palette, dither=0) for p in pictures)
    with written(path) as part, part.open("wb") as file:
        next(quantized).save(
            file,
            format="GIF",
            save_all=True,
            append_images=quantized,
            duration=10 * hundredths,
            loop=0,
        )


def _of_one_size(frames: Sequence[Picture]) -> Iterator[Picture]:
    """The pictures one by one, as long as they are as large as the first."""
    shape: tuple[int, ...] | None = None
    for frame in frames:
        picture = checked(frame)
        shape = shape or picture.shape
        if picture.shape != shape:
            raise InvalidInput(
                "frames must all be of one size, got several; write one file for each renderer"
            )
        yield picture


def _palette(frames: Sequence[Picture]) -> Any:
    """A paletted image with the commonest colours as they are and the others by median cut."""
    images = _pillow()
    chosen = np.linspace(0, len(frames) - 1, min(12, len(frames))).round().astype(int)
    shown = [checked(frames[int(k)]).reshape(-1, 3) for k in chosen]
    colors = np.concatenate(shown).astype(np.uint32)
    packed = colors @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    found, counts = np.unique(packed, return_counts=True)
    found = np.stack([found >> 16, found >> 8 & 255, found & 255], axis=-1).astype(np.uint8)
    commonest = found[np.argsort(-counts, kind="stable")[:32]]
    weighted = np.repeat(found, np.ceil(np.sqrt(counts)).astype(int), axis=0)  # for the rare ones
    cut = images.fromarray(weighted[None]).quantize(128).getpalette()
    entries: list[npt.NDArray] = []
    for color in np.concatenate([commonest, np.reshape(cut, (-1, 3))]).astype(int):
        # Pillow looks colours up in cells of 4: nearer ones than 8 would be taken for each other.
        if all(np.abs(color - entry).max() >= 8 for entry in entries):
            entries.append(color)
    palette = images.new("P", (1, 1))
    palette.putpalette(np.concatenate(entries).tolist())
    return palette


def checked(frame: npt.ArrayLike) -> Picture:
    """The picture; raises `InvalidInput` if it is none."""
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
