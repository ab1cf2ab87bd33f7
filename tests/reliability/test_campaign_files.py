"""The campaigns against files, for a few seeds: kills, disks that fail, damaged files."""

import builtins
import errno
import io
import os
import signal
import sys

import numpy as np
import pytest

pytest.importorskip("resource")
pytest.importorskip("tyro")
pytest.importorskip("matplotlib")
pytest.importorskip("pyarrow")
pytest.importorskip("statsmodels")
pytest.importorskip("stable_baselines3")

from benchmarks.soak import damaged, disks, kills
from benchmarks.soak.commands import faults, whole
from benchmarks.soak.commands.scenes import SCENES, check_end, check_files
from benchmarks.soak.commands.server import server
from benchmarks.soak.damage.mutations import damaged as damage
from benchmarks.soak.damage.readers import READERS
from coopenv.errors import FileTrouble, InvalidInput
from coopenv.files import reading

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="children are forked and watched")


@pytest.mark.parametrize("seed", [2, 3, 7])  # a decomposition, a training, compiling
def test_killed_commands_lose_nothing_and_go_on(seed, tmp_path):
    assert kills.trial(seed, tmp_path)["kills"] > 0


@pytest.mark.parametrize("seed", [0, 4])  # a training, something short
def test_a_disk_that_fails_is_a_sentence_and_tears_no_file(seed, tmp_path):
    assert disks.trial(seed, tmp_path)["failed_writes"] > 0


@pytest.mark.parametrize("seed", [1, 2, 49])  # 49: a compile cache
def test_damaged_files_are_answered_with_a_sentence(seed, tmp_path):
    assert damaged.trial(seed, tmp_path)["damaged_files"] > 0


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: f"{reader.name} {reader.file}")
def test_what_is_damaged_is_read_while_it_is_whole(reader, tmp_path):
    assert not damaged.is_refused(reader, reader.whole(), tmp_path)


def test_damage_changes_a_file_and_is_the_same_for_the_same_seed():
    for reader in READERS:
        content, suffix = reader.whole(), os.path.splitext(reader.file)[1]
        made = [[damage(content, np.random.default_rng(seed), suffix) for seed in range(20)]] * 2
        assert made[0] == made[1]
        assert sum(each != content for each in made[0]) >= 18


def test_every_injected_failure_strikes(tmp_path):
    """Else the campaign would look at commands that nothing disturbed."""
    scene = next(scene for scene in SCENES if "a.npz" in scene.inputs)
    scene.prepare(tmp_path)
    for kind in ("open", "write", "rename"):
        ended = scene.run(tmp_path, (kind, 0, 28))
        assert ended.struck, kind
        assert ended.code == 1, ended
    ended = scene.run(tmp_path, ("size", 3000, 28))
    assert ended.code == 1, ended


def test_what_is_there_can_be_read_while_the_disk_is_full(tmp_path, monkeypatch):
    """Without end, zeros of ``/dev/full`` were read into memory until the system killed."""
    for module in (builtins, io):  # they come back
        monkeypatch.setattr(module, "open", io.open)
    path = tmp_path / "a.zip"
    path.write_bytes(b"what was there")
    faults.install("write", 0, errno.ENOSPC, folder=str(tmp_path))

    def add() -> None:
        with path.open("r+b") as file:
            assert file.read() == b"what was there"
            file.write(b"more")

    with pytest.raises(OSError, match="No space"):
        add()
    assert path.read_bytes() == b"what was there"


def test_a_child_that_is_killed_says_so_and_the_server_goes_on(tmp_path):
    scene = next(scene for scene in SCENES if scene.name == "evaluate" and not scene.inputs)
    for number in (signal.SIGKILL, signal.SIGTERM):
        child = server().start(scene.task(tmp_path))
        child.kill(number)
        assert child.wait().code in (-number, 128 + number)
    assert scene.run(tmp_path).code == 0


def test_torn_and_foreign_files_are_told(tmp_path):
    scene = next(scene for scene in SCENES if scene.name == "evaluate" and not scene.inputs)
    scene.run(tmp_path)
    check_end(scene, tmp_path)
    table = tmp_path / "table.csv"
    table.write_bytes(table.read_bytes()[:-5])
    with pytest.raises(AssertionError, match=r"table\.csv is neither"):
        check_files(scene, tmp_path, {})
    table.unlink()
    with pytest.raises(AssertionError, match=r"table\.csv was there and is lost"):
        check_files(scene, tmp_path, {"table.csv": b""})
    (tmp_path / ".left-over").touch()
    with pytest.raises(AssertionError, match=r"leaves \.left-over"):
        check_end(scene, tmp_path)


@pytest.mark.parametrize("reader", READERS[:3], ids=lambda reader: reader.file)
def test_half_a_file_is_told(reader, tmp_path):
    path = tmp_path / reader.file
    path.write_bytes(reader.whole())
    whole.require_whole(path)
    path.write_bytes(reader.whole()[:-3])
    with pytest.raises(AssertionError, match="is torn"):
        whole.require_whole(path)


def test_what_a_library_says_of_a_damaged_file_is_one_line_and_blames_no_disk():
    """As pyarrow does, by an OSError that is none of the system's."""
    with pytest.raises(InvalidInput, match="must be whole") as told, reading("a.parquet"):
        raise OSError("Couldn't deserialize thrift\nDeserializing page header failed.\n")
    assert not isinstance(told.value, FileTrouble)
    assert len(str(told.value).splitlines()) == 1
