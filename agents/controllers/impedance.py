"""Impedance control of the object towards its goal, its wrench shared by an allocation."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import UnknownName
from coopenv.geometry import frames
from coopenv.geometry.frames import wrapped
from coopenv.pushes import nearest
from coopenv.transition import Transition
from coopenv.wrench import allocate
from coopenv.wrench.methods.pseudoinverse import ALLOCATIONS

from .guidance import Gains, gains_row, wanted_twists
from .wrenches import require_wrenches

__all__ = ["Gains", "ImpedanceController", "approach", "wrapped"]

_TORQUE_FREE = 1e-9  # [kg·m²] virtual inertia that leaves all torque to the forces' levers


class ImpedanceController:
    """Inverse dynamics and impedance towards the goal, the wrench shared by an allocation.

        h_o = M (k_d (v_d − v) − g) + D v,    v_d = saturated k_p (goal − pose)

    Stateless; masses, drag and room are those of the episodes under way. The object keeps off the
    walls while it turns: where the coming turn needs more room than there is, it moves away from
    the wall first. Obstacles are not avoided. Tasks that ask for more have controllers of their
    own, which override `wanted_motion`; see `coopenv.agents.controllers.find_controller`.

    Where an agent would exceed a limit, all agents' wrenches are scaled down together, so that
    the object wrench keeps its direction and the split its proportions.

    Parameters
    ----------
    config
        Of the environment it acts in: the kind of action, the number of agents.
    method
        ``"moore_penrose"``, ``"nonsqueezing"`` or ``"parametrized"``; see
        `coopenv.wrench.allocate`. Agents that give forces only (``action="force"``) share by
        ``"parametrized"`` without virtual inertia, whatever is asked for.
    virtual_masses, virtual_inertias
        For ``"parametrized"``: one an agent [kg], [kg·m²].
    gains
        How briskly.

    Raises
    ------
    UnknownName
        If the method does not exist.
    """

    def __init__(
        self,
        config: TransportConfig,
        *,
        method: str = "moore_penrose",
        virtual_masses: Sequence[float] | None = None,
        virtual_inertias: Sequence[float] | None = None,
        gains: Gains | None = None,
    ):
        if method not in ALLOCATIONS:
            raise UnknownName("method", method, ALLOCATIONS)
        self.config, self.method = config, method
        self.gains = gains if gains is not None else Gains()
        self._width, self._table = ACTIONS[config.action], config.table
        if self._width == 2:
            self.method, virtual_inertias = "parametrized", [_TORQUE_FREE] * config.num_agents
        self._masses, self._inertias = virtual_masses, virtual_inertias

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``; it counts on a partner to do its part.

        Where actions are discrete, the numbers ``(world, learner)`` of the nearest pushes.
        """
        require_wrenches(self.config, "a scripted controller")
        team = transition.team
        applied = allocate(
            self.object_wrench(transition),
            team.grips,
            self.method,
            virtual_masses=self._masses,
            virtual_inertias=self._inertias,
        )
        action = frames.actions_from_wrenches(applied, team.frame, team.limits, self._width)
        largest = np.abs(action).max(axis=(1, 2), keepdims=True)
        scaled = action / np.maximum(largest, 1.0)
        given = scaled if self.config.partner is None else scaled[:, list(self.config.learners)]
        return nearest(given, self._table)

    def object_wrench(self, transition: Transition) -> FloatArray:
        """Wrench ``(world, 3)`` [N, N·m] that the object needs, object frame."""
        state, load = transition.next_state, transition.conditions.load
        inertia = np.stack([load.mass, load.mass, load.inertia], axis=-1)
        drag = np.stack([load.linear_drag, load.linear_drag, load.angular_drag], axis=-1)
        twist, acceleration = self.wanted_motion(transition)
        acceleration = acceleration + self.gains.damping * (twist - state.twist)
        if (gravity := transition.conditions.room.gravity).any():
            acceleration[:, :2] -= gravity
        wrench = inertia * acceleration + drag * state.twist  # world frame
        c, s = np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])
        wrench[:, 0], wrench[:, 1] = frames.rotated_back(c, s, wrench[:, 0], wrench[:, 1])
        return wrench

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, FloatArray | float]:
        """Twist ``(world, 3)`` [m/s, rad/s] and acceleration to aim for, world frame."""
        state, conditions = transition.next_state, transition.conditions
        half = conditions.room.size / 2
        return approach(
            state.pose, state.goal, conditions.load.outline, -half, half, self.gains
        ), 0.0


def approach(
    pose: FloatArray,
    goal: FloatArray,
    outline: FloatArray,
    low: FloatArray,
    high: FloatArray,
    gains: Gains,
) -> FloatArray:
    """Twist ``(world, 3)`` that leads an object to a goal within a rectangle, world frame.

    Parameters
    ----------
    pose, goal
        ``(world, 3)``.
    outline
        ``(world, vertex, 2)`` [m], object frame.
    low, high
        Corners ``(world, 2)`` [m] of what is free.
    gains
        How briskly.
    """
    return wanted_twists(gains_row(gains), pose, goal, outline, low, high)
