"""Learned entries of the benchmark: what each learns in, and that it is trained and entered."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.board import hands, learners, tables
from benchmarks.board.learners import LEARNERS, Learners
from coopenv import Transport
from coopenv.agents.benchmark import SUITES, plan, read_entry, read_summary
from coopenv.agents.controllers import Follower
from coopenv.agents.pretrained import load
from coopenv.agents.settings import TrainConfig
from coopenv.errors import InvalidInput, UnknownName

HAPTICS = SUITES["haptics"]
BOTH = hands.LEADER, hands.FOLLOWER
TINY = {"num_worlds": 4, "rollout": 8, "epochs": 1, "batch_size": 16, "hidden": (8,)}


@pytest.fixture(scope="module")
def hands_trained(tmp_path_factory):
    """A folder in which leader and follower were trained for some steps."""
    out = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(learners, "TrainConfig", lambda **given: short(TrainConfig(**given)))
        for name in BOTH:
            learners.run(Learners(only=(name,), out=out), tell=lambda line: None)
    return out


def short(config):
    return replace(config, steps=64, **TINY)


def test_learners_of_bodies_train_within_what_the_suite_allows():
    for name in ("bodies-joint-0", "bodies-shared-0"):
        config, environment = LEARNERS[name](Path("runs"))
        assert environment == SUITES["bodies"].scenarios[0].config
        assert name == f"bodies-{config.control}-{config.seed}"


def test_every_learner_is_within_the_budget_of_its_suite():
    suites = {"bodies": "bodies", "population": "partners"}
    for name, made in LEARNERS.items():
        if name not in BOTH:
            config, _ = made(Path("runs"))
            assert config.steps <= SUITES[suites[name.partition("-")[0]]].budget
    assert HAPTICS.budget >= 2 * learners.HANDS_STEPS


def test_learners_by_hands_learn_in_what_the_suite_shows(hands_trained):
    scenario = HAPTICS.scenarios[0].config
    for name in BOTH:
        _, environment = LEARNERS[name](hands_trained)
        assert environment is not None
        kept = ("action", "observe", "informed", "task", "reward", "dt")
        for field in kept:
            assert getattr(environment, field) == getattr(scenario, field), field


def test_the_pair_acts_each_by_its_own_policy(hands_trained, monkeypatch):
    monkeypatch.setattr(hands, "OUT", hands_trained)
    config = HAPTICS.scenarios[1].config
    core = Transport(num_worlds=3, config=config)
    obs, _ = core.reset(seed=1)
    transition = core.transition
    assert transition is not None
    given, other = hands.pair(config)(obs, transition), hands.led(config)(obs, transition)
    for agent, name in enumerate(BOTH):
        mine = load(hands.policy_of(name, hands_trained))(obs, transition)
        np.testing.assert_array_equal(given[:, agent], mine[:, agent])
    np.testing.assert_array_equal(other[:, 0], given[:, 0])
    np.testing.assert_array_equal(other[:, 1], Follower(config)(obs, transition)[:, 1])


def test_the_pair_is_entered_by_hands_alone(hands_trained, monkeypatch):
    monkeypatch.setattr(hands, "OUT", hands_trained)
    for name in ("pair", "led"):
        planned = plan([read_entry(f"benchmarks.board.hands:{name}", trained=128)], [HAPTICS])
        entered = [cell.scenario.name for cell in planned.cells]
        assert entered == ["motion, 7.7 kg", "motion, 20 kg"]


def test_a_pair_that_was_not_trained_says_how_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr(hands, "OUT", tmp_path)
    with pytest.raises(InvalidInput, match=r"run python -m benchmarks\.board\.learners"):
        hands.pair(HAPTICS.scenarios[0].config)


def test_a_learner_that_is_not_known_is_refused():
    with pytest.raises(UnknownName, match="did you mean 'bodies-joint-0'"):
        Learners(only=("bodies-joint",))


def test_summaries_of_learners_say_the_steps_of_their_runs():
    for suite in SUITES.values():
        for file in (tables.FOLDER / suite.label).glob("*.json"):
            one = read_summary(file)
            if one.entry in LEARNERS:
                config, _ = LEARNERS[one.entry](Path("runs"))
                for told in one.trained:
                    assert told is not None
                    assert 0 <= told.steps - config.steps < config.num_worlds * config.rollout
