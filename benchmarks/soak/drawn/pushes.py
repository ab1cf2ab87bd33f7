"""Adversarial actions: uniform, bang-bang, constant, zero, one-hot, slowly turning, far outside."""

from collections.abc import Callable

import numpy as np

from coopenv import Transport
from coopenv.arrays import FloatArray, IntArray

Shape = tuple[int, ...]  # world, learner, numbers an agent gives


def any_actions(rng: np.random.Generator, core: Transport, steps: int) -> FloatArray | IntArray:
    """Actions ``(step, …)`` of a core's own shape: `any_pushes`, or numbers of pushes."""
    if core.table is not None:
        return rng.integers(len(core.table), size=(steps, *core.action_shape))
    return any_pushes(rng, steps, core.action_shape)


def any_pushes(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """Actions ``(step, *shape)``; each world has a kind of its own half of the time."""
    if rng.random() < 0.5:
        return KINDS[rng.integers(len(KINDS))](rng, steps, shape)
    pushes = np.empty((steps, *shape))
    for which, worlds in enumerate(np.array_split(rng.permutation(shape[0]), len(KINDS))):
        if len(worlds):
            pushes[:, worlds] = KINDS[which](rng, steps, (len(worlds), *shape[1:]))
    return pushes


def _uniform(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    return rng.uniform(-1.0, 1.0, (steps, *shape))


def _bang_bang(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """From limit to limit, held for a while."""
    hold = int(rng.integers(1, 20))
    pushes = rng.choice([-1.0, 1.0], (steps // hold + 1, *shape))
    return np.repeat(pushes, hold, axis=0)[:steps]


def _constant(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """Into the walls and on."""
    return np.broadcast_to(np.sign(rng.uniform(-1.0, 1.0, shape)), (steps, *shape)).copy()


def _zero(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    return np.zeros((steps, *shape))


def _one_hot(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """One number of one agent, the others still."""
    pushes = np.zeros((steps, *shape))
    agent, number = rng.integers(shape[1]), rng.integers(shape[2])
    pushes[..., agent, number] = rng.choice([-1.0, 1.0], (steps, shape[0]))
    return pushes


def _turning(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """Forces that turn slowly, so that the body goes round along the walls."""
    pace, phase = rng.uniform(0.0, 0.2, shape[:2]), rng.uniform(0.0, 6.3, shape[:2])
    angle = pace * np.arange(steps)[:, None, None] + phase
    pushes = np.zeros((steps, *shape))
    pushes[..., 0], pushes[..., 1] = np.cos(angle), np.sin(angle)
    return pushes


def _outside(rng: np.random.Generator, steps: int, shape: Shape) -> FloatArray:
    """Numbers of any size of which floats hold the square, or which are clipped."""
    return rng.normal(size=(steps, *shape)) * 10.0 ** rng.uniform(-140, 300, (steps, *shape))


KINDS: tuple[Callable[[np.random.Generator, int, Shape], FloatArray], ...] = (
    _uniform,
    _bang_bang,
    _constant,
    _zero,
    _one_hot,
    _turning,
    _outside,
)
