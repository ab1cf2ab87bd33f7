"""Exit codes: the same for every command."""

import os
import re
import signal
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.errors import InvalidInput
from tests.cli.commands import LEAST

NAMES = [*cli.COMMANDS]


def stopped(*arguments: str) -> int | str | None:
    with pytest.raises(SystemExit) as raised:
        cli.main(arguments)
    return raised.value.code


def run_as(name: str, does, monkeypatch) -> int:
    monkeypatch.setattr(cli.COMMANDS[name], "run", does)
    return cli.main([name, *LEAST[name]])


def refuse(command):
    raise InvalidInput("mass must be positive, got -1; give another")


def fill_the_disk(command):
    raise OSError(28, "No space left on device", "table.csv")


def interrupt(command):
    raise KeyboardInterrupt


def terminate(command):
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(5)
    raise AssertionError("it went on")


@pytest.mark.parametrize("name", NAMES)
def test_help_is_0_and_options_that_make_no_sense_are_2(name, capsys):
    assert stopped(name, "--help") == 0
    assert stopped(name, *LEAST[name], "--nonesuch") == 2
    assert "coopenv" in capsys.readouterr().err


@pytest.mark.parametrize("name", NAMES)
def test_done_is_0_and_refused_or_failed_is_1_with_the_reason(name, monkeypatch, capsys):
    assert run_as(name, lambda command: None, monkeypatch) == 0
    assert not capsys.readouterr().err
    assert run_as(name, refuse, monkeypatch) == 1
    assert capsys.readouterr().err == "coopenv: mass must be positive, got -1; give another\n"
    assert run_as(name, fill_the_disk, monkeypatch) == 1
    assert "table.csv" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")
@pytest.mark.parametrize("name", NAMES)
def test_interrupted_is_130_and_terminated_143(name, monkeypatch, capsys):
    assert run_as(name, interrupt, monkeypatch) == 130
    assert capsys.readouterr().err == "coopenv: interrupted\n"
    assert run_as(name, terminate, monkeypatch) == 143
    assert capsys.readouterr().err == "coopenv: terminated\n"


def test_the_page_of_commands_lists_them_all():
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| (\d+) \|", page, flags=re.MULTILINE)
    assert listed == ["0", "1", "2", "130", "143"]
