"""``coopenv experiment``, ``sweep`` and ``report`` on the command line."""

import io
import re
import sys
from contextlib import contextmanager

import pytest

pytest.importorskip("tyro")
pytest.importorskip("matplotlib")

from rich.console import Console

from coopenv import cli
from coopenv.agents import experiments
from coopenv.agents.experiments import conduct, run
from coopenv.cli.progress import bar_over
from tests.agents.experiments.cases import TEXT, files, here, no_pictures, small
from tests.agents.experiments.nodes.cases import Threads


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(TEXT)
    return path


@pytest.fixture(autouse=True)
def _here(monkeypatch):
    """Cells are worked on in this process."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(run.Processes, "__call__", lambda self, *given: here(*given))
    with no_pictures():
        yield


def test_an_experiment_runs_reports_and_is_not_repeated(file, tmp_path, capsys):
    out = tmp_path / "out"
    command = ["experiment", str(file), f"--out={out}", "--workers=1"]
    assert cli.main(command) == 0
    printed = capsys.readouterr().out
    assert "0 of 10 cells\n" in printed
    assert re.search(r"[1-9] of 10 cells, \d:\d\d:\d\d left", printed)
    assert "10 of 10 cells\n" in printed
    assert "tiny: interquartile mean" in printed
    assert re.search(r"^ *setting +runs +\w", printed, re.MULTILINE)
    page = (out / "report" / "report.md").read_bytes()
    results = {path: path.stat().st_mtime_ns for path in out.glob("cells/*/*/*")}
    assert cli.main(command) == 0
    assert {path: path.stat().st_mtime_ns for path in out.glob("cells/*/*/*")} == results
    (out / "report" / "report.md").unlink()
    assert cli.main(["report", str(out)]) == 0
    assert (out / "report" / "report.md").read_bytes() == page


def test_a_dry_run_says_what_it_comes_to_and_writes_nothing(file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["experiment", str(file), "--dry-run"]) == 0
    printed = capsys.readouterr().out
    assert "reward (3): none, squeeze, share" in printed
    assert "10 cells, 0 control steps of training" in printed
    assert cli.main(["sweep", "wasted_cost", "0", "0.1", "--seeds=2", "--dry-run"]) == 0
    assert "4 cells, 3,600,000 control steps" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["tiny.toml"]


def test_a_mistake_ends_the_command_before_anything_is_written(file, tmp_path, capsys):
    text = TEXT.replace("LoadShare", "LodShare")
    file.write_text(text)
    out = tmp_path / "out"
    assert cli.main(["experiment", str(file), f"--out={out}"]) == 1
    said = capsys.readouterr().err
    assert "did you mean 'LoadShare'" in said
    assert f"line {text.partition('LodShare')[0].count(chr(10)) + 1}" in said
    assert said.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize("dry", [[], ["--dry-run"]])
@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--tune=2", "write [search.space] into the file"),
        ("--tune=-1", "tune must be a whole number of at least 0"),
        ("--workers=0", "workers must be a whole number of at least 1"),
    ],
)
def test_an_option_that_breaks_its_rule_is_refused_before_anything_is_written(
    option, said, dry, file, tmp_path, capsys
):
    out = tmp_path / "out"
    assert cli.main(["experiment", str(file), f"--out={out}", option, *dry]) == 1
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_a_grid_on_rays_nodes_says_which_and_leaves_the_same_report(
    file, tmp_path, monkeypatch, capsys
):
    asked = []

    class Nodes(Threads):
        def __str__(self):
            return "Ray: 3 nodes, 24 cores"

    @contextmanager
    def joined(address):
        asked.append(address)
        yield Nodes()

    monkeypatch.setattr(experiments, "joined", joined)
    outs = [tmp_path / name for name in ("here", "there")]
    for out, options in zip(outs, ([], ["--ray", "--address=auto"]), strict=True):
        assert cli.main(["experiment", str(file), f"--out={out}", *options]) == 0
    assert asked == ["auto"]
    assert capsys.readouterr().out.count("Ray: 3 nodes, 24 cores") == 1
    assert files(outs[0]) == files(outs[1])


def test_a_grid_asks_for_ray_only_where_it_is_wanted_and_there(file, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ray", None)
    out = tmp_path / "out"
    assert cli.main(["experiment", str(file), f"--out={out}", "--ray"]) == 1
    assert "pip install 'coopenv[ray]'" in capsys.readouterr().err
    assert cli.main(["experiment", str(file), f"--out={out}", "--address=auto"]) == 1
    assert "address must come with ray, got 'auto'" in capsys.readouterr().err
    assert cli.main(["experiment", str(file), "--ray", "--dry-run"]) == 0
    assert not out.exists()


def test_a_failure_is_the_exit_code_and_the_report_is_written(file, tmp_path, monkeypatch, capsys):
    def failing(self, folder, report):
        return "it broke" if "share" in str(folder) else here(folder, report)

    monkeypatch.setattr(run.Processes, "__call__", failing)
    out = tmp_path / "out"
    assert cli.main(["experiment", str(file), f"--out={out}", "--workers=1"]) == 1
    said = capsys.readouterr().err
    assert "got 4 of 10 that failed" in said
    assert "it broke" in said
    assert "6 of 10 cells are finished" in (out / "report" / "report.md").read_text()


def test_an_interruption_says_how_to_go_on(file, tmp_path, monkeypatch, capsys):
    def interrupted(*_, **given):
        raise KeyboardInterrupt

    monkeypatch.setattr(experiments, "conduct", interrupted)
    assert cli.main(["experiment", str(file), f"--out={tmp_path / 'out'}"]) == 130
    assert "the same command goes on" in capsys.readouterr().err


def test_a_report_of_nothing_is_refused(tmp_path, capsys):
    assert cli.main(["report", str(tmp_path)]) == 1
    assert "no experiment.json" in capsys.readouterr().err
    experiment = small(tmp_path / "out")
    conduct(experiment, launch=lambda folder, report: "no", workers=1)
    assert cli.main(["report", str(experiment.out)]) == 1
    assert "which has none of 4" in capsys.readouterr().err


def test_on_a_terminal_a_bar_counts_cells_and_steps():
    text = io.StringIO()
    console = Console(file=text, force_terminal=True, width=120)
    with bar_over(console) as show:
        show(done=30.0, total=120.0, cells=1, of=4)
    printed = text.getvalue()
    assert "1 of 4 cells" in printed
    assert "25 %" in printed
