"""What a run's folder and a policy's file say of where they come from."""

import json
import sys
import zipfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from stable_baselines3 import PPO

import coopenv
from coopenv import Body, Scene, TransportConfig, rewards
from coopenv.agents import provenance
from coopenv.agents.differences import described, differences
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.errors import InvalidInput
from tests.modules import OWN_REWARD

SHORT = TransportConfig(horizon=8, body=Body(mass=5.0), reward="harmony")


def tiny(out: Path, **changes) -> TrainConfig:
    """Two rollouts of 32 steps."""
    given = {"steps": 64, "num_worlds": 4, "rollout": 8, "batch_size": 16, "epochs": 1}
    return TrainConfig(**{**given, "hidden": (8,), "out": out, **changes})


def with_weight(name: str, weight: float) -> TransportConfig:
    term = replace(cast(Any, SHORT.terms[name]), weight=weight)
    terms = {**SHORT.terms, name: term}
    return replace(SHORT, reward=rewards.RewardSum(terms))


def stopped(row) -> None:
    if row["steps"] == 64:
        raise KeyboardInterrupt


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    return out, train(tiny(out), environment=SHORT)


def test_the_folder_and_the_policy_hold_all_of_the_environment(run):
    out, policy = run
    config = json.loads((out / "config.json").read_text())["provenance"]
    with zipfile.ZipFile(out / "policy.zip") as archive:
        notes = json.loads(archive.read("coopenv.json"))
    assert notes["provenance"] == config == policy.notes["provenance"]
    assert config["environment"] == json.loads(SHORT.to_json())
    found = Provenance.read(out / "policy.zip")
    assert found is not None
    assert found.config() == SHORT
    assert TrainConfig.from_dict(found.training) == tiny(out)
    assert TrainConfig.load(out / "config.json") == tiny(out)


def test_versions_and_the_command_are_written(run, monkeypatch):
    out, _ = run
    found = Provenance.read(out / "policy.zip")
    assert found is not None
    assert set(found.versions) == {
        "python",
        "coopenv",
        "numpy",
        "torch",
        "stable-baselines3",
        "pymunk",
    }
    assert found.versions["numpy"] == np.__version__
    assert found.versions["coopenv"] == coopenv.__version__
    assert found.command[1:] == sys.argv[1:]
    monkeypatch.setattr(sys, "argv", ["/somewhere/coopenv/__main__.py", "train"])
    assert Provenance.of(tiny(out), SHORT).command == ["coopenv", "train"]


def test_a_partner_that_training_adds_is_written(tmp_path):
    train(tiny(tmp_path, control="partner"), environment=replace(SHORT, partner=None))
    found = Provenance.read(tmp_path / "policy.zip")
    assert found is not None
    assert found.config().partner is not None


def test_a_policy_that_is_saved_again_keeps_it_and_sb3_reads_it(run, tmp_path):
    out, policy = run
    SB3Policy.load(out / "policy.zip").save(tmp_path / "copy.zip")
    policy.save(tmp_path / "other.zip")
    for name in ("copy.zip", "other.zip"):
        assert Provenance.read(tmp_path / name) == Provenance.read(out / "policy.zip")
        assert PPO.load(tmp_path / name).num_timesteps == 64


@pytest.mark.parametrize(
    ("other", "part"),
    [
        (with_weight("progress", 4.0), "environment.reward.progress.weight"),
        (replace(SHORT, reward="task"), "environment.reward.relative_cost"),
        (replace(SHORT, body=Body(mass=6.0)), "environment.body.mass"),
        (replace(SHORT, scene=Scene(size=(5.0, 6.0))), r"environment.scene.size\[0\]"),
        (replace(SHORT, horizon=9), "environment.horizon"),
        (replace(SHORT, substeps=3), "environment.substeps"),
        (replace(SHORT, randomise=coopenv.Ranges(mass=(4.0, 6.0))), "environment.randomise"),
    ],
)
def test_another_environment_goes_on_with_no_checkpoint_and_no_finished_run(run, other, part):
    out, _ = run
    with pytest.raises(InvalidInput, match=rf"policy\.zip, which differs in .*{part}"):
        train(tiny(out, steps=128), environment=other)
    assert Provenance.read(out / "policy.zip").config() == SHORT  # type: ignore[union-attr]


