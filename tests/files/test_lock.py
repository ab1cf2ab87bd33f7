"""A folder is locked by one process at a time, and by a dead one not at all."""

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from coopenv.errors import InvalidInput
from coopenv.files import LOCK, locked, nothing_left
from coopenv.files.lock import Holder

HOLD = """
import sys
from coopenv.files import locked
with locked(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that has ``tmp_path``."""
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def sign(folder: Path, **changes) -> Holder:
    """A lock that nobody removed, of this process but for the changes."""
    told = json.loads(Holder.current().encode())
    told["process"].update({k: v for k, v in changes.items() if k in told["process"]})
    told.update({k: v for k, v in changes.items() if k in told})
    (folder / LOCK).write_text(json.dumps(told))
    return Holder.current()


def holder_of(folder):
    return json.loads((folder / LOCK).read_text())["process"]["pid"]


def test_a_second_process_is_told_who_is_at_work_and_since_when(tmp_path, holder):
    with pytest.raises(InvalidInput) as refused, locked(tmp_path):
        pass
    told = json.loads((tmp_path / LOCK).read_text())
    assert f"process {holder.pid} on {told['node']} has had since {told['since']}" in str(
        refused.value
    )
    assert "\n" not in str(refused.value)
    holder.communicate("")
    with locked(tmp_path):
        pass
    assert not list(tmp_path.iterdir())


def test_the_lock_of_a_process_that_was_killed_is_taken_over(tmp_path, holder):
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        assert holder_of(tmp_path) == os.getpid()
    assert not list(tmp_path.iterdir())


def test_a_lock_from_before_a_restart_of_the_machine_is_taken_over(tmp_path):
    sign(tmp_path, kernel="00000000", started="00000000")
    with locked(tmp_path):
        assert holder_of(tmp_path) == os.getpid()


def test_a_lock_of_another_machine_is_refused_with_what_to_do(tmp_path):
    sign(tmp_path, kernel="00000000", host="00000000", node="far", pid=7)
    with pytest.raises(InvalidInput, match="process 7 on far") as refused, locked(tmp_path):
        pass
    assert str(refused.value).endswith(f"if it has ended, remove {tmp_path / LOCK}")
    (tmp_path / LOCK).unlink()
    with locked(tmp_path):
        pass


@pytest.mark.parametrize("content", ["", "{", "[1]", '{"process": 3}', "\0" * 9])
def test_a_lock_that_says_nothing_and_is_free_is_taken(content, tmp_path):
    (tmp_path / LOCK).write_text(content)
    with locked(tmp_path):
        assert holder_of(tmp_path) == os.getpid()


@pytest.mark.parametrize("alive", [True, False])
def test_without_locks_of_the_system_the_named_process_is_looked_up(alive, tmp_path, monkeypatch):
    def cannot(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", cannot)
    sign(tmp_path, **({} if alive else {"started": "00000000"}))
    if not alive:
        with locked(tmp_path):
            pass
        return
    with pytest.raises(InvalidInput, match=f"process {os.getpid()} on"), locked(tmp_path):
        pass


def test_the_same_caller_may_lock_again_and_another_thread_may_not(tmp_path):
    told = []

    def work():
        try:
            with locked(tmp_path):
                told.append("locked")
        except InvalidInput as error:
            told.append(str(error))

    with locked(tmp_path), locked(tmp_path):
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
    assert [f"process {os.getpid()} on" in each for each in told] == [True]
    work()
    assert told[1:] == ["locked"]


def test_a_forked_child_does_not_keep_the_lock_of_its_parent(tmp_path):
    ready, go = os.pipe()
    with locked(tmp_path):
        child = os.fork()
        if not child:
            os.close(go)
            os.read(ready, 1)  # until the parent closes it
            os._exit(0)
    with locked(tmp_path):  # while the child lives
        assert holder_of(tmp_path) == os.getpid()
    os.close(go)
    os.waitpid(child, 0)
    os.close(ready)


def test_a_forked_child_that_leaves_the_block_does_not_unlock_its_parent(tmp_path):
    parent = os.getpid()
    try:
        with locked(tmp_path):
            child = os.fork()
            if not child:
                with pytest.raises(InvalidInput, match=f"process {parent}"), locked(tmp_path):
                    pass
                raise KeyboardInterrupt
            assert os.waitpid(child, 0)[1] == 0
            assert (tmp_path / LOCK).exists()
    except BaseException:
        if os.getpid() != parent:
            os._exit(0 if (tmp_path / LOCK).exists() else 1)
        raise


def test_a_lock_follows_no_link(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.write_text("theirs")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / LOCK).symlink_to(foreign)
    with pytest.raises(InvalidInput, match="must be writable"), locked(tmp_path / "run"):
        pass
    assert foreign.read_text() == "theirs"


def test_folders_that_a_lock_made_and_nobody_used_are_removed_again(tmp_path):
    with locked(tmp_path / "a" / "b"):
        assert (tmp_path / "a" / "b").is_dir()
    assert not list(tmp_path.iterdir())


def test_a_lock_that_was_left_is_not_left_again_as_the_process_ends(tmp_path):
    with nothing_left():
        with locked(tmp_path):
            pass
        (tmp_path / LOCK).touch()  # another process is about to sign it
    assert (tmp_path / LOCK).exists()
