"""Hands as stiff as dt and substeps can integrate, against an independent integration."""

import numpy as np
import pytest

from coopenv import Body
from coopenv.arrays import FloatArray
from coopenv.physics.hands import (
    DAMPING,
    STIFFNESS,
    TORQUE_DAMPING,
    TORQUE_STIFFNESS,
    Hands,
    needed_substeps,
)
from tests.physics.held import Held
from tests.physics.independent import path

DT, STEPS, SEEDS = 0.05, 8, 3  # [s], control steps, random velocities
STATED = {1: 3.5e-3, 2: 1.8e-3, 5: 0.74e-3}  # [m], substeps: of default hands, docs/accuracy.md
BODIES: dict[str, Body] = {"free": Body(), "wheels": Body.walker(angular_drag=8.0)}
RATIOS = {"little damped": 0.1, "much damped": 10.0}  # times the default damping for stiffness
UNLIMITED = (1e9, 1e9)  # [N, N·m]


def stiffest(body: Body, substeps: int, damped: float) -> FloatArray:
    """``(agent, 6)``: the most times default hands that the substeps can integrate."""
    low, high = 0.0, 1e6
    while high - low > 1e-6 * high:
        middle = (low + high) / 2
        enough = needed_substeps(body, scaled(body, middle, damped), DT) <= substeps
        low, high = (middle, high) if enough else (low, middle)
    assert needed_substeps(body, scaled(body, 1.01 * high, damped), DT) == substeps + 1
    return scaled(body, low, damped)


def scaled(body: Body, number: float, damped: float) -> FloatArray:
    """Default hands of so many times the stiffness, and ``damped`` times that of the damping."""
    table = Hands().table(body.num_agents)
    table[:, [STIFFNESS, TORQUE_STIFFNESS]] *= number
    table[:, [DAMPING, TORQUE_DAMPING]] *= number * damped
    return table


def off(body: Body, springs: FloatArray, substeps: int, seed: int) -> float:
    """Largest distance [m] from the independent path, under a random velocity of each hand."""
    held = Held([body], springs[None, :, :4], UNLIMITED, dt=DT, substeps=substeps)
    held.velocity[:] = np.random.default_rng(seed).uniform(-1, 1, held.velocity.shape)
    apart = []
    for wanted in path(held, np.linspace(DT, STEPS * DT, STEPS)):
        held.step()
        apart.append(np.linalg.norm(held.world.pose[0, :2] - wanted[:2]))
    return float(max(apart))


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("substeps", STATED)
def test_hands_as_stiff_as_substeps_allow_move_a_body_to_the_stated_error(substeps, name, ratio):
    body = BODIES[name]
    springs = stiffest(body, substeps, RATIOS[ratio])
    errors = [off(body, springs, substeps, seed) for seed in range(SEEDS)]
    assert np.mean(errors) < STATED[substeps]
