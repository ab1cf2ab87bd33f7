"""What partners refuse, number by number: each check of each kind, just within and just beyond."""

import numpy as np
import pytest

from coopenv.agents.controllers import Gains
from coopenv.agents.partners import (
    Compliant,
    Follower,
    Impedance,
    Lagging,
    Leader,
    LoadSharing,
    Noisy,
    Population,
    Robot,
    Stubborn,
    Switching,
    Walking,
)
from coopenv.agents.partners.traits import MOST_DELAY
from coopenv.errors import InvalidInput

PLANNERS = (Impedance, Leader, Stubborn)
WALKERS = (Walking, Robot)
LEADING = (*PLANNERS, *WALKERS)

# kind, name, what is taken, what is not
SPANS = [
    *((kind, "offset", (0, 2.5, (0, 0.5)), (-1e-9, (-0.1, 0.5))) for kind in LEADING),
    *((kind, "turn", (0, np.pi, (0, 3)), (-1e-9, 3.1416, (0, 3.2))) for kind in LEADING),
    *((kind, "strength", (1e-9, 9.0), (0, -1.0)) for kind in PLANNERS),
    (Follower, "heaviness", (0.05, 1, (0.05, 1)), (0.0499, 1.0001, (0.04, 0.5), (0.5, 1.1))),
    (Compliant, "yielding", (0, 0.02, 1e12, (0, 0.1)), (-1e-9, 1.1e12, (0, 1e300))),
    (Compliant, "turn_yielding", (0, 1e12, (0, 0.1)), (-1e-9, 1.1e12, (0, 1e300))),
    (Follower, "eagerness", (1e-9, 50), (0, -1)),
    (LoadSharing, "share", (0, 0.9, (0.1, 0.9)), (-1e-9, 0.9001, (0, 0.95))),
    (Lagging, "delay", (0, 3, MOST_DELAY, (0, 4)), (-1, MOST_DELAY + 1, (0, 10**5), 0.5, (0.5, 2))),
    (Noisy, "force", (0, 5, (0, 5)), (-1e-9, (-1, 2))),
    (Noisy, "torque", (0, 5, (0, 5)), (-1e-9, (-1, 2))),
    (Switching, "mean_time", (1e-9, 100), (0, -1)),
    *(
        (kind, name, (0.01, 5, (0.01, 3)), (0.0099, 0, (0.009, 3)))
        for kind in WALKERS
        for name in ("approach", "damping", "speed", "spin", "strength")
    ),
    *(
        (kind, name, (0, 5, (0, 3)), (-1e-9, (-1, 3)))
        for kind in WALKERS
        for name in ("force_tremor", "torque_tremor")
    ),
    *((kind, "delay", (0, MOST_DELAY, (1, 2)), (-1, MOST_DELAY + 1, 1.5)) for kind in WALKERS),
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "name", "taken", "refused"),
    SPANS,
    ids=[f"{kind.__name__} {name}" for kind, name, *_ in SPANS],
)
def test_every_number_of_a_partner_has_its_bounds(kind, name, taken, refused):
    for value in taken:
        assert getattr(kind(**{name: value}), name) == value
    for value in (*refused, np.nan, np.inf, "much", (0.5, 0.1), (1, 2, 3), None):
        with pytest.raises(InvalidInput, match=f"partner.{name}"):
            kind(**{name: value})


@pytest.mark.parametrize(
    ("kind", "name"),
    [(Lagging, "partner"), (Noisy, "partner"), (Switching, "first"), (Switching, "second")],
)
@pytest.mark.parametrize("value", ["leader", Leader, None, 5])
def test_a_partner_in_a_partner_must_be_one(kind, name, value):
    with pytest.raises(InvalidInput, match=rf"partner.{name} must be a partner"):
        kind(**{name: value})


@pytest.mark.parametrize(
    "inner",
    [
        Switching(), Lagging(partner=Switching()), Noisy(partner=Lagging(partner=Switching())),
        Population(members=(Leader(), Noisy(partner=Switching()))),
    ],
)  # fmt: skip
def test_neither_role_of_a_switching_partner_may_switch(inner):
    for name in ("first", "second"):
        with pytest.raises(InvalidInput, match=f"partner.{name} must not switch itself"):
            Switching(**{name: inner})
    steady = Population(members=(Leader(), Noisy(partner=Lagging())))
    assert Switching(first=steady, second=Lagging()).first == steady


@pytest.mark.parametrize(
    "weights", [(1.0,), (1, 2, 3), (-1e-9, 1), (0, 0), (np.nan, 1), "ab", ((1, 2),)]
)
def test_weights_of_a_population_are_one_for_each_member_and_not_all_zero(weights):
    with pytest.raises(InvalidInput, match=r"partner.weights must be"):
        Population(members=(Leader(), Follower()), weights=weights)
    assert Population(members=(Leader(), Follower()), weights=[0, 2]).weights == (0.0, 2.0)  # pyright: ignore[reportArgumentType]


def test_gains_must_be_gains():
    with pytest.raises(InvalidInput, match=r"partner.gains must be Gains"):
        Impedance(gains=3.0)  # pyright: ignore[reportArgumentType]
    assert Leader(gains=Gains(speed=1.0)).gains.speed == 1.0


@pytest.mark.parametrize(
    ("kind", "delay"),
    [
        (Leader(), 0), (Follower(), 0), (Lagging(delay=(1, 4)), 4), (Lagging(delay=3), 3),
        (Noisy(partner=Lagging(delay=2)), 2), (Lagging(partner=Lagging(delay=(0, 2)), delay=5), 7),
        (Switching(first=Leader(), second=Lagging(delay=6)), 6),
        (Switching(first=Lagging(delay=6), second=Lagging(delay=2)), 6),
        (Population(members=(Lagging(delay=1), Lagging(delay=9), Leader())), 9),
        (Walking(delay=(2, 5)), 5), (Robot(), 0),
    ],
)  # fmt: skip
def test_the_longest_delay_is_what_may_be_drawn_of_all_there_is(kind, delay):
    assert kind.longest_delay == delay
