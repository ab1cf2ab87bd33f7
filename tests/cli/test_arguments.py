"""How the command line is read: help, version, exit codes, and what an unknown option means."""

import subprocess
import sys

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.rewards import COSTS


def stopped(*arguments: str) -> int | str | None:
    with pytest.raises(SystemExit) as raised:
        cli.main(arguments)
    return raised.value.code


def test_nothing_asked_for_is_answered_by_help(capsys):
    assert stopped() == 0
    printed = capsys.readouterr().out
    for word in (*cli.COMMANDS, "--version", "Exit codes", "130"):
        assert word in printed


def test_the_help_of_a_cost_names_every_one(capsys):
    assert stopped("train", "--help") == 0
    told = capsys.readouterr().out.split("--cost ")[1].split("--observe ")[0]
    for name in COSTS:
        assert name in told


@pytest.mark.parametrize("option", ["--version", "-V"])
def test_versions_are_told_one_a_line(option, capsys):
    assert cli.main([option]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines][:3] == ["coopenv", "python", "numpy"]
    assert "torch" in "\n".join(lines)


def test_the_package_itself_is_the_command():
    done = subprocess.run(
        [sys.executable, "-m", "coopenv", "train", "--help"], capture_output=True, text=True
    )
    assert done.returncode == 0
    assert done.stdout.startswith("usage: coopenv train")


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (("train", "--lr", "3"), "--learning-rate"),
        (("train", "--gamma=0.9"), "--discount"),
        (("train", "--n-steps", "3"), "--rollout"),
        (("train", "--n_envs", "3"), "--num-worlds"),
        (("train", "--max-steps", "3"), "--horizon"),
        (("train", "--total-timesteps", "3"), "--steps"),
        (("train", "--stepz", "3"), "--steps"),
        (("evaluate", "random", "--n-envs", "3"), "--num-worlds"),
        (("decompose", "a.csv", "--output", "3"), "--out"),
    ],
)
def test_an_option_of_other_tools_is_told_its_name_here(arguments, meant, capsys):
    assert stopped(*arguments) == 2
    printed = capsys.readouterr().err
    assert f"did you mean {meant}?" in printed
    assert printed.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("train", "--frobnicate", "3"),
        ("train", "--steps", "many"),
        ("train", "--action", "forces"),
        ("trian",),
        ("study", "--out", "x"),
        ("decompose",),
    ],
)
def test_what_makes_no_sense_is_explained_without_names_from_inside(arguments, capsys):
    assert stopped(*arguments) == 2
    printed = capsys.readouterr().err
    assert printed.strip()
    for inside in ("dummy", "training.", "TrainConfig", "Traceback", "<class"):
        assert inside not in printed


BARE = """
import sys
sys.modules.update(dict.fromkeys(["tyro", "rich", "torch", "pandas"]))
from coopenv import cli
print(*[cli.main(line.split()) for line in sys.argv[1:]])
"""


def test_a_bare_install_asks_for_the_extra_of_the_command_and_tells_its_versions():
    asked = {"decompose a.csv": "analysis", "train": "train", "evaluate random": "train"}
    done = subprocess.run(
        [sys.executable, "-c", BARE, *asked, "--version"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines() == [
        f"coopenv: the command line needs an optional package; pip install 'coopenv[{extra}]'"
        for extra in asked.values()
    ]
    assert done.stdout.startswith("coopenv ")
    assert done.stdout.splitlines()[-1] == "1 1 1 0"
