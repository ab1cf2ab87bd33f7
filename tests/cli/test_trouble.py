"""The command line in trouble: one line that names what to mend, before the work, no traceback."""

import os
import subprocess
import sys
import zipfile

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.agents import evaluate, train
from tests.cli.test_program import TINY

LONG = 300 * "x"


@pytest.fixture
def complaint(monkeypatch, capsys):
    """Run a command that must not begin its work, and return the one line that it says."""

    def worked(*_, **__):
        raise AssertionError("the work was begun")

    def run(*arguments) -> str:
        monkeypatch.setattr(train, "train", worked)
        monkeypatch.setattr(evaluate, "compare", worked)
        monkeypatch.setattr(evaluate, "evaluate", worked)
        for study in ("Beam", "WalkerTurn", "WalkerAvoid", "Dyads"):
            monkeypatch.setattr(f"coopenv.agents.studies.commands.{study}.run", worked)
        assert cli.main([str(argument) for argument in arguments]) == 1
        printed = capsys.readouterr()
        assert not printed.out
        assert printed.err.startswith("coopenv: ")
        assert printed.err.count("\n") == 1
        return printed.err

    return run


OUTPUTS = {
    "train": ("train", *TINY, "--out"),
    "study": ("study", "beam", "--out"),
}


@pytest.mark.parametrize("command", OUTPUTS.values(), ids=OUTPUTS)
def test_a_folder_that_cannot_be_written_is_refused_before_the_work(command, tmp_path, complaint):
    file = tmp_path / "file"
    file.write_text("")
    assert "out must be a folder, got the file" in complaint(*command, file)
    assert "file/below must be writable" in complaint(*command, file / "below")
    assert "File name too long; check its name" in complaint(*command, tmp_path / LONG)
    assert "must be writable" in complaint(*command, "/proc/here")
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_a_table_that_cannot_be_written_is_refused_before_the_work(
    tmp_path, complaint, monkeypatch
):
    table = ("evaluate", "random", "--out")
    (tmp_path / "folder.csv").mkdir()
    assert "got a folder" in complaint(*table, tmp_path / "folder.csv")
    assert "must end in .json or .csv" in complaint(*table, tmp_path / "table.txt")
    assert "File name too long" in complaint(*table, tmp_path / f"{LONG}.csv")
    assert "/proc/t.csv must be writable" in complaint(*table, "/proc/t.csv")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("coopenv.files.checks.begin", full)
    said = complaint(*table, tmp_path / "new" / "table.csv")
    assert "No space left on device; the disk is full: make room" in said
    assert [each.name for each in tmp_path.iterdir()] == ["folder.csv"]


def test_a_disk_that_fills_during_the_work_is_told(tmp_path, monkeypatch, capsys):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    table = tmp_path / "table.json"
    assert cli.main(["evaluate", "random", "--episodes=1", f"--out={table}"]) == 1
    assert f"{table} must be writable, got: No space left" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("--steps=0", "steps must be"),
        ("--episodes=0", "episodes must be a whole number of at least 1, got 0"),
        ("--episodes=-3", "episodes must be"),
        ("--episodes=10000000", "at most 1048576 worlds"),
        ("--num-worlds=0", "num_worlds must be a whole number of at least 1, got 0"),
        ("--num-worlds=10000000", "num_worlds must be at most"),
        (f"--steps={10**40}", "steps must be at most 1,000,000,000,000"),
        ("--seed=-1", "seed must be a whole number of at least 0"),
        ("--seed=100000000000000000000", "seed must be below 2048"),
        ("--hidden=0", "hidden must be a whole number of at least 1"),
        ("--batch-size=1", "batch_size must be a whole number of at least 2"),
        ("--learning-rate=1e30", "learning_rate must be at most 1"),
        ("--learning-rate=nan", "learning_rate must be"),
        ("--entropy-weight=nan", "entropy_weight must be finite"),
        ("--initial-std=1e300", "initial_std must be at most"),
        ("--clip-range=1e300", "clip_range must be at most"),
        ("--threads=100000000000", "threads must be at most"),
    ],
)
def test_a_number_that_makes_no_sense_is_refused_before_the_work(
    option, message, tmp_path, complaint
):
    assert message in complaint("train", *TINY, f"--out={tmp_path / 'run'}", option)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "option",
    ["--episodes=0", "--episodes=10000000", "--num-worlds=0", "--seed=-1", "--seed=99999999"],
)
def test_numbers_of_an_evaluation_are_checked_before_it(option, complaint):
    assert "must be" in complaint("evaluate", "random", option)


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x05\x06" + bytes(18), os.urandom(999)])
def test_a_file_that_is_no_policy_is_named(content, tmp_path, complaint):
    path = tmp_path / "policy.zip"
    path.write_bytes(content)
    said = complaint("evaluate", path)
    assert "policy must be a file that" in said
    assert repr(str(path)) in said


