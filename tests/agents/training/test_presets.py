"""Settings that each environment's id has, and who wins over them."""

from dataclasses import fields

import gymnasium
import pytest

pytest.importorskip("tyro")

from coopenv import cli
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.training.presets import PRESETS, observing, preset, train_config
from coopenv.cli.options.reading import read
from coopenv.envs.registry import PREFIX
from coopenv.errors import InvalidInput
from coopenv.observation.observation import find_block

DOORWAY = "coopenv/BeamDoorway-v0"
AVOID = "coopenv/WalkerAvoid-v0"
DEFAULT = "coopenv/BeamTransport-v0"
MINE = preset(DOORWAY)


def trained(*arguments: object) -> TrainConfig:
    command = read(["train", *map(str, arguments)], cli.COMMANDS)
    return observing(command.training)  # as it is run


def test_presets_are_of_our_ids_and_change_settings_of_a_training():
    ids = {name for name in gymnasium.registry if name.startswith(PREFIX)}
    known = {entry.name for entry in fields(TrainConfig)}
    known -= {"environment", "control", "seed", "out"}
    assert set(PRESETS) <= ids
    for env, given in PRESETS.items():
        assert given, env
        assert set(given) <= known
        default = TrainConfig()
        assert all(getattr(default, name) != value for name, value in given.items()), env


def test_a_run_has_what_is_given_and_the_rest_of_its_id():
    config = train_config(EnvironmentChoice(env=DOORWAY, horizon=70), seed=3, epochs=2)
    assert config.environment.config().horizon == 70
    assert "epochs" in MINE
    for name, value in {**MINE, "epochs": 2, "seed": 3}.items():
        assert getattr(config, name) == value


def test_walkers_led_by_hands_have_settings_of_their_own(tmp_path):
    by_hands = EnvironmentChoice(env=AVOID, action="motion")
    assert train_config(by_hands).steps > train_config(AVOID).steps
    assert seen(train_config(by_hands)) == [*seen(train_config(AVOID)), "stretch"]
    assert trained("--env", AVOID, "--action", "motion") == train_config(by_hands)
    assert trained("--action=impedance", "--env", AVOID).steps == train_config(by_hands).steps
    assert trained("--action", "motion") == train_config(EnvironmentChoice(action="motion"))
    file = tmp_path / "run.toml"
    file.write_text(f'[environment]\nenv = "{AVOID}"\n')
    assert trained("--config", file, "--action", "motion") == train_config(by_hands)
    file.write_text(f'[environment]\nenv = "{AVOID}"\naction = "motion"\n')
    assert trained("--config", file) == train_config(by_hands)


def test_walkers_whose_agents_share_a_policy_learn_for_longer(tmp_path):
    shared = train_config(AVOID, control="shared")
    assert shared.steps > train_config(AVOID).steps
    assert seen(shared) == seen(train_config(AVOID))
    assert trained("--env", AVOID, "--control", "shared") == shared
    assert trained("--control=shared") == train_config(DEFAULT, control="shared")
    file = tmp_path / "run.toml"
    file.write_text(f'control = "shared"\n[environment]\nenv = "{AVOID}"\n')
    assert trained("--config", file) == shared
    assert trained("--config", file, "--control", "joint") == train_config(AVOID)


def test_an_id_of_ones_own_has_the_defaults():
    assert preset("mine/Beam-v0") == {}
    assert preset(f"package.module:{DOORWAY}") == MINE


@pytest.mark.parametrize("arguments", [("--env", DOORWAY), (f"--env={DOORWAY}",)])
def test_the_command_takes_the_settings_of_its_id(arguments):
    config = trained(*arguments)
    assert config.environment.env == DOORWAY
    assert config == train_config(DOORWAY)
    assert config != TrainConfig(environment=config.environment)


def test_options_win_over_the_settings_of_the_id():
    config = trained("--env", DOORWAY, "--steps", 12_345, "--body", "mass=5")
    assert config.steps == 12_345
    assert config.environment.body == ("mass=5",)


def test_a_file_wins_over_the_settings_of_its_id(tmp_path):
    file = tmp_path / "run.toml"
    file.write_text(f'steps = 12345\n[environment]\nenv = "{DOORWAY}"\n')
    assert trained("--config", file) == train_config(DOORWAY, steps=12_345)


def test_the_id_of_the_command_line_counts_where_the_file_has_another(tmp_path):
    file = tmp_path / "run.toml"
    file.write_text("seed = 7\n")
    assert trained("--config", file, "--env", DOORWAY) == train_config(DOORWAY, seed=7)
    assert trained("--config", file) == train_config("coopenv/BeamTransport-v0", seed=7)


def seen(config: TrainConfig) -> list[str]:
    return [find_block(entry).name for entry in config.environment.config().observe]


def test_a_training_also_observes_what_its_id_needs_beside_what_the_environment_shows():
    own = [find_block(entry).name for entry in EnvironmentChoice(env=DOORWAY).config().observe]
    assert seen(trained("--env", DOORWAY)) == [*own, "near_goal"]
    assert seen(trained("--env", DOORWAY, "--also-observe", "time", "goal")) == [*own, "time"]
    assert seen(trained("--env", "coopenv/WalkerAvoid-v0"))[-2:] == ["near_goal", "course"]
    assert "near_goal" not in seen(trained("--env", "coopenv/BeamTransport-v0"))


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (("--observe", "goal", "twist"), ["goal", "twist"]),
        (("--observe", "goal", "--also-observe", "time"), ["goal", "time"]),
        (("--observe", "goal", "--also-observe", "near_goal"), ["goal", "near_goal"]),
    ],
)
def test_who_says_what_is_observed_sees_that_and_no_more(given, wanted):
    assert seen(trained("--env", DOORWAY, *given)) == wanted
    own = ("--env", DOORWAY, "--sensing", "own")
    assert "near_goal" not in seen(trained(*own))
    assert "near_goal" in seen(trained(*own, "--also-observe", "near_goal"))
    assert "near_goal" not in seen(trained("--env", DOORWAY, "--also-observe"))


def test_a_block_in_the_place_of_a_list_is_refused():
    with pytest.raises(InvalidInput, match=r"also_observe must be a list .*'near_goal'; write"):
        EnvironmentChoice(also_observe="near_goal")  # pyright: ignore[reportArgumentType]


def test_a_file_that_says_what_is_observed_says_all_of_it(tmp_path):
    file = tmp_path / "run.toml"
    file.write_text(f'[environment]\nenv = "{DOORWAY}"\nsensing = "own"\n')
    assert "near_goal" not in seen(trained("--config", file))
    file.write_text(f'[environment]\nenv = "{DOORWAY}"\nobserve = ["goal"]\n')
    assert "near_goal" not in seen(trained("--config", file))
    file.write_text(f'[environment]\nenv = "{DOORWAY}"\nalso_observe = ["time"]\n')
    assert seen(trained("--config", file))[-1] == "time"


def test_a_finished_run_is_taken_with_the_settings_that_it_had(tmp_path):
    """A run of before the presets has settings of its own, all of them in its file."""
    file = tmp_path / "config.json"
    before = TrainConfig(environment=EnvironmentChoice(env=DOORWAY, also_observe=()))
    before.save(file)
    assert trained("--config", file) == before
