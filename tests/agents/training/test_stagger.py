"""Worlds whose first episodes end one after the other."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv import TransportConfig
from coopenv.agents.sb3 import make_vec_env
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.stagger import stagger
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny


def ends(venv, steps):
    """In which step each world's episodes end."""
    action = np.zeros((venv.num_envs, *venv.action_space.shape))
    done = np.array([venv.step(action)[2] for _ in range(steps)])
    return [(np.flatnonzero(column) + 1).tolist() for column in done.T]


@pytest.mark.parametrize("control", ["joint", "shared"])
def test_first_episodes_end_one_after_the_other_and_the_next_are_whole(control):
    venv = make_vec_env(TransportConfig(horizon=8), 4, control=control, seed=0)
    venv.reset()
    stagger(venv)
    rows = 2 if control == "shared" else 1
    assert ends(venv, 16) == [[8 - k, 16 - k] for k in (0, 2, 4, 6) for _ in range(rows)]


def test_worlds_are_where_they_were_and_only_their_time_is_shorter():
    venv, other = (make_vec_env(TransportConfig(horizon=8), 4, seed=0) for _ in range(2))
    for each in (venv, other):
        each.reset()
    stagger(venv)
    action = np.full((4, 6), 0.5)
    for mine, theirs in zip(venv.step(action)[:2], other.step(action)[:2], strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_a_training_does_so_where_it_is_told_to(tmp_path):
    """Rollouts of six steps, episodes of eight: together, none ends in the first."""
    found = {}
    for staggered in (False, True):
        config = tiny(tmp_path / str(staggered), rollout=6, staggered=staggered)
        rows = []
        train(config, environment=SHORT, report=rows.append)
        found[staggered] = rows[0].get("episodes", 0)
    assert found == {False: 0, True: 3}  # after 2, 4 and 6 steps


def test_it_is_yes_or_no():
    with pytest.raises(InvalidInput, match="staggered must be True or False, got 'no'"):
        TrainConfig(staggered="no")  # type: ignore[arg-type]
