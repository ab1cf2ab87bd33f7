"""Other algorithms than PPO: the page shows all runs, and each trains with its settings."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")
pytest.importorskip("torchrl")
pytest.importorskip("tyro")

from stable_baselines3 import SAC

from benchmarks.learning import baselines
from benchmarks.learning.algorithms import __main__ as command
from benchmarks.learning.algorithms import (
    mappo,
    policies,
    ppo,
    recurrent,
    runs,
    sac,
    search,
    tables,
)
from benchmarks.learning.algorithms.curve import EVERY, Curve
from benchmarks.learning.algorithms.space import KEPT, OF, SEED
from benchmarks.pages import filled
from coopenv.agents.algorithms import SACConfig
from coopenv.agents.algorithms.models import sac_settings
from coopenv.agents.benchmark import Scenario, read_entry
from coopenv.agents.benchmark.trained import Trained
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.sb3 import feature_scale, make_vec_env
from coopenv.agents.seeds import STOPPING
from coopenv.agents.training.presets import train_config
from tests.agents.training.cases import SHORT
from tests.docs.snippets import Snippet, chains, running

COMMON = {
    "env": "BeamLift",
    "settings": {"steps": 5, "hidden": [8]},
    "steps": 5,
    "seconds": 1.5,
    "success": 0.5,
    "sampled": 0.25,
    "time": None,
    "relative_cost": 0.125,
}
TINY = {
    "ppo": {"steps": 128, "num_worlds": 4, "rollout": 8, "batch_size": 16, "epochs": 1},
    "sac": {"steps": 64, "num_worlds": 4, "random_steps": 16, "hidden": [8], "batch_size": 16},
    "mappo": {"total_steps": 64, "num_worlds": 4, "rollout": 8, "minibatch": 16, "epochs": 1},
    "recurrent": {
        "steps": 64,
        "num_worlds": 4,
        "rollout": 8,
        "batch_size": 16,
        "epochs": 1,
        "units": 8,
        "residual": True,
    },
}
MODULES = {"ppo": ppo, "sac": sac, "mappo": mappo, "recurrent": recurrent}


def of(
    algorithm: runs.Name, seed: int = 0, at: tuple[float | None, float | None] = (0.5, None)
) -> runs.Run:
    return runs.Run(algorithm=algorithm, seed=seed, reached=at, **COMMON)


def test_the_page_shows_every_run_and_every_trial_that_was_saved():
    made = runs.saved()
    shown = {
        "algorithms": tables.table(made),
        "hands": tables.hands(made),
        "cost": tables.cost(made),
    }
    shown["search"] = search.table(search.saved())
    assert filled(tables.PAGE, shown) == tables.PAGE.read_text(encoding="utf-8")


def test_every_run_has_the_settings_that_the_command_has_today():
    for run in runs.saved():
        assert command.is_of(run, command.Piece(run.algorithm, run.env, run.action, run.seed)), run


def test_the_trials_are_those_of_the_space_on_seeds_of_no_table():
    tried = [(one.algorithm, one.env, json.dumps(one.settings)) for one in search.saved()]
    wanted = [
        (name, env, json.dumps(search.settings_of(name, env, changed)))
        for name, env, changed in search.planned(search.Search())
    ]
    assert sorted(tried) == sorted(wanted)
    seeds = {run.seed for run in runs.saved()} | {run.seed for run in baselines.saved()}
    assert SEED not in seeds
    assert search.EVALUATION not in (0, STOPPING)


def test_every_algorithm_is_searched_in_every_environment_with_settings_that_it_has():
    for name, space in OF.items():
        assert set(space.steps) == set(baselines.names())
        known = {*MODULES[name].settings("BeamLift"), space.steps_name}
        assert all(
            {*space.start, *change} <= known
            for env in space.steps
            for change in space.changes_in(env)
        )


def test_settings_of_an_environment_are_those_that_the_search_takes():
    for env in baselines.names():
        for name, space in OF.items():
            if (name, env) in KEPT:
                continue
            wanted = {**space.start, **search.taken(search.saved(name, env)).changed}
            settings = json.loads(json.dumps(MODULES[name].settings(env)))
            assert {key: settings[key] for key in wanted} == json.loads(json.dumps(wanted))


def test_a_table_has_a_row_a_run_by_algorithm_and_seed_and_without_runs_there_is_none():
    _, _, *rows = tables.table([of("mappo"), of("sac", 1), of("sac")]).splitlines()
    assert [line.split(" | ")[1:3] for line in rows] == [["SAC", "0"], ["SAC", "1"], ["MAPPO", "0"]]
    assert tables.table([]) == tables.cost([]) == search.table([]) == tables.NONE


def test_runs_by_hands_have_a_table_and_files_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "FOLDER", tmp_path)
    plain, by_hands = of("sac"), replace(of("sac"), action="motion")
    for run in (plain, by_hands):
        runs.save(run)
    assert runs.saved("sac", plain.task) == [plain]
    assert runs.saved("sac", by_hands.task) == [by_hands]
    assert len(tables.table([by_hands, plain]).splitlines()) == 3
    assert tables.hands([plain]) == tables.table([by_hands]) == tables.NONE
    assert tables.cost([plain, by_hands]) == tables.cost([plain])


def test_actions_that_an_environment_has_anyway_are_no_others():
    asked = command.Algorithms(envs=("BeamLift",), only=("sac",), actions=("wrench", "motion"))
    assert [piece.action for piece in command.planned(asked)] == [None, "motion"]


@pytest.mark.parametrize("name", runs.NAMES)
def test_an_algorithm_trains_by_hands_and_its_policy_can_be_entered(name, tmp_path, monkeypatch):
    settings = {**runs.settings_of(name, "BeamLift", "motion"), **TINY[name]}
    monkeypatch.setattr(MODULES[name], "settings", lambda env, action: settings)
    monkeypatch.setattr(runs, "FOLDER", tmp_path / "runs")
    monkeypatch.setattr(runs, "EPISODES", 2)
    asked = command.Algorithms(
        only=(name,), envs=("BeamLift",), actions=("motion",), policies=tmp_path
    )
    (run,) = command.run_all(asked, lambda line: None)
    assert (run.action, run.steps) == ("motion", 64)
    entry = read_entry(str(policies.file_of(tmp_path, name, "{task}_motion", run.seed)))
    hands = Scenario(name="it", env="BeamLift", settings={"horizon": 10, "action": "motion"})
    assert run_episodes(entry.policy(hands), hands.config, episodes=2).reward.shape[0] == 2


def test_costs_are_medians_of_those_that_got_there_beside_ppo():
    made = [of("sac", seed, (1.0, at)) for seed, at in enumerate((10.0, 20.0, None))]
    header, _, *rows = tables.cost([*made, of("mappo")]).splitlines()
    assert header[2:-2].split(" | ")[1:4] == ["PPO, joint", "PPO, shared", "SAC"]
    (mine,) = (line for line in rows if line.startswith("| BeamLift "))
    assert mine[2:-2].split(" | ")[3:] == ["15 (2 of 3)", "–", "not run"]


def test_runs_come_back_as_they_were_saved_by_seed_and_the_newest_of_each(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "FOLDER", tmp_path)
    last, first, other = of("sac", 3), of("sac", 1), of("mappo")
    again = replace(last, success=1.0)
    for run in (last, first, again, other):
        runs.save(run)
    assert runs.saved("sac") == [first, again]
    assert runs.saved() == [first, again, other]


def test_a_curve_tells_of_the_episodes_that_ended_within_a_horizon():
    curve = Curve(horizon=EVERY, num_worlds=2)
    for step in range(2 * EVERY):
        curve.add([step >= EVERY] if step % 2 else [])
    assert [row for _, row in curve.points] == [
        {"steps": 2 * EVERY, "success": 0.0},
        {"steps": 4 * EVERY, "success": 1.0},
    ]
    assert curve.steps == 4 * EVERY


def test_truncated_episodes_are_no_ends_to_sac():
    venv = make_vec_env(num_worlds=2, horizon=3, seed=0)
    settings = sac_settings(SACConfig(steps=200, random_steps=100, hidden=(8,)), [1.0] * 44)
    model = SAC("MlpPolicy", venv, **settings)
    model.learn(12)
    buffer = model.replay_buffer
    assert buffer is not None
    assert buffer.dones[:6].sum() == buffer.timeouts[:6].sum() == 4
    assert not buffer._get_samples(np.arange(6)).dones.any()


@pytest.mark.parametrize("name", runs.NAMES)
def test_an_algorithm_trains_is_tested_saved_and_not_asked_for_again(name, tmp_path, monkeypatch):
    settings = {**runs.settings_of(name, "BeamTransport"), **TINY[name]}
    monkeypatch.setattr(MODULES[name], "settings", lambda env, action: settings)
    monkeypatch.setattr(runs, "FOLDER", tmp_path)
    monkeypatch.setattr(runs, "EPISODES", 4)
    told: list[str] = []
    asked = command.Algorithms(only=(name,), envs=("BeamTransport",), seeds=(2,))
    (run,) = command.run_all(asked, told.append)
    assert (run.algorithm, run.steps, run.seed, run.reached) == (name, 64, 2, (None, None))
    assert run.settings == settings
    assert run.seconds >= 0
    assert command.run_all(asked, told.append) == [run]
    assert told == [json.dumps(run.to_dict())]
    settings["num_worlds"] = 2  # other settings now, and no time
    command.run_all(replace(asked, minutes=0.0), told.append)
    assert told[-1] == "the budget is spent; the same command goes on"


@pytest.mark.parametrize("name", runs.NAMES)
def test_a_policy_that_is_kept_is_entered_and_acts_as_it_did(name, tmp_path, monkeypatch):
    settings = {**runs.settings_of(name, "BeamLift"), **TINY[name]}
    monkeypatch.setattr(MODULES[name], "settings", lambda env, action: settings)
    monkeypatch.setattr(runs, "FOLDER", tmp_path / "runs")
    monkeypatch.setattr(runs, "EPISODES", 2)
    told: list[str] = []
    asked = command.Algorithms(only=(name,), envs=("BeamLift",), policies=tmp_path)
    (run,) = command.run_all(asked, told.append)
    assert command.run_all(asked, told.append) == [run]  # which finds both
    assert len(told) == 1
    file = policies.file_of(tmp_path, name, "{task}", run.seed)
    entry = read_entry(str(file))
    scenario = Scenario(name="it", env="BeamLift", settings={"horizon": 10})
    assert entry.trained(scenario) == Trained(64)
    mine = run_episodes(entry.policy(scenario), scenario.config, episodes=3)
    seeing = train_config("coopenv/BeamLift-v0").environment.config()
    policy, _ = MODULES[name].learn("BeamLift", run.seed, settings)
    again = run_episodes(policy, replace(seeing, horizon=10), episodes=3)
    np.testing.assert_allclose(mine.reward, again.reward, atol=1e-4)
    file_of_run = policies.file_of(tmp_path, name, "BeamLift", run.seed)
    file_of_run.unlink()
    command.run_all(asked, told.append)
    assert len(told) == 2
    assert file_of_run.exists()


def test_actors_of_mappo_act_by_their_mean_or_by_samples_keyed_by_episode():
    settings = {**mappo.settings("BeamTransport"), **TINY["mappo"], "total_steps": 32}
    policy, _ = mappo.learn("BeamTransport", 0, settings)
    alone, beside = (
        run_episodes(policy.sampled(), SHORT, episodes=3, num_worlds=worlds) for worlds in (1, 3)
    )
    np.testing.assert_allclose(alone.reward, beside.reward, atol=1e-5)
    assert not np.allclose(alone.reward, run_episodes(policy, SHORT, episodes=3).reward)


@pytest.mark.parametrize("name", search.SEARCHED)
def test_trials_are_made_of_what_is_lacking_and_kept(name, tmp_path, monkeypatch):
    steps = {"BeamTransport": TINY[name].get("steps", 64)}
    start = {key: value for key, value in TINY[name].items() if key != OF[name].steps_name}
    space = replace(
        OF[name], steps=steps, start=start, changes=({}, {"learning_rate": 1e-4}), more={}
    )
    monkeypatch.setattr(search, "OF", {**OF, name: space})
    monkeypatch.setattr(search, "TRIALS", tmp_path)
    monkeypatch.setattr(search, "EPISODES", 2)
    told: list[str] = []
    asked = search.Search(only=(name,), envs=("BeamTransport",))
    trials = search.search(asked, told.append)
    assert [trial.changed for trial in trials] == [{}, {"learning_rate": 1e-4}]
    assert {trial.steps for trial in trials} == {TINY[name].get("steps", 64)}
    assert search.search(replace(asked, minutes=0.0), told.append) == trials
    assert told == [json.dumps(asdict(trial)) for trial in trials]
    _, _, *rows = search.table(trials).splitlines()
    assert [row.split(" | ")[2] for row in rows] == ["nothing", "learning_rate 0.0001"]
    assert sum(row.endswith("| × |") for row in rows) == 1


def trial(success: float, at: float | None, sampled: float = 0.5) -> search.Trial:
    return search.Trial(
        algorithm="sac",
        env="BeamLift",
        changed={},
        settings={},
        steps=64,
        seconds=1.0,
        reached=(None, at),
        success=success,
        sampled=sampled,
        relative_cost=0.1,
    )


def test_the_quickest_of_the_best_trials_is_taken_and_where_none_got_there_the_best():
    quick, best, slow, poor = trial(0.99, 10.0), trial(1.0, 20.0), trial(1.0, 30.0), trial(0.5, 1.0)
    assert search.taken([poor, slow, best, quick]) is quick
    assert search.taken([poor, slow, best]) is best
    never, nearly = trial(0.3, None), trial(0.295, None)
    assert search.taken([nearly, never]) is never


def example() -> Snippet:
    """The page's SAC."""
    ((snippet,),) = chains(tables.PAGE)
    return snippet


def test_the_example_has_the_settings_of_the_table_and_runs(tmp_path):
    code, recipe = example().code, SACConfig(**sac.settings("BeamTransport"))
    assert f"learn({recipe.steps:_})" in code
    assert f"learning_starts={recipe.random_steps:_}," in code
    quick = code.replace(f"{recipe.steps:_}", "640").replace(f"{recipe.random_steps:_}", "320")
    with running([replace(example(), code=quick)], tmp_path) as names:
        shown = names["model"]
    mine = sac_settings(recipe, feature_scale(shown.env))
    assert shown.policy_kwargs == {**shown.policy_kwargs, **mine["policy_kwargs"]}
    for name in ("gradient_steps", "batch_size", "learning_rate", "gamma", "tau", "ent_coef"):
        assert getattr(shown, name) == mine[name], name


@pytest.mark.slow
def test_the_example_learns_to_carry_the_beam(tmp_path):
    with running([example()], tmp_path) as names:
        assert names["seen"].success_rate > 0.9
