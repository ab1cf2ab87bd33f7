"""Hands: with how much compliance agents hold their grips, and how many substeps that needs."""

from dataclasses import dataclass, fields
from math import ceil

import numpy as np

from coopenv.arrays import FloatArray, Range, positive_range
from coopenv.physics.body import Body
from coopenv.physics.strengths import PerAgent, check_count, per_agent

# Columns of a table of hands, one row an agent.
STIFFNESS, TORQUE_STIFFNESS, DAMPING, TORQUE_DAMPING, SPEED, TURN_RATE = range(6)
NUM_COLUMNS = 6

_MAY_BE_ZERO = ("torque_stiffness", "damping", "torque_damping")


@dataclass(frozen=True, slots=True, kw_only=True)
class Hands:
    """Springs and dampers through which agents move what they hold.

    What they do in a substep is in `coopenv.physics.compliance`.

    Each number is one for all agents, or a sequence of one an agent.

    Parameters
    ----------
    stiffness, torque_stiffness
        Force and torque for each metre and radian between the hand's reference and its grip. A hand
        without torque stiffness and torque damping holds its grip as a ball joint does.
    damping, torque_damping
        Force and torque for each unit of velocity between them.
    speed, turn_rate
        Of the reference, under an action of 1.
    stiffness_factors, damping_factors
        With ``action="impedance"``: what an action of −1 and of 1 multiply stiffness and torque
        stiffness by, and both dampings; geometric in between.

    Raises
    ------
    InvalidInput
        If a value breaks its rule.
    """

    stiffness: PerAgent = 150.0  # [N/m]
    torque_stiffness: PerAgent = 20.0  # [N·m/rad]
    damping: PerAgent = 30.0  # [N·s/m]
    torque_damping: PerAgent = 5.0  # [N·m·s/rad]
    speed: PerAgent = 1.0  # [m/s]
    turn_rate: PerAgent = 1.0  # [rad/s]
    stiffness_factors: Range = (0.25, 4.0)
    damping_factors: Range = (0.5, 2.0)

    def __post_init__(self) -> None:
        for entry in fields(self):
            name, value = entry.name, getattr(self, entry.name)
            if name.endswith("_factors"):
                given = positive_range(value, f"hands.{name}")
            else:
                given = per_agent(value, f"hands.{name}", or_zero=name in _MAY_BE_ZERO)
            object.__setattr__(self, name, given)

    def check(self, num_agents: int) -> None:
        """Raise `InvalidInput` where a sequence is not of one number an agent."""
        for entry in fields(self):
            if not entry.name.endswith("_factors"):
                check_count(getattr(self, entry.name), f"hands.{entry.name}", num_agents)

    def table(self, num_agents: int) -> FloatArray:
        """``(agent, 6)``: the columns that this module numbers."""
        table = np.empty((num_agents, NUM_COLUMNS))
        names = [entry.name for entry in fields(self)][:NUM_COLUMNS]
        for column, name in enumerate(names):
            table[:, column] = getattr(self, name)
        return table


def needed_substeps(body: Body, hands: FloatArray, dt: float) -> int:
    """The fewest substeps in which hands turn no motion of a body round within a substep.

    Hands at rest leave of a velocity v of their body, after a substep h by the rule of
    `coopenv.physics.compliance`, (1 − a) / (1 + a) v, where a is an eigenvalue of

        M⁻¹ (h² K / 4 + h B / 2)

    with M the inertia of the body, and K and B what springs and dampers of all hands make of its
    translation and rotation, the latter by the levers of the grips too. Above a = 1 the velocity
    comes out of the substep with its sign changed: nothing grows, but what is computed has little
    to do with springs. So a ≤ 1 is asked for.

    Parameters
    ----------
    body
        What is held; its drag is left out.
    hands
        ``(agent, 6)``, as `Hands.table`.
    dt
        Control step [s].
    """
    root = np.sqrt([body.mass, body.mass, body.inertia or 0.0])
    scale = root[:, None] * root
    stiff = _at_centre(body, hands[:, STIFFNESS], hands[:, TORQUE_STIFFNESS]) / scale
    damped = _at_centre(body, hands[:, DAMPING], hands[:, TORQUE_DAMPING]) / scale

    def largest(substeps: int) -> float:
        h = dt / substeps
        return float(np.linalg.eigvalsh(h * h / 4 * stiff + h / 2 * damped)[-1])

    # a falls with h at least in proportion, which bounds the number from above.
    low, high = 0, max(ceil(largest(1)), 1)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if largest(middle) <= 1 else (middle, high)
    return high


def _at_centre(body: Body, linear: FloatArray, angular: FloatArray) -> FloatArray:
    """``(3, 3)``: wrench of springs at the grips, for units of displacement; centre of mass."""
    total = np.zeros((3, 3))
    for (x, y), along, turning in zip(body.grips, linear, angular, strict=True):
        grip = np.array(
            [(1.0, 0.0), (0.0, 1.0), (-y, x)]
        )  # displacement of the centre → of the grip
        total += along * grip @ grip.T
        total[2, 2] += turning
    return total
