"""Finite bounds of observations: from the room, the limits of the team and what drag leaves.

A feature without a bound of its own gets one by its unit. Where physics gives none (a reading of a
noisy sensor, a reference that leaves the room) a reading is clipped, and that is told.
"""

from collections.abc import Iterable, Mapping, Sequence
from math import hypot

import numpy as np

from coopenv.arrays import LARGEST, FloatArray
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.observation.block import Block
from coopenv.observation.blocks import BLOCKS, OF_BODY
from coopenv.physics.body import Body
from coopenv.physics.hands import STIFFNESS, TORQUE_STIFFNESS
from coopenv.physics.scene import Scene
from coopenv.physics.strengths import parted
from coopenv.randomisation import Ranges, Variations

BEYOND = 1e-6  # of a feature's range: what is beyond its bound by less is rounding, and not told


class Bounds:
    """The largest magnitudes that there can be in an environment, by unit.

    Parameters
    ----------
    bodies
        All that may be carried; of ranges, the lowest and the highest.
    scenes
        Where.
    strengths
        ``(team, agent, column)``: force [N] and torque [N·m] that an action of 1 stands for, of
        every team there may be, and what hands and actuators they have
        (`coopenv.physics.strengths`).
    duration
        Of an episode [s].
    dt
        Control step [s].
    softest
        What an action can multiply the stiffness of hands by, at least.
    """

    @classmethod
    def of(
        cls,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        strengths: FloatArray,
        ranges: Ranges | None,
        duration: float,
        *,
        dt: float,
        softest: float = 1.0,
    ) -> "Bounds":
        """Bounds for ``bodies`` and one team's ``strengths``, or for what ``ranges`` make of them.

        ``strengths`` are ``(agent, column)``, as `coopenv.physics.strengths` has them; everything
        else as in the class.
        """
        if ranges is None:
            return cls(bodies, scenes, strengths[None], duration, dt, softest)
        ends = [end for body in bodies for end in Variations(ranges, body, strengths).ends()]
        scenes = [end for scene in scenes for end in ranges.scenes(scene)]
        teams = np.array([team for _, team in ends])
        return cls([body for body, _ in ends], scenes, teams, duration, dt, softest)

    def __init__(
        self,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        strengths: FloatArray,
        duration: float,
        dt: float,
        softest: float = 1.0,
    ):
        limits, hands, _ = parted(strengths)
        self._force, self._torque = limits.max(axis=(0, 1)).tolist()
        force = np.sqrt(2) * limits[..., 0].max(axis=0)  # (agent,): both axes at their limit
        grip = np.hypot(*np.abs([body.grips for body in bodies]).max(axis=0).T)  # (agent,)
        torque = limits[..., 1].max(axis=0) + grip * force
        self._bodies, self._grip = bodies, float(grip.max())
        gravity = max(hypot(*scene.gravity) for scene in scenes)  # [m/s²]
        most = float(force.sum()) + max(body.mass for body in bodies) * gravity
        speed, spin = _fastest(bodies, most, float(torque.sum()), duration)
        self.by_unit: Mapping[str, float] = {
            "1": 1.0,
            "m": max(float(np.hypot(*scene.size)) for scene in scenes),
            "m/s": speed,
            "rad/s": spin,
            "N": float(force.max()),
            "N·m": self._torque,
            "m/s²": min(2 * (speed + self._grip * spin) / dt + gravity, LARGEST),
            "W": _passed_on(bodies, float(force.sum()), float(torque.sum()), speed, spin),
        }
        wrench = [self._force, self._force, self._torque]  # along the axes that are limited
        total = float(force.sum())
        at_grip = min(speed + self._grip * spin, LARGEST)
        self._by_block: dict[str, list[float]] = {
            "own_wrench": wrench,
            "felt_wrench": wrench,
            "own_motion": [at_grip, at_grip, spin],
            "others_wrench": [total, total, float(torque.sum()) + self._grip * total],
        }
        if hands.shape[-1]:
            way, turn, energy = _stretched(limits, hands, softest)
            self._by_block |= {"stretch": [way, way, turn], "stored_energy": [energy]}

    def ends(self, block: Block, num_agents: int) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest of every feature of a block, ``(feature,)`` each, finite.

        Raises
        ------
        InvalidInput
            If it has a feature without bound, of a unit that says nothing about one.
        """
        low, high = block.ends(num_agents)
        if np.isfinite(low).all() and np.isfinite(high).all():
            return low, high
        if block == BLOCKS["body"]:
            most, signs = self._of_body(num_agents)
            least = 0.0 - most * signs
        else:
            most = self._magnitudes(block, num_agents)
            least = 0.0 - most
        return (
            np.where(np.isfinite(low), low, np.minimum(least, high)),
            np.where(np.isfinite(high), high, np.maximum(most, low)),
        )

    def _magnitudes(self, block: Block, num_agents: int) -> FloatArray:
        """The largest magnitude of each feature, by its unit."""
        if block.name in self._by_block and block.read is BLOCKS[block.name].read:
            return np.array(self._by_block[block.name])
        units = block.unit.split(", ")
        unknown = [unit for unit in units if unit not in self.by_unit]
        if unknown:
            raise InvalidInput(
                f"bounded must find a bound for every block, got {block.name!r} in the unit "
                f"{unknown[0]!r}; give the block low= and high=, or one of the units "
                f"{', '.join(self.by_unit)}"
            )
        values = [self.by_unit[unit] for unit in units]
        return block.spread(values[0] if len(values) == 1 else values, num_agents, "unit")

    def _of_body(self, num_agents: int) -> tuple[FloatArray, FloatArray]:
        """Magnitudes of the block about body and team, and 1 where a feature may be negative."""
        most = [max(getattr(body, name) for body in self._bodies) for name in OF_BODY]
        limits = [self._force, self._torque]
        other = [self._grip, self._grip, *limits] * (num_agents - 1)
        signs = [0.0] * 6 + [1.0, 0.0, 0.0] + [1.0, 1.0, 0.0, 0.0] * (num_agents - 1)
        return np.array([*most, self._grip, *limits, *other]), np.array(signs)


def _stretched(limits: FloatArray, hands: FloatArray, softest: float) -> tuple[float, float, float]:
    """How far hands [m, rad] are stretched at most, on their leash, and what they store then [J].

    A hand without torque stiffness has no angle to its reference: any bound will do.
    """
    force, torque = limits.max(axis=0).T  # (agent,) each
    stiffness, turning = softest * hands[..., [STIFFNESS, TORQUE_STIFFNESS]].min(axis=0).T
    turns = turning > 0
    way = force / stiffness
    turn = np.where(turns, torque / np.where(turns, turning, 1.0), np.pi)
    energy = (force * way + np.where(turns, torque * turn, 0.0)) / 2
    return tuple(min(float(each.max()), LARGEST) for each in (way, turn, energy))  # pyright: ignore[reportReturnType]


def _passed_on(
    bodies: Sequence[Body], force: float, torque: float, speed: float, spin: float
) -> float:
    """Power [W] that no agents pass on who together give these forces and torques at most.

    The mean twist of a step is that of its path, in which the parting of an overlap may be: a point
    of the body is moved by no more than it can have come in.
    """
    far = max(hypot(*point) for body in bodies for point in body.outline)
    least = min(((body.inertia or 0.0) / body.mass) ** 0.5 for body in bodies)  # radius of gyration
    parted = speed + far * spin
    most = force * (1.5 * speed + parted) + torque * (spin + parted / (2 * least))
    return min(most / 2, LARGEST)


def _fastest(
    bodies: Sequence[Body], force: float, torque: float, duration: float
) -> tuple[float, float]:
    """Speed [m/s] and spin [rad/s] that no body exceeds under these resultants, from rest.

    The kinetic energy E grows only where c v² + d ω² < F v + T ω, c and d the drag, so that it
    stays below that of the box round this ellipse. Without drag d√E/dt ≤ F/√(2m) + T/√(2J). What
    touches gives no energy, so that neither bound needs to know of walls.
    """
    light, heavy = _range(body.mass for body in bodies)
    small, large = _range(body.inertia or 0.0 for body in bodies)
    drag, _ = _range(body.linear_drag for body in bodies)
    spin_drag, _ = _range(body.angular_drag for body in bodies)
    by_time = force / np.sqrt(light) + torque / np.sqrt(small)  # of √(2E), a second
    root = duration * by_time
    if drag > 0 and spin_drag > 0:
        with np.errstate(over="ignore"):  # of next to no drag; time then says more
            ratio = np.sqrt(drag) / np.sqrt(spin_drag)
            speed = (force + np.hypot(force, torque * ratio)) / drag / 2
            spin = (torque + np.hypot(torque, force / ratio)) / spin_drag / 2
            root = min(root, np.hypot(np.sqrt(heavy) * speed, np.sqrt(large) * spin))
    most = root / np.sqrt(light), root / np.sqrt(small)
    return min(float(most[0]), LARGEST), min(float(most[1]), LARGEST)


def _range(values: Iterable[float]) -> tuple[float, float]:
    given = list(values)
    return min(given), max(given)


@compiled
def clip(seen, low, high):
    """Clip observations ``(world, agent, feature)`` to their bounds, in place.

    Returns ``(world, agent)``: whether one was beyond them, by more than rounding.
    """
    num_worlds, num_agents, num_features = seen.shape
    clipped = np.zeros((num_worlds, num_agents), dtype=np.bool_)
    for k in range(num_worlds):
        for i in range(num_agents):
            for j in range(num_features):
                value, least, most = seen[k, i, j], low[j], high[j]
                slack = BEYOND * (most - least)
                if value < least:
                    seen[k, i, j] = least
                    clipped[k, i] |= value < least - slack
                elif value > most:
                    seen[k, i, j] = most
                    clipped[k, i] |= value > most + slack
    return clipped
