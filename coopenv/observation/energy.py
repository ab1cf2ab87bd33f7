"""Blocks of energy: share of the power, what passes between agents, what a hand's springs hold."""

from coopenv.arrays import FloatArray
from coopenv.observation.block import Block
from coopenv.observation.senses import of_hands
from coopenv.transition import Transition


def _energy_share(transition: Transition) -> FloatArray:
    return transition.power.share[..., None]


def _internal_power(transition: Transition) -> FloatArray:
    return transition.per_agent(transition.power.internal)[..., None]


def _stored_energy(transition: Transition) -> FloatArray:
    return of_hands(transition.stored_energy, "stored_energy")[..., None]


ENERGY = (
    Block(
        name="energy_share",
        size=1,
        describe="β, this agent's share of the power over the step; 1/n where undefined",
        read=_energy_share,
        low=0.0,
        high=1.0,
        unit="1",
    ),
    Block(
        name="internal_power",
        size=1,
        describe="Ė_I, the power that agents pass to each other through the object, mean over the "
        "step",
        read=_internal_power,
        low=0.0,
        unit="W",
    ),
    Block(
        name="stored_energy",
        size=1,
        describe="energy that the springs of this agent's hand hold",
        read=_stored_energy,
        low=0.0,
        unit="J",
        needs_hands=True,
    ),
)
