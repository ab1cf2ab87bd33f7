"""The notebook runs from its first cell to its last, and its figure shows what it says."""

import json
from typing import Any

import pytest

from tests.docs.snippets import ROOT

NOTEBOOK = ROOT / "examples" / "recording_to_figure.ipynb"


def test_the_notebook_runs_and_draws_its_figure(tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {"__name__": "__main__"}
    for cell in cells:
        if cell["cell_type"] == "code":
            assert not cell["outputs"]  # outputs are made, not kept
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    assert (tmp_path / "fight.png").read_bytes().startswith(b"\x89PNG")
    level = names["level"]
    assert level[:20].max() < 1e-6 < 0.1 < level[20:].mean()  # no fight, then one
