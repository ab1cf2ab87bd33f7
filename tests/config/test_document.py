"""A configuration as JSON: all of it comes back equal, and what cannot is refused by name."""

import json
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from coopenv import (
    BLOCKS,
    Actuators,
    Block,
    Body,
    Box,
    DoorwayTask,
    Hands,
    Ranges,
    Reference,
    Scene,
    Sensor,
    TrackingTask,
    Transport,
    TransportConfig,
    TransportTask,
    WalkerAvoidTask,
    WalkerTurnTask,
    rewards,
)
from coopenv.agents import partners
from coopenv.agents.controllers import Gains
from coopenv.config.kinds import FUNCTIONS, kinds_at
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import ranges
from coopenv.tasks import TASKS
from coopenv.wrench import Settings
from tests.agents.partners.cases import acting
from tests.helpers import CLUTTERED, IDS

EVERY_TERM = rewards.RewardSum(
    {
        "progress": rewards.Progress(weight=5, discount=0.99),
        "shaping": rewards.PotentialShaping(potential=rewards.closeness, discount=0.9),
        "success": rewards.Success(),
        "time": rewards.TimeCost(weight=0.25),
        "effort": rewards.Effort(weight=2e-4, torque_weight=3e-4),
        "force": rewards.InternalForce(settings=Settings(method="moore_penrose")),
        "torque": rewards.InternalTorque(weight=0.02),
        "relative": rewards.RelativeCost(settings=Settings(torque_weight=0.1)),
        "wasted": rewards.WastedCost(scale=7.0),
        "power": rewards.InternalPower(scale=3.0),
        "share": rewards.LoadShare(wanted=(0.25, 0.75), of="torque", scale=None),
        "rate": rewards.ActionRate(),
        "contact": rewards.Contact(weight=0.1),
        "tracking": rewards.TrackingError(),
    }
)
MOTION = Reference(times=(0.0, 1.0, 2.5), poses=((-1, 0, 0), (0, 0.5, 1), (1, 0, 0.5)))
HAND = partners.Noisy(
    partner=partners.Lagging(partner=partners.Follower(heaviness=(0.2, 0.9)), delay=(1, 3)),
    force=(0.0, 3.0),
)
CASES: dict[str, dict[str, Any]] = {
    "defaults": {},
    "task": {"task": TransportTask(min_distance=1.0, clearance=0.0)},
    "doorway": {"task": DoorwayTask(guide=(1,)), "scene": Scene(size=(8, 6))},
    "motion": {"task": TrackingTask(reference=MOTION), "observe": ("preview", "reference_twist")},
    "kinds of motion": {"task": TrackingTask(reference=("rotate", "translate"))},
    "turn": {"task": WalkerTurnTask(turn=(0.5, 1.0)), "body": Body.walker()},
    "avoid": {
        "task": WalkerAvoidTask(),
        "body": Body.walker(),
        "scene": Scene(size=(8, 6)),
        "observe": ("goal", Sensor("nearest", noise=0.1), "twist"),
        "action": "force",
    },
    "plates": {"body": (Body.plate(3), Body.plate(3, size=(1.5, 0.8))), "scene": CLUTTERED},
    "rooms": {"scene": (Scene(), Scene(obstacles=(Box(center=(1, 2), size=(0.5, 0.5)),)))},
    "rewards": {"reward": EVERY_TERM, "decomposition": Settings(include_induced=True)},
    "one term": {"reward": rewards.TimeCost(weight=1)},
    "preset": {"reward": "balanced", "horizon": 17, "dt": 0.02, "substeps": 3},
    "observation": {
        "observe": (
            "goal",
            "obstacles",
            BLOCKS["time"],
            ranges(num_rays=3, reach=2, heading=0.5, name="coarse"),
            replace(ranges(num_rays=4, name="told"), describe="said otherwise"),
            Sensor("partner_obstacles", noise=0.1, bias=(0.1,) * 15, delay=3),
            Sensor(BLOCKS["twist"], noise=(0.1, 0.2, 0.3)),
            Block(name="rays", size=5, describe="", low=[0.0] * 5, read=ranges(num_rays=2).read),
        )
    },
    "limits": {"force_limit": (5, 10), "torque_limit": 3, "informed": (), "sensing": "shared"},
    "hands": {
        "action": "impedance",
        "hands": Hands(stiffness=(80, 120.5), turn_rate=2, damping_factors=(0.5, 1)),
        "randomise": Ranges(stiffness=(50, 100), damping=(0, 9), logarithmic=("stiffness",)),
        "observe": ("stretch", Sensor("felt_wrench", noise=0.1, delay=2), BLOCKS["stored_energy"]),
        "cost": {"stretched": rewards.StoredEnergy(scale=0.3)},
    },
    "actuators": {
        "actuators": Actuators(delay=(1, 0), time_constant=0.1, rate_limit=(None, 4)),
        "randomise": Ranges(delay=(0, 3), rate_limit=(2, 8), logarithmic=("rate_limit",)),
    },
    "ranges": {
        "randomise": Ranges(
            mass=(3, 9), grips=((-0.05, 0.05), (0.0, 0.0)), length=(1.5, 2), logarithmic=("mass",)
        )
    },
    "gravity": {
        "scene": Scene(gravity=(0.5, -9.81)),
        "randomise": Ranges(gravity=(1, 12.5), ground_friction=(0, 1), logarithmic=("gravity",)),
    },
    "partner": {"partner": HAND, "partner_agents": (0,)},
    "population": {
        "partner": partners.Population(
            members=(
                HAND,
                partners.Impedance(offset=(0.1, 0.2), turn=0.3, gains=Gains(speed=2)),
                partners.Switching(first=partners.Stubborn(), mean_time=0.4),
            ),
            weights=(1, 2, 0),
        )
    },
    **{name: {"partner": name, **acting(name)} for name in partners.PARTNERS},
}
CONFIGS = {
    **{name: TransportConfig(**values) for name, values in CASES.items()},
    **{name: find_config(name, {}) for name in IDS},
}


