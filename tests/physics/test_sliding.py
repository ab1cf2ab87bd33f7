"""Hands on a body that rubs on its ground: rest, sliding, energy, an independent solution."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from coopenv import Body
from coopenv.geometry.frames import rotated
from coopenv.physics.friction import held as held_by_friction
from coopenv.physics.hands import Hands
from tests.physics.held import ROOM, STRONG, Held
from tests.physics.test_compliance import assert_never_fed, drawn, shaken

MU, G = 0.3, 9.81
SLED = Body(ground_friction=MU, linear_drag=0.0, angular_drag=0.0)


def rough(held: Held, seed: int) -> Held:
    """The same worlds on grounds of all sorts, the bodies moving."""
    chance = np.random.default_rng(seed)
    friction = np.exp(chance.uniform(-5.0, 1.0, len(held.bodies))).tolist()
    bodies = [
        replace(body, ground_friction=mu) for body, mu in zip(held.bodies, friction, strict=True)
    ]
    made = Held(bodies, held.springs, held.limit, dt=held.dt, substeps=held.substeps)
    made.world.twist = chance.normal(0.0, 1.0, made.world.twist.shape)
    return made


def test_a_steady_pull_stretches_hands_by_friction_over_their_stiffness():
    held = Held.of(SLED, Hands())
    held.velocity[..., 0] = 0.2
    for _ in range(200):
        held.step()
    np.testing.assert_allclose(held.world.twist[0], [0.2, 0.0, 0.0], atol=1e-9)
    each = MU * SLED.mass * G / 2 / 150.0
    np.testing.assert_allclose(np.linalg.norm(held.stretch[0, :, :2], axis=1), each, rtol=1e-8)


@pytest.mark.parametrize("share", [0.3, 0.98])
def test_a_pull_below_the_limit_moves_nothing_and_its_spring_stores(share):
    held = Held.of(SLED, Hands(), 2)
    away = share * MU * SLED.mass * G / 2 / 150.0
    held.reference[0, :, 0] += away
    held.reference[1, :, 0] += away / share * 1.02  # more than friction holds
    start = held.world.pose.copy()
    for _ in range(50):
        held.step()
    np.testing.assert_array_equal(held.world.pose[0], start[0])
    assert not held.world.twist[0].any()
    np.testing.assert_allclose(held.energy[0], 150.0 * away**2 / 2)
    assert held.world.pose[1, 0] > start[1, 0] + 1e-4


def test_a_turn_below_the_limit_of_friction_moves_nothing():
    held = Held.of(SLED, Hands())
    _, most = held_by_friction(SLED, ROOM)
    held.reference[..., 2] += 0.9 * most / 2 / 20.0
    start = held.world.pose.copy()
    for _ in range(20):
        held.step()
    np.testing.assert_array_equal(held.world.pose, start)


@given(seed=st.integers(0, 2**32 - 1), apart=st.sampled_from([0.001, 0.1, 0.3]))
@settings(max_examples=10)
def test_hands_at_rest_never_feed_energy_into_a_body_that_rubs(seed, apart):
    held = rough(drawn(np.random.default_rng(seed), 16), seed)
    assert_never_fed(shaken(held, seed, apart, turned=5 * apart), steps=20)


def test_what_hands_hold_on_rough_ground_comes_to_rest():
    held = shaken(Held.of(SLED, Hands(damping=0.0, torque_damping=0.0), 32), 1, 0.1, 0.3)
    for _ in range(200):
        held.step()
    assert not held.world.twist.any()
    pose = held.world.pose.copy()
    held.step()
    np.testing.assert_array_equal(held.world.pose, pose)


def exact(held: Held, seconds: float):
    """Pose and twist of the first world by SciPy, from the laws alone, while it slides."""
    body = held.bodies[0]
    most, most_turn = held_by_friction(body, ROOM)
    stiff, turn_stiff, damp, turn_damp = held.springs[0].T
    begun, velocity, grips = held.reference[0].copy(), held.velocity[0], held.grips[0]

    def law(time, y):
        levers = np.stack(rotated(np.cos(y[2]), np.sin(y[2]), *grips.T), axis=-1)
        across = np.stack([-levers[:, 1], levers[:, 0]], axis=-1)
        gone = begun + time * velocity
        force = stiff[:, None] * (gone[:, :2] - y[:2] - levers)
        force += damp[:, None] * (velocity[:, :2] - y[3:5] - y[5] * across)
        torque = turn_stiff * (gone[:, 2] - y[2]) + turn_damp * (velocity[:, 2] - y[5])
        norm = np.hypot(most * np.hypot(y[3], y[4]), most_turn * y[5])
        pushed = (force.sum(axis=0) - most**2 * y[3:5] / norm) / body.mass
        turned = (across * force).sum() + torque.sum() - most_turn**2 * y[5] / norm
        return np.concatenate([y[3:], pushed, [turned / body.inertia]])

    start = np.concatenate([held.world.pose[0], held.world.twist[0]])
    return solve_ivp(law, (0.0, seconds), start, rtol=1e-10, atol=1e-12).y[:, -1]


def test_the_motion_is_that_of_an_independent_integration():
    errors = []
    for substeps in (4, 16, 64):
        held = Held.of(SLED, Hands(), limits=STRONG, substeps=substeps)
        held.velocity[:] = [[(0.9, 0.3, 0.4), (0.7, -0.1, 0.2)]]
        held.world.twist = np.array([[0.8, 0.2, 0.5]])
        wanted = exact(held, 0.4)
        for _ in range(8):
            held.step()
        reached = np.concatenate([held.world.pose[0], held.world.twist[0]])
        errors.append(float(np.abs(reached - wanted).max()))
    assert errors[2] < 1e-3
    assert errors[1] < errors[0] / 2.5
    assert errors[2] < errors[1] / 2.5
