"""The tests under other versions of Python and of what the package needs: ``make matrix``.

python -m benchmarks.matrix                   # every corner whose Python is at hand
python -m benchmarks.matrix oldest --whole    # one of them, with all tests
python -m benchmarks.matrix --write           # also writes the table of docs/install.md

A corner is a virtual environment with the versions of its file in ``tests/matrix``; what it came to
is kept beside it, so that corners may be run one by one.
"""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.pages import DOCS, fill, markdown
from coopenv.errors import UnknownName
from coopenv.files import written

ROOT = Path(__file__).parents[1]
PINS = ROOT / "tests" / "matrix"
SHOWN = ("numpy", "numba", "scipy", "clarabel", "gymnasium", "pettingzoo", "pymunk")
COLUMNS = ("command", "Python", *SHOWN, "tests")
WRENCH = (
    "tests/wrench/test_measures.py",
    "tests/wrench/pair/test_solver.py",
    "tests/wrench/conic/test_solver.py::test_planar_problems_are_spatial_problems_in_a_plane",
    "tests/wrench/conic/test_solver.py::test_degenerate_wrenches_are_answered_at_any_scale",
)
_CONTRACT = "tests/envs/test_contract.py::"
_CHECKERS = (
    "test_the_gymnasium_view_passes_gymnasiums_checker",
    "test_the_pettingzoo_views_pass_its_api_tests",
)
_PICKLED = "test_a_pickled_environment_begins_again_alike_after_a_reset_and_a_step"
_NAMES = ("BeamTransport", "BeamDoorway", "BeamTracking", "WalkerAvoid", "WalkerTurn", "BeamLift")
VIEWS = (
    "tests/test_first_steps.py",
    "tests/test_missing.py",
    "tests/physics/test_world.py",
    "tests/envs/test_registry.py",
    *(
        f"{_CONTRACT}{checker}[coopenv/{name}-v0-{options}]"
        for checker in _CHECKERS
        for name in _NAMES
        for options in ("defaults", "discrete")  # all of them would take most of the time
    ),
    f"{_CONTRACT}test_vector_results_are_finite_and_of_the_types_promised",
    "tests/envs/test_state.py::test_a_view_is_copied_right_after_its_reset_and_at_the_end",
    *(f"tests/interop/test_{library}.py::{_PICKLED}" for library in ("gymnasium", "pettingzoo")),
)


@dataclass(frozen=True, slots=True)
class Corner:
    """A set of versions, and the tests that tell whether it works."""

    python: str
    tests: tuple[str, ...]
    complete: bool = True  # all that pyproject.toml asks for is installed


CORNERS = {
    "oldest": Corner("3.10", (*WRENCH, *VIEWS)),
    "rllib": Corner("3.11", (*WRENCH, *VIEWS)),
    "middle": Corner("3.12", (*WRENCH, *VIEWS)),
    "newest": Corner("3.13", (*WRENCH, *VIEWS)),
    "wrench": Corner("3.10", WRENCH, complete=False),
}


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Run the tests under other versions of Python and of what the package needs."""

    corners: Annotated[tuple[str, ...], tyro.conf.Positional] = tuple(CORNERS)
    """Which; all by default."""
    folder: Path = ROOT / ".matrix"
    """For the virtual environments and results."""
    whole: bool = False
    """Run all tests, which need what is installed by hand, not those that tell most."""
    write: bool = False
    """Write the table of docs/install.md."""


def main() -> int:
    """Run the corners, print what came of them; 1 if a test failed or a corner was not run."""
    settings = tyro.cli(Settings)
    folder = settings.folder.resolve()
    for name in settings.corners:
        if name not in CORNERS:
            raise UnknownName("corner", name, CORNERS)
    codes = [_tried(name, folder / name, settings.whole) for name in settings.corners]
    table = markdown(COLUMNS, [row(name, folder / name) for name in CORNERS])
    print(table)
    if settings.write:
        fill(DOCS / "install.md", {"matrix": table})
    return int(any(codes))


def row(name: str, folder: Path) -> list[str]:
    """What a corner is made of, and what its last run came to."""
    versions, kept = pins(name), folder / "result.json"
    found = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    told = found["told"] if found.get("pins") == versions else "not run"
    shown = [versions.get(package, "–") for package in SHOWN]
    return [f"`make matrix ARGS={name}`", CORNERS[name].python, *shown, told]


def pins(name: str) -> dict[str, str]:
    """Package → version, in the file of a corner."""
    lines = (PINS / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    pairs = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {package: version for package, version in pairs}


def interpreter(version: str) -> str | None:
    """A Python of that version: the one that runs, on the path or of pyenv."""
    if version == f"{sys.version_info.major}.{sys.version_info.minor}":
        return sys.executable
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    own = sorted(versions.glob(f"{version}.*/bin/python"))
    return str(own[-1]) if own else shutil.which(f"python{version}")


def _tried(name: str, folder: Path, whole: bool) -> int:
    """Make a corner's environment if it is not there, and run its tests; their exit code."""
    python = interpreter(CORNERS[name].python)
    if python is None:
        print(f"{name}: Python {CORNERS[name].python} is not at hand")
        return 1
    print(f"{name}: Python {CORNERS[name].python}", flush=True)
    _install(name, folder, python)
    tests = ("tests",) if whole else CORNERS[name].tests
    environment = {
        **_environment(),
        "NUMBA_CACHE_DIR": str(folder / "numba"),  # that of the sources is another numba's
        "SDL_VIDEODRIVER": "dummy",
    }
    done = subprocess.run(
        [str(folder / "bin" / "python"), "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    told = _counts(done.stdout)
    print(done.stdout if done.returncode else told, flush=True)
    with written(folder / "result.json") as part:
        part.write_text(json.dumps({"pins": pins(name), "told": told}), encoding="utf-8")
    return done.returncode


def _install(name: str, folder: Path, python: str) -> None:
    """The versions of a corner, which are all that it gets, and the package."""
    mark, wanted = folder / "pins.json", json.dumps({**pins(name), "of": str(ROOT)})
    if mark.exists() and mark.read_text(encoding="utf-8") == wanted:
        return
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python")]
    install = [*pip, "install", "--quiet", "--no-deps"]
    check = [[*pip, "check"]] if CORNERS[name].complete else []
    for command in (
        [python, "-m", "venv", "--clear", "--without-pip", str(folder)],
        [*install, "--requirement", str(PINS / f"{name}.txt")],
        [*install, "--editable", str(ROOT)],
        *check,  # that pyproject.toml takes these versions
    ):
        subprocess.run(command, env=_environment(), check=True)
    mark.write_text(wanted, encoding="utf-8")


def _environment() -> dict[str, str]:
    """That of this process, but for modules that a corner would take instead of its own."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def _counts(output: str) -> str:
    """Pytest's own summary, without the time."""
    last = output.strip().splitlines()[-1:] or ["nothing"]
    return last[0].strip("= ").partition(" in ")[0]


if __name__ == "__main__":
    sys.exit(main())
