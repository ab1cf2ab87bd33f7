"""The cache on disk: whose kernels it keeps, and what a write that was broken off leaves."""

import importlib
import sys

import pytest

from coopenv.compiled import cache
from coopenv.compiled.dependencies import KERNELS, is_constant, stamp
from tests.modules import TWO_KERNELS

HELPER = """
from coopenv.compiled import compiled

FACTOR = 2.0

@compiled
def scaled(x):
    return FACTOR * x
"""
USER = """
from coopenv.compiled import compiled
from coopenv.compiled.dependencies import stamp

@compiled
def first(x):
    return x

EARLY = stamp(first.py_func, 0)

import kept_helper

@compiled
def second(x):
    return kept_helper.scaled(x)
"""


def test_the_cache_is_for_kernels_of_ours_alone():
    kernel = next(iter(KERNELS))
    assert cache.Locator.from_function(kernel, kernel.__code__.co_filename) is not None
    assert cache.Locator.from_function(pytest.fail, pytest.__file__) is None


def test_a_write_that_is_broken_off_leaves_nothing(tmp_path):
    files = cache.Files(str(tmp_path), "kernel", "stamp")

    def stopped():
        with files._open_for_write(str(tmp_path / "data")) as file:
            file.write(b"half of it")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert not list(tmp_path.iterdir())
    with files._open_for_write(str(tmp_path / "data")) as file:
        file.write(b"all of it")
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_a_kernel_depends_on_numbers_and_on_tuples_of_nothing_else():
    assert all(map(is_constant, (1, 0.5, (1, (2.0, True)))))
    assert not any(map(is_constant, ("word", (1, "word"), ((1, object()), 2), [1])))


@pytest.fixture
def imported(tmp_path, monkeypatch):
    """Write a module and import it; kernels are kept beside it."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path / "kept"))
    names: list[str] = []

    def write_and_import(name, text):
        names.append(name)
        (tmp_path / f"{name}.py").write_text(text)
        importlib.invalidate_caches()
        return importlib.import_module(name)

    yield write_and_import
    for name in names:
        sys.modules.pop(name, None)


def test_a_gufunc_and_its_loop_are_kept_when_it_is_first_called(imported, tmp_path):
    module = imported("kept_kernels", TWO_KERNELS)
    assert not list(tmp_path.rglob("*.nb[ic]"))
    assert module.total([1.0, 2.0]) == 3.0
    kept = [path.suffix for path in tmp_path.rglob("*.nb[ic]")]
    assert sorted(kept) == [".nbc", ".nbc", ".nbi", ".nbi"]


def test_what_is_compiled_while_its_module_is_imported_hides_nothing_imported_later(
    imported, monkeypatch
):
    helper = imported("kept_helper", HELPER)
    user = imported("kept_user", USER)
    before = stamp(user.second.py_func, 0)
    assert stamp(user.second.py_func, 0) == before != user.EARLY
    monkeypatch.setattr(helper, "FACTOR", 3.0)
    assert stamp(user.second.py_func, 0) != before


def test_a_named_tuple_that_changes_after_its_import_stamps_nothing_twice_alike(
    tmp_path, monkeypatch
):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "with_tuples"
    package.mkdir()
    tuples = package / "alone.py"  # without a function whose file would be noted
    tuples.write_text("from typing import NamedTuple\nclass Pair(NamedTuple):\n    a: float\n")
    (package / "used.py").write_text(
        "from with_tuples.alone import Pair\nfrom coopenv.compiled import compiled\n"
        "@compiled\ndef first(x):\n    return Pair(x).a\n"
    )
    (package / "late.py").write_text((package / "used.py").read_text())
    first = importlib.import_module("with_tuples.used").first.py_func
    try:
        assert stamp(first, 0) == stamp(first, 0)
        tuples.write_text(tuples.read_text() + "    b: float\n")
        assert stamp(first, 0) != stamp(first, 0)  # what was imported is in no file any more
        late = importlib.import_module("with_tuples.late").first.py_func
        assert stamp(late, 0) != stamp(late, 0)  # nor what another module takes of it
    finally:
        for name in [name for name in sys.modules if name.partition(".")[0] == "with_tuples"]:
            del sys.modules[name]