def rollout(config, steps=12):
    """Everything that a few random steps hand out, one after another."""
    many = [value for value in (config.body, config.scene) if isinstance(value, tuple)]
    core = Transport(num_worlds=len(many[0]) if many else 3, config=config)
    generator = np.random.default_rng(4)
    out: list[Any] = [core.reset(seed=11)[0]]
    shape = core.num_worlds, len(core.learners), core.action_size
    for _ in range(steps):
        observation, reward, terminated, truncated, info = core.step(
            generator.uniform(-1, 1, shape)
        )
        out += [observation, reward, info["relative_cost"], *info["reward_terms"].values()]
        if (terminated | truncated).any():
            core.reset(mask=terminated | truncated)
    return out


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_a_configuration_comes_back_equal_and_as_the_same_text(config):
    text = config.to_json()
    again = TransportConfig.from_json(text)
    assert again == config
    assert again.to_json() == text
    assert json.loads(text) == json.loads(text, parse_constant=lambda name: pytest.fail(name))


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_what_comes_back_does_the_same_bit_for_bit(config):
    again = TransportConfig.from_json(config.to_json())
    for mine, other in zip(rollout(config), rollout(again), strict=True):
        np.testing.assert_array_equal(mine, other)


def test_terms_come_back_in_their_order_however_a_tool_sorts_the_text():
    terms = {name: rewards.TimeCost() for name in ("c", "a", "b")}
    text = TransportConfig(reward=rewards.RewardSum(terms)).to_json()
    again = TransportConfig.from_json(json.dumps(json.loads(text), sort_keys=True))
    assert list(again.terms) == ["c", "a", "b"]


def test_equal_configurations_have_one_text():
    ways: tuple[Any, ...] = (
        (1, ("obstacles", "time"), 9),
        (1.0, (ranges(), BLOCKS["time"]), np.int64(9)),
        (np.float64(1), (np.str_("obstacles"), BLOCKS["time"]), 9.0),
    )
    texts = set()
    for weight, observe, horizon in ways:
        reward = rewards.RewardSum({"effort": rewards.Effort(weight=weight)})
        texts.add(TransportConfig(reward=reward, observe=observe, horizon=horizon).to_json())
    assert len(texts) == 1


def test_every_field_is_written_so_that_a_default_may_change():
    for config in CONFIGS.values():
        document = json.loads(config.to_json())
        names = {entry.name for entry in fields(TransportConfig)} - {"sensing"}
        assert set(document) == {"kind", "version", *names}
        for name in ("task", "decomposition"):
            value = getattr(config, name)
            assert set(document[name]) == {"kind", *(entry.name for entry in fields(value))}
        assert "obstacles" not in document["observe"]  # its numbers are there instead


def test_the_text_names_every_kind_as_it_is_imported():
    kinds = kinds_at("coopenv.agents.partners")
    for name, kind in {**kinds, **FUNCTIONS}.items():
        module, _, attribute = name.rpartition(".")
        assert getattr(import_module(module), attribute) is kind
        if is_dataclass(kind):
            assert not {"kind", "sha256"} & {entry.name for entry in fields(kind)}