def test_a_name_too_long_for_a_file_is_told(complaint):
    assert "File name too long" in complaint("evaluate", LONG)


@pytest.mark.parametrize("content", ['{"steps": ', "[1]", "3", '{"environment": {"envv": 3}}', "�"])
def test_a_broken_configuration_beside_a_policy_is_named(content, tmp_path, complaint):
    with zipfile.ZipFile(tmp_path / "policy.zip", "w") as archive:  # which does not say where from
        for member in ("data", "policy.pth"):
            archive.writestr(member, "")
    beside = tmp_path / "config.json"
    beside.write_bytes(content.encode("latin-1", errors="replace"))
    assert str(beside) in complaint("evaluate", tmp_path / "policy.zip")


@pytest.mark.parametrize("option", ["--layout=lab.toml", "--platform 0 0 1 1"])
def test_options_for_files_without_files_are_not_ignored(option, tmp_path, capsys):
    assert cli.main(["study", "dyads", *option.split(), f"--out={tmp_path}"]) == 1
    assert "must come with files of recorded trials" in capsys.readouterr().err


@pytest.mark.parametrize(
    "error",
    [MemoryError("Unable to allocate 640 TiB"), RuntimeError("DefaultCPUAllocator: can't "
     "allocate memory: you tried to allocate 1760000000000 bytes")],
)  # fmt: skip
def test_memory_that_does_not_suffice_is_told(error, monkeypatch, capsys):
    def starved(*_, **__):
        raise error

    monkeypatch.setattr(evaluate, "evaluate", starved)
    assert cli.main(["evaluate", "random"]) == 1
    assert f"memory must suffice, got: {error}" in capsys.readouterr().err


@pytest.mark.parametrize("error", [RuntimeError("ours"), KeyError("ours"), ValueError("ours")])
def test_an_error_of_our_own_keeps_its_traceback(error, monkeypatch):
    def wrong(*_, **__):
        raise error

    monkeypatch.setattr(evaluate, "evaluate", wrong)
    with pytest.raises(type(error), match="ours"):
        cli.main(["evaluate", "random"])


def test_trouble_that_names_no_file_is_told_too(monkeypatch, capsys):
    def no_place(*_, **__):
        raise FileNotFoundError(2, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr(evaluate, "evaluate", no_place)
    assert cli.main(["evaluate", "random"]) == 1
    assert "No usable temporary directory found" in capsys.readouterr().err


def shell(script: str, **environment: str) -> subprocess.CompletedProcess:
    """Run a script in which ``$C`` is the command, and return what came of it."""
    return subprocess.run(
        ["bash", "-c", f"set -o pipefail; C='{sys.executable} -m coopenv'; {script}"],
        capture_output=True,
        text=True,
        errors="replace",
        env={**os.environ, "COLUMNS": "80", **environment},
    )


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="of Linux")
@pytest.mark.parametrize("command", ["--version", "evaluate random --episodes 1"])
def test_an_output_that_is_full_is_told_in_one_line(command):
    done = shell(f"$C {command} >/dev/full")
    assert done.returncode == 1
    assert done.stderr.startswith("coopenv: the output must be usable, got: No space left")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["--version", "--help", "evaluate random --episodes 1"])
def test_a_pipe_that_is_closed_ends_it_without_a_word(command):
    done = shell(f"$C {command} | (exec 0<&-; sleep 0.1)")
    assert not done.stderr
    assert done.returncode in (0, 1)


@pytest.mark.parametrize("encoding", ["ascii", "cp437"])
def test_a_terminal_without_greek_letters_shows_tables(encoding):
    done = shell("$C evaluate random --episodes 1", PYTHONIOENCODING=encoding)
    assert done.returncode == 0, done.stderr
    assert "F_I" in done.stdout


def test_a_terminal_without_greek_letters_shows_help_and_refusals():
    assert shell("$C train --help", PYTHONIOENCODING="ascii").returncode == 0
    refused = shell("$C evaluate scripted:γ", PYTHONIOENCODING="ascii")
    assert refused.returncode == 1
    assert "Traceback" not in refused.stderr
