"""An active follower: it infers whether its partner turns or moves, and takes a share of it."""

from dataclasses import replace

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.transition import Transition

from .follower import Follower, borne
from .velocities import gain, in_world, levers


class ActiveFollower(Follower):
    """A `Follower` that takes a share of what it infers from the object's motion that others give.

    What moved the object beside its own hand in the last step, as a wrench at the others' grip:

        F_o = M v̇ + D v − f,    t_o = (J ω̇ + D_ω ω − τ) − r_o × F_o

    with (f, τ) what its hand gave in the mean of the step, at the centre of mass and beyond its
    part of the weight, and r_o the others' grip, or the middle of their grips. Force is taken for a
    wish to move, torque at the grip for one to turn: a push across a beam's end alone would be
    either, and the torque beside it tells which. So its own hand is to give, and gives way to what
    is beyond it,

        f_w = a_m F_o + a_t t_o ẑ × l / ‖l‖²,    t_w = a_t t_o

    with l from the others' grip to its own: a force across the object that turns it about the
    others' grip, and a torque. It knows the object (mass, inertia, drag, where is held) beside what
    its own hand can sense. What walls, and wheels across them, give is taken for the others'.
    Stateless.

    Parameters
    ----------
    config
        Of an environment with hands.
    move_share, turn_share
        a_m and a_t: what it adds to each newton, and newton metre, of the others. Beyond 1 it does
        more than they do, up to what its hand can. The defaults are the outcome of
        ``python -m benchmarks.followers``.
    compliance, turn_compliance, anticipation, firmness
        See `Follower`.
    """

    def __init__(
        self,
        config: TransportConfig,
        *,
        move_share: float = 0.15,
        turn_share: float = 10.0,
        compliance: float = 0.02,
        turn_compliance: float = 0.15,
        anticipation: float = 0.075,
        firmness: float = 0.0,
    ):
        super().__init__(
            config,
            compliance=compliance,
            turn_compliance=turn_compliance,
            anticipation=anticipation,
            firmness=firmness,
        )
        self.move_share = gain(move_share, "move_share", "parts of the others' force")
        self.turn_share = gain(turn_share, "turn_share", "parts of the others' torque")

    def resisted(self, transition: Transition) -> FloatArray:
        """See `Follower.resisted`."""
        others, lever = others_wrenches(transition), levers(transition)
        apart = lever - _of_others(lever)
        square = np.maximum((apart**2).sum(axis=-1), 1e-12)  # holding at one place, none turns
        turning = self.turn_share * others[..., 2]
        wish = np.empty_like(others)
        wish[..., 0] = self.move_share * others[..., 0] - turning * apart[..., 1] / square
        wish[..., 1] = self.move_share * others[..., 1] + turning * apart[..., 0] / square
        wish[..., 2] = turning
        return super().resisted(transition) - wish


def others_wrenches(transition: Transition) -> FloatArray:
    """What all but one hand gave in the mean of the last step, as each agent can infer it.

    From the object's motion and its own wrench, beyond everybody's part of the object's weight
    (`follower.borne`). Drag is taken by the mean of the velocities before and after the step.

    Returns
    -------
    ``(world, agent, 3)`` at the others' grip, or the middle of their grips, world frame [N, N·m];
    zero at the start of an episode, and where nobody else holds.
    """
    load, state = transition.conditions.load, transition.next_state
    middle = (transition.state.twist + state.twist) / 2
    pose = state.pose - 0.5 * transition.dt * middle
    held = replace(transition, next_state=replace(state, pose=pose))  # half a step ago
    change = (state.twist - transition.state.twist) / transition.dt
    total = np.empty_like(middle)
    total[:, :2] = load.mass[:, None] * change[:, :2] + load.linear_drag[:, None] * middle[:, :2]
    total[:, 2] = load.inertia * change[:, 2] + load.angular_drag * middle[:, 2]
    lever, own = levers(held), in_world(held, transition.applied) - borne(held)
    others = total[:, None] - own
    others[..., 2] -= _moment(lever, own)
    others[..., 2] -= _moment(_of_others(lever), others)
    begins = (state.time == 0) | (transition.team.num_agents == 1)
    others[begins] = 0.0
    return others


def _moment(lever: FloatArray, force: FloatArray) -> FloatArray:
    """Torque ``(...)`` of forces with levers ``(..., 2)``."""
    return lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]


def _of_others(lever: FloatArray) -> FloatArray:
    """The middle ``(world, agent, 2)`` of all other agents' grips; one's own if there are none."""
    count = lever.shape[1]
    return (lever.sum(axis=1, keepdims=True) - lever) / (count - 1) if count > 1 else lever
