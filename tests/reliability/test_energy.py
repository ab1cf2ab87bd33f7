"""Contacts give no energy: searched on every id, with bodies and rooms of every kind."""

from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Ranges, Scene, Transport
from coopenv.envs.registry import find_config
from coopenv.physics.world import World
from coopenv.wrench.grasp import sum_at_centre
from tests.helpers import CLUTTERED, IDS
from tests.reliability.energy import search

TOLERANCE = 1e-12  # [J]
AVOID, TURN = "coopenv/WalkerAvoid-v0", "coopenv/WalkerTurn-v0"
CARRY, DOORWAY = "coopenv/BeamTransport-v0", "coopenv/BeamDoorway-v0"
BEAMS = Ranges(
    mass=(2.0, 100.0),
    inertia=(0.5, 60.0),
    linear_drag=(0.0, 20.0),
    angular_drag=(0.0, 20.0),
    friction=(0.0, 3.0),
    length=(1.2, 2.2),
)
WALKERS = Ranges(
    mass=(5.0, 200.0),
    inertia=(0.5, 40.0),
    linear_drag=(0.0, 10.0),
    angular_drag=(0.0, 150.0),
    friction=(0.0, 3.0),
)
UPRIGHT = Scene(gravity=(0.0, -9.81))
CASES: dict[str, tuple[str, int, int, dict[str, Any]]] = {  # id, seed, steps, keywords
    **{name.removeprefix("coopenv/"): (name, 0, 400, {}) for name in IDS},
    "noisy human": (AVOID, 0, 400, {"partner": "noisy", "partner_agents": (0,)}),
    "random beams": (CARRY, 0, 300, {"randomise": BEAMS}),
    "random beams in a gap": (DOORWAY, 0, 300, {"randomise": BEAMS}),
    "random walkers": (TURN, 1, 300, {"randomise": WALKERS, "force_limit": 100.0}),
    "no drag": (CARRY, 0, 250, {"body": Body(linear_drag=0.0, angular_drag=0.0)}),
    "upright": (CARRY, 0, 250, {"scene": UPRIGHT, "force_limit": 80.0, "randomise": BEAMS}),
    "on rough ground": (CARRY, 0, 250, {"body": Body(ground_friction=0.2)}),
    "two corners at once": (CARRY, 0, 250, {"scene": Scene(size=(2.3, 2.3))}),
    "among boxes": (CARRY, 0, 250, {"scene": CLUTTERED}),
    "coarse steps": (DOORWAY, 0, 250, {"dt": 0.1, "substeps": 1}),
    "fine steps": (DOORWAY, 0, 300, {"dt": 0.05, "substeps": 5}),
}


@pytest.mark.parametrize(("name", "seed", "steps", "keywords"), CASES.values(), ids=list(CASES))
def test_contacts_give_no_energy(name, seed, steps, keywords):
    found = search(name, seed, steps, **keywords)
    print(f"seed {seed}: {found.touched} of {found.searched} substeps in contact")
    assert found.touched > 1000
    assert found.worst <= TOLERANCE, f"contacts gave {found.worst} J; run\n{found}"


@pytest.mark.parametrize("name", IDS)
def test_no_control_step_gains_more_energy_than_its_wrench_can_give(name):
    core = Transport(num_worlds=64, config=find_config(name, {}))
    core.reset(seed=1)
    generator, load = np.random.default_rng(1), core.conditions.load
    mass = np.column_stack([load.mass, load.mass, load.inertia])  # of each part of the twist
    weight = core.dt * np.sqrt(load.mass) * np.hypot(*core.scenes[0].gravity)
    action, touched = np.zeros((64, 2, 3)), 0
    for step in range(300):
        if step % 10 == 0:
            action = generator.choice([-1.0, 1.0], action.shape)
        before = core.world.twist
        *_, terminated, truncated, _ = core.advance(action)
        assert core.transition is not None
        wrench = sum_at_centre(core.transition.applied, core.team.grips)
        root = np.sqrt((mass * core.world.twist**2).sum(axis=1))  # √(2E)
        most = np.sqrt((mass * before**2).sum(axis=1))
        most += core.dt * np.sqrt((wrench**2 / mass).sum(axis=1)) + weight
        assert (root <= most * (1 + 1e-12)).all()
        touched += np.count_nonzero(core.world.contact_impulse)
        core.reset(mask=terminated | truncated)
    assert touched > 100


def test_a_search_finds_energy_that_a_step_adds_and_says_where(monkeypatch):
    stepped, calls = World.step, []

    def step_and_add(world, wrench):
        stepped(world, wrench)
        calls.append(None)
        if len(calls) == 30:
            world.twist[7] = 3.0, 4.0, 0.0

    monkeypatch.setattr(World, "step", step_and_add)
    found = search(CARRY, 3, 40, num_worlds=16)
    assert (found.step, found.world, found.searched) == (29, 7, 640)
    assert found.worst == pytest.approx(7.7 * 25 / 2 - found.energy)


def test_the_text_of_an_excess_repeats_its_last_substeps():
    found = search(CARRY, 2, 20, num_worlds=4, randomise=BEAMS)
    with redirect_stdout(StringIO()) as printed:
        exec(str(found), {})
    lines = printed.getvalue().splitlines()
    assert len(lines) == len(found.history) == min(found.step + 1, 8)
    assert f"step {found.step} of world {found.world}" in str(found)


def test_the_same_search_finds_the_same():
    first, second = (search(AVOID, 4, 60, num_worlds=32) for _ in range(2))
    assert first == second
    assert first != search(AVOID, 5, 60, num_worlds=32)
