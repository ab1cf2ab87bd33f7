"""``--config`` for every command: options by their names, checked, and those given win."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.cli.options.files import before
from coopenv.cli.options.reading import read
from coopenv.errors import InvalidInput
from tests.cli.commands import LEAST


def command(*arguments: str) -> Any:
    return read(arguments, cli.COMMANDS)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def write(text: str) -> Path:
        path = tmp_path / "options.toml"
        path.write_text(text)
        return path

    return write


CASES = {
    "experiment": ('file = "a.toml"\nworkers = 2\ndry-run = true', {"workers": 2, "dry_run": True}),
    "sweep": ('term = "time"\nvalues = [0, 1]\nsteps = 20_000\nseeds = 2', {"values": (0.0, 1.0)}),
    "report": ('folder = "runs/a"', {"folder": Path("runs/a")}),
    "benchmark": ('entries = ["random"]\nsuites = ["team"]\ndry-run = true',
                  {"entries": ("random",), "suites": ("team",), "dry_run": True}),
    "show": ("applied = [3, 0, 0, -1, 0, 0]\ngrips = [-1, 0, 1, 0]\nregions = false",
             {"grips": (-1.0, 0.0, 1.0, 0.0), "regions": False}),
    "replay": ('what = "scripted"\nfps = 10\nout = "a.mp4"', {"fps": 10.0, "out": Path("a.mp4")}),
    "decompose": ('file = "t.csv"\ngrips = [-1, 0, 1, 0]\nmap = ["f1x=Fx"]',
                  {"map": ("f1x=Fx",), "grips": (-1.0, 0.0, 1.0, 0.0)}),
    "inspect": ('files = ["a.csv", "b.csv"]', {"files": (Path("a.csv"), Path("b.csv"))}),
    "warmup": ("json = true", {}),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_file_says_everything_that_a_command_can_be_given(name, file):
    text, values = CASES[name]
    made = command(name, "--config", str(file(text)))
    assert values == {each: getattr(made, each) for each in values}
    assert made.common.json is (name == "warmup")


def test_what_is_given_wins_by_name_and_by_place(file):
    path = str(file('file = "a.csv"\nmethod = "moore_penrose"\nforce = "kN"'))
    made = command("decompose", "b.csv", f"--config={path}", "--force", "lbf")
    assert (made.file, made.method, made.force) == (Path("b.csv"), "moore_penrose", "lbf")


def test_numbers_of_an_environment_are_taken_together(file):
    path = str(file('[environment]\nenv = "coopenv/BeamDoorway-v0"\nbody = {mass = 4}'))
    for line in (["replay", "random"], ["sweep", "time", "0"]):
        made = command(*line, "--config", path, "--body", "linear_drag=2")
        choice = made.environment if line[0] == "replay" else made.training.environment
        assert choice.env == "coopenv/BeamDoorway-v0"
        assert (choice.config().body.mass, choice.config().body.linear_drag) == (4.0, 2.0)


def test_a_study_has_its_own_options(file):
    path = str(file("pairs = 3\napproach = [0.5, 0.9]\nout = 'runs/few'\njson = true"))
    made = command("study", "dyads", "--config", path, "--trials", "2").study
    assert (made.simulation.pairs, made.simulation.trials) == (3, 2)
    assert made.simulation.people.approach == (0.5, 0.9)
    assert (made.out, made.common.json) == (Path("runs/few"), True)


@pytest.mark.parametrize("name", [name for name in LEAST if name != "completion"])
def test_an_unknown_name_is_refused_with_the_nearest(name, file, capsys):
    line = [name, *LEAST[name], "--config", str(file("jsno = true\nepisodse = 3"))]
    assert cli.main(line) == 1
    said = capsys.readouterr().err
    assert "must be one of the known names, got 'jsno'" in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("decompose", "methd = 'optimal'", "did you mean 'method'"),
        ("decompose", "config = 'other.toml'", "got 'config'"),
        ("decompose", "map = 'f1x=Fx'", "map must be a list, got 'f1x=Fx'"),
        ("decompose", "check = 1", "check must be true or false, got 1"),
        ("show", "row = 1.5", "row must be a whole number, got 1.5"),
        ("show", "grips = ['a']", "grips must be a number, got 'a'"),
        ("show", "regions = 'no'", "regions must be true or false, got 'no'"),
        ("replay", "fps = true", "fps must be a number, got True"),
        ("replay", f"speed = 1{400 * '0'}", "speed must be a number that a computer can hold"),
        ("replay", f"speed = 0x{5000 * 'f'}", "speed must be a number that a computer can hold"),
        ("sweep", "num-worlds = 3\nnum_worlds = 4", "must be said once, got 'num-worlds' and"),
        ("replay", "out = 3", "out must be the name of a place, got 3"),
        ("replay", "method = 'optimal'", "got 'method'"),
        ("replay", "[environment]\nhorizn = 3", "did you mean 'horizon'"),
        ("replay", "[environment]\nenv = 'mine:Mine-v0'", "would import and run 'mine'"),
        ("sweep", "control = 'jont'", "control must be one of the known names, got 'jont'; did"),
        ("sweep", "fresh = true", "fresh must be given on the command line"),
        ("study", "duration = 'long'", "duration must be a number, got 'long'"),
        ("inspect", "= 3", "must be whole and of the format"),
    ],
)
def test_what_is_wrong_in_a_file_is_one_line(name, text, says, file, capsys):
    assert cli.main([name, *LEAST[name], "--config", str(file(text))]) == 1
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1


def test_a_file_of_no_command_is_no_traceback(file, capsys):
    path = str(file("json = true"))
    for line in (["study", "--config", path], ["completion", "bash", "--config", path]):
        with pytest.raises(SystemExit) as stopped:
            cli.main(line)
        assert stopped.value.code == 2
        assert "Traceback" not in capsys.readouterr().err


@dataclass(frozen=True, kw_only=True)
class Long:
    """A part."""

    pairs: int | None = 4
    config: Path | None = None


@dataclass(frozen=True, kw_only=True)
class Short:
    """Another."""

    trials: int = 1
    config: Path | None = None


@dataclass(frozen=True, kw_only=True)
class Either:
    """A command of parts with an option of its own."""

    part: Long | Short
    loud: bool = False


def test_a_command_of_parts_may_have_options_of_its_own(file):
    line = ["either", "long", "--config", str(file("pairs = 3"))]
    assert before(line, {"either": Either}, None) == Either(part=Long(pairs=3, config=None))


def test_nothing_is_said_in_json_where_an_option_may_be_nothing(tmp_path):
    path = tmp_path / "options.json"
    path.write_text('{"pairs": null}')
    made = before(["long", "--config", str(path)], {"long": Long}, None)
    assert made == Long(pairs=None)
    path.write_text('{"trials": null}')
    with pytest.raises(InvalidInput, match="trials must be a whole number, got None"):
        before(["short", "--config", str(path)], {"short": Short}, None)
