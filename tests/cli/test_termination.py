"""SIGTERM, as Slurm and docker send it, ends a command as Ctrl-C does: nothing is half written."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.cli import signals
from tests.cli.test_program import TINY
from tests.logs import cases

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")

PATIENT = """
import os, signal, sys, time
from coopenv.cli import signals
signals.SAME = 0.1
with signals.interrupted_by_termination():
    try:
        print("ready", flush=True)
        time.sleep(60)
    finally:
        print("saving", flush=True)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            time.sleep(0.01)
"""


def terminate(*_, **__):
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(5)  # until it is handled
    raise AssertionError("it went on")


@pytest.fixture(autouse=True)
def handler():
    """Of whoever calls the command line, who finds it again."""

    def own(number, frame):
        raise AssertionError("the command line did not handle it")

    before = signal.signal(signal.SIGTERM, own)
    yield
    assert signal.getsignal(signal.SIGTERM) is own
    signal.signal(signal.SIGTERM, before)


def test_a_training_leaves_a_checkpoint_and_goes_on_from_it(tmp_path, monkeypatch, capsys):
    from coopenv.agents.training import progress

    means = progress.episode_means
    calls = []

    def terminated(ended):
        calls.append(ended)
        return means(ended) if len(calls) < 2 else terminate()

    options = [*TINY, "--episodes=2", "--no-gif", f"--out={tmp_path}"]
    with monkeypatch.context() as patch:
        patch.setattr(progress, "episode_means", terminated)
        assert cli.main(["train", *options]) == 143
    assert "holds 32 of 64 steps" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "checkpoint.zip",
        "config.json",
        "curves.csv",
        "tensorboard",
    ]
    assert cli.main(["train", *options]) == 0
    assert "at 32 of 64 steps" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("old", [True, False])
def test_an_evaluation_leaves_the_old_table_or_none(old, tmp_path, monkeypatch, capsys):
    table = tmp_path / "table.json"
    if old:
        table.write_text("old")
    monkeypatch.setattr("pathlib.Path.write_text", terminate)
    assert cli.main(["evaluate", "random", "--episodes=1", f"--out={table}"]) == 143
    assert capsys.readouterr().err.splitlines()[-1] == "coopenv: terminated"
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"] * old


def test_a_decomposition_leaves_nothing_half_written(tmp_path, monkeypatch, capsys):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    monkeypatch.setattr("coopenv.logs.run.Summary.save", terminate)
    assert cli.main(["decompose", str(path), "--grips", *map(str, cases.BEAM)]) == 143
    assert capsys.readouterr().err.splitlines()[-1] == "coopenv: terminated"
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("nth", range(2))
def test_a_signal_that_comes_before_a_temporary_file_is_removed_leaves_none(
    nth, tmp_path, monkeypatch
):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    unlink, seen = Path.unlink, []

    def struck(each, **given):
        seen.append(each)
        if len(seen) == nth + 1:
            terminate()
        unlink(each, **given)

    monkeypatch.setattr(Path, "unlink", struck)
    code = cli.main(["decompose", str(path), "--grips", *map(str, cases.BEAM), "--no-picture"])
    assert code == 143
    assert not [each.name for each in tmp_path.iterdir() if each.name.startswith(".")]


def test_a_study_leaves_nothing_half_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", terminate)
    assert cli.main(["study", "beam", f"--out={tmp_path}"]) == 143
    assert capsys.readouterr().err.splitlines()[-1] == "coopenv: terminated"
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGTERM, 143, "terminated"), (signal.SIGINT, 130, "interrupted")],
)
def test_an_error_that_compiled_code_makes_of_a_signal_is_named_and_no_fault_of_ours(
    number, code, said, tmp_path, monkeypatch, capsys
):
    def swallowed(*_, **__):
        try:
            os.kill(os.getpid(), number)
            time.sleep(5)
        except KeyboardInterrupt:
            raise ValueError("Invalid bounding box") from None

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", swallowed)
    assert cli.main(["study", "beam", f"--out={tmp_path}"]) == code
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == f"coopenv: {said}, while ValueError: Invalid bounding box"
    assert not [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_a_second_signal_ends_the_process_at_once():
    with subprocess.Popen(
        [sys.executable, "-c", PATIENT], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGTERM)
        assert process.stdout.readline() == "saving\n"
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.3)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == -signal.SIGTERM


def struck(number):
    """Send a signal, and stay until it was handled."""
    os.kill(os.getpid(), number)
    for _ in range(1000):
        time.sleep(0)


def ended(drop) -> signals.Termination:
    """What the command line was told when it went on after ``drop`` until it is interrupted."""
    with signals.interrupted_by_termination() as told:
        try:
            drop()
            gc.collect()  # what is part of a circle
            time.sleep(5)
        except KeyboardInterrupt:
            return told
    raise AssertionError("the signal was swallowed")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_that_finds_a_destructor_at_work_is_not_swallowed(number):
    class Dying:
        def __del__(self):
            struck(number)

    held = [Dying()]
    assert (ended(held.clear).since is not None) == (number == signal.SIGTERM)


def test_a_signal_that_finds_a_callback_of_the_garbage_collector_is_not_swallowed():
    left = [signal.SIGTERM]

    def callback(phase, info):
        while left:
            struck(left.pop())

    gc.callbacks.append(callback)
    try:
        assert ended(lambda: None).since is not None
    finally:
        gc.callbacks.remove(callback)


def test_a_signal_that_finds_pymunk_freeing_a_body_is_not_swallowed(monkeypatch):
    from pymunk import body

    class Library:
        def __getattr__(self, name):
            if name == "cpBodyFree":
                struck(signal.SIGTERM)
            return getattr(real, name)

    real = vars(body)["lib"]
    held = [body.Body(1.0, 1.0)]
    monkeypatch.setattr("pymunk.body.lib", Library())
    assert ended(held.clear).since is not None


def test_two_signals_at_once_count_as_one():
    told = signals.Termination()
    with pytest.raises(KeyboardInterrupt, match="terminated"):
        told.handle(signal.SIGTERM, None)
    told.handle(signal.SIGTERM, None)


def test_a_process_that_was_told_to_ignore_it_goes_on_ignoring_it():
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    with signals.interrupted_by_termination() as told:
        os.kill(os.getpid(), signal.SIGTERM)
    assert told.since is None
    signal.signal(signal.SIGTERM, before)


def test_other_threads_than_the_main_one_leave_signals_alone(capsys):
    codes = []
    thread = threading.Thread(target=lambda: codes.append(cli.main(["--version"])))
    thread.start()
    thread.join()
    assert codes == [0]


def test_an_interruption_by_hand_is_told_from_a_termination(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("coopenv.agents.evaluate.evaluate", interrupted)
    assert cli.main(["evaluate", "random"]) == 130
