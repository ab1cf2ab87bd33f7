"""Other libraries on our environments, each with its own code: ``make interop``.

python -m tests.interop                        # every library
python -m tests.interop --only minari rllib    # some of them
python -m tests.interop --write                # also writes the table of docs/ecosystem.md

Each has a virtual environment with the versions of its file in ``requirements``; files that say
``-r other.txt`` and no more share one. Environments are kept, and installed into again when a file
or our own requirements change.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.pages import DOCS, fill, markdown
from coopenv.errors import UnknownName
from coopenv.files import written

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
PAGE = DOCS / "ecosystem.md"
COLUMNS = ("library", "version", "Python", "ids", "what is asserted", "command")
FOLDER = os.environ.get("COOPENV_INTEROP", str(ROOT / ".interop"))
INSTALLING, RUNNING = 3600, 3600  # most seconds that may take
ABSENT = {  # library → why no row of it can be run here
    "PufferLib": "3.0.0 and 2.0.6 have no wheel, and their build downloads a library from outside "
    "PyPI; 2.0.2, the last with a wheel, asks for numpy==1.23.3, gymnasium<=0.29.1 and "
    "pettingzoo<=1.24.1, below what ours takes",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run libraries, print what came of them; 1 if one failed."""
    asked = _read(arguments)
    names = asked.only or libraries()
    for name in names:
        if name not in libraries():
            raise UnknownName("library", name, libraries())
    folder = Path(asked.folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for number, name in enumerate(names, start=1):
        print(f"[{number}/{len(names)}] {name}", flush=True)
        result = tried(name, folder)
        print(f"    {result.get('failed') or 'passed'} in {result['seconds']:.0f} s", flush=True)
        with written(folder / f"{name}.json") as part:
            part.write_text(json.dumps(result), encoding="utf-8")
    results = {name: _kept(folder / f"{name}.json") for name in libraries()}
    rows = table_rows(results, page_rows())
    print(markdown(COLUMNS, rows))
    if asked.write:
        fill(PAGE, {"libraries": markdown(COLUMNS, rows)})
    return int(any("failed" in results[name] for name in names))


def libraries() -> list[str]:
    """Names of the scripts, those that most people use first."""
    found = sorted(path.stem for path in (HERE / "libraries").glob("[a-z]*.py"))
    first = ["gymnasium", "stable_baselines3", "sb3_contrib", "supersuit", "rl_zoo3"]
    return [*(name for name in first if name in found), *(n for n in found if n not in first)]


def pins(name: str) -> Path:
    """The file of versions of a library: its own, or the one that it names and no more."""
    path = HERE / "requirements" / f"{name}.txt"
    text = path.read_text(encoding="utf-8").strip()
    return path.with_name(text[3:].strip()) if text.startswith("-r ") and "\n" not in text else path


def tried(name: str, folder: Path) -> dict[str, Any]:
    """What a script told, or ``failed``: why it could not."""
    begun = time.monotonic()
    try:
        told = run(name, environment(pins(name), folder))
    except subprocess.TimeoutExpired as error:
        told = {"failed": f"took more than {error.timeout:.0f} s"}
    except subprocess.CalledProcessError as error:
        lines = (error.stderr or error.stdout or "").strip().splitlines()
        print("\n".join(lines[-30:]), file=sys.stderr, flush=True)
        told = {"failed": lines[-1] if lines else f"ended with {error.returncode}"}
    return {**told, "seconds": time.monotonic() - begun}


def environment(versions: Path, folder: Path) -> Path:
    """The Python of the virtual environment with these versions, made if it is not there."""
    home = folder / versions.stem
    python, mark = home / "bin" / "python", home / "versions.txt"
    project, _, _ = (
        (ROOT / "pyproject.toml").read_text(encoding="utf-8").partition("\n[tool.pytest")
    )
    wanted = versions.read_text(encoding="utf-8") + project
    if not (mark.exists() and mark.read_text(encoding="utf-8") == wanted):
        print(f"    installing {versions.name}", flush=True)
        if not python.exists():
            _call([sys.executable, "-m", "venv", "--without-pip", str(home)], INSTALLING)
        pip = [sys.executable, "-m", "pip", "--python", str(python)]
        _call([*pip, "install", "--quiet", "-r", str(versions), "-e", str(ROOT)], INSTALLING)
        with written(mark) as part:
            part.write_text(wanted, encoding="utf-8")
    return python


def run(name: str, python: Path) -> dict[str, Any]:
    """What a script tells in its last line of JSON, run as a module in an empty folder.

    So it may import the examples, and none of the scripts hides the library of its name.
    """
    module = ".".join((HERE / "libraries" / name).relative_to(ROOT).parts)
    with TemporaryDirectory() as empty:
        said = _call([str(python), "-m", module], RUNNING, cwd=empty, PYTHONPATH=str(ROOT))
    told = next(line for line in reversed(said.splitlines()) if line.startswith("{"))
    version = _call([str(python), "-c", "import platform; print(platform.python_version())"], 60)
    return {**json.loads(told), "python": version.strip()}


def table_rows(
    results: Mapping[str, Mapping[str, Any]], before: Mapping[str, list[str]]
) -> list[list[str]]:
    """A row a library: of its last run here, else as it was before; then those that cannot be."""
    rows = []
    for name, told in results.items():
        command = f'`make interop ARGS="--only {name}"`'
        if "failed" in told:
            python = platform.python_version()
            rows.append([name, "–", python, "–", f"fails: {_cell(told['failed'])}", command])
        elif told:
            ids = ", ".join(f"`{view.removeprefix('coopenv/')}`" for view in told["ids"])
            cells = (told["library"], told["version"], told["python"], ids, told["checked"])
            rows.append([*map(_cell, cells), command])
        elif command in before:
            rows.append(before[command])
    return [*rows, *([name, "–", "–", "–", _cell(why), "–"] for name, why in ABSENT.items())]


def page_rows() -> dict[str, list[str]]:
    """The rows of the page, by their command."""
    _, table, _ = PAGE.read_text(encoding="utf-8").split("<!-- libraries -->\n")
    rows = [line.strip("| ").split(" | ") for line in table.splitlines()[2:]]
    return {row[-1]: row for row in rows if row[-1].startswith("`make")}


def _read(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="make interop", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--only", nargs="+", metavar="NAME", help=", ".join(libraries()))
    parser.add_argument("--write", action="store_true", help="write the table of the page")
    parser.add_argument(
        "--folder", default=FOLDER, help="for virtual environments and results; COOPENV_INTEROP"
    )
    return parser.parse_args(arguments)


def _kept(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def _cell(text: str) -> str:
    return str(text).replace("|", "/").replace("\n", " ")


def _call(command: list[str], seconds: float, cwd: str | None = None, **variables: str) -> str:
    """What a command prints; `subprocess.CalledProcessError` with what it said if it fails."""
    environment = {**os.environ, "SDL_VIDEODRIVER": "dummy", "PYTHONPATH": "", **variables}
    done = subprocess.run(
        command,
        check=True,
        capture_output=True,
        text=True,
        timeout=seconds,
        cwd=cwd,
        env=environment,
    )
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
