"""A step of an entry in a scenario, before the first episode of any: mistakes are told then."""

import numpy as np

from coopenv.errors import CoopenvError, InvalidInput
from coopenv.transport import Transport

from ..policy import Policy, check_environment, forget
from ..seeds import training_seeds
from .entries import Entry
from .scenario import Scenario

WORLDS = 2  # so that a policy for one world alone is told
STEPS = 2


def rehearse(entry: Entry, scenario: Scenario) -> CoopenvError | None:
    """Let an entry act for two steps; why it says that it cannot, ``None`` where it did.

    The worlds are none of the episodes of an evaluation.

    Raises
    ------
    InvalidInput
        If what it gives is no action of the scenario, or it breaks off.
    """
    core = Transport(num_worlds=WORLDS, config=scenario.config)
    try:
        policy = entry.policy(scenario)
        check_environment(policy, core)
    except CoopenvError as error:
        return error
    except Exception as error:
        raise wrong(entry, scenario, error) from error
    try:
        _act(policy, core)
    except Exception as error:
        raise wrong(entry, scenario, error) from error
    return None


def _act(policy: Policy, core: Transport) -> None:
    seeds = [*training_seeds(0, WORLDS)]
    obs, _ = core.reset(seed=seeds)
    forget(policy, np.ones(WORLDS, dtype=np.bool_), seeds)
    for _ in range(STEPS):
        assert core.transition is not None
        obs, *_ = core.step(policy(obs, core.transition))


def wrong(entry: Entry, scenario: Scenario, error: Exception) -> InvalidInput:
    """Says in whose scenario something is wrong."""
    kind = "" if isinstance(error, CoopenvError) else f"{type(error).__name__}: "
    return InvalidInput(
        f"{entry.name} must act in the scenario {scenario.name!r}, got {kind}{error}; mend it"
    )
