"""What a reset may be told, checked."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, finite_array, whole
from coopenv.errors import InvalidInput
from coopenv.physics.scene import Scene

Seed = int | Sequence[int | None] | None


def world_seeds(seed: Seed, worlds: list[int], num_worlds: int) -> list[int | None]:
    """The seed of each of ``worlds``; ``None`` lets its generator go on."""
    if seed is None:
        return [None] * len(worlds)
    if not isinstance(seed, Sequence | np.ndarray):
        first = whole(seed, "seed", at_least=0)
        return [first + k for k in worlds]
    if len(seed) != num_worlds:
        raise InvalidInput(
            f"seed must be one number or one for each of {num_worlds} worlds, "
            f"got {len(seed)}; world k of seed=s is seeded with s + k"
        )
    return [None if seed[k] is None else whole(seed[k], "seed", at_least=0) for k in worlds]


def marked_worlds(mask: BoolArray | None, num_worlds: int, *, first: bool) -> IntArray:
    """The worlds that ``mask`` marks: at the ``first`` reset it has to be all of them."""
    if mask is None:
        return np.arange(num_worlds)
    marked = np.asarray(mask)
    if marked.dtype != np.bool_ or marked.shape != (num_worlds,):
        raise InvalidInput(
            f"mask must be {num_worlds} booleans, got {marked.dtype} of shape "
            f"{marked.shape}; pass for example terminated | truncated"
        )
    if first and not marked.all():
        raise InvalidInput(
            f"mask must mark every world before the first step, got {marked.sum()} of "
            f"{num_worlds}; call reset() once without it"
        )
    return np.flatnonzero(marked)


def given_pose(pose: npt.ArrayLike | None, name: str, num_worlds: int) -> FloatArray | None:
    """One pose a world ``(world, 3)``, from one for all or one for each."""
    if pose is None:
        return None
    given = finite_array(pose, name)
    if given.shape not in ((3,), (num_worlds, 3)):
        raise InvalidInput(
            f"{name} must have shape (3,) or ({num_worlds}, 3), got {given.shape}; "
            "give x, y [m] and θ [rad]"
        )
    return np.broadcast_to(given, (num_worlds, 3)).copy()


def check_free(
    worlds: IntArray,
    given: Sequence[tuple[FloatArray | None, str]],
    scenes: Sequence[Scene],
) -> None:
    """Raise where a given pose is in a wall, an obstacle or another world's room."""
    for pose, name in given:
        if pose is None:
            continue
        for k in worlds.tolist():
            if not scenes[k].is_free(*pose[k, :2].tolist()):
                raise InvalidInput(
                    f"{name} must put the centre of mass inside the room of {scenes[k].size} m "
                    f"and off its obstacles, got {pose[k].tolist()} in world {k}; the origin "
                    "is the room's centre"
                )
