"""Tables in CSV have the same line ends on every system."""

from pathlib import Path

import pytest

from coopenv import TransportConfig
from coopenv.agents import curves
from coopenv.agents.controllers import ImpedanceController
from coopenv.agents.evaluate import evaluate, save
from coopenv.agents.studies import claims, series


def _evaluation(path):
    config = TransportConfig(horizon=1)
    save([evaluate(ImpedanceController(config), config, episodes=1)], path)


WRITERS = {
    "evaluation": _evaluation,
    "learning curves": lambda path: curves.save_rows([{"steps": 1.0}], path),
    "claims of a study": lambda path: claims.save_rows([{"claim": "a"}], path.with_suffix("")),
    "series of a study": lambda path: series.save_columns({"time": [0.0]}, path),
}


@pytest.fixture
def _windows(monkeypatch):
    """Text is written as Windows writes it: each line feed with a carriage return before it."""
    plain = Path.open

    def opened(path, mode="r", buffering=-1, encoding=None, errors=None, newline=None):
        if "b" not in mode and newline is None:
            newline = "\r\n"
        return plain(path, mode, buffering, encoding, errors, newline)

    monkeypatch.setattr(Path, "open", opened)


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.usefixtures("_windows")
def test_a_table_ends_its_lines_as_csv_does_on_windows_too(kind, tmp_path):
    WRITERS[kind](tmp_path / "a.csv")
    content = (tmp_path / "a.csv").read_bytes()
    assert content.endswith(b"\r\n")
    assert content.count(b"\r\n") == content.count(b"\r") == content.count(b"\n") == 2