def test_a_checkpoint_of_another_reward_is_refused_by_the_weight_that_differs(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path), environment=SHORT, report=stopped)
    with pytest.raises(
        InvalidInput,
        match=r"checkpoint\.zip, which differs in environment\.reward\.progress\.weight; choose"
        r".* --config .*config\.json",
    ):
        train(tiny(tmp_path), environment=with_weight("progress", 4.0))
    train(tiny(tmp_path), environment=SHORT)


def test_the_same_environment_by_another_name_is_the_same_run(run):
    out, _ = run
    said = []
    config = tiny(out, environment=EnvironmentChoice(reward="task", horizon=3))
    train(config, environment=SHORT, tell=said.append)
    assert "has done its 64 steps" in said[0]


def test_a_record_from_before_a_field_was_added_is_of_the_same_run():
    now = Provenance.of(TrainConfig(), TransportConfig())
    older = {name: value for name, value in now.environment.items() if name != "pushes"}
    assert replace(now, environment=older).differences(now) == []
    other = Provenance.of(TrainConfig(), TransportConfig(pushes="grid"))
    assert replace(now, environment=older).differences(other) == ["environment.pushes"]


def test_what_cannot_be_written_is_refused_before_any_training(tmp_path):
    @dataclass(frozen=True)
    class Local:
        weight: float = 1.0

        def __call__(self, transition):
            return self.weight * np.zeros(transition.action.shape[:2])

    environment = replace(SHORT, reward=rewards.RewardSum({"mine": Local()}))
    rows = []
    with pytest.raises(InvalidInput, match=r"reward\.mine.*module of your own"):
        train(tiny(tmp_path / "new"), environment=environment, report=rows.append)
    assert not rows
    assert not (tmp_path / "new").exists()
    train(tiny(tmp_path), environment=SHORT)
    with pytest.raises(InvalidInput, match=r"reward\.mine"):
        train(tiny(tmp_path, fresh=True), environment=environment)
    assert (tmp_path / "policy.zip").exists()


def test_another_version_is_a_warning_and_no_refusal(run, monkeypatch):
    out, _ = run
    monkeypatch.setattr(provenance, "version", lambda name: "999.0" if name == "torch" else "1")
    with pytest.warns(UserWarning, match=r"policy\.zip was written with .*torch .* \(now 999\.0\)"):
        policy = train(tiny(out), environment=SHORT)
    assert policy.model.num_timesteps >= tiny(out).steps  # it is the run that was there


def test_a_file_without_it_says_so_and_one_of_another_format_is_refused(tmp_path):
    policy = SB3Policy(PPO("MlpPolicy", "Pendulum-v1", device="cpu"))
    policy.save(tmp_path / "plain.zip")
    assert Provenance.read(tmp_path / "plain.zip") is None
    assert SB3Policy.load(tmp_path / "plain.zip").notes == {}
    with zipfile.ZipFile(tmp_path / "later.zip", "w") as archive:
        archive.writestr("coopenv.json", json.dumps({"provenance": {"format": 99}}))
        for member in ("data", "policy.pth"):
            archive.writestr(member, "")
    with pytest.raises(InvalidInput, match="format 1"):
        Provenance.read(tmp_path / "later.zip")
    (tmp_path / "torn.zip").write_bytes(b"PK")
    with pytest.raises(InvalidInput, match=r"torn\.zip"):
        Provenance.read(tmp_path / "torn.zip")


def test_a_damaged_record_is_named_with_its_file(run, tmp_path):
    out, _ = run
    content = json.loads((out / "config.json").read_text())
    path = tmp_path / "config.json"
    path.write_text(json.dumps(content))
    found = Provenance.read_beside(path)
    assert found == Provenance.read(out / "policy.zip")
    path.write_text(json.dumps({**content, "provenance": [3]}))
    with pytest.raises(InvalidInput, match=rf"format 1, got \[3\].*{path}"):
        Provenance.read_beside(path)
    path.write_text("[]")
    assert Provenance.read_beside(path) is None


