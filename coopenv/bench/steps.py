"""How many steps of an environment a second, with all that a step has: infos and reward too."""

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.bench.clock import repeated
from coopenv.transport import Transport

BLOCK = 20_000  # steps of one world that a repeat has, at most a thousand of the batch
FEWEST, MOST = 20, 1000


class StepRate(NamedTuple):
    """Medians of a batch of worlds."""

    worlds: int
    threads: int
    steps_per_second: float  # of all worlds together
    microseconds: float  # a world and step, as time passed
    processor_microseconds: float  # likewise, of all threads


def step_rate(core: Transport, seconds: float) -> StepRate:
    """Time the steps of a team that acts at random for about so long; compiles first."""
    worlds = core.num_worlds
    steps = max(FEWEST, min(MOST, BLOCK // worlds))
    actions = random_actions(core, steps)
    sum(full_steps(core, actions[:2]))
    passed, processor = repeated(lambda: sum(full_steps(core, actions)), seconds)
    each = steps * worlds
    return StepRate(
        worlds, core.threads, each / passed, 1e6 * passed / each, 1e6 * processor / each
    )


def full_step(core: Transport, steps: int) -> float:
    """Seconds a batched control step of a team that acts at random."""
    return sum(full_steps(core, random_actions(core, steps))) / steps


def full_steps(core: Transport, actions: npt.NDArray[Any]) -> Iterator[float]:
    """Seconds of each batched control step, resets of ended worlds included."""
    core.reset(seed=0)
    for action in actions:
        began = time.perf_counter()
        *_, terminated, truncated, _ = core.step(action)
        ended = terminated | truncated
        if ended.any():
            core.reset(mask=ended)
        yield time.perf_counter() - began


def random_actions(core: Transport, steps: int) -> npt.NDArray[Any]:
    """``(step, world, learner, action_size)``, of numbers of pushes ``(step, world, learner)``."""
    generator, shape = np.random.default_rng(0), (steps, *core.action_shape)
    if core.table is not None:
        return generator.integers(len(core.table), size=shape)
    return generator.uniform(-1, 1, shape)
