"""Configurations drawn at random from everything that this package has come back from JSON."""

import math
from dataclasses import fields
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from coopenv import (
    BLOCKS,
    Actuators,
    Block,
    Body,
    Box,
    DoorwayTask,
    Hands,
    LiftTask,
    Ranges,
    Reference,
    Scene,
    Sensor,
    TrackingTask,
    TransportConfig,
    TransportTask,
    WalkerAvoidTask,
    WalkerTurnTask,
    rewards,
)
from coopenv.agents import partners
from coopenv.agents.controllers import Gains
from coopenv.observation import ranges
from coopenv.wrench import METHODS, Settings
from tests.helpers import BLIND_TO_HANDS

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False) | st.integers(-9, 9)
SIZES = st.floats(1e-6, 1e3)
TOLERANCES = st.floats(0.01, 3.0)


def pair(numbers):
    return st.tuples(numbers, numbers).map(sorted).map(tuple)


def span(numbers):
    return numbers | pair(numbers)


def as_list(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


SETTINGS = st.none() | st.builds(
    Settings,
    method=st.sampled_from([name for name in METHODS if name != "one_dimensional"]),
    torque_weight=st.floats(0.01, 0.99),
    include_induced=st.booleans(),
)
SCALED = ("InternalPower",)
WEIGHTED = ("Success", "TimeCost", "ActionRate", "Contact", "TrackingError")
SOLVED = ("InternalForce", "InternalTorque", "RelativeCost", "WastedCost")
TERMS = st.one_of(
    *(st.builds(getattr(rewards, name), weight=NUMBERS) for name in WEIGHTED),
    *(st.builds(getattr(rewards, name), weight=NUMBERS, settings=SETTINGS) for name in SOLVED),
    *(st.builds(getattr(rewards, name), weight=NUMBERS, scale=SIZES) for name in SCALED),
    st.builds(rewards.Effort, weight=NUMBERS, torque_weight=NUMBERS),
    st.builds(rewards.Progress, weight=NUMBERS, discount=st.floats(0.01, 1.0)),
    st.builds(
        rewards.LoadShare,
        weight=NUMBERS,
        wanted=st.none() | NUMBERS | st.tuples(NUMBERS, NUMBERS),
        of=st.sampled_from(["force", "torque"]),
        scale=st.none() | SIZES,
    ),
)
NAMES = st.text(
    st.characters(exclude_categories=["Cs"], exclude_characters="/"), min_size=1, max_size=8
)
REWARDS = st.sampled_from(list(rewards.PRESETS)) | st.dictionaries(
    NAMES, TERMS, min_size=1, max_size=4
).map(rewards.RewardSum)

GAINS = st.builds(Gains, **{entry.name: SIZES for entry in fields(Gains)})
PLANS = {"offset": span(st.floats(0, 2)), "turn": span(st.floats(0, 3)), "gains": GAINS}
HANDS = st.one_of(
    *(
        st.builds(getattr(partners, name), **PLANS, strength=SIZES)
        for name in ("Impedance", "Leader", "Stubborn")
    ),
    st.builds(partners.Follower, heaviness=span(st.floats(0.05, 1)), eagerness=SIZES),
    st.builds(partners.LoadSharing, share=span(st.floats(0, 0.9))),
)
DELAYS = st.integers(0, 5) | pair(st.integers(0, 5))
KINDS = st.recursive(
    HANDS,
    lambda kinds: st.one_of(
        st.builds(partners.Lagging, partner=kinds, delay=DELAYS | DELAYS.map(as_list)),
        st.builds(partners.Noisy, partner=kinds, force=span(SIZES), torque=span(SIZES)),
        st.builds(partners.Switching, first=HANDS, second=HANDS, mean_time=SIZES),
        st.lists(kinds, min_size=1, max_size=3).flatmap(
            lambda members: st.builds(
                partners.Population,
                members=st.just(tuple(members)),
                weights=st.none() | st.tuples(*[SIZES] * len(members)),
            )
        ),
    ),
    max_leaves=6,
)


RANGES = st.builds(
    ranges,
    num_rays=st.integers(1, 20),
    reach=SIZES,
    field_of_view=st.floats(0.01, 2 * math.pi),
    heading=NUMBERS,
    where=st.sampled_from(["grip", "centre"]),
    whose=st.sampled_from(["own", "partners"]),
    name=NAMES.map(lambda name: f"_{name}"),
)
OWN = st.builds(
    Block,
    name=NAMES.map(lambda name: f"+{name}"),
    size=st.just(4),
    describe=NAMES,
    read=st.just(ranges(num_rays=1).read),
    low=st.just(-math.inf) | NUMBERS | st.lists(NUMBERS, min_size=4, max_size=4),
    needs_told=st.sampled_from([(), (0, 0, 1, 1)]),
)
KNOWN = [*BLIND_TO_HANDS, *map(BLOCKS.get, BLIND_TO_HANDS)]
PLAIN = st.sampled_from(KNOWN) | RANGES | OWN
ENTRIES = PLAIN | st.builds(Sensor, block=PLAIN, noise=SIZES, bias=SIZES, delay=st.integers(0, 4))


def name_of(entry):
    block = entry.block if isinstance(entry, Sensor) else entry
    return block if isinstance(block, str) else block.name


OBSERVE = st.lists(ENTRIES, min_size=1, max_size=5, unique_by=name_of)

ROOM = Scene(size=(8.0, 6.0))
TIMES = st.tuples(st.just(0.0), st.floats(1, 2), st.floats(3, 5))
MOTION = st.builds(
    Reference,
    times=TIMES,
    poses=st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=3, max_size=3),
)
WALKER = st.just(Body.walker())
BEAM = st.builds(Body.beam, length=st.floats(1.0, 2.0), mass=SIZES, friction=st.floats(0, 1))
RUBBING = st.builds(Body.beam, mass=SIZES, ground_friction=st.floats(0.01, 1))
BOXES = st.builds(
    Box, center=st.tuples(st.floats(3, 4), st.floats(2, 3)), size=pair(st.floats(0.01, 0.1)),
    angle=NUMBERS,
)  # fmt: skip
STRONG = st.floats(60.0, 200.0)  # enough to bear the default beam
CARRIED = st.one_of(
    st.fixed_dictionaries(
        {
            "task": st.builds(TransportTask, angle_tolerance=TOLERANCES, angle_weight=SIZES),
            "body": BEAM | RUBBING | st.lists(BEAM, min_size=2, max_size=2).map(tuple),
            "scene": st.builds(
                Scene,
                size=st.just((8, 6)),
                obstacles=st.tuples(BOXES, BOXES),
                gravity=st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
                normal_gravity=st.floats(0, 20),
            ),
            "randomise": st.none()
            | st.builds(
                Ranges,
                mass=pair(SIZES),
                force_limit=st.none() | pair(SIZES),
                logarithmic=st.sampled_from([(), ("mass",)]),
            ),
        }
    ),
    st.fixed_dictionaries(
        {
            "task": st.builds(
                DoorwayTask,
                spin_tolerance=TOLERANCES,
                guide=st.sampled_from(["both", "one", "none", 1, (0,), (0, 1)]),
            ),
            "scene": st.just(ROOM),
        }
    ),
    st.fixed_dictionaries(
        {
            "task": st.builds(
                TrackingTask,
                reference=MOTION | st.sampled_from(["rotate", ("rotate", "translate")]),
                preview=st.lists(SIZES, min_size=1, max_size=3).map(tuple),
            ),
            "scene": st.just(ROOM),
        }
    ),
    st.fixed_dictionaries(
        {
            "task": st.builds(WalkerTurnTask, turn=pair(st.floats(0.1, 2.0)))
            | st.builds(WalkerAvoidTask, obstacles=st.integers(1, 2), veer=st.floats(0, 0.5)),
            "body": WALKER,
            "scene": st.just(ROOM),
        }
    ),
    st.fixed_dictionaries(
        {
            "task": st.builds(LiftTask, tilt_limit=st.floats(0.5, 3.0)),
            "scene": st.just(Scene(size=(8.0, 6.0), gravity=(0.0, -9.81))),
            "force_limit": STRONG | st.tuples(STRONG, STRONG),
        }
    ),
)
SOFT = st.floats(1e-4, 1e-2)  # for the lightest body's sake
WEAK = st.floats(1e-6, 1e-5)
PAIRS = {"stiffness": SOFT | st.tuples(SOFT, SOFT), "damping": WEAK | st.tuples(WEAK, WEAK)}
PAIRS |= {"speed": SIZES | st.tuples(SIZES, SIZES), "turn_rate": SIZES}
HOLDING = st.fixed_dictionaries(
    {
        "action": st.sampled_from(["motion", "impedance"]),
        "hands": st.builds(
            Hands,
            **PAIRS,
            torque_stiffness=st.floats(0, 1e-4),
            torque_damping=st.floats(0, 1e-8),
            stiffness_factors=st.tuples(st.floats(0.1, 1), st.floats(1, 4)),
            damping_factors=st.tuples(st.floats(0.1, 1), st.floats(1, 4)),
        ),
        "dt": st.floats(1e-4, 1e-3),
        "randomise": st.none() | st.builds(Ranges, stiffness=pair(SOFT), damping=pair(WEAK)),
    }
)
VALUES = st.fixed_dictionaries(
    {
        "reward": REWARDS,
        "observe": OBSERVE,
        "action": st.sampled_from(["wrench", "force"]),
        "force_limit": SIZES | st.tuples(SIZES, SIZES),
        "torque_limit": SIZES,
        "horizon": st.integers(1, 10**6),
        "dt": SIZES,
        "informed": st.none() | st.sampled_from([(), (0,), (1, 0)]),
        "decomposition": SETTINGS.filter(bool),
        "partner": st.none() | KINDS,
        "actuators": st.none()
        | st.builds(
            Actuators,
            delay=st.integers(0, 9) | st.tuples(st.integers(0, 9), st.integers(0, 9)),
            time_constant=st.just(0) | SIZES,
            rate_limit=st.none() | SIZES | st.tuples(st.none(), SIZES),
        ),
    }
)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(CARRIED, VALUES, st.none() | HOLDING)
def test_any_configuration_comes_back_equal_and_as_the_same_text(carried, values, holding):
    if holding is not None and not getattr(carried.get("body"), "ground_friction", 0.0):
        values = {**values, **holding}
    strength = {name: carried[name] for name in ("force_limit",) if name in carried}
    config = TransportConfig(**{**carried, **values, **strength})
    text = config.to_json()
    again = TransportConfig.from_json(text)
    assert again == config
    assert again.to_json() == text
    assert again.learners == config.learners
    assert list(again.terms) == list(config.terms)
