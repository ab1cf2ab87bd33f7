"""A world alone beside itself in a batch: how far apart rounding may bring the two.

A batch keeps each world at a place of its own, so that positions are rounded otherwise, by some
1e-15 m. Most motions leave it at that. Some amplify without end whatever displaces them: stiff
hands that press against each other on a body that sticks and slips, for one. There a world is
compared with what nudges do to it that are some hundred times as large as rounding.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from coopenv import Transport
from coopenv.arrays import FloatArray

ALONE = 1e-9  # [m, rad, m/s, rad/s] by which company changes a world whose motion is not unstable
NUDGE = 1e-12  # [m, rad] at most, at every step


def check_alone(
    core: Transport,
    rides: Iterable[object],
    among: Sequence[tuple[FloatArray, ...]],
    explained: Callable[[], FloatArray],
    place: str,
) -> None:
    """Raise unless a world alone moves as it did ``among`` others.

    Parameters
    ----------
    core, rides
        The world alone, and its steps.
    among
        Pose and twist after every step, in the batch.
    explained
        Called where they are more than `ALONE` apart: by how much they may be, at every step.
    place
        What an error is about.
    """
    most = None
    for step, _ in enumerate(rides):
        off = apart(core, among[step])
        if off <= ALONE:
            continue
        most = explained() if most is None else most
        assert off <= most[step], (
            f"{place} alone is {off:.1e} off at step {step}, nudged {most[step]:.1e}"
        )


def growth(
    core: Transport, rides: Iterable[object], twin: Transport, twin_rides: Iterable[object]
) -> FloatArray:
    """The most by which a world alone is off its twin, up to every step, that is nudged after each.

    Both are alone, so that what company does to either is not in it.
    """
    rng, off = np.random.default_rng(0), []
    for _ in zip(rides, twin_rides, strict=True):
        off.append(apart(core, (twin.world.pose[0], twin.world.twist[0])))
        nudge(twin, rng)
    return np.maximum.accumulate(off)


def apart(core: Transport, other: tuple[FloatArray, ...]) -> float:
    """The largest difference of pose and twist of a core's first world [m, rad, m/s, rad/s]."""
    own = core.world.pose[0], core.world.twist[0]
    return max(float(np.abs(a - b).max()) for a, b in zip(own, other, strict=True))


def nudge(core: Transport, rng: np.random.Generator) -> None:
    """Displace all bodies by up to `NUDGE`, and nothing else."""
    state = core.get_state()
    pose = state.parts["world"]["pose"]
    pose += rng.uniform(-NUDGE, NUDGE, pose.shape)
    core.set_state(state)
