"""Narrowing of exploration: the largest spread of the actions falls as a training goes on."""

from math import log

import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from ..settings import TrainConfig

SPREAD = "log_std"  # parameter of a policy whose actions are normally distributed


def largest_std(config: TrainConfig, done: float) -> float | None:
    """Largest spread of the actions, in units of the limits; ``None`` if there is none.

    From ``initial_std`` to ``final_std``, by the same factor in every step.

    Parameters
    ----------
    config
        Of the run.
    done
        Fraction of its steps that are done; what is beyond them counts as 1.
    """
    if config.final_std is None:
        return None
    return config.initial_std * (config.final_std / config.initial_std) ** min(done, 1.0)


def narrow(model: BaseAlgorithm, largest: float | None) -> None:
    """Lower the spread of a model's actions to ``largest`` where it is more.

    The mean actions are what a finished policy does. Where the spread is wide they are hardly ever
    tried: episodes in which they would stand still beside the goal are ended by luck, and nothing
    is learned of them. Models of discrete actions have no spread.
    """
    spread = getattr(model.policy, SPREAD, None)
    if largest is not None and spread is not None:
        with torch.no_grad():
            spread.clamp_(max=log(largest))
