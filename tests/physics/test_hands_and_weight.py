"""Hands and weight: springs sag under a load, a floor bears it, a ground that rubs is refused."""

import numpy as np
import pytest

from coopenv import Body, Hands, Scene, Transport

UPRIGHT = Scene(size=(6.0, 6.0), gravity=(0.0, -9.81))
STILL = np.zeros((1, 2, 3))


def held(steps: int, height: float, **keywords) -> Transport:
    core = Transport(action="motion", horizon=steps, scene=UPRIGHT, **keywords)
    core.reset(seed=0, pose=(0.0, height, 0.0), goal=(1.0, 1.0, 0.0))
    for _ in range(steps):
        core.step(STILL)
    return core


def test_a_load_hangs_in_hands_by_its_weight_over_their_stiffness():
    stiffness = 2000.0
    hands = Hands(stiffness=stiffness, damping=100.0)
    core = held(200, 0.0, hands=hands, force_limit=80.0, substeps=10)
    weight = core.bodies[0].mass * 9.81
    after = core.transition
    assert after is not None
    np.testing.assert_allclose(after.next_state.pose[0, :2], (0.0, -weight / 2 / stiffness))
    np.testing.assert_allclose(after.applied[0, :, 1], weight / 2)
    assert after.stored_energy is not None
    np.testing.assert_allclose(after.stored_energy[0], (weight / 2) ** 2 / (2 * stiffness))


@pytest.mark.parametrize("damping", [0.0, 30.0, 90.0])
def test_what_hands_pull_along_a_floor_stays_where_friction_holds_it(damping):
    hands = Hands(damping=damping, torque_damping=damping / 6)
    core = Transport(action="motion", horizon=500, scene=UPRIGHT, hands=hands)
    core.reset(seed=0, pose=(0.0, -2.95, 0.0), goal=(-2.0, 2.0, 0.0))
    pull = STILL.copy()
    pull[0, :, 0] = 0.5, -0.5  # agents look at each other: both along the floor
    core.step(pull)
    for _ in range(50):
        core.step(STILL)
    before = core.transition
    for _ in range(400):
        core.step(STILL)
    after = core.transition
    assert before is not None
    assert after is not None
    np.testing.assert_allclose(after.next_state.pose, before.next_state.pose, atol=1e-7)
    np.testing.assert_allclose(after.next_state.twist, 0.0, atol=1e-12)
    np.testing.assert_allclose(after.applied, before.applied, atol=1e-5)
    assert np.abs(after.applied[0, :, 0]).min() > 3.0
    assert after.contact_shift[0] == pytest.approx(0.0, abs=1e-9)


def test_a_floor_bears_what_weak_hands_do_not():
    core = held(100, -2.9, force_limit=20.0)
    after = core.transition
    assert after is not None
    pulled = after.applied[0, :, 1].sum()
    assert 1.0 < pulled < core.bodies[0].mass * 9.81
    bottom = after.next_state.pose[0, 1] + min(y for _, y in core.bodies[0].outline)
    assert bottom == pytest.approx(-3.0, abs=3e-3)


def test_hands_pull_what_rubs_on_its_ground_only_once_they_are_stretched_enough():
    body = Body(ground_friction=0.2)
    core = Transport(action="motion", body=body, horizon=100)
    core.reset(seed=0, pose=(0.0, 0.0, 0.0), goal=(1.0, 1.0, 0.0))
    pull = STILL.copy()
    pull[0, :, 0] = 0.1, -0.1  # agents look at each other: both along the beam, 0.1 m/s
    moved = []
    for _ in range(60):
        core.step(pull)
        after = core.transition
        assert after is not None
        moved.append((np.abs(after.applied[0, :, 0]).sum(), after.next_state.pose[0, 0]))
    given, x = np.array(moved).T
    limit = 0.2 * body.mass * 9.81
    still = given < 0.99 * limit
    assert still.sum() > 3
    assert (x[still] == 0.0).all()
    assert given[0] < given[1] < given[2]
    assert x[-1] > 0.1
