"""Left-overs of dead processes are swept; those of live ones, and what is not ours, are not."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from coopenv.files import sweep, written
from coopenv.files.process import Process

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="nothing is swept there")


def leave(target: Path, owner: Process) -> Path:
    """A file that a process left behind while it wrote ``target``."""
    mark = f"{owner.pid}-{owner.started}-{owner.host}-{os.urandom(8).hex()}"
    path = target.with_name(f".{target.name}.{mark}.part{target.suffix}")
    path.write_text("half")
    return path


@pytest.fixture
def dead() -> Process:
    """A process of this machine that has ended."""
    child = subprocess.Popen(["true"])
    child.wait()
    return replace(Process.current(), pid=child.pid, started="0123abcd")


def test_a_writer_that_is_killed_leaves_what_the_next_removes(tmp_path):
    path = tmp_path / "table.csv"
    child = os.fork()
    if not child:
        with written(path) as part:
            part.write_text("half")
            os.kill(os.getpid(), 9)
    os.waitpid(child, 0)
    (left,) = tmp_path.iterdir()
    assert left.suffix == ".csv"
    with written(path) as part:
        part.write_text("whole")
    assert [each.name for each in tmp_path.iterdir()] == ["table.csv"]


def test_left_overs_of_other_targets_are_removed_by_a_sweep_of_the_folder_only(tmp_path, dead):
    other = leave(tmp_path / "other.png", dead)
    with written(tmp_path / "table.csv"):
        pass
    assert other.exists()
    assert sweep(tmp_path) == [other]
    assert not other.exists()


def test_a_process_that_was_given_the_number_of_a_dead_one_protects_nothing(tmp_path):
    reused = replace(Process.current(), started="0123abcd")
    left = leave(tmp_path / "table.csv", reused)
    assert sweep(tmp_path) == [left]


def test_what_a_live_process_writes_stays(tmp_path):
    with written(tmp_path / "table.csv") as part:
        assert not sweep(tmp_path)
        with written(tmp_path / "table.csv") as second:
            second.write_text("second")
        part.write_text("first")
    assert (tmp_path / "table.csv").read_text() == "first"


def test_what_another_machine_or_container_left_stays(tmp_path, dead):
    left = leave(tmp_path / "table.csv", replace(dead, host="00000000"))
    assert not sweep(tmp_path)
    assert left.exists()


@pytest.mark.parametrize(
    "name",
    [
        "table.csv",
        ".part-1-table.csv",
        ".table.csv.part",
        ".table.csv.{pid}-{started}-{host}.part.csv",
        "table.csv.{pid}-{started}-{host}-{random}.part.csv",
        ".table.csv.{pid}-{started}-{host}-{random}.part.csv.keep/x",
        ".table.csv.{pid}-{started}-{host}-{random}.copy.csv",
    ],
)
def test_what_is_not_ours_stays(name, tmp_path, dead):
    path = tmp_path / name.format(
        pid=dead.pid, started=dead.started, host=dead.host, random=16 * "0"
    )
    path.parent.mkdir(exist_ok=True)
    path.write_text("theirs")
    assert not sweep(tmp_path)
    assert path.read_text() == "theirs"


def test_links_and_folders_of_such_a_name_stay(tmp_path, dead):
    (tmp_path / "foreign").write_text("theirs")
    link, folder = (leave(tmp_path / name, dead) for name in ("a.csv", "b.csv"))
    for path in (link, folder):
        path.unlink()
    link.symlink_to(tmp_path / "foreign")
    folder.mkdir()
    assert not sweep(tmp_path)
    assert link.is_symlink()
    assert folder.is_dir()


def test_left_overs_of_a_long_name_are_found_again(tmp_path):
    path = tmp_path / (200 * "n" + ".csv")
    child = os.fork()
    if not child:
        with written(path):
            os.kill(os.getpid(), 9)
    os.waitpid(child, 0)
    assert len(list(tmp_path.iterdir())) == 1
    with written(path):
        pass
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
