"""Whatever instruction a signal interrupts, a process leaves no temporary file and no lock."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from coopenv.files import LOCK, locked, nothing_left, require_folder, require_writable, written
from coopenv.files.ending import is_due, promise, settle

OURS = (os.path.join("coopenv", "files", ""), "contextlib.py")
MOST = 10_000  # instructions of a block


class Interruption:
    """A trace function that raises at one instruction of the code of files."""

    def __init__(self, at: int):
        self._left, self.where = at, ""

    def __call__(self, frame, event, arg):
        if self.where or not any(part in frame.f_code.co_filename for part in OURS):
            return None
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        if event == "opcode":
            self._left -= 1
            if self._left < 0:
                self.where = f"{frame.f_code.co_qualname}, line {frame.f_lineno}"
                raise KeyboardInterrupt
        return self


def interrupted(block, at: int) -> str:
    """Run a block and interrupt it; where, empty if it has fewer instructions."""
    tracer, before = Interruption(at), sys.gettrace()
    sys.settrace(tracer)
    try:
        block()
    except (KeyboardInterrupt, ArithmeticError):
        pass
    finally:
        sys.settrace(before)
    return tracer.where


def write(folder: Path) -> None:
    with written(folder / "a.csv") as part:
        part.write_text("new")


def fail(folder: Path) -> None:
    with written(folder / "a.csv"):
        raise ArithmeticError


def try_file(folder: Path) -> None:
    require_writable(folder / "a.csv")


def try_folder(folder: Path) -> None:
    require_folder(folder)


def lock(folder: Path) -> None:
    with locked(folder):
        assert (folder / LOCK).exists()


@pytest.mark.parametrize("block", [write, fail, try_file, try_folder, lock])
def test_no_instruction_is_one_at_which_a_signal_leaves_something(block, tmp_path):
    for at in range(MOST):
        with nothing_left():
            where = interrupted(lambda: block(tmp_path), at)
        left = [name for name in os.listdir(tmp_path) if name.startswith(".")]
        assert not left, f"interrupted in {where}: {left}"
        if not where:
            break
    else:
        raise AssertionError("the block never ended")
    assert at > 50
    with locked(tmp_path):  # and nobody holds it
        pass


def test_a_file_that_its_writer_never_left_is_removed_as_the_interpreter_ends(tmp_path):
    code = """
import builtins, os, sys
from pathlib import Path
from coopenv.files import locked, written
builtins.kept = [written("a.csv"), locked(".")]
for each in builtins.kept:
    each.__enter__()
print(len(os.listdir()))
def interrupted(*_, **__):
    raise KeyboardInterrupt
Path.unlink, unlink = interrupted, Path.unlink
try:
    builtins.kept[0].__exit__(KeyError, KeyError(), None)
except KeyboardInterrupt:
    Path.unlink = unlink
os.chdir("/")
sys.exit(3)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stdout, done.stderr) == (3, "2\n", "")
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is forked there")
def test_a_forked_child_removes_nothing_that_its_parent_writes(tmp_path):
    code = """
import os, sys
from coopenv.files import locked, written
with locked("."), written("a.csv") as part:
    part.write_text("whole")
    child = os.fork()
    if not child:
        sys.exit(0)
    os.waitpid(child, 0)
    print(len(os.listdir()))
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "2\n", "")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["whole"]


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is forked there")
def test_a_forked_child_of_multiprocessing_leaves_no_file_either(tmp_path):
    code = """
import multiprocessing, os
from pathlib import Path
from coopenv.files import written
def interrupted(*_, **__):
    raise KeyboardInterrupt
def write():
    unlink = Path.unlink
    try:
        with written("a.csv"):
            Path.unlink = interrupted
            raise KeyError
    finally:
        Path.unlink = unlink
        print(len(os.listdir()), flush=True)
def run():
    with written("kept.csv") as part:
        part.write_text("whole")
        child = multiprocessing.get_context("fork").Process(target=write)
        child.start()
        child.join()
        print(child.exitcode, len(os.listdir()))
run()
grandparent = multiprocessing.get_context("fork").Process(target=run)
grandparent.start()
grandparent.join()
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    # Of child and parent a file each, then the parent's; the second time kept.csv is there too.
    assert done.stdout.split() == ["2", "1", "1", "3", "1", "2"], done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["kept.csv"]


def test_only_what_was_promised_in_the_block_is_undone_newest_first():
    undone = []
    promise("before", lambda: undone.append("before"))
    try:
        with nothing_left():
            for name in ("first", "settled", "last"):
                promise(name, lambda name=name: undone.append(name))
            settle("settled")
        assert undone == ["last", "first"]
        assert is_due("before")
        assert not is_due("first")
    finally:
        settle("before")
