"""Threads of torch while a run trains and is evaluated."""

import sys

import pytest

pytest.importorskip("torch")
pytest.importorskip("tyro")

import torch

from coopenv.agents import evaluate
from coopenv.agents.training.threads import torch_threads
from coopenv.cli.evaluate import Evaluate
from coopenv.cli.train import Train
from tests.agents.training.cases import tiny


@pytest.fixture
def three():
    """Torch with three threads, as many as nobody asks for."""
    before = torch.get_num_threads()
    torch.set_num_threads(3)
    yield
    torch.set_num_threads(before)


@pytest.mark.usefixtures("three")
def test_threads_are_as_before_afterwards_also_after_an_error():
    with torch_threads(1):
        assert torch.get_num_threads() == 1
    assert torch.get_num_threads() == 3
    with pytest.raises(KeyError), torch_threads(2):
        raise KeyError
    assert torch.get_num_threads() == 3


def test_torch_is_not_imported_for_it(monkeypatch):
    monkeypatch.delitem(sys.modules, "torch")
    with torch_threads(1):
        assert "torch" not in sys.modules


@pytest.mark.usefixtures("three")
def test_the_commands_evaluate_with_one_thread(tmp_path, monkeypatch):
    """As many threads as cores take many times as long for batches of this size."""
    counts = []
    original = evaluate.run_episodes

    def counted(*args, **options):
        counts.append(torch.get_num_threads())
        return original(*args, **options)

    monkeypatch.setattr(evaluate, "run_episodes", counted)
    Train(training=tiny(tmp_path / "run"), episodes=2, gif=False).run()
    Evaluate(policies=("scripted",), episodes=2).run()
    assert counts == [1] * 5  # trained, by mean and by samples, random, scripted; and scripted
    assert torch.get_num_threads() == 3
