"""The command line, as a user calls it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli

TINY = (
    "--steps=64",
    "--num-worlds=4",
    "--rollout=8",
    "--batch-size=16",
    "--epochs=1",
    "--hidden=8",
)


def run(*arguments) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")


def test_train_prints_the_table_and_leaves_its_files(tmp_path, capsys):
    pytest.importorskip("pygame")
    assert run("train", *TINY, "--episodes", 3, "--horizon", 80, "--out", tmp_path) == 0
    printed = capsys.readouterr().out
    for word in ("trained PPO", "random", "scripted", "success", "γ", "F_I", "share"):
        assert word in printed
    names = {path.name for path in tmp_path.iterdir()}
    assert {"policy.zip", "curves.png", "table.csv", "table.json", "episode.gif"} <= names
    assert not any(name.startswith(".") for name in names)
    assert (tmp_path / "episode.gif").read_bytes().startswith(b"GIF8")
    table = json.loads((tmp_path / "table.json").read_text())
    assert [row["policy"] for row in table] == ["trained PPO", "random", "scripted"]
    assert table[2]["success_rate"] == 1.0
    assert table[2]["relative_cost"] < 1e-6


def test_the_same_command_goes_on_after_an_interruption(tmp_path, monkeypatch, capsys):
    from coopenv.agents.training import progress

    means = progress.episode_means

    def interrupted(ended):
        if (tmp_path / "checkpoint.zip").exists():
            raise KeyboardInterrupt
        return means(ended)

    options = (*TINY, "--checkpoint-every=1", "--episodes=2", "--no-gif", f"--out={tmp_path}")
    with monkeypatch.context() as patch:
        patch.setattr(progress, "episode_means", interrupted)
        assert run("train", *options) == 130
    assert "holds 32 of 64 steps, give the same command again to go on" in capsys.readouterr().err
    assert run("train", *options) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "going on from" in printed
    assert "at 32 of 64 steps" in printed
    assert (tmp_path / "policy.zip").exists()


def test_an_interrupted_evaluation_loses_no_training(tmp_path, monkeypatch, capsys):
    from coopenv.agents import evaluate

    def interrupted(*arguments, **keywords):
        raise KeyboardInterrupt

    out = tmp_path / "[red]"  # a name that would be taken for a colour
    options = (*TINY, "--episodes=2", "--no-gif", f"--out={out}")
    with monkeypatch.context() as patch:
        patch.setattr(evaluate, "compare", interrupted)
        assert run("train", *options) == 130
    assert "goes straight to its evaluation" in capsys.readouterr().err
    trained = (out / "policy.zip").read_bytes()
    assert run("train", *options) == 0
    printed = "".join(capsys.readouterr().out.split())
    assert f"{out / 'policy.zip'}hasdoneits64steps" in printed
    assert (out / "policy.zip").read_bytes() == trained
    assert (out / "table.csv").exists()


def test_evaluate_takes_the_environment_a_policy_was_trained_in(tmp_path, capsys):
    out = tmp_path / "blind"
    options = ("--observe", "goal", "twist", "--no-gif", "--episodes", 2, "--out", out)
    assert run("train", *TINY, *options) == 0
    assert not (out / "episode.gif").exists()
    capsys.readouterr()
    table = tmp_path / "table.csv"
    policies = (out / "policy.zip", "random", "scripted:nonsqueezing")
    assert run("evaluate", *policies, "--episodes", 4, "--out", table) == 0
    printed = capsys.readouterr().out
    assert "blind" in printed
    assert "scripted:nonsqueezing" in printed
    assert len(table.read_text().splitlines()) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("evaluate", "nowhere.zip"), "coopenv train writes such a file"),
        (("evaluate", "scripted:moore"), "moore_penrose"),
        (("evaluate", "random", "--reward", "harmonie"), "harmony"),
        (("evaluate", "random", "--env", "coopenv/Beam-v0"), "BeamTransport-v0"),
        (("evaluate", "random", "--partner", "stuborn"), "stubborn"),
    ],
)
def test_a_wrong_name_is_explained_in_one_line(arguments, message, capsys):
    assert run(*arguments) == 1
    printed = capsys.readouterr().err
    assert message in printed
    assert printed.count("\n") == 1


def test_an_unknown_option_is_refused(capsys):
    with pytest.raises(SystemExit) as stopped:
        run("train", "--stepz", 3)
    assert stopped.value.code == 2
    assert "--steps" in capsys.readouterr().err


def test_an_option_like_no_other_is_refused_in_one_line(capsys):
    with pytest.raises(SystemExit) as stopped:
        run("train", "--nonesuch", 3)
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert "got --nonesuch; look there" in said
    assert said.count("\n") == 1


def test_a_missing_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tyro", None)
    assert run("train") == 1
    assert "pip install 'coopenv[train]'" in capsys.readouterr().err


def test_without_the_drawing_extra_there_is_a_note_instead_of_a_gif(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "coopenv.render", None)
    assert run("train", *TINY, "--episodes", 2, "--out", tmp_path) == 0
    assert "coopenv[render]" in " ".join(capsys.readouterr().out.split())
    assert not (tmp_path / "episode.gif").exists()


def test_the_installed_command_explains_itself_without_loading_torch():
    program = (
        "import sys; from coopenv import cli\n"
        "try: cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "assert 'torch' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "train" in done.stdout
    assert "evaluate" in done.stdout
    command = Path(sys.executable).with_name("coopenv")
    if command.exists():
        helped = subprocess.run([command, "train", "--help"], capture_output=True, text=True)
        assert "--num-worlds" in helped.stdout


def test_evaluating_nothing_is_refused(capsys):
    assert cli.main(["evaluate"]) == 1
    assert "policies must name at least one" in capsys.readouterr().err
