"""The recurrent learner's policy: its parent's outputs, and what it takes a batch for."""

import numpy as np
import pytest

pytest.importorskip("sb3_contrib")

import torch
from gymnasium.spaces import Box
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.common.recurrent.type_aliases import RNNStates

from coopenv.agents.learned.sequences import WholeSequences

SEQUENCES, STEPS, INPUTS, UNITS = 5, 12, 7, 16
BEGINNINGS = {
    "nowhere": np.zeros((SEQUENCES, STEPS)),
    "first": np.outer([1, 0, 1, 1, 0], np.arange(STEPS) == 0),
    "anywhere": np.random.default_rng(2).random((SEQUENCES, STEPS)) < 0.2,
}


def passed(policy, where, layers):
    """Outputs, states and gradients of one pass."""
    torch.manual_seed(3)
    lstm = torch.nn.LSTM(INPUTS, UNITS, num_layers=layers)
    features = torch.randn(SEQUENCES * STEPS, INPUTS, requires_grad=True)
    states = torch.randn(2, layers, SEQUENCES, UNITS, requires_grad=True)
    starts = torch.tensor(BEGINNINGS[where], dtype=torch.float32).flatten()
    output, (hidden, cell) = policy._process_sequence(
        features, (states[0], states[1]), starts, lstm
    )
    (output.square().sum() + hidden.sum() + cell.sum()).backward()
    return output, hidden, cell, features.grad, states.grad, *(p.grad for p in lstm.parameters())


@pytest.mark.parametrize("layers", [1, 2])
@pytest.mark.parametrize("where", BEGINNINGS)
def test_whole_sequences_have_the_outputs_and_gradients_of_their_parent(where, layers):
    mine = passed(WholeSequences, where, layers)
    for one, other in zip(mine, passed(RecurrentActorCriticPolicy, where, layers), strict=True):
        torch.testing.assert_close(one, other, rtol=1e-5, atol=1e-6)


def test_a_batch_to_learn_from_has_beginnings_at_the_first_step_of_sequences_alone():
    rows, worlds, shape = 20, 6, (20, 1, 6, UNITS)
    space = Box(-1.0, 1.0, (INPUTS,))
    buffer = RecurrentRolloutBuffer(rows, space, Box(-1.0, 1.0, (2,)), shape, n_envs=worlds)
    generator, state = np.random.default_rng(0), torch.ones(1, worlds, UNITS)
    for _ in range(rows):
        begins, value = generator.random(worlds) < 0.2, torch.zeros(worlds)
        obs, action = generator.random((worlds, INPUTS)), generator.random((worlds, 2))
        states = RNNStates((state, state), (state, state))
        buffer.add(obs, action, np.zeros(worlds), begins, value, value, lstm_states=states)
    begun = 0.0
    for batch in buffer.get(16):
        sequences = batch.lstm_states.pi[0].shape[1]
        starts = batch.episode_starts.reshape(sequences, -1)
        begun += float(starts[:, 0].sum())
        assert not starts[:, 1:].any()
    assert begun == buffer.episode_starts.sum() > worlds
