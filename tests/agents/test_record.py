"""A recorded episode: all its pictures at the speed of life, and a pause on the last."""

import numpy as np
import pytest

pytest.importorskip("pygame")
pytest.importorskip("PIL")

from coopenv import TransportConfig, render
from coopenv.agents.controllers import RandomPolicy
from coopenv.agents.record import PAUSE, episode_pictures, record_episode


@pytest.mark.parametrize(("dt", "rate"), [(0.1, 10), (0.04, 25), (2.0, 1)])
def test_the_last_picture_stays(dt, rate, tmp_path, monkeypatch):
    written = []

    def save(path, pictures, *, fps):
        written.append((path, pictures, fps))

    monkeypatch.setattr(render, "save_gif", save)
    config = TransportConfig(horizon=3, dt=dt)
    record_episode(RandomPolicy(config), config, tmp_path / "a.gif", seed=1)
    ((path, pictures, fps),) = written
    assert (path, fps) == (tmp_path / "a.gif", rate)
    episode = episode_pictures(RandomPolicy(config), config, seed=1)
    assert len(episode) == 1 + 3
    assert len(pictures) == len(episode) + round(PAUSE * rate)
    np.testing.assert_array_equal(pictures[: len(episode)], episode)
    for picture in pictures[len(episode) :]:
        np.testing.assert_array_equal(picture, episode[-1])
