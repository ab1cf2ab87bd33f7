"""Mistakes of frames and orientations, and exchanged grips, tried on a motion as it was read."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from coopenv.logs.consistency.known_body.found import Explanation
from coopenv.logs.consistency.known_body.known import Motion, Windows
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.layout import UNITS, Layout


def mistakes_of_pose(
    windows: Sequence[Windows], layout: Layout, whose: str
) -> Iterator[Explanation]:
    """Mistakes of frames and of orientations, which are ``whose``, and grips exchanged."""
    dimension = windows[0].motion.dimension

    def share(change: Callable[[Motion], Motion]) -> float:
        motions = [Windows(change(each.motion)) for each in windows]
        return Misfit.of(motions, layout.body, dimension).share()

    if dimension == 2:
        unit = "rad" if layout.angle == "deg" else "deg"
        factor = UNITS["angle"][unit] / layout.factor("angle")
        yield Explanation(
            "angle",
            f"theta{whose} is in {unit}",
            f"--angle {unit}",
            share(lambda motion: motion.turned_by(factor)),
            1,
        )
    if dimension == 3:
        order = "wxyz" if layout.pose.order == "xyzw" else "xyzw"
        places = [3, 0, 1, 2] if order == "xyzw" else [1, 2, 3, 0]
        yield Explanation(
            "order",
            f"quaternions{whose} are {' '.join(order)}",
            f'[pose] order = "{order}"',
            share(lambda motion: replace(motion, quaternion=motion.quaternion[:, places])),
            1,
        )
        yield Explanation(
            "inverse",
            f"orientations{whose} turn the world's vectors to the object's",
            "take the inverse (of a matrix, order = columns)",
            share(lambda motion: replace(motion, quaternion=motion.quaternion * [1, -1, -1, -1])),
            1,
        )
    frame = "world" if layout.frame == "object" else "object"
    yield Explanation(
        "frame",
        f"forces and torques are in the {frame} frame",
        f"--frame {frame}",
        share(lambda motion: _in_other_frame(motion, frame)),
        1,
    )
    count = windows[0].motion.force.shape[1]
    for i, j in combinations(range(count if count <= 4 else 0), 2):
        swapped = list(range(count))
        swapped[i], swapped[j] = j, i
        yield Explanation(
            "grips",
            f"the grips of effectors {i + 1} and {j + 1} are exchanged",
            "exchange them",
            share(lambda motion, to=swapped: replace(motion, grips=motion.grips[:, to])),
            1,
        )


def _in_other_frame(motion: Motion, frame: str) -> Motion:
    turn = Windows(motion).turn
    turn = turn.swapaxes(-1, -2) if frame == "world" else turn
    return replace(
        motion,
        force=np.einsum("tij,tnj->tni", turn, motion.force),
        torque=np.einsum("tij,tnj->tni", turn, motion.torque),
    )
