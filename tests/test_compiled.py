"""Compilation with numba: recompilation, cache and threads."""

import importlib
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numba.core import dispatcher
from numba.np.ufunc import wrappers

from coopenv import wrench
from coopenv.compiled import cache as compile_cache
from coopenv.geometry.frames import wrap_pose, wrapped
from tests.modules import TWO_KERNELS

KERNEL = """
from numba import njit
from coopenv.compiled import gufunc

@gufunc("(n)->()", "void(float64[:], float64[:])")
def total(values, result):
    result[0] = 0.0
    for i in range(values.shape[0]):
        result[0] += values[i]
"""
CALL = "import kernel_in_two_minds as k; print(k.total([1.0, 2.0]))"
OTHER_NAMES = "import numba; f = numba.njit(lambda x: x); f(1); f(1.0); " + CALL


ROOT = Path(__file__).parents[1]
HELPERS = """
from typing import NamedTuple
from coopenv.compiled import anywhere, compiled, fused

FACTOR = 2.0

class Pair(NamedTuple):
    first: float
    second: float

@compiled
def scaled(x):
    return 3.0 * x

@anywhere
def raised(x):
    return x + 1.0

@fused
def shifted(x):
    return x + 4.0
"""
SIZES = """
OFFSET = 0.0
TABLE = ((0.0, 1.0), (2.0, 3.0))
"""
USERS = """
import helpers
import sizes
from helpers import FACTOR, Pair, raised, scaled, shifted
from sizes import TABLE
from coopenv.compiled import compiled, fused_entry, gufunc, inlined

@inlined
def through(x):
    return helpers.scaled(x)

@compiled
def plain(x):
    return raised(through(x) + FACTOR) - 1.0 + sizes.OFFSET + TABLE[0][0]

@fused_entry
def entry(x):
    return shifted(x)

@compiled
def first(pair):
    return pair.first

@gufunc("()->()", "void(float64, float64[:])")
def broadcast(x, result):
    result[0] = scaled(x)
"""
ASK = """
import users
found = users.plain(1.0), users.entry(1.0), users.broadcast(1.0), users.first(users.Pair(7.0, 8.0))
misses = [sum(kernel.stats.cache_misses.values()) for kernel in (users.plain, users.entry)]
print(*map(float, found), *misses)
"""
DECOMPOSE = """
from coopenv import wrench
d = wrench.decompose([[3, 0, 0], [-1, 0, 0]], [[-0.9, 0], [0.9, 0]])
print(float(d.internal[0, 0]), d.solver)
"""


def run(script: str, folder: Path, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | variables,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def replace(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert text.count(old) == 1
    file.write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("3.0 * x", "5.0 * x", "7.0 5.0 5.0 7.0 1 1"),
        ("x + 4.0", "x + 6.0", "5.0 7.0 3.0 7.0 1 1"),
        ("x + 1.0", "x + 2.0", "6.0 5.0 3.0 7.0 1 1"),
        ("FACTOR = 2.0", "FACTOR = 8.0", "11.0 5.0 3.0 7.0 1 1"),
        (
            "first: float\n    second: float",
            "second: float\n    first: float",
            "5.0 5.0 3.0 8.0 1 1",
        ),
        ("OFFSET = 0.0", "OFFSET = 9.0", "14.0 5.0 3.0 7.0 1 1"),
        ("((0.0,", "((7.0,", "12.0 5.0 3.0 7.0 1 1"),
        ("FACTOR = 2.0", "FACTOR = 2.0", "5.0 5.0 3.0 7.0 0 0"),
    ],
)
def test_a_kernel_is_recompiled_when_what_it_uses_from_another_file_changes(
    old, new, expected, asked_once, tmp_path
):
    folder = shutil.copytree(asked_once, tmp_path / "copy")
    replace(folder / ("helpers.py" if old in HELPERS else "sizes.py"), old, new)
    assert run(ASK, folder) == expected


@pytest.fixture(scope="module")
def asked_once(tmp_path_factory):
    """Modules with kernels, and the cache of a process that called them."""
    folder = tmp_path_factory.mktemp("kernels")
    lay_out(folder)
    assert run(ASK, folder) == "5.0 5.0 3.0 7.0 1 1"
    return folder


