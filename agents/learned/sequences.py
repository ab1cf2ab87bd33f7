"""Recurrent policies of sb3-contrib that go over a whole sequence at once.

The parent steps through time in Python as soon as any episode begins in a batch, which costs most
of the training. Its buffer cuts sequences where episodes begin, so that one begins at the first
step of a sequence alone, and there that is a state of zero to begin from.
"""

from itertools import pairwise

import torch
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from torch import nn
from torch.nn.functional import pad

States = tuple[torch.Tensor, torch.Tensor]  # hidden and cell, (layer, sequence, unit)


def gone_over(
    features: torch.Tensor, lstm_states: States, episode_starts: torch.Tensor, lstm: nn.LSTM
) -> tuple[torch.Tensor, States]:
    """What a layer makes of sequences, taken together up to where an episode begins.

    Parameters
    ----------
    features
        ``(sequence * step, feature)``.
    lstm_states
        Before the first step.
    episode_starts
        ``(sequence * step,)``, 1 where an episode begins, else 0.
    lstm
        The layer.

    Returns
    -------
    tuple
        ``(sequence * step, unit)``, and the states after the last step.
    """
    hidden, cell = lstm_states
    sequences = hidden.shape[1]
    steps = features.reshape(sequences, -1, lstm.input_size).swapaxes(0, 1)
    kept = 1.0 - episode_starts.reshape(sequences, -1).T  # (step, sequence)
    begins = (kept[1:] < 1.0).any(dim=1).nonzero().flatten() + 1
    bounds = [0, *begins.tolist(), len(steps)]
    outputs = []
    for first, end in pairwise(bounds):
        keep = kept[first][None, :, None]
        output, (hidden, cell) = lstm(steps[first:end], (keep * hidden, keep * cell))
        outputs.append(output)
    flat = torch.cat(outputs).transpose(0, 1).flatten(end_dim=1)
    return flat, (hidden, cell)


class WholeSequences(RecurrentActorCriticPolicy):
    """The parent's policy and outputs, in less time."""

    @staticmethod
    def _process_sequence(  # pyright: ignore[reportIncompatibleMethodOverride]
        features: torch.Tensor, lstm_states: States, episode_starts: torch.Tensor, lstm: nn.LSTM
    ) -> tuple[torch.Tensor, States]:
        """See the parent, which means a pair by its states as well."""
        return gone_over(features, lstm_states, episode_starts, lstm)


class Residual(WholeSequences):
    """Features are added to what the recurrent layer makes of them, as far as it has units."""

    ALIAS = "ResidualLstmPolicy"  # what a blueprint calls it

    @staticmethod
    def _process_sequence(  # pyright: ignore[reportIncompatibleMethodOverride]
        features: torch.Tensor, lstm_states: States, episode_starts: torch.Tensor, lstm: nn.LSTM
    ) -> tuple[torch.Tensor, States]:
        """See the parent."""
        made, states = gone_over(features, lstm_states, episode_starts, lstm)
        return made + pad(features, (0, lstm.hidden_size - lstm.input_size)), states
