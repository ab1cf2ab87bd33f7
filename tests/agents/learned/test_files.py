"""Files of learned policies: of every algorithm, and files that are none."""

import json
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

import gymnasium
from sb3_contrib import QRDQN, MaskablePPO
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.policies import ActorCriticPolicy

from coopenv import Body, Transport, TransportConfig
from coopenv.agents.evaluate import evaluate
from coopenv.agents.learned import read_notes
from coopenv.agents.sb3 import SB3Policy, make_vec_env
from coopenv.errors import InvalidInput, MissingExtra
from tests.agents.learned.cases import (
    ALGORITHMS,
    CONFIG,
    small,
    start,
    trained,
    untrained,
    write_member,
)


@pytest.fixture
def file(tmp_path):
    """A policy that `SB3Policy.save` wrote."""
    path = tmp_path / "policy.zip"
    SB3Policy(trained("PPO", small())).save(path)
    return path


@pytest.mark.parametrize("name", ALGORITHMS)
def test_every_algorithm_loads_without_being_named(name, tmp_path):
    model = trained(name, small())
    policy = SB3Policy(model)
    obs, transition = start()
    expected = policy(obs, transition)
    assert expected.shape == (5, 2, 3)
    policy.save(tmp_path / "ours.zip")
    model.save(tmp_path / "theirs.zip")
    for written, trust in (("ours", False), ("ours", True), ("theirs", True)):
        loaded = SB3Policy.load(tmp_path / f"{written}.zip", normalize=False, trust=trust)
        np.testing.assert_array_equal(loaded(obs, transition), expected)
        assert type(loaded.model).__name__ == (
            "TD3" if (written, name) == ("theirs", "DDPG") else name
        )
    assert type(model).load(tmp_path / "ours.zip").num_timesteps == model.num_timesteps


class Own(PPO):
    pass


class OwnPolicy(ActorCriticPolicy):
    pass


def test_an_algorithm_of_ones_own_is_asked_for_and_not_imported_from_a_file(tmp_path):
    path = tmp_path / "own.zip"
    model = untrained(Own, small())
    SB3Policy(model).save(path)
    with pytest.raises(InvalidInput, match=r"algorithm must be given.*:Own trained"):
        SB3Policy.load(path)
    assert isinstance(SB3Policy.load(path, Own).model, Own)


def test_a_policy_class_of_ones_own_shows_whose_it_is(tmp_path):
    untrained(PPO, small(), OwnPolicy).save(tmp_path / "model.zip")
    assert isinstance(SB3Policy.load(tmp_path / "model.zip", trust=True).model, PPO)


def test_what_others_note_in_the_file_stays_there(file, tmp_path):
    policy = SB3Policy(trained("PPO", small()), notes={"environment": {"horizon": 6}})
    policy.save(file)
    notes = read_notes(file)
    assert notes.pop("provenance")["environment"]["horizon"] == 6
    assert notes == {
        "environment": {"horizon": 6},
        "algorithm": "stable_baselines3.ppo.ppo:PPO",
        "normalized": False,
    }
    loaded = SB3Policy.load(file).notes
    assert {**policy.notes, "provenance": loaded["provenance"]} == loaded
    SB3Policy.load(file).save(tmp_path / "again.zip")
    assert read_notes(tmp_path / "again.zip") == read_notes(file)


def test_notes_of_others_alone_do_not_matter(tmp_path):
    trained("SAC", small()).save(tmp_path / "model.zip")
    assert read_notes(tmp_path / "model.zip") == {}
    write_member(tmp_path / "model.zip", "coopenv.json", json.dumps({"rows": []}))
    loaded = SB3Policy.load(tmp_path / "model.zip", normalize=False, trust=True)
    assert type(loaded.model) is SAC


def test_the_suffix_may_be_left_out_as_in_sb3(file):
    assert SB3Policy.load(file.with_suffix("")).model.num_timesteps == 16


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "which is empty"),
        (b"some text", "which is no archive"),
        (b"PK\x03\x04 and then nothing", "cut short"),
    ],
)
def test_a_file_that_is_no_archive_is_refused(data, message, tmp_path):
    path = tmp_path / "policy.zip"
    path.write_bytes(data)
    for read in (SB3Policy.load, read_notes):
        with pytest.raises(InvalidInput, match=f"policy must be a file .*{message}"):
            read(path)


def test_another_archive_a_folder_and_nothing_are_refused(file, tmp_path):
    other = tmp_path / "other.zip"
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("readme", "hello")
    with pytest.raises(InvalidInput, match=r"without data and policy\.pth"):
        SB3Policy.load(other)
    with pytest.raises(InvalidInput, match=r"a folder; give .*policy\.zip"):
        SB3Policy.load(file.parent)
    with pytest.raises(InvalidInput, match="which is not there; coopenv train"):
        SB3Policy.load(tmp_path / "nothing.zip")
    with pytest.raises(InvalidInput, match="policy must be the file"):
        SB3Policy.load("")


