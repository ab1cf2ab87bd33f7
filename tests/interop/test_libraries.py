"""The runner of other libraries' scripts, and those scripts whose libraries our tests have."""

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from coopenv.errors import UnknownName
from tests.interop import __main__ as runner

BESIDE = [name for name in runner.libraries() if runner.pins(name).stem == "beside"]
MODULES = {"cleanrl": "torch"}  # of a script whose name is not that of its library
MARK = "-- script "
ONE_BY_ONE = f"""
import sys, traceback
from importlib import import_module
for name in sys.argv[1:]:
    print("{MARK}" + name, flush=True)
    try:
        import_module("tests.interop.libraries." + name).main()
    except Exception:
        traceback.print_exc(file=sys.stdout)
"""


def test_every_script_has_its_versions_and_every_file_of_versions_its_script():
    files = {path.stem for path in (runner.HERE / "requirements").glob("*.txt")}
    assert files - {"beside"} == set(runner.libraries())
    assert all(runner.pins(name).is_file() for name in runner.libraries())


def test_the_page_has_a_row_for_every_library():
    commands = [f'`make interop ARGS="--only {name}"`' for name in runner.libraries()]
    assert list(runner.page_rows()) == commands
    text = runner.PAGE.read_text(encoding="utf-8")
    assert all(name in text for name in runner.ABSENT)


@pytest.fixture(scope="module")
def lines(tmp_path_factory) -> Callable[[str], list[str]]:
    """What the script of a name prints; all run in one process, as importing takes seconds."""
    there = [name for name in BESIDE if importlib.util.find_spec(MODULES.get(name, name))]
    done = subprocess.run(
        [sys.executable, "-c", ONE_BY_ONE, *there],
        capture_output=True,
        text=True,
        cwd=tmp_path_factory.mktemp("empty"),
        env={**os.environ, "SDL_VIDEODRIVER": "dummy", "PYTHONPATH": str(runner.ROOT)},
    )
    parts = dict(part.split("\n", 1) for part in done.stdout.split(MARK)[1:])

    def of(name: str) -> list[str]:
        if name not in there:
            pytest.skip(f"needs {MODULES.get(name, name)}")
        return parts.get(name, done.stderr).splitlines()

    return of


@pytest.mark.parametrize("name", BESIDE)
def test_a_library_beside_ours_does_what_its_script_asserts(name: str, lines):
    said = lines(name)
    assert said[-1].startswith("{"), "\n".join(said)
    told = json.loads(said[-1])
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
