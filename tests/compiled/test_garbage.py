"""Python's collector of garbage while kernels are compiled."""

import gc
import importlib
import sys

import pytest
from numba import TypingError
from numba.core import event

KERNELS = """
from coopenv.compiled import compiled, gufunc, inlined

@inlined
def part(x):
    return 2.0 * x

@compiled
def entry(x):
    return part(x)

@gufunc("()->()", "void(float64, float64[:])")
def broadcast(x, result):
    result[0] = part(x)
"""


@pytest.fixture
def kernels(tmp_path, monkeypatch):
    """A module whose kernels nobody has called."""
    (tmp_path / "with_parts.py").write_text(KERNELS)
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    yield importlib.import_module("with_parts")
    sys.modules.pop("with_parts")


@pytest.fixture(autouse=True)
def on_again():
    yield
    gc.enable()


class Collects(event.Listener):
    """Whether the collector was on as the compilation of each function began."""

    def __init__(self):
        self.told = {}

    def on_start(self, event):
        self.told[event.data["dispatcher"].py_func.__name__] = gc.isenabled()

    def on_end(self, event):
        pass


@pytest.mark.parametrize("name", ["entry", "broadcast"])
def test_the_collector_rests_while_parts_of_a_kernel_are_compiled(name, kernels):
    collects = Collects()
    with event.install_listener("numba:compile", collects):
        assert getattr(kernels, name)(3.0) == 6.0
    assert collects.told["part"] is False
    assert gc.isenabled()


def test_a_collector_that_was_off_stays_off(kernels):
    gc.disable()
    assert kernels.entry(3.0) == 6.0
    assert not gc.isenabled()


def test_a_kernel_that_cannot_be_compiled_leaves_the_collector_on(kernels):
    with pytest.raises(TypingError):
        kernels.entry("three")
    assert gc.isenabled()
