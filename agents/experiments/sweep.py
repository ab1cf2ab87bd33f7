"""Sweep of one weight of one reward term, as an experiment."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from coopenv.arrays import number, whole
from coopenv.errors import InvalidInput, UnknownName

from ..environment import GROUPS, EnvironmentChoice, values_of
from ..settings import TrainConfig
from .grid import MOST_SEED, Experiment
from .levels import TRAINING
from .terms import SMALL, kind_named


def sweep(
    term: str,
    values: Sequence[float],
    training: TrainConfig,
    *,
    seeds: int = 5,
    episodes: int = 200,
    wandb: str | None = None,
) -> Experiment:
    """The experiment of a reward whose term has one weight after the other.

    Parameters
    ----------
    term
        Of the reward of ``training``'s environment; or the name of a class of terms in small
        letters, such as ``wasted_cost``, which is added to it with its other defaults.
    values
        The weights; each once.
    training
        Of all runs; ``seed`` is the first of the seeds, ``out`` the folder of the experiment.
    seeds
        Trainings of each weight.
    episodes
        Held-out episodes of each evaluation.
    wandb
        Project of Weights & Biases.

    Raises
    ------
    InvalidInput, UnknownName
        If there is no such term, or a weight is no number or comes twice.
    """
    if not len(values):
        raise InvalidInput("values must be at least one weight, got none; give some: 0 0.1 0.3")
    weights = [number(value, "values") for value in values]
    if len(set(weights)) < len(weights):
        raise InvalidInput(f"values must each be there once, got {weights}; drop what repeats")
    whole(seeds, "seeds", at_least=1, at_most=MOST_SEED + 1 - min(training.seed, MOST_SEED))
    if training.fresh:
        raise InvalidInput(
            "fresh must be False in a sweep, got True, which would remove runs; choose another out"
        )
    known = training.environment.config().terms
    kind = kind_named(term)
    if term not in known and kind is None:
        raise UnknownName("reward term", term, {*known, *SMALL})
    levels: dict[str, Any] = {
        f"{term}_{weight!r}": {"weights": {term: weight}}
        if term in known
        else {"terms": {term: {"kind": kind, "weight": weight}}}
        for weight in weights
    }
    return Experiment(
        name=f"weight of {term}",
        grid={"reward": levels},
        environment=_options(training.environment),
        training={name: getattr(training, name) for name in (*TRAINING, "control")},
        seeds=range(training.seed, training.seed + seeds),
        episodes=episodes,
        wandb=wandb,
        out=training.out,
    )


def _options(choice: EnvironmentChoice) -> dict[str, Any]:
    """What is not left to the id, as an experiment has it."""
    given = {entry.name: getattr(choice, entry.name) for entry in fields(choice)}
    return {
        name: values_of(value, name) if name in GROUPS else value
        for name, value in given.items()
        if value not in (None, ())
    }
