"""Hands on a body by their laws alone, integrated by SciPy; what several tests compare with."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated
from tests.physics.held import Held


def exact(held: Held, seconds: float) -> FloatArray:
    """Pose and twist of the first world after a while."""
    # limits make corners, at which a solver that looks ahead must not take long steps
    found = solve_ivp(
        law_of(held), (0.0, seconds), start_of(held), rtol=1e-10, atol=1e-12, max_step=2e-3
    )
    return found.y[:, -1]


def path(held: Held, times: FloatArray) -> FloatArray:
    """Poses and twists ``(time, 6)`` of the first world, whose hands stay within their limits."""
    found = solve_ivp(
        law_of(held),
        (0.0, float(times[-1])),
        start_of(held),
        method="DOP853",
        t_eval=times,
        rtol=1e-9,
        atol=1e-11,
    )
    return found.y.T


def start_of(held: Held) -> FloatArray:
    """``(6,)``."""
    return np.concatenate([held.world.pose[0], held.world.twist[0]])


def law_of(held: Held) -> Callable[[float, FloatArray], FloatArray]:
    """What pose and twist of the first world change by, while velocities of hands are held."""
    body, (force_limit, torque_limit) = held.bodies[0], held.limit[0, 0]
    stiff, turn_stiff, damp, turn_damp = held.springs[0].T
    start_ref, velocity, grips = held.reference[0].copy(), held.velocity[0].copy(), held.grips[0]

    def law(time, y):
        c, s = np.cos(y[2]), np.sin(y[2])
        levers = np.stack(rotated(c, s, *grips.T), axis=-1)
        across = np.stack([-levers[:, 1], levers[:, 0]], axis=-1)
        ref = start_ref + time * velocity
        stretch = ref[:, :2] - y[:2] - levers
        slip = velocity[:, :2] - y[3:5] - y[5] * across
        force = stiff[:, None] * stretch + damp[:, None] * slip
        size = np.linalg.norm(force, axis=1, keepdims=True)
        force = np.where(size > force_limit, force * force_limit / np.maximum(size, 1e-300), force)
        torque = turn_stiff * (ref[:, 2] - y[2]) + turn_damp * (velocity[:, 2] - y[5])
        torque = np.clip(torque, -torque_limit, torque_limit)
        hx, hy = rotated(c, s, *held.held[0, :, :2].T)
        force = force + np.stack([hx, hy], axis=-1)
        total = force.sum(axis=0) + body.mass * np.array(held.scene.gravity)
        turning = (across * force).sum() + torque.sum() + held.held[0, :, 2].sum()
        spin = (turning - body.angular_drag * y[5]) / body.inertia
        if body.nonholonomic:
            heading = np.array([c, s])
            speed = y[3:5] @ heading
            along = (total @ heading - body.linear_drag * speed) / body.mass
            pushed = along * heading + speed * y[5] * np.array([-s, c])
        else:
            pushed = (total - body.linear_drag * y[3:5]) / body.mass
        return np.concatenate([y[3:], pushed, [spin]])

    return law
