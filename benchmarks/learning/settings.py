"""Settings of PPO with which the tables of what is learned were made."""

from typing import Any

from coopenv.agents.settings import TrainConfig


def of_tables(**changes: Any) -> TrainConfig:
    """A training as the tables have it, which were made before the defaults became faster.

    Parameters
    ----------
    **changes
        Other fields of `coopenv.agents.settings.TrainConfig`.
    """
    given = {"steps": 600_000, "num_worlds": 64, "rollout": 128, "epochs": 10, **changes}
    return TrainConfig(**given)
