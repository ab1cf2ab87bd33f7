"""Descriptions of hands, and how many substeps they need."""

import numpy as np
import pytest

from coopenv import Body, Hands, Ranges, TransportConfig
from coopenv.config.hands import outwards
from coopenv.errors import InvalidInput
from coopenv.physics.hands import needed_substeps
from tests.physics.held import Held


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"stiffness": 0.0}, r"hands\.stiffness must be positive, one number or one an agent"),
        ({"damping": -1.0}, r"hands\.damping must be zero or positive"),
        ({"speed": float("nan")}, r"hands\.speed must be finite"),
        ({"turn_rate": ((1.0,), (2.0,))}, r"hands\.turn_rate must be positive, one number or one"),
        (
            {"torque_damping": 1e13},
            r"hands\.torque_damping must be zero or positive.*at most 1e\+12",
        ),
        ({"stiffness_factors": (2.0, 1.0)}, r"hands\.stiffness_factors must be \(low, high\)"),
        ({"damping_factors": (0.0, 1.0)}, r"hands\.damping_factors must begin above zero"),
    ],
)
def test_a_hand_that_breaks_a_rule_is_refused_by_name(values, message):
    with pytest.raises(InvalidInput, match=message):
        Hands(**values)


def test_one_number_is_for_all_agents_and_a_sequence_for_one_each():
    hands = Hands(stiffness=(100, 200), speed=0.5)
    np.testing.assert_array_equal(
        hands.table(2), [[100, 20, 30, 5, 0.5, 1.0], [200, 20, 30, 5, 0.5, 1.0]]
    )
    with pytest.raises(InvalidInput, match=r"hands\.stiffness must be one number or one for each"):
        TransportConfig(action="motion", hands=Hands(stiffness=(1.0, 2.0, 3.0)))


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_the_number_asked_for_is_where_a_substep_would_turn_a_velocity_round(substeps):
    """Along each way in which the body moves by itself, v → (1 − a) / (1 + a) v."""
    stiffness, damping, mass, dt = 900.0, 60.0, 4.0, 0.1
    body = Body(mass=mass, inertia=1.0, linear_drag=0.0, angular_drag=0.0, grips=((0.0, 0.0),))
    hands = Hands(stiffness=stiffness, damping=damping, torque_stiffness=0.0, torque_damping=0.0)
    step = dt / substeps
    a = (step**2 * stiffness / 4 + step * damping / 2) / mass
    held = Held.of(body, hands, dt=step, substeps=1)
    held.world.twist = np.array([[0.5, 0.0, 0.0]])
    held.step()
    np.testing.assert_allclose(held.world.twist[0, 0], 0.5 * (1 - a) / (1 + a), rtol=1e-12)
    assert (a <= 1) == (needed_substeps(body, hands.table(1), dt) <= substeps)


def test_levers_and_light_bodies_need_more_substeps():
    hands = Hands().table(2)
    near, far = (Body.beam(length=2.0, grips=((-x, 0.0), (x, 0.0))) for x in (0.1, 0.9))
    assert needed_substeps(near, hands, 0.4) < needed_substeps(far, hands, 0.4)
    few, more = (needed_substeps(Body(mass=mass), hands, 0.05) for mass in (7.7, 0.5))
    assert (few, more > few) == (1, True)


LIGHT = {"body": Body(mass=1.0), "action": "motion"}


def test_what_substeps_cannot_integrate_is_refused_with_the_number_that_can():
    with pytest.raises(
        InvalidInput, match=r"substeps must be at least (\d+) for hands this stiff"
    ) as told:
        TransportConfig(**LIGHT)
    number = int(str(told.value).split("at least ")[1].split()[0])
    TransportConfig(**LIGHT, substeps=number)
    with pytest.raises(InvalidInput, match=f"at least {number} "):
        TransportConfig(**LIGHT, substeps=number - 1)


@pytest.mark.parametrize(
    "ranges",
    [
        Ranges(mass=(0.5, 10.0)),
        Ranges(inertia=(0.1, 2.0)),
        Ranges(length=(0.2, 5.0), inertia=(2.0, 2.5)),
        Ranges(stiffness=(100.0, 9000.0)),
        Ranges(damping=(10.0, 900.0)),
        Ranges(inertia=(0.5, 0.6), grips=((-0.09, 0.09), (-0.04, 0.04))),
    ],
)
def test_the_hardest_that_may_be_drawn_decides(ranges):
    body = Body(inertia=0.7)
    TransportConfig(body=body, action="motion", substeps=3)
    with pytest.raises(InvalidInput, match="substeps must be at least"):
        TransportConfig(body=body, action="motion", randomise=ranges, substeps=3)


def test_the_stiffest_step_of_an_impedance_decides():
    hands = Hands(stiffness_factors=(0.5, 50.0))
    TransportConfig(action="motion", hands=hands)
    with pytest.raises(InvalidInput, match="substeps must be at least"):
        TransportConfig(action="impedance", hands=hands)


@pytest.mark.parametrize("action", ["wrench", "force", "discrete"])
def test_hands_beside_an_action_that_none_carry_out_are_refused(action):
    with pytest.raises(InvalidInput, match="hands must come with action='motion'"):
        TransportConfig(action=action, hands=Hands())
    with pytest.raises(InvalidInput, match=r"randomise\.stiffness must come with action='motion'"):
        TransportConfig(action=action, randomise=Ranges(stiffness=(10.0, 20.0)))


def test_agents_that_a_partner_drives_count_since_they_may_have_hands():
    hands = Hands(stiffness=(150.0, 1e6))
    with pytest.raises(InvalidInput, match="substeps must be at least"):
        TransportConfig(action="motion", hands=hands)
    for driven in (0, 1):
        with pytest.raises(InvalidInput, match="substeps must be at least"):
            TransportConfig(
                action="motion", hands=hands, partner="leader", partner_agents=(driven,)
            )


def test_a_grip_is_drawn_outwards_on_both_axes_and_at_the_centre_stays():
    offsets = ((-0.1, 0.2), (-0.1, 0.3))
    assert outwards((0.5, 0.4), offsets) == pytest.approx((0.7, 0.7))
    assert outwards((-0.5, -0.4), offsets) == pytest.approx((-0.6, -0.5))
    assert outwards((0.0, 0.0), offsets) == (0.0, 0.0)
    assert outwards((0.5, 0.4), None) == (0.5, 0.4)
