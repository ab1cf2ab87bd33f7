"""One description for every view: what it reads, what it refuses, and its way through JSON."""

import dataclasses
import json
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import coopenv
from coopenv import (
    BLOCKS,
    Block,
    Body,
    Box,
    DoorwayTask,
    Scene,
    TrackingTask,
    Transport,
    TransportConfig,
    TransportTask,
    WalkerAvoidTask,
    rewards,
)
from coopenv.agents.partners import Follower, Noisy
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import DEFAULT_BLOCKS, SENSING, ranges
from coopenv.wrench import Settings
from tests.helpers import CLUTTERED, IDS, OPEN_ROOM, OPTIONS, OWN_OPTIONS, PARALLEL, TRIO, room

HALL = Scene(size=(7.0, 4.0))


def test_the_keywords_of_every_view_are_the_fields_of_one_configuration():
    keywords = {"horizon": 7, "action": "force", "dt": 0.1, "substeps": 3, "reward": "harmony"}
    assert Transport(**keywords).config == TransportConfig(**keywords)
    for name, module in PARALLEL.items():
        wanted = find_config(name, keywords)
        for view in (
            gymnasium.make(name, **keywords),
            gymnasium.make_vec(name, num_envs=2, **keywords),
            module.parallel_env(**keywords),
            module.env(**keywords),
        ):
            assert view.unwrapped.transport.config == wanted  # pyright: ignore[reportAttributeAccessIssue]


def test_a_ready_configuration_stands_for_its_keywords():
    config = TransportConfig(horizon=3)
    assert Transport(config=config).config is config
    with pytest.raises(InvalidInput, match="config must come alone"):
        Transport(config=config, horizon=4)


def test_a_configuration_cannot_be_changed_but_by_replacing():
    config = TransportConfig()
    with pytest.raises(dataclasses.FrozenInstanceError):
        config.horizon = 3  # pyright: ignore[reportAttributeAccessIssue]
    assert dataclasses.replace(config, horizon=3).horizon == 3
    assert dataclasses.replace(config) == config
    assert hash(dataclasses.replace(config)) == hash(config)


