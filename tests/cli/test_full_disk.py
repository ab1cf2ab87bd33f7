"""A disk that fills at any moment is told in one sentence, and leaves nothing half written."""

from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import cli
from coopenv.agents import curves
from coopenv.agents.training.checkpoint import Checkpoint
from tests.cli.test_program import TINY
from tests.logs import cases

resource = pytest.importorskip("resource", reason="files are limited by it")


@pytest.fixture
def run(capsys):
    """Run a command while no file may get longer than so many bytes; the line that it says."""

    def limited(size: int, *arguments) -> str:
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
        try:
            code = cli.main([str(argument) for argument in arguments])
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        said = capsys.readouterr().err
        assert "Traceback" not in said
        assert code == 1
        last = said.splitlines()[-1]
        assert last.startswith("coopenv: ")
        assert "File too large; the file gets too large: make room" in last
        return last

    return limited


def halves(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.name.startswith(".")]


@pytest.mark.parametrize(
    ("size", "named"),
    [(300, "config.json"), (9_700, "checkpoint.zip"), (30_000, "checkpoint.zip")],
)
def test_a_training_names_what_it_could_not_write(size, named, tmp_path, run):
    said = run(size, "train", *TINY, "--checkpoint-every=1", "--episodes=2", f"--out={tmp_path}")
    assert f"{tmp_path / named} must be writable" in said
    assert not halves(tmp_path)


def test_curves_that_find_no_room_lose_no_policy(tmp_path, run, undrawn, monkeypatch):
    monkeypatch.setattr(curves, "draw", undrawn)
    run(60_000, "train", *TINY, "--checkpoint-every=1", "--episodes=2", f"--out={tmp_path}")
    assert Checkpoint.read(tmp_path / "policy.zip").progress.steps == 64
    assert not halves(tmp_path)


def test_events_of_tensorboard_that_find_no_room_are_told_once(tmp_path, monkeypatch, capfd):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tensorboard.summary.writer.record_writer.RecordWriter.write", full)
    assert cli.main(["train", *TINY, "--episodes=2", f"--out={tmp_path}"]) == 1
    said = capfd.readouterr().err
    assert "Traceback" not in said
    assert f"{tmp_path} must be writable, got: No space left on device; the disk is full" in said
    assert not halves(tmp_path)


def test_a_gif_that_finds_no_room_is_told_after_the_table(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pygame")
    image = pytest.importorskip("PIL.Image").Image
    save = image.save

    def full(self, file, *arguments, **keywords):
        if keywords.get("format") == "GIF":
            raise OSError(28, "No space left on device")
        return save(self, file, *arguments, **keywords)

    monkeypatch.setattr(image, "save", full)
    assert cli.main(["train", *TINY, "--episodes=2", "--horizon=9", f"--out={tmp_path}"]) == 1
    assert "episode.gif must be writable, got: No space left" in capsys.readouterr().err
    assert (tmp_path / "table.csv").exists()
    assert (tmp_path / "policy.zip").exists()
    assert not halves(tmp_path)


def test_an_evaluation_leaves_the_old_table(tmp_path, run):
    table = tmp_path / "table.json"
    table.write_text("old")
    said = run(10, "evaluate", "random", "--episodes=1", f"--out={table}")
    assert f"{table} must be writable" in said
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".parquet"])
@pytest.mark.parametrize("size", [10, 30_000])
def test_a_decomposition_leaves_nothing(suffix, size, tmp_path, run):
    path = cases.save(cases.planar(rows=3000), tmp_path / "a.csv")
    table = tmp_path / f"table{suffix}"
    said = run(size, "decompose", path, f"--out={table}", "--grips", *cases.BEAM)
    assert f"{table} must be writable" in said
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize(("size", "named"), [(300, "claims.md"), (20_000, "motion_J1.png")])
def test_a_study_names_what_it_could_not_write(size, named, tmp_path, run):
    assert f"{tmp_path / named} must be writable" in run(size, "study", "beam", f"--out={tmp_path}")
    assert not halves(tmp_path)
