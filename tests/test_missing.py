"""What works beside numerical packages alone, and what the rest says there."""

import subprocess
import sys
from pathlib import Path

import pytest

from coopenv.errors import MissingPackage
from coopenv.missing import PACKAGES, refusal, told

ROOT = Path(__file__).parents[1]
WITHOUT = """
import sys
for name in sys.argv[1].split(","):
    sys.modules[name] = None  # as if it were not installed
"""
BESIDES = ("moviepy", "PIL", "pygame", "rich", "stable_baselines3", "tomli", "torch", "tyro")
DECOMPOSE = """
from coopenv import wrench
split = wrench.decompose([[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], [[-0.9, 0.0], [0.9, 0.0]])
print(split.internal[0, 0])
"""
USE = """
import coopenv, coopenv.logs, coopenv.wrench
from coopenv import Body, TransportConfig, TransportTask, rewards
TransportConfig(task=TransportTask(), body=Body.beam(length=1.0), reward="harmony")
def said(ask):
    try:
        ask()
    except ImportError as error:
        print(type(error).__name__, error)
said(lambda: coopenv.Transport)
said(lambda: coopenv.beam_transport_v0)
def face():
    from coopenv import register
said(face)
def commands():
    import coopenv.cli
said(commands)
print(hasattr(coopenv, "Transprot"))
"""

IMPORTED = """
import sys
from importlib import import_module
from pathlib import Path
class Nothing:
    def find_spec(name, path=None, target=None):
        if name in sys.argv[1].split(","):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Nothing)
for path in sorted(Path("tests").rglob("test_*.py")):
    try:
        import_module(".".join(path.with_suffix("").parts))
    except BaseException as error:
        if type(error).__name__ != "Skipped":
            print(path, error)
"""
EXTRAS = (  # that no row of the matrix installs
    *("matplotlib", "moviepy", "optuna", "pandas", "pyarrow", "rich", "sb3_contrib"),
    *("stable_baselines3", "statsmodels", "supersuit", "tensordict", "torch", "torchrl", "tyro"),
)


def run(script: str, *missing: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", script, ",".join(missing)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_wrenches_are_decomposed_beside_numpy_scipy_numba_and_clarabel_alone():
    assert run(WITHOUT + DECOMPOSE, *PACKAGES, "typing_extensions", *BESIDES) == ["1.0"]


@pytest.mark.parametrize("missing", PACKAGES)
def test_without_a_package_that_simulates_the_rest_works_and_names_what_to_install(missing):
    *refused, unknown = run(WITHOUT + USE, missing)
    features = ("coopenv.Transport", "coopenv.beam_transport_v0", "coopenv.register")
    for said, feature in zip(refused, (*features, "the command line"), strict=True):
        start = f"MissingPackage {feature} needs {missing}, which is not installed; pip install '"
        assert said.startswith(start)
        assert all(f"'{package}" in said for package in PACKAGES)  # and the versions of each
    assert unknown == "False"


def test_another_module_that_is_missing_is_no_package_to_install():
    error = ModuleNotFoundError("No module named 'coopenv.slip'", name="coopenv.slip")
    assert told(error, "the command line") is error
    with pytest.raises(ModuleNotFoundError, match="slip"):
        refusal(error, "coopenv", {"Transport"})


def test_a_part_of_a_package_that_is_missing_counts_as_the_package():
    error = ModuleNotFoundError("No module named 'pymunk.batch'", name="pymunk.batch")
    assert isinstance(told(error, "coopenv.Transport"), MissingPackage)


def test_every_file_of_tests_is_read_or_skipped_without_any_extra():
    assert run(IMPORTED, *EXTRAS) == []
