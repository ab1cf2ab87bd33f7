"""A recorded episode: all its pictures at the speed of life, and a pause on the last."""

import numpy as np
import pytest

pytest.importorskip("pygame")
pytest.importorskip("PIL")

from coopenv import TransportConfig, render
from coopenv.agents.controllers import RandomPolicy, find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.record import (
    Recorder,
    episode_pictures,
    episode_steps,
    record_episode,
)
from coopenv.agents.seeds import evaluation_seeds
from coopenv.logs import Layout, analyse, read
from coopenv.logs.formats import open_sink
from coopenv.randomisation import Ranges
from coopenv.render.film import PAUSE
from coopenv.transport import Transport


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


def test_the_steps_of_an_episode_stay_what_they_were_while_it_went_on():
    config = TransportConfig(horizon=6)
    policy = find_controller(config)
    steps = episode_steps(policy, config, seed=2, episode=3)
    core = Transport(num_worlds=1, config=config)
    obs, _ = core.reset(seed=[evaluation_seeds(2, 3)[2]])
    assert len(steps) == 1 + 6
    for k, step in enumerate(steps):
        assert core.transition is not None
        np.testing.assert_array_equal(step.next_state.pose, core.transition.next_state.pose)
        np.testing.assert_array_equal(step.applied, core.transition.applied)
        assert step.next_state.time[0] == pytest.approx(k * config.dt)
        obs = core.step(policy(obs, core.transition))[0] if k < 6 else obs


def recorded(path, config, *, num_worlds):
    """What a random policy's three episodes came to, and the table of their steps."""
    sink = open_sink(path)
    recorder = Recorder(sink, "random")
    policy = RandomPolicy(config)
    seen = run_episodes(policy, config, episodes=3, num_worlds=num_worlds, recorder=recorder)
    sink.close()
    return seen, read(path, Layout())


def test_recorded_steps_decompose_to_what_the_evaluation_says(tmp_path):
    config = TransportConfig(horizon=5, randomise=Ranges(grips=((-0.05, 0.05), (-0.02, 0.02))))
    seen, recording = recorded(tmp_path / "steps.npz", config, num_worlds=2)
    trials = [*recording.trials()]
    assert [len(trial) for trial in trials] == seen.length.tolist() == [5, 5, 5]
    for k, trial in enumerate(trials):
        table = analyse(trial)
        for name in ("relative_cost", "internal_force_level", "internal_torque_level"):
            assert table[name].mean() == pytest.approx(getattr(seen, name)[k])
        assert trial.carried["reward"].sum() == pytest.approx(seen.reward[k].mean())
        assert set(trial.carried["condition"].tolist()) == {"random"}
        assert set(trial.carried["trial"].tolist()) == {k + 1}


def test_recorded_poses_and_twists_are_those_of_the_episode(tmp_path):
    config = TransportConfig(horizon=5)
    _, recording = recorded(tmp_path / "steps.csv", config, num_worlds=3)
    second = [*recording.trials()][1]
    assert second.orientation is not None
    assert second.twist is not None
    steps = episode_steps(RandomPolicy(config), config, episode=2)[1:]
    state = [step.next_state for step in steps]
    np.testing.assert_allclose(second.orientation, [each.pose[0, 2] for each in state])
    turn = np.exp(1j * second.orientation)
    world = (second.twist[:, 0] + 1j * second.twist[:, 1]) * turn
    np.testing.assert_allclose(world, [complex(*each.twist[0, :2]) for each in state])
    np.testing.assert_allclose(second.applied, [step.applied[0] for step in steps], atol=1e-12)
    assert second.time is not None
    np.testing.assert_allclose(second.time, 0.05 * np.arange(1, 6))
