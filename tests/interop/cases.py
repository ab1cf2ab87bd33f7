"""What the tests of other libraries share."""

import importlib.util
from collections.abc import Iterable
from itertools import cycle
from typing import Any

import gymnasium

from tests.helpers import IDS

DRAWS = all(importlib.util.find_spec(name) for name in ("coopenv.render", "pygame"))


def around_ids(names: Iterable[str]) -> list[tuple[str, str]]:
    """(id, name) for what does not look at the task: each name with the first id and another."""
    others = cycle(IDS[1:])
    return [(view, name) for name in names for view in (IDS[0], next(others))]


def drawn_actions(env: Any, steps: int, seed: int = 1) -> list[Any]:
    """Actions that the environment's own space draws."""
    env.action_space.seed(seed)
    return [env.action_space.sample() for _ in range(steps)]


def started(env: Any) -> Any:
    """The environment, reset and stepped once."""
    env.reset(seed=0)
    env.step(*drawn_actions(env, 1))
    return env


def names(env: Any) -> list[str]:
    """Class names of the wrappers and of what they wrap, from outside in."""
    found = []
    while isinstance(env, gymnasium.Wrapper):
        found.append(type(env).__name__)
        env = env.env
    return [*found, type(env).__name__]
