"""Two trainings in one folder: the second is told who is at work there."""

import os
import threading

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents.train import train
from coopenv.errors import InvalidInput
from coopenv.files import locked
from tests.agents.training.cases import SHORT, tiny


@pytest.mark.parametrize("fresh", [False, True])
def test_a_second_training_in_the_folder_is_refused_and_the_first_goes_on(fresh, tmp_path):
    told = []

    def second():
        try:
            train(tiny(tmp_path, steps=64, fresh=fresh), environment=SHORT, tell=told.append)
        except InvalidInput as error:
            told.append(error)

    def report(row):
        thread = threading.Thread(target=second)
        thread.start()
        thread.join()

    policy = train(tiny(tmp_path, steps=64), environment=SHORT, report=report)
    assert policy.model.num_timesteps == 64
    assert len(told) == 2
    for error in told:
        assert isinstance(error, InvalidInput)
        assert f"process {os.getpid()} on" in str(error)
    assert (tmp_path / "policy.zip").exists()
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_the_command_keeps_the_folder_while_it_evaluates(tmp_path, monkeypatch, capsys):
    pytest.importorskip("tyro")
    from coopenv import cli
    from coopenv.agents import evaluate

    compare, told = evaluate.compare, []

    def work():
        try:
            with locked(tmp_path):
                pass
        except InvalidInput as error:
            told.append(error)

    def watched(*arguments, **keywords):
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        return compare(*arguments, **keywords)

    monkeypatch.setattr(evaluate, "compare", watched)
    options = ("--steps=64", "--num-worlds=4", "--rollout=8", "--batch-size=16", "--hidden=8")
    assert cli.main(["train", *options, "--episodes=2", "--no-gif", f"--out={tmp_path}"]) == 0
    assert len(told) == 1
    work()
    assert len(told) == 1


def test_a_training_removes_what_killed_ones_left_in_its_folder(tmp_path):
    from coopenv.files import written

    child = os.fork()
    if not child:
        with written(tmp_path / "table.csv"):
            os.kill(os.getpid(), 9)
    os.waitpid(child, 0)
    assert len(list(tmp_path.iterdir())) == 1
    train(tiny(tmp_path, steps=64), environment=SHORT)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
