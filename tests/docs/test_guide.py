"""The guide on recordings ends near what truly happened in the laboratory of its example."""

import numpy as np
import pytest

from benchmarks.recordings import PAGE
from coopenv.logs import Layout, analyse, read
from examples import record_laboratory
from tests.docs.snippets import snippets
from tests.logs import cases

LAYOUT = next(each.code for each in snippets(PAGE) if each.file == "laboratory.toml")
MEASURES = ("internal_force_level", "internal_torque_level", "relative_cost")


def truly(trial, at):
    """Columns of what the hands applied at those times, object frame."""
    rows = np.searchsorted(trial["time"], at - 1e-6)
    columns = {"time": at}
    for i in (1, 2):
        read_by = trial["wrenches"][rows, i - 1]
        names = [f"{kind}{i}{axis}" for kind in "ft" for axis in "xyz"]
        columns |= dict(zip(names, read_by.T, strict=True))
        grip = record_laboratory.GRIPS[i - 1]
        columns |= {f"r{i}{a}": np.full(len(at), grip[j]) for j, a in enumerate("xyz")}
    return columns


def test_the_guides_layout_gives_what_truly_happened_to_a_hundredth(tmp_path, capsys):
    pytest.importorskip("pyarrow")
    trial = record_laboratory.main(tmp_path, np.random.default_rng(0))
    assert "mocap.csv: 2,000 rows" in capsys.readouterr().out
    (tmp_path / "laboratory.toml").write_text(LAYOUT, encoding="utf-8")
    recording = read(tmp_path / "mocap.csv", Layout.load(tmp_path / "laboratory.toml"))
    assert len(recording.done) == 7
    seen = recording.take(slice(5, -5, 15))
    truth = read(cases.save(truly(trial, seen.time), tmp_path / "truth.npz"), Layout())
    got, wanted = analyse(seen), analyse(truth)
    for name in MEASURES:
        size = np.abs(wanted[name]).max()
        assert np.abs(got[name] - wanted[name]).mean() < 0.01 * size, name
    assert wanted["internal_force_level"].max() > 20.0
