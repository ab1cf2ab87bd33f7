"""What the wheel holds: all of coopenv with its two top-level folders, and nothing beside it."""

import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from coopenv.files import toml

ROOT = Path(__file__).parent.parent
POLICIES = ROOT / "agents" / "pretrained"
LINKED = ("rewards", "agents")  # coopenv/<name> is a link to the folder beside coopenv

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("build") is None or not (ROOT / "pyproject.toml").exists(),
    reason="needs the build package and a source checkout",
)


def built(source: Path, target: Path) -> tuple[Path, Path]:
    """Build an sdist and, from that, a wheel."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(target), "."]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (sdist,), (wheel,) = target.glob("*.tar.gz"), target.glob("*.whl")
    return sdist, wheel


def copied(target: Path, *, links: bool) -> Path:
    """The sources; without links as a checkout on a system that has none."""
    source = target / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    rubbish = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
    for name in ("coopenv", *LINKED):
        shutil.copytree(ROOT / name, source / name, symlinks=True, ignore=rubbish)
    for name in LINKED:
        link = source / "coopenv" / name
        assert link.is_symlink()
        if not links:
            link.unlink()
            link.write_text(f"../{name}")  # what git leaves there
    return source


@pytest.fixture(scope="module", params=["links", "no links"])
def distribution(request, tmp_path_factory):
    """The sdist, and the wheel built from it."""
    target = tmp_path_factory.mktemp("build")
    return built(copied(target, links=request.param == "links"), target)


def modules() -> set[str]:
    """Every module of the source tree by its path in the wheel."""
    found = {path.relative_to(ROOT).as_posix() for path in (ROOT / "coopenv").rglob("*.py")}
    for name in LINKED:
        found |= {
            f"coopenv/{path.relative_to(ROOT).as_posix()}" for path in (ROOT / name).rglob("*.py")
        }
    return found


def test_every_folder_of_the_package_is_listed():
    setuptools = toml.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {Path(path).parent for path in modules()}
    assert set(setuptools["packages"]) == {".".join(folder.parts) for folder in folders}
    linked = {folder for folder in folders if len(folder.parts) > 1 and folder.parts[1] in LINKED}
    assert setuptools["package-dir"] == {
        ".".join(folder.parts): "/".join(folder.parts[1:]) for folder in linked
    }


def test_the_wheel_holds_every_module(distribution):
    names = set(zipfile.ZipFile(distribution[1]).namelist())
    assert {name for name in names if name.endswith(".py")} == modules()
    assert {"coopenv/rewards/__init__.py", "coopenv/agents/__init__.py"} <= names


def test_the_wheel_holds_the_policies_that_come_with_it(distribution):
    policies = {f"coopenv/agents/pretrained/{path.name}" for path in POLICIES.glob("*.npz")}
    with zipfile.ZipFile(distribution[1]) as wheel:
        sizes = {name: wheel.getinfo(name).file_size for name in wheel.namelist()}
    assert policies
    assert {name for name in sizes if name.endswith(".npz")} == policies
    assert sum(sizes[name] for name in policies) < 1_000_000


def test_the_wheel_says_that_it_is_typed(distribution):
    assert "coopenv/py.typed" in zipfile.ZipFile(distribution[1]).namelist()


def test_the_wheel_installs_no_other_top_level_name(distribution):
    tops = {name.split("/")[0] for name in zipfile.ZipFile(distribution[1]).namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"coopenv"}


def test_the_source_distribution_can_be_built_from(distribution):
    with tarfile.open(distribution[0]) as sdist:
        names = {name.split("/", 1)[-1] for name in sdist.getnames()}
    assert {"pyproject.toml", "README.md", "LICENSE", "rewards/terms.py"} <= names


@pytest.mark.parametrize("distribution", ["no links"], indirect=True)
def test_the_wheel_is_imported_without_the_checkout(distribution, tmp_path):
    with zipfile.ZipFile(distribution[1]) as wheel:
        wheel.extractall(tmp_path)
    code = """
import coopenv, coopenv.agents
print(coopenv.__file__, coopenv.rewards.__file__, coopenv.agents.__file__, sep="\\n")
"""
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    for path in done.stdout.split():
        assert Path(path).is_relative_to(tmp_path), path


FIRST_STEP = """
import coopenv, gymnasium
assert "site-packages" in coopenv.__file__, coopenv.__file__
env = gymnasium.make("coopenv/BeamTransport-v0")
env.reset(seed=0)
_, reward, *_, info = env.step(env.action_space.sample())
assert reward == reward and "relative_cost" in info
"""


@pytest.mark.slow
@pytest.mark.parametrize("distribution", ["no links"], indirect=True)
def test_what_is_released_is_sound_and_works_in_an_empty_environment(distribution, tmp_path):
    """Needs the net, for twine and for what the package depends on."""
    venv.create(tmp_path / "venv", with_pip=True)
    bin = tmp_path / "venv" / ("Scripts" if sys.platform == "win32" else "bin")

    def run(*command: object) -> str:
        clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        done = subprocess.run(
            [*map(str, command)], cwd=tmp_path, env=clean, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    run(bin / "python", "-m", "pip", "install", "--quiet", "twine")
    checked = run(bin / "python", "-m", "twine", "check", "--strict", *distribution)
    assert checked.count("PASSED") == 2
    run(bin / "python", "-m", "pip", "install", "--quiet", distribution[1])
    run(bin / "python", "-c", FIRST_STEP)
    assert "decompose" in run(bin / "coopenv", "--help")
    assert run(bin / "coopenv", "--version").startswith("coopenv ")


def test_extras_name_what_their_modules_import():
    """The core imports neither torch nor pygame: `pip install coopenv` has to be enough."""
    code = "import sys, coopenv; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "pymunk" in loaded
    assert not loaded & {"torch", "stable_baselines3", "pygame", "matplotlib", "tyro", "rich"}