def test_all_that_a_configuration_may_be_made_of_is_a_kind():
    kinds = set(kinds_at("coopenv.agents.partners").values())
    assert kinds >= {*TASKS, Body, Scene, Box, Block, Sensor, Ranges, Reference, Settings}
    for face in (rewards, partners):
        for name in face.__all__:
            thing = getattr(face, name)
            assert not (isinstance(thing, type) and is_dataclass(thing)) or thing in kinds


def changed(*path, value, config=None):
    """The text of a configuration in which one place holds another value."""
    document = json.loads((config or TransportConfig()).to_json())
    place = document
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return json.dumps(document)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "text must be JSON"),
        (b"{}", "text must be JSON"),
        ("[]", "text must hold an object"),
        ("{}", "text must be of kind"),
        ('{"kind": "coopenv.TransportConfig"}', "version must be 1, got None"),
        ("[" * 100_000, "text must be JSON"),
        ('{"a": 1, "a": 2}', "a name comes twice"),
        ('{"a": NaN}', "NaN is no number"),
        (changed("version", value=2), "version must be 1, got 2; read it with"),
        (changed("version", value=True), "version must be 1"),
        (changed("hroizon", value=2), "did you mean 'horizon'"),
        (changed("task", "kind", value="coopenv.TransprtTask"), "kind of task .* 'coopenv.Transpo"),
        (changed("task", "clearence", value=1.0), "field of task .* did you mean 'clearance'"),
        (changed("task", value={"clearance": 1.0}), "task must say its kind"),
        (changed("body", "mass", value="heavy"), "body.mass must be made of float, got 'heavy'"),
        (changed("body", "mass", value=True), "body.mass must be made of float, got True"),
        (changed("body", "mass", value=-1.0), "body.mass must be positive"),
        (changed("body", "outline", 0, value=None), r"body.outline\[0\] must be made of"),
        (changed("reward", "terms", value=[{"name": "a"}]), r"reward.terms\[0\] must have exactly"),
        (changed("reward", "terms", value=[]), "reward must have at least one term"),
        (changed("reward", "terms", 0, "name", value="time"), "must name each term once"),
        (changed("reward", "terms", 0, "name", value=[]), "must name each term once"),
        (
            changed("reward", "terms", 0, "term", "potential", "name", value="coopenv.cli.main"),
            "function of reward.progress.potential must be one of the known names",
        ),
        (
            changed("reward", "terms", 0, "term", "potential", "name", value={}),
            "function of reward.progress.potential must be one of the known names, got {}",
        ),
        (changed("body", "mass", value=10**400), "body.mass must be a number that a computer can"),
        (changed("reward", "terms", 0, "term", "weight", value=None), "weight must be made of"),
        (changed("dt", value={"kind": "float", "value": "nan"}), "value of dt"),
        (changed("dt", value={"kind": "float", "value": "inf"}), "dt must be finite"),
        (
            changed("dt", value=0.5).replace('"dt": 0.5', '"dt": 1e999'),
            "dt must be finite, got inf",
        ),
        (changed("partner", value={"kind": "coopenv.agents.partners.Foe"}), "kind of partner"),
        (
            changed("partner", value={"kind": "coopenv.agents.partners.Stubborn", "gains": 3}),
            "partner.gains must be made of Gains, got 3",
        ),
        (changed("observe", value=["gaol"]), "did you mean 'goal'"),
        (changed("scene", value={"kind": "list", "items": 3}), "items of scene must be an array"),
    ],
)
def test_a_wrong_text_is_refused_by_the_name_of_its_part(text, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        TransportConfig.from_json(text)


def test_a_field_that_is_not_there_has_its_default():
    text = '{"kind": "coopenv.TransportConfig", "version": 1, "horizon": 7, "reward": "harmony"}'
    assert TransportConfig.from_json(text) == TransportConfig(horizon=7, reward="harmony")


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        (
            {"reward": rewards.Effort(weight=np.float32(0.1))},  # pyright: ignore
            "reward.Effort.weight must be made",
        ),
        ({"partner": partners.Impedance(gains=Gains(speed="fast"))}, "partner.gains.speed"),  # pyright: ignore
        ({"reward": rewards.Progress(potential=lambda state: -state.distance)}, "name, got <func"),
    ],
)
def test_what_would_not_come_back_as_it_was_is_not_written(keywords, said):
    with pytest.raises(InvalidInput, match=said):
        TransportConfig(**keywords).to_json()
