"""Files are written whole or not at all, under names that nobody can guess."""

import os
import stat
from pathlib import Path

import pytest

from coopenv.errors import FileTrouble, InvalidInput
from coopenv.files import require_writable, written
from coopenv.files.temporary import begin


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def permissions(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def umask():
    """The process's, for the time of a test."""
    before = os.umask(0o027)
    yield
    os.umask(before)


def test_a_file_or_link_that_waits_under_a_temporary_name_is_not_overwritten(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.write_text("theirs")
    (tmp_path / f".part-{os.getpid()}-table.csv").symlink_to(foreign)  # as the names once were
    with written(tmp_path / "table.csv") as part:
        part.write_text("ours")
    assert foreign.read_text() == "theirs"
    assert not (tmp_path / "table.csv").is_symlink()


def test_a_signal_as_soon_as_the_temporary_file_is_there_leaves_nothing(tmp_path, monkeypatch):
    def struck(*given):
        begin(*given)
        raise KeyboardInterrupt

    monkeypatch.setattr("coopenv.files.whole.begin", struck)
    with pytest.raises(KeyboardInterrupt), written(tmp_path / "a.csv"):
        pass
    monkeypatch.setattr("coopenv.files.checks.begin", struck)
    with pytest.raises(KeyboardInterrupt):
        require_writable(tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def test_temporary_names_differ_from_time_to_time_and_keep_the_suffix(tmp_path):
    seen = set()
    for _ in range(3):
        with written(tmp_path / "table.csv") as part:
            seen.add(part.name)
    assert len(seen) == 3
    assert all(name.startswith(".table.csv.") and name.endswith(".part.csv") for name in seen)
    assert names(tmp_path) == ["table.csv"]


def test_a_temporary_file_is_made_by_itself_alone(tmp_path, monkeypatch):
    monkeypatch.setattr("secrets.token_hex", lambda count: "0" * 2 * count)
    with written(tmp_path / "a") as part:
        guessed = part
    target = tmp_path / "target"
    guessed.symlink_to(target)
    with pytest.raises(FileTrouble, match="must be writable"), written(tmp_path / "a") as part:
        part.write_text("ours")
    assert guessed.is_symlink()
    assert not target.exists()


def test_a_link_put_in_place_of_the_temporary_file_is_told(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.write_text("theirs")

    def swap():
        with written(tmp_path / "a") as part:
            part.unlink()
            part.symlink_to(foreign)

    with pytest.raises(FileTrouble):
        swap()
    assert names(tmp_path) == ["foreign"]


def test_a_link_is_replaced_and_what_it_points_to_stays(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with written(tmp_path / "link") as part:
        part.write_text("new")
    assert (tmp_path / "real").read_text() == "old"
    assert (tmp_path / "link").read_text() == "new"
    assert not (tmp_path / "link").is_symlink()


@pytest.mark.usefixtures("umask")
def test_a_new_file_has_the_permissions_that_the_umask_leaves(tmp_path):
    with written(tmp_path / "new") as part:
        part.write_text("")
    assert permissions(tmp_path / "new") == 0o640


@pytest.mark.usefixtures("umask")
@pytest.mark.parametrize("mode", [0o600, 0o664, 0o444])
def test_a_file_that_is_replaced_hands_its_permissions_on_and_is_at_no_time_more_open(
    mode, tmp_path
):
    path = tmp_path / "old"
    path.write_text("old")
    path.chmod(mode)
    with written(path) as part:
        part.write_text("new")
        assert permissions(part) & ~stat.S_IWUSR & ~mode == 0
    assert permissions(path) == mode
    assert path.read_text() == "new"


def test_what_is_written_is_flushed_before_it_replaces_and_its_name_after(tmp_path, monkeypatch):
    done = []
    sync, replace = os.fsync, Path.replace
    path = tmp_path / "table.csv"

    def fsync(file):
        done.append("folder" if stat.S_ISDIR(os.fstat(file).st_mode) else "file")
        sync(file)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", lambda *a: (done.append("replace"), replace(*a))[1])
    with written(path) as part:
        part.write_text("")
    assert done == ["file", "replace", "folder"]


def test_what_cannot_be_flushed_is_told_and_leaves_the_old_file(tmp_path, monkeypatch):
    def full(file):
        raise OSError(28, "No space left on device")

    path = tmp_path / "table.csv"
    path.write_text("old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileTrouble, match="the disk is full: make room"), written(path) as part:
        part.write_text("new")
    assert path.read_text() == "old"
    assert names(tmp_path) == ["table.csv"]


def test_a_device_or_pipe_is_no_file_to_replace(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InvalidInput, match="got the device or pipe"), written(tmp_path / "pipe"):
        pass
    assert names(tmp_path) == ["pipe"]


def test_names_as_long_as_the_system_takes_are_written(tmp_path):
    path = tmp_path / (251 * "n" + ".csv")
    with written(path) as part:
        part.write_text("ours")
        assert part.suffix == ".csv"
    assert path.read_text() == "ours"
