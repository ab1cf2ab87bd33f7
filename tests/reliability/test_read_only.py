"""Machines on which nothing can be written: read-only installation, no home, no cache."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.modules import TWO_KERNELS

ROOT = Path(__file__).parents[2]
KERNELS = (
    TWO_KERNELS
    + """
@compiled
def unused(x):
    return x
"""
)
CALL = "import kernels; print(kernels.twice(3.0), kernels.total([1.0, 2.0]))"
COUNT = """
from numba.core import event
with event.install_recorder("numba:compile") as compiling:
    import kernels
    print(kernels.twice(3.0), kernels.total([1.0, 2.0]), len(compiling.buffer))
"""
USE = """
import numpy as np
import coopenv
from coopenv import wrench
from coopenv.cli import main

core = coopenv.Transport(num_worlds=2)
core.reset(seed=0)
core.step(np.zeros((2, 2, 3)))
split = wrench.decompose([[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], [[-0.9, 0.0], [0.9, 0.0]])
print(coopenv.__file__, split.internal[0, 0])
assert main(["--version"]) == 0
"""


def without_rights() -> list[str]:
    """What has a command obey the rights of files: the superuser may write all."""
    if os.geteuid() != 0:
        return []
    if shutil.which("setpriv") is None:
        pytest.skip("the superuser cannot be kept from writing without setpriv")
    return ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]


def run_read_only(
    script: str, folder: Path, **variables: str
) -> "subprocess.CompletedProcess[str]":
    """Run a script in a folder of which nothing can be written, with hardly an environment."""
    inside = [path for path in (folder, *folder.rglob("*")) if path.is_dir()]
    for path in inside:
        path.chmod(0o555)
    environment = {
        "PATH": "/usr/bin:/bin",
        "HOME": str(folder / "nobody"),
        "LC_ALL": "C",
        "PYTHONCOERCECLOCALE": "0",
        "PYTHONUTF8": "0",
        "PYTHONPATH": os.pathsep.join((str(folder), str(ROOT))),
        **variables,
    }
    try:
        return subprocess.run(
            [*without_rights(), sys.executable, "-c", script],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    finally:
        for path in inside:
            path.chmod(0o755)


def fill(folder: Path, **variables: str) -> None:
    """Compile the kernels of a folder while it can be written."""
    subprocess.run(
        [sys.executable, "-c", CALL],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), **variables},
        check=True,
        stdout=subprocess.DEVNULL,
    )


@pytest.fixture(scope="module")
def filled(tmp_path_factory) -> Path:
    """A folder with kernels and their cache, to be copied."""
    folder = tmp_path_factory.mktemp("filled")
    (folder / "kernels.py").write_text(KERNELS)
    fill(folder)
    return folder


def test_kernels_of_a_read_only_folder_are_compiled_in_memory_and_it_is_said_once(tmp_path):
    folder = tmp_path / "site"
    folder.mkdir()
    (folder / "kernels.py").write_text(TWO_KERNELS)
    done = run_read_only(CALL, folder)
    assert (done.stdout, done.returncode) == ("6.0 3.0\n", 0), done.stderr
    assert done.stderr.count("cache of compiled kernels must be writable") == 1
    assert "NUMBA_CACHE_DIR names another folder" in done.stderr
    assert [path.name for path in folder.iterdir()] == ["kernels.py"]


def test_kernels_of_a_read_only_folder_are_kept_where_the_variable_says(tmp_path):
    folder, cache = tmp_path / "site", tmp_path / "cache"
    folder.mkdir()
    (folder / "kernels.py").write_text(TWO_KERNELS)
    done = run_read_only(CALL, folder, NUMBA_CACHE_DIR=str(cache))
    assert (done.stdout, done.stderr, done.returncode) == ("6.0 3.0\n", "", 0)
    assert list(cache.rglob("kernels.twice*.nbi"))


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", None])
def test_kernels_that_were_kept_before_a_folder_became_read_only_are_not_compiled_again(
    tmp_path, variable, filled
):
    folder = shutil.copytree(filled, tmp_path / "site")
    kept = folder / ("cache" if variable else "__pycache__")
    where = {variable: str(kept)} if variable else {}
    if variable:
        shutil.rmtree(folder / "__pycache__")
        fill(folder, **where)
    assert len(list(kept.rglob("*kernels.t*.nbi"))) == 3  # function, gufunc and its loop
    again = run_read_only(COUNT, folder, **where)
    assert (again.stdout, again.stderr) == ("6.0 3.0 0\n", "")


def test_what_a_read_only_cache_lacks_is_compiled_once_and_kept_in_the_home(tmp_path, filled):
    folder, home = shutil.copytree(filled, tmp_path / "site"), tmp_path / "home"
    home.mkdir()
    of_integers = COUNT.replace("twice(3.0)", "twice(3)")
    told = [run_read_only(of_integers, folder, HOME=str(home)) for _ in range(2)]
    assert [one.stderr for one in told] == ["", ""]
    first, second = (one.stdout.split() for one in told)
    assert first[:2] == ["6.0", "3.0"]
    assert int(first[2]) > 0
    assert second == ["6.0", "3.0", "0"]
    assert list(home.rglob("kernels.twice*.nbi"))
    assert not list(home.rglob("*kernels.total*.nbi"))


@pytest.mark.slow  # compiles for half a minute
def test_a_read_only_installation_without_home_imports_steps_and_decomposes(tmp_path):
    folder = tmp_path / "site"
    rubbish = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "coopenv", folder / "coopenv", ignore=rubbish)
    done = run_read_only(USE, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{folder / 'coopenv' / '__init__.py'} 1.0\ncoopenv ")
    assert done.stderr.count("Warning") == 1
    assert "cache of compiled kernels must be writable" in done.stderr


@pytest.mark.parametrize("name", ["x.zipped", "env.zip"])
def test_a_folder_that_is_called_like_an_archive_is_one_like_others(tmp_path, name):
    folder = tmp_path / name
    folder.mkdir()
    (folder / "kernels.py").write_text(KERNELS)
    environment = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        [sys.executable, "-c", CALL], env=environment, capture_output=True, text=True
    )
    assert (done.stdout, done.returncode) == ("6.0 3.0\n", 0), done.stderr
