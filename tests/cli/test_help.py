"""Help: the commands in groups, an example for each, and lines that fit the terminal."""

import os
import shlex

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.cli.options.reading import read
from coopenv.cli.program import GROUPS
from coopenv.cli.study import Study
from tests.cli.commands import LEAST, STUDIES

PAGES = [[], *([name] for name in cli.COMMANDS), *(["study", name] for name in STUDIES)]


def help_of(arguments: list[str], capsys) -> list[str]:
    with pytest.raises(SystemExit) as stopped:
        cli.main([*arguments, "--help"])
    assert stopped.value.code == 0
    printed = capsys.readouterr()
    assert not printed.err
    return printed.out.splitlines()


@pytest.mark.parametrize("arguments", PAGES, ids=" ".join)
@pytest.mark.parametrize("width", [80, 100])
def test_no_line_is_wider_than_the_terminal(width, arguments, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    lines = help_of(arguments, capsys)
    assert max(map(len, lines)) <= width
    assert not [line for line in lines if line != line.rstrip() and "│" not in line]


def test_every_command_is_in_one_group_with_a_sentence(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    grouped = [name for names in GROUPS.values() for name in names]
    assert sorted(grouped) == sorted(cli.COMMANDS) == sorted(LEAST)
    lines = help_of([], capsys)
    for title, names in GROUPS.items():
        below = lines[lines.index(title) + 1 :]
        told = below[: below.index("")]
        heads = [line.split()[0] for line in told if not line.startswith("   ")]
        assert heads == list(names)
        assert all(len(line.split()) > 2 for line in told if not line.startswith("   "))


@pytest.mark.parametrize("arguments", PAGES[1:], ids=" ".join)
def test_examples_stand_last_and_are_read(arguments, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    lines = help_of(arguments, capsys)
    shown = "\n".join(lines[lines.index("examples:") + 1 :]).replace("\\\n", " ")
    examples = [shlex.split(line) for line in shown.splitlines()]
    assert len(examples) >= 2
    for words in examples:
        if words[0] == "eval":
            words = shlex.split(words[1].removeprefix("$(").removesuffix(")"))
        words = words[1:] if "=" in words[0] else words
        words = words[: words.index(">")] if ">" in words else words
        given = words[1:]
        assert words[0] == "coopenv"
        assert given[: len(arguments)] == arguments
        if "--help" not in given and "--config" not in given:
            made = read(given, cli.COMMANDS)
            assert type(made.study if isinstance(made, Study) else made).examples


def test_help_on_a_terminal_that_is_very_narrow_is_still_told(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "10")
    assert "usage: coopenv COMMAND [OPTIONS]" in help_of([], capsys)


def test_an_unknown_option_of_a_study_is_told_its_name(capsys):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["study", "dyads", "--pair", "3"])
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert said == (
        "coopenv: option must be one of coopenv study dyads --help, got --pair; "
        "did you mean --pairs?" + os.linesep
    )
