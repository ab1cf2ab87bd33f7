"""Wrenches of the snapshots, and where their numbers come from.

Fig. 2, the couple of Fig. 3 and the sums of Fig. 5 have numbers to meet. For the others none were
at hand, so ours are declared here: they show what the section is about. That Figs. 3, 4, 7, 8 and
17 are of these subjects is our reading of the sections.
"""

from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray

BEAM = np.array([(-1.0, 0.0), (1.0, 0.0)])  # the paper's [m]
SHORTER = np.array([(-0.9, 0.0), (0.9, 0.0)])  # off the tie that a lever of 1 m makes [m]
POINT = np.zeros((3, 2))  # three effectors on a point mass [m]
PAIR_POINT = np.zeros((2, 2))

LINE = np.array([(2.0, 0.0), (1.0, 1.0), (3.0, -1.0)])  # Fig. 2, along the beam [N]
COUPLE = np.array([(0.0, -0.7, 0.0), (0.0, 0.7, 0.0)])  # Fig. 3 [N, N·m]
SINGLE = np.array([3.0, 1.0])  # Fig. 4 [N]
TRIO = np.array([(3.0, 3.0, 0.0), (4.0, -1.0, 0.0), (-3.0, 0.0, 0.0)])  # Fig. 5, reconstructed [N]
TRIO_SPLIT = np.array([(3.0, 1.5, 0.0), (1.0, 0.5, 0.0), (0.0, 0.0, 0.0)])  # h_M of that figure
PAIR = np.array([(6.0, 4.0, 2.0), (1.0, -3.0, -2.0)])  # Fig. 7 [N, N·m]
WEIGHED = np.array([(0.5, -2.0, 1.0), (1.0, 2.0, -3.0)])  # Fig. 8 [N, N·m]
UNWEIGHED = WEIGHED * np.array([[1.0, 1.0, 1.0], [1.0, 1.0, 2.0]])  # −6 N·m outdo all else
CROSSING = np.array([(3.0, 1.0, 0.0), (-1.0, 2.0, 0.0)])  # Fig. 17 [N]
TWIST = np.array([1.0, -0.2, 0.0])  # [m/s, rad/s]

_ANGLES = np.pi / 2 + 2 * np.pi / 3 * np.arange(3)
DIGITS = 0.05 * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=-1)  # Fig. 6 [m]
SQUEEZE = np.concatenate(
    [-4.0 * DIGITS / 0.05, np.zeros((3, 1))], axis=-1
)  # towards the middle [N]
LIFT = np.array([(0.0, 0.0, 0.0), (0.0, 1.5, 0.0), (0.0, 1.5, 0.0)])  # by the lower two [N]
GRASP = SQUEEZE + LIFT


@dataclass(frozen=True, slots=True)
class Source:
    """Where the numbers of a figure come from."""

    figure: str
    subject: str
    numbers: str


SOURCES = (
    Source("Fig. 2", "two forces along a beam", "printed"),
    Source(
        "Fig. 3",
        "a couple of forces on a beam",
        "the paper's couple of 0.7 N at ±1 m; figure by subject",
    ),
    Source("Fig. 4", "the disc of a plausible force, eq. 9", "ours; figure by subject"),
    Source("Fig. 5", "three forces on a point mass", "reconstructed from the sums that it states"),
    Source("Fig. 6", "three digits, after Yoshikawa & Nagai", "ours: 4 N each inwards, lift 3 N"),
    Source("Fig. 7", "two forces askew to a beam", "ours; figure by subject"),
    Source(
        "Fig. 8", "torques that compensate each other or forces, eq. 24", "ours; figure by subject"
    ),
    Source("Fig. 17", "power of a manipulation wrench, eqs. 35-36", "ours; figure by subject"),
)


def along(forces: FloatArray) -> FloatArray:
    """Applied wrenches ``(..., 2, 3)`` of forces along a beam ``(..., 2)`` [N]."""
    applied = np.zeros((*forces.shape, 3))
    applied[..., 0] = forces
    return applied
