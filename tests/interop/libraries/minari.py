"""Minari: episodes with their infos, read again, and the environment made again from them."""

import json
import os
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import minari
import numpy as np

import coopenv  # noqa: F401 - whose ids Gymnasium then knows

IDS = ["coopenv/BeamTransport-v0", "coopenv/WalkerAvoid-v0"]
EPISODES, HORIZON = 3, 12


def main() -> None:
    """Run all of it, and print one line of JSON."""
    with TemporaryDirectory() as folder:
        os.environ["MINARI_DATASETS_PATH"] = folder
        for view in IDS:
            collect(view)
    checked = (
        "DataCollector(record_infos=True) with every key of the info; load_dataset gives the same "
        "arrays; recover_environment makes the same configuration, which replays the episodes"
    )
    version = minari.__version__
    told = {"library": "Minari", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def collect(view: str) -> None:
    """A few random episodes there and back."""
    made = gymnasium.make(view, horizon=HORIZON, reward="balanced")
    env = minari.DataCollector(made, record_infos=True)
    env.action_space.seed(0)
    told = []
    for episode in range(EPISODES):
        steps = [env.reset(seed=episode)[1]]
        ended = False
        while not ended:
            *_, terminated, truncated, info = env.step(env.action_space.sample())
            steps.append(dict(info))
            ended = terminated or truncated
        told.append(steps)
    name = f"coopenv/{view.rpartition('/')[2].removesuffix('-v0').lower()}-v0"
    env.create_dataset(
        name, algorithm_name="random", author="coopenv", author_email="-", code_permalink="-"
    )
    data = minari.load_dataset(name)
    assert data.total_episodes == EPISODES
    assert data.total_steps == sum(len(steps) - 1 for steps in told)
    again = data.recover_environment()
    assert again.unwrapped.transport.config == made.unwrapped.transport.config
    for number, episode in enumerate(data.iterate_episodes()):
        columns = flat(episode.infos)
        assert set(columns) == set(told[number][0])
        for key, column in columns.items():
            wanted = np.array([info[key] for info in told[number]])
            np.testing.assert_array_equal(column, wanted, err_msg=key)
        obs, _ = again.reset(seed=number)
        np.testing.assert_array_equal(obs, episode.observations[0])
        for k, action in enumerate(episode.actions):
            obs, reward, *_ = again.step(action)
            np.testing.assert_array_equal(obs, episode.observations[k + 1])
            assert reward == episode.rewards[k]


def flat(infos: dict[str, Any], start: str = "") -> dict[str, np.ndarray]:
    """Columns by their names; HDF5 takes ``reward/progress`` for an entry of a group."""
    found = {}
    for name, value in infos.items():
        found |= (
            flat(value, f"{start}{name}/") if isinstance(value, dict) else {start + name: value}
        )
    return found


if __name__ == "__main__":
    main()
