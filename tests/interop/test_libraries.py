"""The runner of other libraries' scripts, and those scripts whose libraries our tests have."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from coopenv.errors import UnknownName
from tests.interop import __main__ as runner

BESIDE = [name for name in runner.libraries() if runner.pins(name).stem == "beside"]
MODULES = {"cleanrl": "torch"}  # of a script whose name is not that of its library


def test_every_script_has_its_versions_and_every_file_of_versions_its_script():
    files = {path.stem for path in (runner.HERE / "requirements").glob("*.txt")}
    assert files - {"beside"} == set(runner.libraries())
    assert all(runner.pins(name).is_file() for name in runner.libraries())


def test_the_page_has_a_row_for_every_library():
    commands = [f'`make interop ARGS="--only {name}"`' for name in runner.libraries()]
    assert list(runner.page_rows()) == commands
    text = runner.PAGE.read_text(encoding="utf-8")
    assert all(name in text for name in runner.ABSENT)


@pytest.mark.parametrize("name", BESIDE)
def test_a_library_beside_ours_does_what_its_script_asserts(name: str):
    module = MODULES.get(name, name)
    if not importlib.util.find_spec(module):
        pytest.skip(f"needs {module}")
    told = runner.run(name, Path(sys.executable))
    assert len(told["ids"]) >= 2
    assert told["checked"]


def test_an_environment_is_made_once_and_installed_into_again_when_its_versions_change(
    tmp_path, monkeypatch
):
    called = []

    def call(command, seconds, cwd=None):
        called.append(command)
        (tmp_path / "versions" / "bin").mkdir(parents=True, exist_ok=True)
        (tmp_path / "versions" / "bin" / "python").touch()
        return ""

    monkeypatch.setattr(runner, "_call", call)
    versions = tmp_path / "versions.txt"
    versions.write_text("x==1")
    for _ in range(2):
        python = runner.environment(versions, tmp_path)
        assert python == tmp_path / "versions" / "bin" / "python"
    assert [command[1:3] for command in called] == [["-m", "venv"], ["-m", "pip"]]
    assert called[1][4] == str(tmp_path / "versions" / "bin" / "python")
    assert called[1][-4:] == ["-r", str(versions), "-e", str(runner.ROOT)]
    versions.write_text("x==2")
    runner.environment(versions, tmp_path)
    assert [command[1:3] for command in called[2:]] == [["-m", "pip"]]


GOOD = """
import json, sys, tempfile
from pathlib import Path
import examples.of_ours
assert Path(sys.path[0]).parent == Path(tempfile.gettempdir())  # not the folder of the scripts
print("noise")
print(json.dumps({"library": "Good", "version": "1", "ids": ["coopenv/A-v0"], "checked": "a | b"}))
"""


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """A folder with a script that fails and one that does not, and no installing."""
    for name, text in (("bad", "raise SystemExit('what broke')"), ("good", GOOD)):
        for folder, suffix, held in (("libraries", "py", text), ("requirements", "txt", "x==1")):
            (tmp_path / folder).mkdir(exist_ok=True)
            (tmp_path / folder / f"{name}.{suffix}").write_text(held)
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "of_ours.py").write_text("")
    monkeypatch.setattr(runner, "HERE", tmp_path)
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "PAGE", tmp_path / "page.md")
    (tmp_path / "page.md").write_text("<!-- libraries -->\n<!-- libraries -->\n")
    monkeypatch.setattr(runner, "environment", lambda versions, folder: Path(sys.executable))
    return tmp_path


def test_the_runner_goes_on_after_a_failure_and_says_so(scripts, capsys):
    out = scripts / "out"
    assert runner.main(["--folder", str(out)]) == 1
    said = capsys.readouterr().out
    assert "[1/2] bad" in said
    assert "what broke in" in said
    assert "[2/2] good" in said
    assert "passed in" in said
    assert "| fails: what broke |" in said
    assert "| Good | 1 |" in said
    assert "a / b" in said
    assert json.loads((out / "good.json").read_text())["ids"] == ["coopenv/A-v0"]
    assert runner.main(["--folder", str(out), "--only", "good"]) == 0


def test_a_row_that_is_not_run_stays_on_the_page(scripts):
    out = scripts / "out"
    runner.main(["--folder", str(out), "--only", "good", "--write"])
    kept = runner.page_rows()
    assert [row[0] for row in kept.values()] == ["Good"]
    (out / "good.json").unlink()
    runner.main(["--folder", str(out), "--only", "bad", "--write"])
    assert [row[0] for row in runner.page_rows().values()] == ["bad", "Good"]


def test_a_library_that_is_not_known_is_refused(scripts):
    with pytest.raises(UnknownName, match=r"library must be .* known: bad, good"):
        runner.main(["--only", "goud"])