def lay_out(folder: Path) -> None:
    for name, text in (("helpers", HELPERS), ("sizes", SIZES), ("users", USERS)):
        (folder / f"{name}.py").write_text(text)


def test_a_file_that_changes_between_import_and_first_call_leaves_no_stale_kernel(tmp_path):
    lay_out(tmp_path)
    text = "h = Path('helpers.py'); h.write_text(h.read_text().replace('3.0 * x', '5.0 * x'))"
    early = f"import users; from pathlib import Path; {text}{ASK}"
    assert run(early, tmp_path) == "5.0 5.0 3.0 7.0 1 1"  # what it imported
    assert run(ASK, tmp_path) == "7.0 5.0 5.0 7.0 1 1"


def test_fused_helpers_that_change_between_import_and_first_call_leave_no_stale_kernel(tmp_path):
    helper, user = tmp_path / "fused_helper.py", tmp_path / "fused_user.py"
    helper.write_text("from coopenv.compiled import fused\n@fused\ndef h(x):\n    return x + 1.0\n")
    user.write_text(
        "from coopenv.compiled import fused_entry\nfrom fused_helper import h\n"
        "@fused_entry\ndef k(x):\n    return h(x)\n"
    )
    text = "h = Path('fused_helper.py'); h.write_text(h.read_text().replace('1.0', '2.0'))"
    early = f"import fused_user; from pathlib import Path; {text}; print(fused_user.k(1.0))"
    assert run(early, tmp_path) == "2.0"  # what it imported
    assert run("import fused_user; print(fused_user.k(1.0))", tmp_path) == "3.0"


def test_what_is_compiled_anywhere_is_the_same_for_numbers_arrays_and_kernels():
    angles = np.random.default_rng(0).uniform(-20, 20, 200)
    from_arrays = wrapped(angles)
    np.testing.assert_array_equal([wrapped(float(angle)) for angle in angles], from_arrays)
    np.testing.assert_array_equal(wrap_pose(np.repeat(angles[:, None], 3, 1))[:, 2], from_arrays)


def test_a_changed_helper_of_the_package_shows_in_what_it_decomposes(tmp_path):
    rubbish = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "coopenv", tmp_path / "coopenv", ignore=rubbish)
    cache = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert run(DECOMPOSE, tmp_path, **cache) == "1.0 pair"
    helper = tmp_path / "coopenv" / "geometry" / "frames.py"  # of a helper of the kernel's helpers
    replace(helper, "return c * x - s * y, s * x + c * y", "return s * y - c * x, s * x + c * y")
    assert run(DECOMPOSE, tmp_path, **cache) == "-1.0 pair"


def test_a_cache_left_by_two_processes_at_once_is_mended(tmp_path):
    # numba caches kernel and loop apart; with the loop of another process the call would crash
    (tmp_path / "kernel_in_two_minds.py").write_text(KERNEL)
    assert run(CALL, tmp_path) == "3.0"
    for kernel in (tmp_path / "__pycache__").glob("kernel_in_two_minds.total*.nb[ic]"):
        kernel.unlink()
    assert run(OTHER_NAMES, tmp_path) == "3.0"
    assert run(CALL, tmp_path) == "3.0"


def test_a_loop_left_by_another_process_is_compiled_again(start, tmp_path):
    assert start() == (0, 1)
    for kernel in (tmp_path / "__pycache__").glob("fragile.total*.nb[ic]"):
        kernel.unlink()  # compiled anew, it has a name that the cached loop does not know
    assert start() == (1, 0)
    assert start() == (1, 0)


