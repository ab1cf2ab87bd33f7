"""The benchmark of feeling hands: what its learners see, what it keeps, what its page shows."""

import sys
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("rich")
pytest.importorskip("sb3_contrib")

from rich.console import Console
from sb3_contrib import RecurrentPPO
from stable_baselines3.common.vec_env import VecFrameStack

from benchmarks.haptics import __main__ as command
from benchmarks.haptics import elsewhere, learned, page, scripted
from benchmarks.haptics.__main__ import FOLLOWERS, Haptics, run
from benchmarks.haptics.cells import BEAMS, EVALUATION, Cell, Found, environment, kept, read_found
from benchmarks.haptics.learned import FRAMES, LEARNERS, Stacked
from coopenv.agents.benchmark import SUITES, read_entry
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.learned.sequences import WholeSequences
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv
from coopenv.errors import InvalidInput, UnknownName

TEXT = page.PAGE.read_text(encoding="utf-8")


def on_page(name):
    return TEXT.split(f"<!-- {name} -->\n")[1].rstrip("\n")


def found(cell, **values):
    whole = {
        "episodes": 500, "success": 0.5, "steps": 90.0, "effort": 3.0, "relative_cost": 0.1,
        "internal_force": 0.5, "seconds": 1.0,
    }  # fmt: skip
    return Found(cell=cell, **{**whole, **values})


def test_a_policy_sees_the_frames_that_it_learned_from():
    config = replace(environment(Cell("PPO, frames", "motion", "7.7 kg")), horizon=7)
    plain = TransportVecEnv(config, 3, control="shared")
    stacked = VecFrameStack(TransportVecEnv(config, 3, control="shared"), FRAMES)
    seen = []

    def policy(obs, transition):
        seen.append(obs.reshape(6, -1))
        return np.zeros((3, 2, 3))

    policy_of_frames = Stacked(policy, FRAMES)
    plain.seed(5)
    stacked.seed(5)
    obs, wanted = plain.reset(), stacked.reset()
    generator = np.random.default_rng(0)
    for _ in range(18):  # beyond two ends
        transition = plain.transport.transition
        assert transition is not None
        policy_of_frames(np.asarray(obs).reshape(3, 2, -1), transition)
        np.testing.assert_array_equal(seen[-1], wanted)
        action = generator.uniform(-1, 1, (6, 3)).astype(np.float32)
        obs, *_ = plain.step(action)
        wanted, *_ = stacked.step(action)


def test_agent_0_alone_is_told_and_each_has_its_own_senses():
    for beam, (mass, horizon) in BEAMS.items():
        config = environment(Cell("gives way", "motion", beam))
        assert (config.informed, config.horizon) == ((0,), horizon)
        assert config.body.mass == mass  # pyright: ignore[reportAttributeAccessIssue]
        names = [str(entry) for entry in config.observe]
        assert "own_wrench" in names
        assert not [name for name in names if name.startswith("partner")]


def test_finished_cells_are_kept_and_not_run_again(tmp_path, monkeypatch):
    study = Haptics(
        only=("lets go",), actions=("motion",), beams=("7.7 kg",), episodes=4, out=tmp_path
    )
    run(study, Console(quiet=True))
    (cell,) = kept((tmp_path,))
    assert cell == Cell("lets go", "motion", "7.7 kg")
    assert study.shown()[cell].relative_cost <= 1e-6

    def never(cell, episodes):
        raise AssertionError

    monkeypatch.setattr(scripted, "run", never)
    run(study, Console(quiet=True))
    with pytest.raises(AssertionError):
        run(replace(study, episodes=5), Console(quiet=True))  # another measure


def test_a_learner_is_run_again_where_its_policy_is_wanted_and_not_kept(tmp_path):
    study = Haptics(policies=tmp_path)
    plain, frames, still = (
        Cell(name, "motion", "7.7 kg", seed, 1)
        for name, seed in (("PPO", 0), ("PPO, frames", 0), ("lets go", None))
    )
    done = (plain, frames, still)
    assert study.lacks(plain, done)
    assert not study.lacks(frames, done)  # of a stack there is no file
    assert not study.lacks(still, done)
    (tmp_path / f"{plain.name}.zip").touch()
    assert not study.lacks(plain, done)
    assert not Haptics().lacks(plain, done)
    assert Haptics().lacks(plain, ())


def test_a_recurrent_learner_is_kept_as_a_file_that_the_benchmark_takes(tmp_path):
    suite = SUITES["haptics"]
    scenario = next(each for each in suite.scenarios if each.name == "wrench, 7.7 kg")
    config = replace(environment(Cell("PPO, recurrent", "wrench", "7.7 kg")), horizon=5)
    venv = TransportVecEnv(config, 2, control="shared")
    model = RecurrentPPO(WholeSequences, venv, n_steps=4, batch_size=8, n_epochs=1, seed=0)
    model.learn(16)
    path = tmp_path / "policies" / "mine.zip"
    learned.keep(SB3Policy(model), path)
    entered = read_entry(str(path)).policy(scenario)  # by nobody's trust
    mine, again = (run_episodes(each, config, episodes=3) for each in (SB3Policy(model), entered))
    np.testing.assert_allclose(again.reward, mine.reward, rtol=1e-5)


