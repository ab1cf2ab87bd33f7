"""What a policy's file records of its training is checked where sizes say nothing."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import Sensor, Transport, TransportConfig, cli
from coopenv.agents.evaluate import evaluate
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.errors import InvalidInput

SEEN = TransportConfig(horizon=3, observe=("goal", "twist", "own_wrench"))


def trained(out: Path, environment: TransportConfig = SEEN, **settings) -> Path:
    given = {"steps": 16, "num_worlds": 2, "rollout": 4, "batch_size": 8, "epochs": 1}
    train(TrainConfig(**{**given, "hidden": (4,), "out": out, **settings}), environment=environment)
    return out / "policy.zip"


@pytest.fixture(scope="module")
def team(tmp_path_factory) -> Path:
    return trained(tmp_path_factory.mktemp("team"))


@pytest.fixture(scope="module")
def one(tmp_path_factory) -> Path:
    """A policy of one agent beside a partner."""
    return trained(tmp_path_factory.mktemp("one"), control="partner")


@pytest.mark.parametrize(
    "observe", [("goal", "twist", "partner_wrench"), ("twist", "goal", "own_wrench")]
)
def test_other_blocks_of_the_same_size_are_refused(team, observe, capsys):
    policy = SB3Policy.load(team)
    with pytest.raises(InvalidInput, match=f"trained on, goal twist own_wrench, got {observe[0]}"):
        evaluate(policy, replace(SEEN, observe=observe), episodes=2)
    for env in ([], ["--env=coopenv/BeamTransport-v0", "--horizon=3"]):
        arguments = ["evaluate", str(team), "--episodes=2", *env, "--observe", *observe]
        assert cli.main(arguments) == 1
        assert "--observe goal twist own_wrench" in capsys.readouterr().err


def test_the_same_blocks_through_worse_sensors_are_taken(team):
    noisy = replace(SEEN, observe=("goal", Sensor("twist", noise=0.1), "own_wrench"))
    assert evaluate(SB3Policy.load(team), noisy, episodes=2).episodes == 2


@pytest.fixture(scope="module")
def by_hand(tmp_path_factory) -> Path:
    """A policy whose actions are velocities of hands."""
    moved = replace(SEEN, action="motion")
    return trained(tmp_path_factory.mktemp("hands"), moved, control="shared")


def test_velocities_are_not_taken_for_wrenches_nor_wrenches_for_velocities(team, by_hand, capsys):
    said = "action must be 'motion' for a policy that was trained with it, got 'wrench'"
    with pytest.raises(InvalidInput, match=said):
        evaluate(SB3Policy.load(by_hand), SEEN, episodes=2)
    with pytest.raises(InvalidInput, match=r"action must be 'wrench' for .* got 'motion'"):
        evaluate(SB3Policy.load(team), replace(SEEN, action="motion"), episodes=2)
    assert cli.main(["evaluate", str(by_hand), "--episodes=2", "--action", "wrench"]) == 1
    assert said in " ".join(capsys.readouterr().err.split())
    assert cli.main(["evaluate", str(by_hand), "--episodes=2"]) == 0
    assert cli.main(["evaluate", "random", "--episodes=2", "--action", "motion"]) == 0


def test_a_partner_whose_actions_are_velocities_gives_no_wrenches(by_hand):
    with pytest.raises(InvalidInput, match="action must be 'motion' for a policy"):
        Transport(config=replace(SEEN, partner=str(by_hand)))


def test_a_scripted_one_beside_a_policy_that_moves_hands_moves_hands_too(by_hand, capsys):
    assert cli.main(["evaluate", str(by_hand), "scripted", "--episodes=2"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "action motion" in told
    assert "scripted" in told


def test_an_allocation_that_hands_do_not_take_is_told_how_to_be_evaluated(by_hand, capsys):
    assert cli.main(["evaluate", str(by_hand), "scripted:nonsqueezing", "--episodes=2"]) == 1
    said = " ".join(capsys.readouterr().err.split())
    assert "options must be gains alone for action='motion'" in said
    assert "evaluate scripted:nonsqueezing --env coopenv/BeamTransport-v0 --action wrench" in said


def test_a_policy_of_one_agent_does_not_drive_several(one, capsys):
    with pytest.raises(InvalidInput, match=r"one agent.* beside a partner .* 2 learners"):
        evaluate(SB3Policy.load(one), SEEN, episodes=2)
    env = ["--env=coopenv/BeamTransport-v0", "--observe", "goal", "twist", "own_wrench"]
    assert cli.main(["evaluate", str(one), "--episodes=2", *env]) == 1
    assert "--partner" in capsys.readouterr().err
    assert cli.main(["evaluate", str(one), "--episodes=2"]) == 0
    assert cli.main(["evaluate", str(one), "--episodes=2", *env, "--partner=walking"]) == 0


def test_a_policy_of_a_whole_team_is_not_called_one_of_one_agent(tmp_path):
    alone = SB3Policy.load(trained(tmp_path, replace(SEEN, partner="walking")))
    said = r"the whole team that it was trained for beside a partner \(control='joint'\)"
    with pytest.raises(InvalidInput, match=said):
        evaluate(alone, SEEN, episodes=2)


def test_a_policy_that_every_agent_runs_may_drive_another_team(tmp_path):
    shared = SB3Policy.load(trained(tmp_path, control="shared"))
    assert evaluate(shared, SEEN, episodes=2).episodes == 2
    assert evaluate(shared, replace(SEEN, partner="walking"), episodes=2).episodes == 2
