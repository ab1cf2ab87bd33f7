"""What works beside numerical packages alone, and what the rest says there."""

import subprocess
import sys

import pytest

from coopenv.errors import MissingPackage
from coopenv.missing import PACKAGES, refusal, told

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


def run(script: str, *missing: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT + script, ",".join(missing)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_wrenches_are_decomposed_beside_numpy_scipy_numba_and_clarabel_alone():
    assert run(DECOMPOSE, *PACKAGES, "typing_extensions", *BESIDES) == ["1.0"]


@pytest.mark.parametrize("missing", PACKAGES)
def test_without_a_package_that_simulates_the_rest_works_and_names_what_to_install(missing):
    *refused, unknown = run(USE, missing)
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
