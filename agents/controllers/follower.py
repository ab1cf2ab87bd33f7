"""Followers that are told nothing: hands go with their grips and give way to what they feel."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.config.keywords import read_agents
from coopenv.config.worlds import each
from coopenv.errors import InvalidInput
from coopenv.physics.hands import DAMPING, STIFFNESS, TORQUE_DAMPING, TORQUE_STIFFNESS
from coopenv.physics.strengths import parted
from coopenv.randomisation import Ranges, Variations
from coopenv.transition import Transition

from .velocities import HandPolicy, carried, gain, in_world, levers

_NOTHING = 1e-6  # [N/m] stiffness of a hand that lets go; a positive one has to be given


class Follower(HandPolicy):
    """A hand that goes with its grip and gives way to what it feels.

        v = v_g − c (f − f_w),    ω = ω_g − c_t (t − t_w)

    with (f, t) what the hand gives (`coopenv.Transition.felt_wrench`), (f_w, t_w) its part of the
    object's weight, which it bears, and v_g, ω_g what its grip will move with after
    ``anticipation``, if it goes on speeding up as in the last step. An agent can know all that of
    its own hand, and the weight of what it has lifted. Stateless.

    A hand whose reference moves through a step with what its grip had before lags behind wherever
    the object speeds up, by half a step if it speeds up evenly. Its springs keep that way: it drags
    as viscous drag of K dt / 2 does. ``anticipation=0`` is such a hand; with half a control step it
    neither drags nor pushes, with more it helps along.

    What is felt is of the last step, so a hand that gives way to too much of it overshoots farther
    in every step. On an object that holds still it does unless

        c (B + K dt / 2) < 1,    c_t (β + κ dt / 2) < 1

    with the stiffness and damping of the hand, so more is refused.

    Parameters
    ----------
    config
        Of an environment with hands.
    compliance, turn_compliance
        c [m/s per N] and c_t [rad/s per N·m]. Zero: it floats; what its springs have once been
        stretched by stays.
    anticipation
        How far ahead [s]. The default is the outcome of ``python -m benchmarks.followers``.
    firmness
        See `HandPolicy`.

    Raises
    ------
    InvalidInput
        If a gain breaks its rule, or is too large for the hands of a learner at their stiffest;
        beside what `HandPolicy` raises.
    """

    def __init__(
        self,
        config: TransportConfig,
        *,
        compliance: float = 0.02,
        turn_compliance: float = 0.02,
        anticipation: float = 0.075,
        firmness: float = 0.0,
    ):
        super().__init__(config, firmness=firmness)
        self.compliance = gain(compliance, "compliance", "m/s per N")
        self.turn_compliance = gain(turn_compliance, "turn_compliance", "rad/s per N·m")
        self.anticipation = gain(anticipation, "anticipation", "s")
        most = most_compliance(config, self.firmness)
        for name, bound in zip(("compliance", "turn_compliance"), most, strict=True):
            if (given := getattr(self, name)) >= bound:
                raise InvalidInput(
                    f"{name} must be below {bound:.3g} for the stiffest of these hands at "
                    f"dt={config.dt:g} s, got {given:g}; lower it, or take less stiffness or "
                    "damping"
                )

    def velocities(self, transition: Transition) -> FloatArray:
        """See `HandPolicy.velocities`."""
        before, now = transition.state.twist, transition.next_state.twist
        soon = now + self.anticipation / transition.dt * (now - before)
        yielding = np.array([self.compliance, self.compliance, self.turn_compliance])
        return carried(soon, levers(transition)) - yielding * self.resisted(transition)

    def resisted(self, transition: Transition) -> FloatArray:
        """What hands give beyond what they are to ``(world, agent, 3)``, world frame [N, N·m]."""
        assert transition.felt_wrench is not None
        return in_world(transition, transition.felt_wrench) - borne(transition)


class Still(HandPolicy):
    """A hand that stays where it is."""

    def velocities(self, transition: Transition) -> FloatArray:
        """See `HandPolicy.velocities`."""
        return np.zeros((*transition.team.grips.shape[:2], 3))


def borne(transition: Transition) -> FloatArray:
    """Each hand's part of the object's weight ``(world, agent, 3)``, world frame [N, N·m].

    Equal parts, as hands that hold alike bear them, each with the torque that holds its own part
    level; two hands that hold as far from the centre of mass bear them without torque.
    """
    grips = transition.team.grips
    weight = -transition.conditions.load.mass[:, None] * transition.conditions.room.gravity
    part = np.zeros((*grips.shape[:2], 3))
    part[..., :2] = weight[:, None] / grips.shape[1]
    middle = levers(transition).mean(axis=1)  # the weight's torque about it, shared alike
    part[..., 2] = -(middle[:, :1] * weight[:, 1:] - middle[:, 1:] * weight[:, :1]) / grips.shape[1]
    return part


def most_compliance(config: TransportConfig, firmness: float = 0.0) -> tuple[float, float]:
    """The compliances at which what a `Follower` gives stops settling; see there.

    Returns
    -------
    c [m/s per N] and c_t [rad/s per N·m], of the learner's hand that bears least, as stiff and as
    damped as episodes may draw it; infinite for hands without stiffness and damping.
    """
    assert config.hands is not None
    strengths = config.strengths()
    if config.randomise is not None:
        drawn = Ranges(stiffness=config.randomise.stiffness, damping=config.randomise.damping)
        _, (_, strengths) = Variations(drawn, each(config.body)[0], strengths).ends()
    hands = parted(strengths)[1][list(config.learners), :4]
    if config.action == "impedance":
        factors = config.hands.stiffness_factors, config.hands.damping_factors
        part = (1 + firmness) / 2
        stiffer, damped = (low ** (1 - part) * high**part for low, high in factors)
        hands *= [stiffer, stiffer, damped, damped]
    reply = hands[:, [DAMPING, TORQUE_DAMPING]]
    reply = reply + hands[:, [STIFFNESS, TORQUE_STIFFNESS]] * config.dt / 2
    force, torque = reply.max(axis=0, initial=0.0).tolist()
    return (1 / force if force else inf), (1 / torque if torque else inf)


def released(config: TransportConfig, agents: Sequence[int]) -> TransportConfig:
    """The same environment, in which ``agents`` let go: their hands hold with no force.

    Whatever they do, nothing comes of it but what a stiffness of 1e-6 N/m gives.

    Raises
    ------
    InvalidInput
        If no hands carry out the actions, if an agent is none of the team, or if every episode
        draws stiffness or damping of hands anew, of all agents.
    """
    hands, count = config.hands, config.num_agents
    if hands is None:
        raise InvalidInput(
            f"action must be 'motion' or 'impedance' for hands that let go, got "
            f"{config.action!r}; choose one of them"
        )
    slack_agents = read_agents(agents, "agents", count)
    if slack_agents is None:
        raise InvalidInput("agents must be those whose hands let go, got None; pass (1,)")
    for name in ("stiffness", "damping"):
        if (ends := getattr(config.randomise, name, None)) is not None:
            raise InvalidInput(
                f"randomise.{name} must be None for hands that let go, got {ends}, from which "
                "every episode would draw theirs; drop it"
            )
    columns = hands.table(count)[:, :4]
    columns[list(slack_agents)] = [_NOTHING, 0.0, 0.0, 0.0]
    names = ("stiffness", "torque_stiffness", "damping", "torque_damping")
    slack: dict[str, tuple[float, ...]] = {
        name: tuple(column.tolist()) for name, column in zip(names, columns.T, strict=True)
    }
    return replace(config, hands=replace(hands, **slack))
