"""A recurrent policy of sb3-contrib that goes over a whole sequence at once.

The parent steps through time in Python as soon as any episode begins in a batch, which costs most
of the training. Its buffer cuts sequences where episodes begin, so that a reset is met at the first
step of a sequence alone, and there it is a state of zero to begin from.
"""

import torch
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from torch import nn

States = tuple[torch.Tensor, torch.Tensor]  # hidden and cell, (layer, sequence, unit)


class WholeSequences(RecurrentActorCriticPolicy):
    """The parent's policy and outputs, in less time."""

    @staticmethod
    def _process_sequence(
        features: torch.Tensor, lstm_states: States, episode_starts: torch.Tensor, lstm: nn.LSTM
    ) -> tuple[torch.Tensor, torch.Tensor]:  # as the parent says, though states are a pair
        whole = RecurrentActorCriticPolicy._process_sequence
        starts = episode_starts.reshape(lstm_states[0].shape[1], -1)  # (sequence, step)
        if starts[:, 1:].any():
            return whole(features, lstm_states, episode_starts, lstm)
        kept = (1.0 - starts[:, 0])[None, :, None]
        hidden, cell = lstm_states
        begun = (kept * hidden, kept * cell)
        return whole(features, begun, torch.zeros_like(starts), lstm)