def test_a_file_that_is_no_cell_is_refused_by_its_name(tmp_path):
    (tmp_path / "odd.json").write_text('{"cell": {}}', encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"odd\.json must hold a finished cell"):
        read_found(tmp_path / "odd.json")
    with pytest.raises(UnknownName, match="gives way"):
        Haptics(only=("give way",))
    with pytest.raises(InvalidInput, match="seeds must differ"):
        Haptics(seeds=(1, 1))


def test_equal_budgets_stand_in_one_table_and_others_do_not(tmp_path):
    rates = {0: 0.1, 1: 0.3, 2: 0.2}
    for seed, rate in rates.items():
        found(Cell("PPO", "motion", "20 kg", seed, 10**6), success=rate).save(tmp_path)
    found(Cell("PPO", "motion", "20 kg", 0, 10**5), success=0.9).save(tmp_path)
    shown = Haptics(budget=10**6, out=tmp_path).shown()
    (line,) = page.lines({k: v for k, v in shown.items() if k.follower == "PPO"}, FOLLOWERS)
    middle, low, high = line.success()
    assert middle == pytest.approx(20.0)
    assert 10.0 <= low < middle < high <= 30.0
    assert "| 20 kg | motion | PPO | 3 | 20.0 [" in page.table([line])


def test_every_learner_has_the_same_rows_and_a_reward_with_its_term():
    cells = [cell for cell in Haptics(only=("learned",)).cells()]
    assert {cell.rows for cell in cells} == {2_000_000}
    assert {cell.seed for cell in cells} == {0, 1, 2, 3, 4}
    for name, learner in LEARNERS.items():
        if learner.term is not None and learned.possible(Cell(name, "motion", "7.7 kg", 0, 1)):
            assert set(learner.reward()) == {"progress", "success", "time", learner.term[0]}


def test_the_page_shows_the_cells_beside_it():
    # else: python -m benchmarks.haptics --only scripted --elsewhere --write
    cells = kept((page.CELLS,))
    budgets = {cell.rows for cell in cells if cell.rows} or {Haptics.budget}
    tables = [page.table(page.lines(Haptics(budget=b).shown(), FOLLOWERS)) for b in budgets]
    assert on_page("haptics") in tables
    wanted = {c for c in Haptics(only=("scripted",)).cells()}
    assert wanted <= set(cells)
    assert page.FIGURE.exists()


@pytest.fixture
def own_page(tmp_path, monkeypatch):
    """A page with cells of two budgets beside it."""
    for name, place in (("PAGE", "page.md"), ("FIGURE", "page.png"), ("CELLS", "cells")):
        monkeypatch.setattr(page, name, tmp_path / place)
    page.PAGE.write_text("<!-- haptics -->\n<!-- haptics -->\n", encoding="utf-8")
    for rows in (10**5, 10**6):
        found(Cell("PPO", "motion", "20 kg", 0, rows), success=0.9).save(page.CELLS)
    for name in ("lets go", "floats"):
        found(Cell(name, "motion", "7.7 kg")).save(page.CELLS)
    return page.CELLS


def written_by(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["haptics", *arguments, "--write"])
    command.main()
    return page.PAGE.read_text(encoding="utf-8")


def test_writing_the_page_replaces_the_cells_alone_that_were_asked_for(
    own_page, tmp_path, monkeypatch
):
    before = {path.name: path.read_bytes() for path in own_page.iterdir()}
    out = tmp_path / "out"
    found(Cell("lets go", "motion", "7.7 kg"), success=0.25).save(out)
    found(Cell("floats", "motion", "7.7 kg"), success=0.25).save(out)  # of an earlier call
    asked = ("--only", "lets go", "--actions", "motion", "--beams", "7.7 kg", "--out", str(out))
    text = written_by(monkeypatch, *asked, "--budget", "1000000")
    after = {path.name: path.read_bytes() for path in own_page.iterdir()}
    assert before.keys() == after.keys()
    assert {name for name in after if after[name] != before[name]} == {"motion_7.7-kg_lets-go.json"}
    assert "| 7.7 kg | motion | lets go | – | 25.0 [" in text
    assert "| 7.7 kg | motion | floats | – | 50.0 [" in text
    assert text.count("| PPO |") == 1  # of one budget


def test_a_page_is_not_written_with_cells_of_other_numbers_of_episodes(
    own_page, tmp_path, monkeypatch
):
    asked = ("--only", "lets go", "--out", str(tmp_path / "out"), "--episodes", "4")
    with pytest.raises(InvalidInput, match=r"episodes must be 500 as of .*floats.*, got 4"):
        written_by(monkeypatch, *asked)
    assert len(list(own_page.iterdir())) == 4


def test_the_page_shows_what_is_measured():
    cell = Cell("assists", "motion", "20 kg")
    again = scripted.run(cell, 100)
    assert again.success == pytest.approx(kept((page.CELLS,))[cell].success, abs=0.04)
    config = elsewhere.environment("BeamLift", 7.7, 1.0)
    seen = elsewhere.measure(config, "gives way", 20)
    assert seen.seed == EVALUATION
    assert f"| BeamLift | 7.7 kg | gives way | {100 * seen.success_rate:.1f}" in TEXT
    assert command.GROUPS["scripted"] == tuple(scripted.FOLLOWERS)
