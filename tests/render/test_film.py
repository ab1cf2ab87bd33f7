"""Films: their pace, their files, and pictures side by side."""

import sys

import numpy as np
import pytest

pytest.importorskip("PIL")
pytest.importorskip("pygame")
from PIL import Image

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.render import mosaic, save_film
from coopenv.render.film import Frames, beside, gif_rate, rows_at
from coopenv.render.look import PAGE

STEPS = np.linspace(0.0, 0.2, 5)


def plain(value: int, height: int = 16, width: int = 16) -> np.ndarray:
    return np.full((height, width, 3), value, dtype=np.uint8)


def test_at_the_rate_of_the_steps_every_step_is_a_picture():
    assert rows_at(STEPS, fps=20).tolist() == [0, 1, 2, 3, 4]
    assert rows_at(STEPS + 7.3, fps=20).tolist() == [0, 1, 2, 3, 4]
    assert rows_at(STEPS, fps=20, pause=0.1).tolist() == [0, 1, 2, 3, 4, 4, 4]


def test_a_film_lasts_as_long_as_what_it_shows_and_ends_with_its_end():
    assert rows_at(STEPS, fps=20, speed=2.0).tolist() == [0, 2, 4]
    assert rows_at(STEPS, fps=20, speed=0.5).tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4]
    assert rows_at(np.linspace(0.0, 1.0, 1001), fps=4).tolist() == [0, 250, 500, 750, 1000]
    assert rows_at(np.array([0.0, 0.13]), fps=20).tolist() == [0, 0, 0, 1]
    assert rows_at(np.zeros(1), fps=20).tolist() == [0]


def test_a_film_without_end_is_refused_before_anything_is_made_of_it():
    with pytest.raises(InvalidInput, match="film must have at most 20000 pictures, got 2e"):
        rows_at(np.array([0.0, 1e40]), fps=20)


def test_a_gif_counts_hundredths_of_a_second():
    assert [gif_rate(fps) for fps in (10, 20, 25, 50)] == [10, 20, 25, 50]
    assert gif_rate(30) == pytest.approx(100 / 3)


def test_a_mosaic_has_every_picture_in_its_place():
    page = mosaic([plain(10), plain(20), plain(30, height=8)])
    assert page.shape == (32, 32, 3)
    assert (page[:16, :16] == 10).all()
    assert (page[:16, 16:] == 20).all()
    assert (page[16:24, :16] == 30).all()
    assert (page[16:, 16:] == PAGE).all()
    assert (page[24:] == PAGE).all()
    assert mosaic([plain(1)] * 3, columns=5).shape == (16, 48, 3)
    assert (mosaic([plain(1), plain(2)], columns=1)[16:] == 2).all()


@pytest.mark.parametrize(
    ("pictures", "columns", "says"),
    [([], None, "at least one"), ([plain(1)], 0, "columns"), ([np.zeros((4, 4, 3))], 1, "uint8")],
)
def test_what_makes_no_mosaic_is_refused(pictures, columns, says):
    with pytest.raises(InvalidInput, match=says):
        mosaic(pictures, columns=columns)


def test_pictures_side_by_side_begin_at_the_top():
    page = beside(plain(10), plain(20, height=20, width=7))
    assert page.shape == (20, 24, 3)
    assert (page[:16, :16] == 10).all()
    assert (page[:, 16:23] == 20).all()
    assert (page[16:, :16] == PAGE).all()


def test_pictures_are_drawn_when_they_are_asked_for():
    drawn: list[int] = []

    def draw(row: int) -> np.ndarray:
        drawn.append(row)
        return plain(row)

    frames = Frames(draw, [3, 5, 7])
    assert len(frames) == 3
    assert not drawn
    assert (frames[-1] == 7).all()
    assert [int(frame[0, 0, 0]) for frame in frames[1:]] == [5, 7]
    assert drawn == [7, 5, 7]


def test_a_gif_has_the_pictures_in_order_and_tells_how_far_it_is(tmp_path):
    told: list[float] = []
    frames = [plain(value) for value in (0, 100, 200)]
    save_film(tmp_path / "a.gif", frames, fps=20, report=told.append)
    with Image.open(tmp_path / "a.gif") as image:
        for k, value in enumerate((0, 100, 200)):
            image.seek(k)
            assert (np.asarray(image.convert("RGB")) == value).all()
    assert told == pytest.approx([1 / 3, 2 / 3, 1])


def test_an_mp4_has_the_pictures_in_order_at_its_pace(tmp_path):
    moviepy = pytest.importorskip("moviepy")
    values = (20, 120, 220)
    frames = [plain(value, height=33, width=47) for value in values]  # odd: H.264 wants even
    told: list[float] = []
    save_film(tmp_path / "a.mp4", frames, fps=10, report=told.append)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]
    assert told == pytest.approx([1 / 3, 2 / 3, 1])
    clip = moviepy.VideoFileClip(str(tmp_path / "a.mp4"))
    assert tuple(clip.size) == (48, 34)
    assert clip.duration == pytest.approx(0.3)
    shown = [float(frame[8:24, 8:40].mean()) for frame in clip.iter_frames()]
    clip.close()
    np.testing.assert_allclose(shown, values, atol=6)  # it is a lossy format


@pytest.mark.parametrize("name", ["a.gif", "a.mp4"])
def test_trouble_while_drawing_leaves_nothing(name, tmp_path):
    def draw(row: int) -> np.ndarray:
        if row == 4:
            raise KeyboardInterrupt
        return plain(row)

    with pytest.raises(KeyboardInterrupt):
        save_film(tmp_path / name, Frames(draw, [0, 1, 4]), fps=20)
    with pytest.raises(InvalidInput, match="at least one picture"):
        save_film(tmp_path / name, [], fps=20)
    assert not list(tmp_path.iterdir())


def test_what_is_no_film_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InvalidInput, match=r"out must end in one of \.gif, \.mp4"):
        save_film(tmp_path / "a.avi", [plain(1)], fps=20)
    monkeypatch.setitem(sys.modules, "moviepy", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[render\]"):
        save_film(tmp_path / "a.mp4", [plain(1)], fps=20)
    assert not list(tmp_path.iterdir())