@pytest.mark.parametrize(
    ("misspelt", "meant"),
    [("horizn", "horizon"), ("rewards", "reward"), ("bodies", "body"), ("sub_steps", "substeps")],
)
def test_a_misspelt_keyword_raises_and_suggests_the_nearest_in_every_view(misspelt, meant):
    makers = [TransportConfig.parse, lambda given: Transport(**given)]
    for name, module in PARALLEL.items():
        makers += [
            lambda given, name=name: gymnasium.make(name, **given),
            lambda given, name=name: gymnasium.make_vec(name, num_envs=2, **given),
            lambda given, module=module: module.parallel_env(**given),
            lambda given, module=module: module.env(**given),
        ]
    for make in makers:
        with pytest.raises(UnknownName, match=f"got '{misspelt}'; did you mean '{meant}'"):
            make({misspelt: 1})


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"action": "forces"}, r"action must be .*did you mean 'force'"),
        ({"action": None}, r"action must be one of"),
        ({"reward": "harmny"}, r"reward must be .*did you mean 'harmony'"),
        ({"reward": None}, r"reward must be a preset name"),
        ({"reward": {"x": 3.0}}, r"reward must map names to callable terms, got 'x'"),
        ({"reward": {"a/b": rewards.TimeCost()}}, r"names of terms must be words .* got 'a/b'"),
        ({"cost": {"": rewards.TimeCost()}}, r"names of terms must be words .* got ''"),
        ({"cost": 5}, r"cost must be .* got 5; presets: contact, squeeze, waste"),
        ({"reward": rewards.TimeCost}, r"reward must be a preset name"),
        ({"observe": ("gaol",)}, r"observe must be .*did you mean 'goal'"),
        ({"observe": ()}, r"observe must be a sequence of block names"),
        ({"observe": "goal"}, r"observe must be a sequence of block names"),
        ({"observe": None}, r"observe must be a sequence of block names"),
        ({"observe": ("goal", "goal")}, r"observe must name each block once"),
        ({"observe": ("twist", coopenv.Sensor("twist"))}, r"observe must name each block once"),
        ({"observe": ({"block": "twist", "nois": 1},)}, r"in observe .*did you mean 'noise'"),
        ({"observe": ({"name": "x", "read": {"rays": 1}},)}, r"in observe .*mean 'num_rays'"),
        ({"observe": ({"size": 1},)}, r"observe must be one of the known names"),
        ({"sensing": "shred"}, r"sensing must be .*did you mean 'shared'"),
        ({"sensing": 1}, r"sensing must be one of the known names"),
        ({"sensing": "own", "observe": ("goal",)}, r"sensing must come without observe"),
        ({"sensing": "own", "observe": DEFAULT_BLOCKS}, r"sensing must come without observe"),
        ({"observe": (3,)}, r"observe must be one of the known names"),
        ({"horizon": 0}, r"horizon must be a whole number of at least 1"),
        ({"horizon": 2.5}, r"horizon must be a whole number"),
        ({"horizon": None}, r"horizon must be a number"),
        ({"dt": 0.0}, r"dt must be positive"),
        ({"dt": float("nan")}, r"dt must be finite"),
        ({"substeps": 0}, r"substeps must be a whole number of at least 1"),
        ({"force_limit": 0.0}, r"force_limit must be positive"),
        ({"force_limit": (1.0, 2.0, 3.0)}, r"force_limit must be positive, one number or one for"),
        ({"torque_limit": (1.0, -1.0)}, r"torque_limit must be positive"),
        ({"torque_limit": "strong"}, r"torque_limit must be an array of numbers"),
        ({"body": 7.7}, r"body must be a Body"),
        ({"body": ()}, r"body must not be empty"),
        ({"body": (Body(), 3)}, r"body must be a Body"),
        ({"body": (Body(), TRIO)}, r"body\.grips must be as many in every world"),
        ({"body": {"mas": 3.0}}, r"keyword of body must be .*did you mean 'mass'"),
        ({"scene": "room"}, r"scene must be a Scene"),
        ({"scene": {"sise": (3, 3)}}, r"keyword of scene must be .*did you mean 'size'"),
        ({"scene": {"obstacles": [{"centre": (0, 0)}]}}, r"scene\.obstacles .*mean 'center'"),
        ({"scene": Scene(size=(2.0, 6.0))}, r"scene\.size must be at least 2\.20 m each way"),
        ({"task": {"clearence": 0.2}}, r"keyword of task must be .*did you mean 'clearance'"),
        ({"task": {"clearance": -0.2}}, r"task\.clearance must be zero or positive"),
        ({"task": "transport"}, r"task must be"),
        ({"task": TransportTask}, r"task must be"),
        ({"decomposition": "optimal"}, r"decomposition must be a Settings"),
        ({"decomposition": {"method": "optimol"}}, r"method must be .*did you mean 'optimal'"),
        ({"max_episode_steps": 0}, r"horizon must be a whole number of at least 1"),
    ],
)
def test_a_wrong_value_is_refused_by_the_name_of_its_keyword(values, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        TransportConfig.parse(values)


def test_every_error_is_also_the_builtin_one_would_catch():
    for values in ({"horizon": 0}, {"horizn": 1}):
        with pytest.raises(ValueError):
            TransportConfig.parse(values)


@pytest.mark.parametrize("alias", ["max_episode_steps", "max_cycles"])
def test_the_ecosystems_words_for_the_horizon_override_it(alias):
    assert TransportConfig.parse({alias: 5}).horizon == 5
    assert TransportConfig.parse({alias: 5, "horizon": 9}).horizon == 5
    assert TransportConfig.parse({alias: None, "horizon": 9}).horizon == 9


def test_one_body_serves_every_world_and_a_sequence_gives_each_its_own():
    light, heavy = Body(mass=1.0), Body(mass=9.0)
    assert Transport(num_worlds=3, body=light).bodies == (light, light, light)
    assert Transport(num_worlds=2, body=[light, heavy]).bodies == (light, heavy)
    with pytest.raises(InvalidInput, match="body must be one, or one for each of the 3 worlds"):
        Transport(num_worlds=3, body=[light, heavy])
    with pytest.raises(InvalidInput, match="scene must be one, or one for each of the 3 worlds"):
        Transport(num_worlds=3, scene=[Scene(), Scene()])


def test_a_long_body_needs_a_large_room_only_in_its_own_world():
    short, long = Body.beam(length=1.0), Body.beam(length=6.0)
    Transport(num_worlds=2, body=[short, long], scene=[Scene(size=(2, 2)), Scene(size=(8, 8))])
    with pytest.raises(InvalidInput, match=r"scene\.size must be at least"):
        Transport(num_worlds=2, body=[long, short], scene=[Scene(size=(2, 2)), Scene(size=(8, 8))])
    with pytest.raises(InvalidInput, match=r"scene\.size must be at least"):
        Transport(num_worlds=2, body=[short, long], scene=Scene(size=(2, 2)))


@pytest.mark.parametrize("count", [0, -1, 1.5, True, "two"])
def test_the_number_of_worlds_must_be_whole_and_positive(count):
    with pytest.raises(InvalidInput, match="num_worlds must be a"):
        Transport(num_worlds=count)


def test_what_is_given_overrides_the_senses_that_an_id_starts_from():
    defaults = {"observe": ("goal", "obstacles")}
    assert TransportConfig.parse({}, defaults).observe == ("goal", "obstacles")
    assert TransportConfig.parse({"sensing": "own"}, defaults).observe == SENSING["own"]
    assert TransportConfig.parse({}, {"sensing": "own"}).observe == SENSING["own"]
    assert TransportConfig.parse({"observe": ("goal",)}, {"sensing": "own"}).observe == ("goal",)


@pytest.mark.parametrize("word", SENSING)
@pytest.mark.parametrize("task", [DoorwayTask(), TrackingTask(), WalkerAvoidTask()])
def test_the_words_for_senses_keep_the_blocks_that_a_task_brings(task, word):
    room = Scene(size=(8.0, 6.0))
    own = TransportConfig(task=task, scene=room, sensing=word)
    senses = tuple(block for block in task.blocks if block.is_sense)
    assert senses
    assert own.observe == (*SENSING[word], *senses)
    assert dataclasses.replace(own, sensing="own").observe == (*SENSING["own"], *senses)


def test_a_sensor_may_name_a_block_that_the_task_brings():
    (gap,) = DoorwayTask().blocks
    entries: tuple[Any, ...] = (coopenv.Sensor("gap", noise=0.1), {"block": "gap", "noise": 0.1})
    for entry in entries:
        (seen,) = TransportConfig(task=DoorwayTask(), scene=HALL, observe=(entry,)).observe
        assert seen == coopenv.Sensor(gap, noise=0.1)


def test_senses_can_be_replaced():
    own = TransportConfig(sensing="own")
    assert dataclasses.replace(own) == own
    assert dataclasses.replace(own, sensing="shared").observe == SENSING["shared"]
    assert dataclasses.replace(own, observe=("goal",)).observe == ("goal",)
    with pytest.raises(InvalidInput, match="sensing must come without observe"):
        dataclasses.replace(TransportConfig(observe=("goal",)), sensing="own")


JSON = {
    **OPTIONS,
    "sum": {"reward": rewards.RewardSum({"time": rewards.TimeCost()})},
    "mapping": {"reward": {"progress": rewards.Progress(), "time": rewards.TimeCost(weight=1)}},
    "a block with a reading": {"observe": ("goal", BLOCKS["time"])},
    "a sensor on one": {"observe": ("goal", coopenv.Sensor(BLOCKS["time"], noise=0.1))},
    "a partner": {"partner": Noisy(partner=Follower(heaviness=0.3)), "partner_agents": (0,)},
    "task": {"task": TransportTask(clearance=0.2)},
    "room": {"scene": OPEN_ROOM},
    "many bodies": {"body": (Body(mass=2.0),), "scene": (CLUTTERED,)},
    "a box": {"scene": Scene(obstacles=(Box(center=(1, 2), size=(0.5, 0.5), angle=0.3),))},
    "a block as it is": {"observe": (BLOCKS["goal"], coopenv.Sensor(BLOCKS["twist"], 0.1))},
    "two ranges": {"observe": ("obstacles", ranges(num_rays=3, name="coarse"))},
    "settings": {"decomposition": Settings(method="parametrized", virtual_masses=(2.0, 2.0))},
}


JSON_CASES = {  # every id with what it has to bring back
    **{f"{IDS[0]}-{name}": (IDS[0], values) for name, values in JSON.items()},
    **{
        f"{view}-{name}": (view, values)
        for view in IDS[1:]
        for name, values in {
            **{name: JSON[name] for name in ("defaults", "cluttered")},
            "room": {"scene": room(view, OPEN_ROOM)},
            **OWN_OPTIONS.get(view, {}),
        }.items()
    },
}


@pytest.mark.parametrize(("name", "keywords"), JSON_CASES.values(), ids=JSON_CASES)
def test_an_environment_comes_back_from_json_as_it_was(name, keywords):
    made = gymnasium.make(name, **keywords)
    assert made.spec is not None
    again = gymnasium.make(EnvSpec.from_json(made.spec.to_json()))
    wanted = made.unwrapped.transport.config  # pyright: ignore[reportAttributeAccessIssue]
    assert again.unwrapped.transport.config == wanted  # pyright: ignore[reportAttributeAccessIssue]
    np.testing.assert_array_equal(again.reset(seed=3)[0], made.reset(seed=3)[0])


@pytest.mark.parametrize("name", IDS)
def test_a_vector_environment_comes_back_from_json_as_it_was(name):
    made = gymnasium.make_vec(name, num_envs=3, reward="harmony", autoreset_mode="SameStep")
    assert made.spec is not None
    again = gymnasium.make_vec(EnvSpec.from_json(made.spec.to_json()))
    assert (again.num_envs, again.metadata["autoreset_mode"].value) == (3, "SameStep")
    np.testing.assert_array_equal(again.reset(seed=3)[0], made.reset(seed=3)[0])


def by_the_wall(transition):
    """A block's numbers, all alike."""
    return np.zeros((*transition.applied.shape[:2], 1))


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize(
    "keywords",
    [
        {"reward": rewards.RewardSum({"time": lambda transition: by_the_wall(transition)[..., 0]})},
        {"reward": {"progress": rewards.Progress(potential=lambda state: -state.distance)}},
        {"observe": ("goal", Block(name="wall", size=1, describe="", read=by_the_wall))},
        {
            "observe": (
                "goal",
                coopenv.Sensor(dataclasses.replace(BLOCKS["time"], name="mine"), noise=0.1),
            )
        },
    ],
)
def test_what_json_cannot_hold_raises_rather_than_coming_back_different(name, keywords):
    made = gymnasium.make(name, **keywords)
    assert made.spec is not None
    with pytest.raises((TypeError, ValueError), match=r"JSON|reward must|observe must"):
        gymnasium.make(EnvSpec.from_json(made.spec.to_json()))


def test_the_specification_is_plain_json():
    made = gymnasium.make(IDS[0], body=Body.beam(length=1.0), scene=CLUTTERED)
    assert made.spec is not None
    assert json.loads(made.spec.to_json())["kwargs"]["body"]["mass"] == 7.7


def test_the_defaults_of_an_id_hold_for_its_own_kind_of_task():
    own = find_config("coopenv/BeamDoorway-v0", {"task": DoorwayTask(guide="one")})
    assert own.scene == HALL
    assert own.observe[-1].name == "gap"  # pyright: ignore[reportAttributeAccessIssue]
    other = find_config("coopenv/BeamDoorway-v0", {"task": TransportTask(), "horizon": 9})
    assert other == TransportConfig(horizon=9)
    assert find_config("coopenv/BeamDoorway-v0", {"task": {"guide": "none"}}).task == DoorwayTask(
        guide="none"
    )


@pytest.mark.parametrize("task", [TransportTask(), DoorwayTask(guide=(1,)), TrackingTask()])
def test_any_of_our_tasks_comes_back_from_its_fields(task):
    for name in IDS:
        assert find_config(name, {"task": dataclasses.asdict(task), "scene": HALL}).task == task
