"""Infos of resets and steps: the decomposition, its measures and the reward terms."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray, with_rows
from coopenv.transition import Transition

Info = dict[str, Any]  # name -> array with one entry a world, or a dict of such arrays

UNDEFINED_AT_START = ("force_load_share", "torque_load_share")
POSES = ("partner_plan",)  # three numbers a world, not one an agent


def step_info(transition: Transition, parts: dict[str, FloatArray]) -> Info:
    """Infos of all worlds after a step.

    Wrenches are in the object frame ``(world, agent, 3)`` [N, N·m]; shares ``(world, agent)`` are
    NaN where undefined; the levels F_I [N] and T_I [N·m], γ, the wasted cost [N], ``success``,
    ``contact_impulse`` [N·s] and ``contact_shift`` [m] are ``(world,)``, the last two as
    `coopenv.physics.motion.collect` has them; ``reward_terms`` maps each name to
    ``(world, agent)``. Where body and team are drawn anew in every episode, ``body`` holds
    the numbers drawn (`coopenv.conditions.Conditions.parameters`).
    """
    decomposition = transition.decomposition
    share = decomposition.load_share
    conditions = transition.conditions
    drawn = {"body": conditions.parameters()} if conditions.randomised else {}
    return {
        "internal_wrench": decomposition.internal,
        "manipulation_wrench": decomposition.manipulation,
        "force_load_share": share.force,
        "torque_load_share": share.torque,
        "relative_cost": decomposition.relative_cost,
        "wasted_cost": decomposition.wasted_cost,
        "internal_force_level": decomposition.internal_force_level,
        "internal_torque_level": decomposition.internal_torque_level,
        "reward_terms": parts,
        "success": transition.success,
        "contact_impulse": transition.contact_impulse,
        "contact_shift": transition.contact_shift,
        **drawn,
    }


def start_info(start: Transition, reward_names: tuple[str, ...]) -> Info:
    """Infos at the start of an episode: as after a step in which nothing was applied or earned."""
    nothing = np.zeros(start.applied.shape[:2])
    return step_info(start, {name: nothing.copy() for name in reward_names})


def defined(info: Info) -> Info:
    """``info`` without the load shares, which nothing defines at the start of an episode.

    For single environments: their checkers compare infos of resets, and NaN never equals itself.
    """
    return {name: value for name, value in info.items() if name not in UNDEFINED_AT_START}


def with_worlds(info: Info, worlds: IntArray, other: Info) -> Info:
    """A copy of ``info`` with ``worlds`` replaced by those of ``other``, in order."""
    return {
        name: with_worlds(value, worlds, other[name])
        if isinstance(value, dict)
        else with_rows(value, worlds, other[name])
        for name, value in info.items()
    }


def copied(info: Info) -> Info:
    """A copy down to the arrays, so that what its owner does to it changes nothing here."""
    return {
        name: copied(value) if type(value) is dict else value.copy() for name, value in info.items()
    }


def one(info: Info, k: int) -> Info:
    """A copy of world ``k``'s info: its first axis dropped, single numbers as Python's own."""
    single: Info = {}
    for name, value in info.items():
        if isinstance(value, dict):
            single[name] = one(value, k)
        else:
            single[name] = value[k].copy() if value.ndim > 1 else value.item(k)
    return single