def test_differences_are_named_down_to_the_number():
    one = {"a": {"kind": "x", "b": [1, {"c": 2}]}, "d": [1], "e": {"kind": "x", "f": 1}}
    other = {"a": {"kind": "x", "b": [1, {"c": 3}]}, "d": [1, 2], "e": {"kind": "y", "f": 1}}
    assert differences(one, other) == ["a.b[1].c", "d", "e"]
    assert differences(one, one) == []


def test_an_environment_is_described_by_what_is_not_its_ids_default():
    default = TransportConfig()
    assert described(default, default) == []
    assert described(replace(default, horizon=80, reward="harmony"), default) == [
        "reward harmony",
        "horizon 80",
    ]
    assert described(replace(default, partner="stubborn"), default) == ["partner stubborn"]
    assert described(replace(default, body=Body(mass=5.0)), default)[0] == "body.mass 5.0"
    seen = described(replace(default, observe=("goal", "twist")), default)
    assert seen == ["observe goal twist"]
    terms = {**default.terms, "time": rewards.TimeCost(weight=1.0)}
    weighted = replace(default, reward=rewards.RewardSum(terms))
    assert described(weighted, default) == ["reward.time.weight 1.0"]


def test_a_description_holds_the_numbers_of_what_is_added():
    default = TransportConfig()
    for weight in (0.2, 0.7):
        terms = {**default.terms, "relative_cost": rewards.RelativeCost(weight=weight)}
        weighted = replace(default, reward=rewards.RewardSum(terms))
        assert described(weighted, default) == [
            f"reward.relative_cost RelativeCost(weight={weight})"
        ]
    drawn = replace(default, randomise=coopenv.Ranges(mass=(4.0, 9.0)))
    assert described(drawn, default) == ["randomise Ranges(mass=[4.0, 9.0])"]
    walled = replace(
        default, scene=Scene(obstacles=(coopenv.Box(center=(0.0, 1.0), size=(0.1, 0.2)),))
    )
    (said,) = described(walled, default)
    assert said == "scene.obstacles [Box(center=[0.0, 1.0], size=[0.1, 0.2], angle=0.0)]"
    grips = ((-0.8, 0.0), (0.9, 0.0), (0.0, 0.0))
    gripped = described(replace(default, body=Body(grips=grips)), default)
    assert "body.grips [[-0.8, 0.0], [0.9, 0.0], [0.0, 0.0]]" in gripped


def test_a_description_names_code_of_ones_own_without_its_hash(tmp_path, monkeypatch):
    (tmp_path / "described_rewards.py").write_text(OWN_REWARD)
    monkeypatch.syspath_prepend(str(tmp_path))
    import described_rewards  # type: ignore[import-not-found]

    default = TransportConfig()
    terms = {**default.terms, "mine": described_rewards.Mine(weight=3.0)}
    (said,) = described(replace(default, reward=rewards.RewardSum(terms)), default)
    assert said == "reward.mine described_rewards:Mine(weight=3.0)"


def test_only_an_environment_with_code_of_ones_own_is_said_to_have_some(tmp_path, monkeypatch):
    (tmp_path / "own_rewards.py").write_text(OWN_REWARD)
    monkeypatch.syspath_prepend(str(tmp_path))
    import own_rewards  # type: ignore[import-not-found]

    terms = {**SHORT.terms, "mine": own_rewards.Mine(weight=3.0)}
    own = replace(SHORT, reward=rewards.RewardSum(terms))
    assert Provenance.of_environment(own, "each").has_own_code
    assert not Provenance.of_environment(SHORT, "each").has_own_code


def test_a_choice_over_a_configuration_changes_only_what_it_names():
    changed = EnvironmentChoice(env="coopenv/BeamDoorway-v0", horizon=9).over(SHORT)
    assert changed == replace(SHORT, horizon=9)
    assert EnvironmentChoice().over(SHORT) == SHORT
    own = EnvironmentChoice(sensing="own").over(SHORT)
    assert replace(own, observe=SHORT.observe) == SHORT
    assert own.observe != SHORT.observe
