"""One policy that learns in teams of several sizes side by side."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from stable_baselines3 import PPO

from coopenv import Body, TransportConfig
from coopenv.agents.environment import with_team
from coopenv.agents.evaluate import evaluate
from coopenv.agents.experiments import Experiment
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy, TeamsVecEnv, TransportVecEnv, recommended
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.presets import observing, train_config
from coopenv.errors import InvalidInput
from coopenv.observation.observation import find_block
from tests.agents.training.cases import tiny
from tests.helpers import EASY, actions

SEEN = ("goal", "own_wrench", "others_wrench", "place")
SHORT = TransportConfig(horizon=8, observe=SEEN)


def side_by_side(**keywords) -> TeamsVecEnv:
    return TeamsVecEnv(TransportConfig(horizon=6, observe=SEEN, task=EASY, **keywords), 5, (2, 3))


def test_rows_are_those_of_each_size_as_it_would_be_by_itself():
    venv = side_by_side()
    parts = [TransportVecEnv(part.transport.config, n, control="shared")
             for part, n in zip(venv.parts, (3, 2), strict=True)]  # fmt: skip
    assert venv.num_envs == 3 * 2 + 2 * 3
    venv.seed(4)
    parts[0].seed(4)
    parts[1].seed(4 + 3)
    np.testing.assert_array_equal(venv.reset(), np.concatenate([part.reset() for part in parts]))
    ended = 0
    for action in actions(0, 14, 12, 3):
        seen = venv.step(action)
        alone = [part.step(mine) for part, mine in zip(parts, np.split(action, [6]), strict=True)]
        for one, others in zip(seen[:3], list(zip(*alone, strict=True))[:3], strict=True):
            np.testing.assert_array_equal(one, np.concatenate(others))
        infos = [*alone[0][3], *alone[1][3]]
        assert [set(info) for info in seen[3]] == [set(info) for info in infos]
        ended += sum("episode" in info for info in seen[3])
    assert ended > 0


def test_attributes_and_methods_are_those_of_the_rows_own_part():
    venv = side_by_side()
    assert [core.num_agents for core in venv.get_attr("transport", [0, 11])] == [2, 3]
    venv.reset()
    assert len(venv.env_method("get_state")) == venv.num_envs
    venv.set_attr("render_mode", None)
    assert len(venv.env_is_wrapped(object)) == venv.num_envs
    with pytest.raises(InvalidInput, match="options must be set for each size"):
        venv.set_options({"pose": (0, 0, 0)})
    with pytest.raises(InvalidInput, match=r"actions must have the shape \(12, 3\), got \(5, 3\)"):
        venv.step(np.zeros((5, 3)))
    again = pickle.loads(pickle.dumps(venv))
    assert again.num_envs == venv.num_envs


def test_finite_bounds_hold_the_features_of_every_size():
    venv = side_by_side(bounded=True)
    for end, outer in (("low", np.less_equal), ("high", np.greater_equal)):
        whole = getattr(venv.observation_space, end)
        assert np.isfinite(whole).all()
        assert all(outer(whole, getattr(each.observation_space, end)).all() for each in venv.parts)


def test_blocks_that_grow_with_the_team_are_refused_by_name():
    with pytest.raises(InvalidInput, match=r"blocks of one size .* partner_internal, partner_wren"):
        TeamsVecEnv(TransportConfig(), 4, (2, 3))
    assert TeamsVecEnv(TransportConfig(), 4, (3,)).num_envs == 12  # one size: nothing has to fit


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"control": "joint"}, "control must be 'shared'"),
        ({"teams": (2, 2)}, "teams must be different sizes"),
        ({"teams": (0,)}, "teams must be"),
        ({"teams": "2"}, "teams must be a list"),
        ({"num_worlds": 1, "rollout": 9}, "num_worlds must be at least one for each size"),
        ({"environment": EnvironmentChoice(team=3)}, "team must be left out beside teams"),
        ({"environment": EnvironmentChoice(body=("grips=[[0, 0]]",))}, "body must leave grips"),
    ],
)
def test_settings_that_do_not_go_together_are_refused(changes, named, tmp_path):
    given = {"control": "shared", "teams": (2, 3), **changes}
    with pytest.raises(InvalidInput, match=named):
        tiny(tmp_path, **given)


@pytest.mark.parametrize("body", [Body.walker(), [Body(), Body()]])
def test_a_body_that_is_none_for_any_team_is_refused(body):
    config = TransportConfig()
    object.__setattr__(config, "body", body)
    with pytest.raises(InvalidInput, match="team must be of a body that any number"):
        with_team(config, 3)


def test_a_team_holds_a_plate_and_all_else_of_the_body_stays():
    beam = TransportConfig(body=Body(mass=4.0, linear_drag=2.0), horizon=50)
    made = with_team(beam, 5)
    assert made.body == Body.plate(5, mass=4.0, linear_drag=2.0)
    assert made == replace(beam, body=made.body)
    assert with_team(made, 2).body == Body.plate(2, mass=4.0, linear_drag=2.0)
    box = Body.plate(4, size=(1.0, 2.0), inertia=9.0)
    assert with_team(replace(beam, body=box), 3).body == Body.plate(3, size=(1.0, 2.0), inertia=9.0)
    assert EnvironmentChoice(team=3, body=("mass=4",)).config().body == Body.plate(3, mass=4.0)


def test_a_training_of_teams_sees_what_fits_any_of_them_unless_it_says_itself():
    wide = EnvironmentChoice(env="coopenv/BeamDoorway-v0", task=("gap=[1.6, 1.7]",))
    config = train_config(wide, control="shared", teams=(2, 4))
    seen = {find_block(entry).name for entry in config.environment.config().observe}
    assert {"gap", "near_goal", "others_wrench", "place"} <= seen
    assert not {"partner_wrench", "partner_internal"} & seen
    said = EnvironmentChoice(observe=("goal", "place"))
    own = observing(TrainConfig(control="shared", teams=(2, 4), environment=said))
    assert own.environment.config().observe == ("goal", "place")


def test_a_run_without_teams_reads_as_it_did_before_there_were_any(tmp_path):
    assert "teams" not in tiny(tmp_path).to_dict()
    assert TrainConfig.from_dict(tiny(tmp_path).to_dict()) == tiny(tmp_path)


def test_a_run_says_its_teams_and_goes_on_and_its_policy_acts_in_any(tmp_path):
    config = tiny(tmp_path, control="shared", teams=(2, 3))
    rows, told = [], []
    train(config, environment=SHORT, report=rows.append, tell=told.append)
    assert [row["steps"] for row in rows] == [32, 64, 96, 128]
    for file in (tmp_path / "config.json", tmp_path / "policy.zip"):
        kept = Provenance.read_beside(file) if file.suffix == ".json" else Provenance.read(file)
        assert kept is not None
        assert kept.training["teams"] == [2, 3]
        assert kept.config() == with_team(SHORT, 2)
    longer = replace(TrainConfig.load(tmp_path / "config.json"), steps=192)
    assert longer.teams == (2, 3)
    model = train(longer, environment=SHORT, report=rows.append, tell=told.append).model
    assert [row["steps"] for row in rows[4:]] == [160, 192]
    assert model.num_timesteps == 192 // 4 * 10  # 2 worlds of 2 and 2 of 3
    with pytest.raises(InvalidInput, match=r"no other run, .* differs in teams"):
        train(replace(config, teams=(2, 4)), environment=SHORT)
    policy = SB3Policy.load(tmp_path / "policy.zip")
    for size in (1, 2, 6):
        assert evaluate(policy, with_team(SHORT, size), episodes=3).episodes == 3


def test_a_target_has_to_be_reached_in_every_size(tmp_path):
    always = replace(SHORT, task=replace(EASY, position_tolerance=50.0, angle_tolerance=4.0))
    told = []
    config = tiny(tmp_path, control="shared", teams=(2, 3), until=0.9)
    train(config, environment=always, tell=told.append)
    assert told[0].startswith("100.0% of 500 held-out episodes succeed in the team that does it")


def test_the_file_of_ones_own_learner_says_the_teams(tmp_path):
    venv = side_by_side()
    model = PPO("MlpPolicy", venv, **{**recommended(venv), "n_steps": 2, "batch_size": 8})
    model.learn(24)
    SB3Policy(model).save(tmp_path / "policy.zip")
    kept = Provenance.read(tmp_path / "policy.zip")
    assert kept is not None
    assert (kept.training["control"], kept.training["teams"]) == ("shared", [2, 3])
    json.dumps(kept.to_notes())


def test_a_team_holds_the_outline_that_is_given_beside_it_and_no_grips_can_be():
    outline = "outline=[[-0.3,-0.2],[0.3,-0.2],[0.3,0.2],[-0.3,0.2]]"
    body = EnvironmentChoice(team=4, body=(outline,)).config().body
    assert isinstance(body, Body)
    assert body.num_agents == 4
    assert all(abs(x) <= 0.3 and abs(y) <= 0.2 for x, y in body.grips)
    with pytest.raises(InvalidInput, match="body must leave grips to team"):
        EnvironmentChoice(team=4, body=("grips=[[-0.5,0],[0.5,0]]",)).config()
    with pytest.raises(InvalidInput, match="team must be a whole number of at least 1, got 0"):
        EnvironmentChoice(team=0).config()


def test_settings_that_were_saved_take_other_teams():
    saved = TrainConfig(control="shared", teams=(2, 3)).to_dict()
    again = TrainConfig.from_dict({**saved, "teams": [3, 4]})
    assert again.environment.team == 3
    assert TrainConfig.from_dict(saved).environment.team == 2


def test_what_is_observed_too_comes_beside_the_blocks_of_any_team():
    config = TrainConfig(
        environment=EnvironmentChoice(also_observe=("time",)), control="shared", teams=(2, 3)
    )
    seen = observing(config).environment.config().observe
    assert {"time", "others_wrench", "place"} <= set(seen)
    assert "partner_wrench" not in seen


def test_a_grid_has_no_teams_since_a_cell_is_evaluated_in_one_environment():
    with pytest.raises(InvalidInput, match="teams"):
        Experiment(
            name="teams", grid={"reward": ["task"]}, training={"control": "shared", "teams": [2, 3]}
        ).cells()
