"""The lock as Windows runs it, with its ``msvcrt`` made up: a byte is locked, not the file."""

import importlib.util
import os
import sys
import threading
from types import ModuleType

import pytest

from coopenv.errors import InvalidInput
from coopenv.files import lock as plain


class Locks(ModuleType):
    """``msvcrt``: one descriptor at a time has a byte of a file; closing it gives the byte back."""

    LK_NBLCK = 2

    def __init__(self):
        super().__init__("msvcrt")
        self.taken: dict[int, tuple[int, range]] = {}  # by descriptor: inode and bytes

    def locking(self, file, mode, count):
        assert mode == self.LK_NBLCK
        begin, inode = os.lseek(file, 0, os.SEEK_CUR), os.fstat(file).st_ino
        wanted = set(range(begin, begin + count))
        for other, (of, taken) in self.taken.items():
            had = other != file and of == inode and self._is_open(other, of)
            if had and wanted.intersection(taken):
                raise PermissionError(13, "Permission denied")
        self.taken[file] = inode, range(begin, begin + count)

    def _is_open(self, file, inode):
        try:
            return os.fstat(file).st_ino == inode
        except OSError:
            return False


@pytest.fixture
def locks():
    return Locks()


@pytest.fixture
def lock(locks, monkeypatch):
    """The module, imported where the system is called Windows and has neither flock nor fork."""
    windows = ModuleType("sys")
    vars(windows).update(vars(sys), platform="win32")
    spec = importlib.util.spec_from_file_location("lock_on_windows", plain.__file__)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "sys", windows)
        patch.setitem(sys.modules, "msvcrt", locks)
        patch.setitem(sys.modules, "fcntl", None)
        patch.setitem(sys.modules, "lock_on_windows", module)
        patch.delattr(os, "register_at_fork", raising=False)
        spec.loader.exec_module(module)
    return module


def taken_elsewhere(lock, folder):
    """What another thread is told that wants the folder."""
    told = []

    def ask():
        try:
            with lock.locked(folder):
                told.append("")
        except InvalidInput as error:
            told.append(str(error))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    return told[0]


def test_a_folder_is_had_alone_and_given_back(lock, locks, tmp_path):
    for _ in range(2):
        with lock.locked(tmp_path), lock.locked(tmp_path):
            said = taken_elsewhere(lock, tmp_path)
            assert f"process {os.getpid()}" in said
        assert not [*tmp_path.iterdir()]
    assert taken_elsewhere(lock, tmp_path) == ""


def test_one_byte_is_locked_that_lies_past_what_others_read(lock, locks, tmp_path):
    with lock.locked(tmp_path):
        ((_, bytes_of),) = locks.taken.values()
        assert len(bytes_of) == 1
        assert bytes_of.start > lock.MOST > len((tmp_path / lock.LOCK).read_text())


def test_what_a_process_left_behind_is_taken_over(lock, tmp_path):
    (tmp_path / lock.LOCK).write_text(lock.Holder.current().encode())
    with lock.locked(tmp_path):
        assert taken_elsewhere(lock, tmp_path)
