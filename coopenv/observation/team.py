"""Blocks of an agent's place in its team, of the same size in teams of any size."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated_back
from coopenv.observation.block import Block
from coopenv.transition import Transition
from coopenv.wrench.grasp import moment


def _others_wrench(transition: Transition) -> FloatArray:
    """What the others apply together, as one wrench at this agent's grip, along its axes.

    Force Σ f_j and torque Σ (t_j + (r_j − r_i) × f_j) over the others j ≠ i; 0 of an agent alone.
    """
    applied, team = transition.applied, transition.team
    about_centre = applied.copy()
    about_centre[..., 2:] += moment(team.grips, applied)
    others = about_centre.sum(axis=1, keepdims=True) - about_centre
    torque = others[..., 2] - moment(team.grips, others)[..., 0]
    frame = team.frame
    force = rotated_back(frame[..., 0], frame[..., 1], others[..., 0], others[..., 1])
    return np.stack([*force, torque], axis=-1)


def _place(transition: Transition) -> FloatArray:
    """1/n, this grip's distance from the centre of mass, and the root mean square of the team's."""
    grips = transition.team.grips
    squared = (grips**2).sum(axis=-1)  # (world, agent) [m²]
    spread = np.sqrt(squared.mean(axis=1, keepdims=True)) * np.ones_like(squared)
    even = np.full_like(squared, 1 / grips.shape[1])
    return np.stack([even, np.sqrt(squared), spread], axis=-1)


TEAM = (
    Block(
        name="others_wrench",
        size=3,
        describe="force and torque that the others apply together, about this agent's grip",
        read=_others_wrench,
        unit="N, N, N·m",
        frame="agent",
    ),
    Block(
        name="place",
        size=3,
        describe="1/n; distance of this agent's grip from the centre of mass, and root of the mean "
        "square of all agents' distances",
        read=_place,
        low=0.0,
        high=(1.0, np.inf, np.inf),
        unit="1, m, m",
    ),
)
