"""Hands on a body: their energy, and their motion against an independent integration."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import Body
from coopenv.geometry.frames import rotated
from coopenv.physics.hands import Hands, needed_substeps
from tests.helpers import TRIO
from tests.physics.held import ROOM, STRONG, Held
from tests.physics.independent import exact

GLIDING: dict[str, Any] = {"linear_drag": 0.0, "angular_drag": 0.0}
UNDAMPED = Hands(damping=0.0, torque_damping=0.0)


def shaken(held: Held, seed: int = 0, apart: float = 0.04, turned: float = 0.1) -> Held:
    """References moved off their grips at random [m, rad]."""
    chance = np.random.default_rng(seed)
    held.reference += chance.normal(0.0, 1.0, held.reference.shape) * [apart, apart, turned]
    return held


@pytest.mark.parametrize("substeps", [1, 2, 7])
@pytest.mark.parametrize("body", [Body(**GLIDING), Body.walker(**GLIDING)], ids=["free", "wheels"])
def test_springs_alone_keep_the_energy_in_steps_of_any_length(body, substeps):
    held = shaken(Held.of(body, UNDAMPED, 32, substeps=substeps, dt=0.1))
    start = held.stored()
    moved = 0.0
    for _ in range(100):
        held.step()
        np.testing.assert_allclose(held.kinetic() + held.stored(), start, rtol=1e-8)
        moved = max(moved, float((held.kinetic() / start).max()))
    assert moved > 0.5


def drawn(chance: np.random.Generator, count: int) -> Held:
    """Bodies, hands and limits of all sorts, many at bounds: no drag, no damping, weak, light.

    Bodies are as light as the substeps allow, or heavier.
    """
    grips = chance.uniform(-0.9, 0.9, (count, 2, 2)) * [1.0, 0.05]
    springs = np.exp(chance.uniform(-2.0, 2.0, (count, 2, 4))) * [150.0, 20.0, 30.0, 5.0]
    springs[..., 1:] *= chance.choice([0.0, 1.0], (count, 1, 3), p=[0.3, 0.7])
    limits = chance.choice([0.5, 10.0, 1e4], (count, 2, 2))
    dt, substeps = 0.05, int(chance.integers(1, 4))
    bodies = []
    for k in range(count):
        body = Body(
            mass=float(np.exp(chance.uniform(-2, 4))),
            inertia=float(np.exp(chance.uniform(-3, 3))),
            linear_drag=float(chance.choice([0.0, 8.0])),
            angular_drag=float(chance.choice([0.0, 8.0])),
            grips=tuple(map(tuple, grips[k].tolist())),
        )
        while needed_substeps(body, np.pad(springs[k], ((0, 0), (0, 2))), dt) > substeps:
            body = replace(body, mass=1.3 * body.mass, inertia=1.3 * (body.inertia or 0.0))
        bodies.append(body)
    return Held(bodies, springs, limits, dt=dt, substeps=substeps)


def assert_never_fed(held: Held, steps: int) -> None:
    """No step under references at rest adds energy, to what rounding makes of the positions."""
    before = held.kinetic() + held.stored()
    scale = before.copy()
    for _ in range(steps):
        held.step()
        after = held.kinetic() + held.energy.sum(axis=1)
        assert ((after - before) <= 1e-8 * scale + 1e-12).all()
        before = after


@given(seed=st.integers(0, 2**32 - 1), apart=st.sampled_from([0.001, 0.1, 0.3]))
@settings(max_examples=20)
def test_hands_at_rest_never_feed_energy_in(seed, apart):
    held = drawn(np.random.default_rng(seed), 16)
    held.world.twist = np.random.default_rng(seed).normal(0.0, 1.0, held.world.twist.shape)
    assert_never_fed(shaken(held, seed, apart, turned=5 * apart), steps=20)


def test_hands_at_rest_never_feed_energy_in_over_a_hundred_thousand_steps():
    held = drawn(np.random.default_rng(1), 1000)
    held.world.twist = np.random.default_rng(2).normal(0.0, 1.0, held.world.twist.shape)
    assert_never_fed(shaken(held, 3, 0.3, 0.5), steps=100)


@pytest.mark.parametrize("body", [Body(), TRIO, Body.walker()], ids=["free", "three", "wheels"])
def test_what_hands_give_in_a_step_is_the_change_of_energy_and_what_is_lost(body):
    """Of the mean forces of a step, on the chord of each grip, and of what dampers take."""
    held = Held.of(body, Hands(), dt=1e-3, substeps=1)
    held.velocity[:] = np.random.default_rng(5).uniform(-0.5, 0.5, held.velocity.shape)
    done = lost = 0.0
    energy = held.kinetic()[0] + held.stored()[0]
    for number in range(1500):
        if number % 300 == 299:
            held.velocity *= -1.0
        angle, twist = held.world.pose[0, 2], held.world.twist[0]
        before = held.grips_in_world()
        held.step()
        turn = held.world.pose[0, 2] - angle
        c, s = np.cos(angle + turn / 2), np.sin(angle + turn / 2)
        force = np.stack(rotated(c, s, *held.applied[0, :, :2].T), axis=-1)
        force /= np.sinc(turn / 2 / np.pi)
        moved = held.velocity[0] * held.dt
        done += (force * moved[:, :2]).sum() + (held.applied[0, :, 2] * moved[:, 2]).sum()
        slip = moved[:, :2] - (held.grips_in_world() - before)[0]
        lost += (held.springs[0, :, 2:3] * slip**2).sum() / held.dt
        lost += (held.springs[0, :, 3] * (moved[:, 2] - turn) ** 2).sum() / held.dt
        mean = (np.square(twist) + twist * held.world.twist[0] + held.world.twist[0] ** 2) / 3
        lost += held.dt * mean @ [body.linear_drag, body.linear_drag, body.angular_drag]
    gained = held.kinetic()[0] + held.stored()[0] - energy
    assert done == pytest.approx(lost + gained, rel=1e-6)
    assert lost > 0.2 * done > 0.0


KINDS = {
    "springs": (Hands(), STRONG),
    "one an agent": (Hands(stiffness=(60.0, 200.0), damping=(10.0, 40.0)), STRONG),
    "ball joints": (Hands(torque_stiffness=0.0, torque_damping=0.0), STRONG),
    "weak": (Hands(stiffness=10.0, torque_stiffness=5.0), (4.0, 1.0)),  # but within the leash
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("body", [Body(), Body.walker(angular_drag=8.0)], ids=["free", "wheels"])
def test_the_motion_is_that_of_an_independent_integration(body, kind):
    hands, limits = KINDS[kind]
    errors = []
    for substeps in (4, 16):
        held = Held.of(body, hands, limits=limits, substeps=substeps)
        held.velocity[:] = [[(0.5, 0.2, 0.3), (0.3, -0.2, -0.1)]]
        held.held[0, 1] = (0.3, -0.2, 0.1)
        wanted = exact(held, 0.4)
        for _ in range(8):
            held.step()
        reached = np.concatenate([held.world.pose[0], held.world.twist[0]])
        errors.append(float(np.abs(reached - wanted).max()))
    assert errors[1] < 1e-4
    assert errors[1] < errors[0] / 5 or errors[0] < 1e-8  # of second order


def test_under_gravity_and_changing_impedance_too_the_motion_is_that_of_an_integration():
    errors = []
    for substeps in (4, 16):
        fallen = replace(ROOM, gravity=(0.0, -9.81))
        held = Held.of(Body(), Hands(), substeps=substeps, scene=fallen)
        held.velocity[:] = [[(0.5, 0.2, 0.3), (0.3, -0.2, -0.1)]]
        apart = 0.0
        for step in range(8):
            held.springs[:] *= [[[1.4, 0.8, 0.9, 1.2]]] if step % 2 else [[[0.6, 1.3, 1.2, 0.7]]]
            wanted = exact(held, held.dt)
            held.step()
            reached = np.concatenate([held.world.pose[0], held.world.twist[0]])
            apart = max(apart, float(np.abs(reached - wanted).max()))
        errors.append(apart)
    assert errors[1] < 1e-4
    assert errors[1] < errors[0] / 8  # of second order


def test_no_hand_gives_more_than_its_limits_nor_its_reference_runs_away():
    held = Held.of(Body(), Hands(), 64, limits=(10.0, 5.0), substeps=3)
    chance = np.random.default_rng(0)
    reached = np.zeros(2)
    for _ in range(80):
        held.velocity[:] = 3.0 * chance.choice([-1.0, 1.0], held.velocity.shape)
        held.step()
        for wrench in (held.applied, held.felt):
            sizes = np.linalg.norm(wrench[..., :2], axis=-1), np.abs(wrench[..., 2])
            assert (sizes[0] <= 10.0 * (1 + 1e-12)).all()
            assert (sizes[1] <= 5.0 * (1 + 1e-12)).all()
            reached = np.maximum(reached, [sizes[0].max(), sizes[1].max()])
        assert (np.linalg.norm(held.stretch[..., :2], axis=-1) <= 10.0 / 150.0 + 1e-12).all()
        assert (np.abs(held.stretch[..., 2]) <= 5.0 / 20.0 + 1e-12).all()
    np.testing.assert_allclose(reached, [10.0, 5.0], rtol=1e-6)


@pytest.mark.parametrize("body", [Body(), TRIO], ids=["two", "three"])
def test_the_mean_wrench_of_a_step_explains_the_change_of_momentum(body):
    held = shaken(Held.of(body, Hands(), 8, substeps=1, limits=(10.0, 5.0)))
    for _ in range(20):
        angle, twist = held.world.pose[:, 2], held.world.twist
        held.step()
        mid = (angle + held.world.pose[:, 2])[:, None] / 2
        turn = held.world.pose[:, 2] - angle
        force = np.stack(
            rotated(np.cos(mid), np.sin(mid), *np.moveaxis(held.applied[..., :2], -1, 0))
        )
        total = force.sum(axis=-1).T / np.sinc(turn / 2 / np.pi)[:, None]
        x, y = np.moveaxis(held.grips, -1, 0)
        torque = held.applied[..., 2] + x * held.applied[..., 1] - y * held.applied[..., 0]
        rate, spin_rate = body.linear_drag / body.mass, body.angular_drag / (body.inertia or 1.0)
        grown = -np.expm1(-rate * held.dt) / body.linear_drag * total
        spun = -np.expm1(-spin_rate * held.dt) / body.angular_drag * torque.sum(axis=1)
        faded = twist * np.exp(-held.dt * np.array([rate, rate, spin_rate]))
        wanted = faded + np.concatenate([grown, spun[:, None]], axis=1)
        np.testing.assert_allclose(held.world.twist, wanted, rtol=0, atol=1e-12)


def test_an_agent_without_a_hand_gives_what_it_holds():
    held = Held.of(Body(), Hands(), limits=STRONG)
    held.springs[:, 1] = 0.0
    held.held[0, 1] = (3.0, -2.0, 1.0)
    held.reference[0, 1] += 5.0
    for _ in range(5):
        held.step()
        np.testing.assert_allclose(held.applied[0, 1], [3.0, -2.0, 1.0])
        np.testing.assert_allclose(held.felt[0, 1], [3.0, -2.0, 1.0])
        assert held.energy[0, 1] == 0.0
        assert not held.stretch[0, 1].any()
    assert np.linalg.norm(held.applied[0, 0]) > 0.1  # the other one feels it
