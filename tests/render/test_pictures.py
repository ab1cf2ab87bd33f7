"""Pictures written to disk as PNG and GIF."""

import sys

import numpy as np
import pytest
from PIL import Image

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.render import Renderer, save_gif, save_png
from tests.render.cases import SQUEEZE, last, picture, started, stepped


def test_a_missing_pillow_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[render\]"):
        save_png(tmp_path / "frame.png", np.zeros((4, 4, 3), dtype=np.uint8))
    assert not list(tmp_path.iterdir())


def test_a_png_keeps_every_pixel(tmp_path):
    frame = picture(stepped(SQUEEZE), width=320)
    save_png(tmp_path / "frame.png", frame)
    assert np.array_equal(np.asarray(Image.open(tmp_path / "frame.png")), frame)
    assert [path.name for path in tmp_path.iterdir()] == ["frame.png"]


def test_a_gif_keeps_size_order_pace_and_nearly_every_colour(tmp_path):
    core = started()
    renderer = Renderer(core.bodies, core.scenes, width=320)
    frames = [renderer.picture(last(core))]
    for _ in range(5):
        core.step(np.array([[[0.9, 0.4, 0.3], [0.2, -0.4, -0.7]]]))
        frames.append(renderer.picture(last(core)))
    save_gif(tmp_path / "episode.gif", frames, fps=20)
    with Image.open(tmp_path / "episode.gif") as image:
        assert getattr(image, "n_frames") == len(frames)  # noqa: B009
        assert image.info["loop"] == 0
        for k, frame in enumerate(frames):
            image.seek(k)
            assert image.info["duration"] == 50  # [ms]
            error = np.abs(np.asarray(image.convert("RGB")).astype(int) - frame)
            assert error.mean() < 0.3
            assert (error.max(axis=-1) == 0).mean() > 0.95  # what is plain is exact
    assert (tmp_path / "episode.gif").stat().st_size < 60_000


def test_a_gif_of_one_plain_picture_is_written(tmp_path):
    save_gif(tmp_path / "plain.gif", [np.full((8, 8, 3), 200, dtype=np.uint8)], fps=20)
    with Image.open(tmp_path / "plain.gif") as image:
        assert (np.asarray(image.convert("RGB")) == 200).all()


@pytest.mark.parametrize(
    ("frames", "says"),
    [
        ([], "at least one"),
        ([np.zeros((4, 4, 3))], "uint8"),
        ([np.zeros((4, 4), dtype=np.uint8)], "height"),
        ([np.zeros((n, 4, 3), dtype=np.uint8) for n in (4, 5)], "one size"),
    ],
)
def test_what_is_no_picture_is_refused_before_anything_is_written(frames, says, tmp_path):
    with pytest.raises(InvalidInput, match=says):
        save_gif(tmp_path / "episode.gif", frames, fps=20)
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(monkeypatch, tmp_path):
    path = tmp_path / "frame.png"
    path.write_text("old")

    def fail(self, file, **_):
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(Image.Image, "save", fail)
    frame = np.zeros((4, 4, 3), dtype=np.uint8)
    with pytest.raises(OSError, match="disk full"):
        save_png(path, frame)
    with pytest.raises(OSError, match="disk full"):
        save_gif(tmp_path / "new.gif", [frame], fps=20)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["frame.png"]
