"""Completion, as shells ask for it."""

import contextlib
import io
import shutil
import subprocess

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli

BASH = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
handler=$(complete -p coopenv | sed 's/.*-F \\([^ ]*\\).*/\\1/')
$handler
printf '%s\\n' "${COMPREPLY[@]}"
"""
ZSH = r"""
zmodload zsh/zpty
zpty shell 'TERM=dumb exec zsh -f -i'
zpty -w shell "PROMPT= RPROMPT= LISTMAX=100000 COLUMNS=200"
zpty -w shell "fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -D; print REA''DY"
zpty -m -r shell line '*READY*'
zpty -w -n shell "$2"$'\t\t'
zpty -m -r shell seen "*$3*"
print -r -- "$seen"
zpty -d shell
"""  # in a terminal of its own; comes back when what is waited for is there
FISH = 'source $argv[1]; complete -C "$argv[2]"'


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """Shell → file with its script."""
    folder, made = tmp_path_factory.mktemp("completion"), {}
    for shell in ("bash", "zsh", "fish"):
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            assert cli.main(["completion", shell]) == 0
        made[shell] = folder / f"coopenv.{shell}"
        made[shell].write_text(text.getvalue(), encoding="utf-8")
    return made


def answered(command: list[str]) -> set[str]:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {line.partition("\t")[0].strip() for line in done.stdout.splitlines()}


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
@pytest.mark.parametrize(
    ("words", "offered", "others"),
    [
        (["coopenv", ""], {*cli.COMMANDS}, set()),
        (["coopenv", "re"], {"replay", "report"}, {"train"}),
        (["coopenv", "study", "walker"], {"walker-turn", "walker-avoid"}, {"beam"}),
        (["coopenv", "evaluate", "--ep"], {"--episodes"}, {"--seed"}),
        (["coopenv", "evaluate", "random", "--js"], {"--json"}, {"--seed"}),
        (["coopenv", "train", "--control", "sh"], {"shared"}, {"joint"}),
    ],
    ids=lambda words: " ".join(words) if isinstance(words, list) else "",
)
def test_bash_offers_commands_options_and_choices(words, offered, others, scripts):
    seen = answered(["bash", "-c", BASH, "bash", str(scripts["bash"]), *words])
    assert offered <= seen
    assert not others & seen


@pytest.mark.skipif(shutil.which("zsh") is None, reason="there is no zsh")
@pytest.mark.parametrize(
    ("typed", "offered", "others"),
    [
        ("coopenv re", "replay*report", "train"),
        ("coopenv evaluate --ep", "--episodes", "--seed"),
        ("coopenv train --control sh", "shared", "joint"),
    ],
)
def test_zsh_offers_commands_options_and_choices(typed, offered, others, scripts, tmp_path):
    shutil.copy(scripts["zsh"], tmp_path / "_coopenv")
    command = ["zsh", "-f", "-c", ZSH, "zsh", str(tmp_path), typed, offered]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert others not in done.stdout


@pytest.mark.skipif(shutil.which("fish") is None, reason="there is no fish")
def test_fish_offers_commands_and_options(scripts):
    assert {"replay", "report"} <= answered(
        ["fish", "-c", FISH, str(scripts["fish"]), "coopenv re"]
    )
    seen = answered(["fish", "-c", FISH, str(scripts["fish"]), "coopenv evaluate --ep"])
    assert "--episodes" in seen


def test_each_script_is_of_its_shell(scripts):
    marks = {"bash": "complete -F ", "zsh": "#compdef coopenv", "fish": "--command 'coopenv'"}
    for shell, mark in marks.items():
        assert mark in scripts[shell].read_text(encoding="utf-8"), shell


def test_another_shell_is_refused(capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["completion", "tcsh"])
    assert stopped.value.code == 2
    assert "bash" in capsys.readouterr().err