def test_a_file_cut_short_anywhere_is_refused(file):
    whole = file.read_bytes()
    for length in range(1, len(whole), len(whole) // 7):
        file.write_bytes(whole[:length])
        with pytest.raises(InvalidInput, match="policy must be a file"):
            SB3Policy.load(file)


def test_a_damaged_file_is_refused(file):
    whole = bytearray(file.read_bytes())
    middle = whole.index(b"policy.pth") + 400
    whole[middle : middle + 50] = bytes(50)
    file.write_bytes(whole)
    with pytest.raises(InvalidInput, match="is damaged"):
        SB3Policy.load(file)


@pytest.mark.parametrize("missing", ["policy.optimizer.pth", "policy.pth", "data"])
def test_a_file_without_one_of_its_members_is_refused(missing, file, tmp_path):
    path = tmp_path / "part.zip"
    with zipfile.ZipFile(file) as whole, zipfile.ZipFile(path, "w") as part:
        for name in whole.namelist():
            if name != missing:
                part.writestr(name, whole.read(name))
    with pytest.raises(InvalidInput, match="policy must be a"):
        SB3Policy.load(path)


@pytest.mark.parametrize("notes", ["no json", "[1]"])
def test_broken_notes_are_refused(notes, tmp_path):
    trained("PPO", small()).save(tmp_path / "model.zip")
    write_member(tmp_path / "model.zip", "coopenv.json", notes)
    with pytest.raises(InvalidInput, match=r"in which coopenv\.json"):
        SB3Policy.load(tmp_path / "model.zip")


def test_another_algorithm_than_the_files_is_refused(file):
    with pytest.raises(InvalidInput, match="whole file of the algorithm"):
        SB3Policy.load(file, SAC)


@pytest.mark.parametrize("name", ["TQC", "TRPO", "RecurrentPPO"])
@pytest.mark.parametrize("by", ["us", "SB3"])
def test_without_sb3_contrib_the_file_says_what_to_install(name, by, tmp_path, monkeypatch):
    model = trained(name, small())
    path = tmp_path / "policy.zip"
    SB3Policy(model).save(path) if by == "us" else model.save(path)
    for module in [name for name in sys.modules if name.split(".")[0] == "sb3_contrib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[contrib\]"):
        SB3Policy.load(path, trust=by == "SB3")


class Buttons(gymnasium.Env):
    """An environment with three actions instead of wrenches."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (44,))
    action_space = gymnasium.spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        return np.zeros(44, dtype=np.float32), {}

    def step(self, action):
        return np.zeros(44, dtype=np.float32), 0.0, False, False, {}

    def action_masks(self):
        return np.ones(3, dtype=bool)


@pytest.mark.parametrize("algorithm", [DQN, QRDQN, MaskablePPO])
def test_policies_that_choose_among_other_actions_are_refused(algorithm, tmp_path):
    model = algorithm("MlpPolicy", Buttons(), device="cpu", policy_kwargs={"net_arch": [8]})
    model.save(tmp_path / "model.zip")
    policy = SB3Policy.load(tmp_path / "model.zip", trust=True)
    for config, there in ((CONFIG, "numbers in"), (replace(CONFIG, action="discrete"), "of 7")):
        with pytest.raises(InvalidInput, match=rf"trained with, numbers of 3 pushes, got.*{there}"):
            policy.check_environment(Transport(config=config))


@pytest.mark.parametrize(
    ("space", "match"),
    [
        ({"observation_space": gymnasium.spaces.Box(0, 1, (4, 4))}, "observation space"),
        ({"observation_space": gymnasium.spaces.Discrete(4)}, "observation space"),
    ],
)
def test_policies_of_other_kinds_of_environments_are_refused(space, match):
    class Other(Buttons):
        action_space = gymnasium.spaces.Box(-1, 1, (6,))

    for name, value in space.items():
        setattr(Other, name, value)
    model = untrained(PPO, Other())
    with pytest.raises(InvalidInput, match=match):
        SB3Policy(model)


def test_actions_of_another_range_are_refused_before_the_first_step():
    class Strong(Buttons):
        action_space = gymnasium.spaces.Box(-2, 2, (6,))

    policy = SB3Policy(untrained(PPO, Strong()))
    with pytest.raises(InvalidInput, match=r"actions of a policy must be in \[-1, 1\]"):
        policy(*start())


@pytest.mark.parametrize(
    "config",
    [
        TransportConfig(observe=("goal", "twist")),
        TransportConfig(action="force"),
        TransportConfig(body=Body.plate(4)),
    ],
)
@pytest.mark.parametrize("control", ["joint", "shared"])
def test_another_observation_action_or_team_is_refused_with_both_sizes(config, control):
    policy = SB3Policy(trained("PPO", small(control)))
    obs, transition = start(2, config)
    took = {"joint": "44 features in and 6 numbers", "shared": "22 features in and 3 numbers"}
    with pytest.raises(InvalidInput, match=rf"{took[control]}.*got {obs.shape[1]} agents with"):
        policy(obs, transition)


def test_a_team_whose_observations_happen_to_be_as_many_is_refused():
    half = TransportConfig(
        body=Body.plate(4), observe=("known", "twist", "own_wrench", "load_share")
    )
    obs, transition = start(2, half)
    assert obs.shape[1:] == (4, 10)
    venv = small()
    venv.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (40,))
    policy = SB3Policy(untrained(PPO, venv))
    with pytest.raises(
        InvalidInput, match=r"40 features in and 6 numbers out.*got 4 agents with 10"
    ):
        policy(obs, transition)


def test_other_blocks_of_the_same_size_are_refused_before_the_first_step():
    ranged = replace(CONFIG, observe=("goal", "twist", "load_share"))
    turned = replace(CONFIG, observe=("load_share", "goal", "twist"))
    for control in ("joint", "shared"):
        venv = make_vec_env(ranged, 2, control=control)
        policy = SB3Policy(untrained(PPO, venv))
        evaluate(policy, ranged, episodes=2)
        with pytest.raises(InvalidInput, match=r"blocks that the policy.*got 'load_share' where"):
            evaluate(policy, turned, episodes=2)
        venv.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, venv.observation_space.shape)
        evaluate(SB3Policy(untrained(PPO, venv)), turned, episodes=2)  # it cannot be told