@pytest.fixture
def start(tmp_path, monkeypatch):
    """Import kernels as a new process would; how many were in the cache, and how many not."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(compile_cache, "_warned", [], raising=False)
    (tmp_path / "fragile.py").write_text(TWO_KERNELS)

    def begin() -> tuple[int, int]:
        sys.modules.pop("fragile", None)
        importlib.invalidate_caches()
        fragile = importlib.import_module("fragile")
        assert (fragile.twice(3.0), fragile.total([1.0, 2.0])) == (6.0, 3.0)
        stats = fragile.twice.stats
        return sum(stats.cache_hits.values()), sum(stats.cache_misses.values())

    yield begin
    sys.modules.pop("fragile", None)


def cached(folder: Path) -> list[Path]:
    return sorted((folder / "__pycache__").glob("*fragile.*.nb[ic]"))


def flipped(content: bytes) -> bytes:
    """One bit of the content is another, in the middle."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "cut_short": lambda content: content[:40],
    "zeros": lambda content: bytes(len(content)),
    "garbage": lambda content: np.random.default_rng(0).bytes(len(content)),
    "a_bit": flipped,
    "longer": lambda content: content + b"more",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_cache_heals_itself(damage, start, tmp_path):
    assert start() == (0, 1)
    files = cached(tmp_path)
    assert len(files) == 6  # index and code of a function, of a gufunc and of its loop
    for file in files:
        whole = file.read_bytes()
        file.write_bytes(damage(whole))
        start()
        assert start() == (1, 0), file
        assert len(file.read_bytes()) == pytest.approx(len(whole), rel=0.1), file


def test_a_file_that_was_copied_without_a_change_is_not_compiled_again(start, tmp_path):
    start()
    os.utime(tmp_path / "fragile.py", (1e9, 1e9))
    assert start() == (1, 0)


@pytest.mark.filterwarnings("ignore:the cache of compiled kernels")
def test_a_cache_of_which_a_file_cannot_be_read_does_not_stop_the_import(start, tmp_path):
    start()
    for file in cached(tmp_path):
        file.unlink()
        file.mkdir()  # as unreadable for root as for others
        assert sum(start()) == 1  # taken from what is left, or compiled anew


def test_a_cache_that_numba_wrote_without_digests_is_written_anew(start, tmp_path):
    plain = compile_cache.IndexDataCacheFile(str(tmp_path / "__pycache__"), "x", "stamp")
    start()
    for file in cached(tmp_path):
        with plain._open_for_write(str(file)) as opened:
            opened.write(file.read_bytes()[: -compile_cache.DIGEST])
    assert start() == (0, 1)
    assert start() == (1, 0)


def test_a_cache_that_cannot_be_written_is_warned_of_once_and_compiled_in_memory(
    start, tmp_path, monkeypatch
):
    file = tmp_path / "__pycache__"
    file.write_text("no folder")
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(file))
    monkeypatch.setenv("XDG_CACHE_HOME", str(file))
    with pytest.warns(UserWarning, match="cache of compiled kernels must be writable") as warned:
        found = [start(), start()]
    assert found == [(0, 1), (0, 1)]
    assert len(warned) == 1


def test_what_is_missing_where_kernels_are_kept_is_taken_from_folders_that_are_read_only(
    start, tmp_path, monkeypatch
):
    assert start() == (0, 1)
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path / "home"))
    assert start() == (0, 1)  # the other folder may be written: it is another cache
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path / "another"))
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK and access(path, mode))
    assert start() == (1, 0)


def test_a_disk_that_is_full_while_a_kernel_is_kept_stops_nothing(start, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.warns(UserWarning, match="No space left on device"):
        assert start() == (0, 1)


def test_an_interruption_while_a_kernel_is_kept_leaves_no_temporary_file(
    start, monkeypatch, tmp_path
):
    tried = []

    def interrupted(source, target):
        tried.append(Path(source))
        assert tried[-1].exists()
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        start()
    assert len(tried) == 1
    assert tried[0].is_relative_to(tmp_path)
    assert not list(tmp_path.rglob("*.tmp.*"))


def test_a_kernel_of_ours_has_a_cache_that_is_checked_and_a_function_of_others_has_numbas(start):
    start()
    ours = sys.modules["fragile"].twice.py_func
    for make in (vars(dispatcher)["FunctionCache"], vars(wrappers)["GufWrapperCache"]):
        checked, plain = make(ours), make(run)
        assert type(plain).__module__.startswith("numba.")
        assert type(checked).__module__ == compile_cache.__name__
        assert issubclass(type(checked), type(plain))


def test_threads_may_decompose_at_the_same_time():
    applied = np.random.default_rng(0).normal(size=(20_000, 2, 3))
    decomposer = wrench.Decomposer([[-0.9, 0.0], [0.9, 0.0]])
    expected = decomposer(applied).manipulation
    with ThreadPoolExecutor(2) as pool:
        for found in pool.map(lambda _: decomposer(applied).manipulation, range(6)):
            np.testing.assert_array_equal(found, expected)
