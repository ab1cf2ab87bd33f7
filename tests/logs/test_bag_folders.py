"""Rosbag2 folders are read as the files in them are, and what is wrong with one is said."""

import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags")
pytest.importorskip("pyarrow")

from ruamel.yaml import YAML

from coopenv.__main__ import main
from coopenv.errors import InvalidInput
from coopenv.logs import Layout, decompose_file, read
from coopenv.logs.formats.bags.folder import require_whole
from coopenv.logs.limits import Limits
from coopenv.logs.recording import Reader
from tests.logs import cases, devices
from tests.logs.kinds import ROWS, recorded

LAYOUT = Layout(grips=cases.BEAM, **devices.OF_TOPICS)
TOLD = "rosbag2_bagfile_information"


def bag(folder: Path, storage: str = "MCAP", **said: Any) -> Path:
    return devices.rosbag2_folder(recorded(), folder, storage, **said)


def told(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Have `metadata.yaml` of a bag say something else."""
    path = folder / "metadata.yaml"
    content = YAML(typ="safe").load(path.read_text())
    change(content[TOLD])
    with path.open("w") as file:
        YAML(typ="safe").dump(content, file)


@pytest.mark.parametrize(
    ("storage", "compressed"),
    [
        ("MCAP", ""),
        ("SQLITE3", ""),
        ("MCAP", "FILE"),
        ("SQLITE3", "FILE"),
        ("SQLITE3", "MESSAGE"),
        ("MCAP", "STORAGE"),
    ],
)
def test_a_folder_is_read_whatever_is_in_it_and_however_it_is_compressed(
    storage, compressed, tmp_path
):
    found = read(bag(tmp_path, storage, compressed=compressed), LAYOUT)
    np.testing.assert_allclose(found.applied, cases.wrench(recorded()), rtol=1e-9)


def test_a_bag_of_several_files_is_one_recording(tmp_path):
    columns = recorded()
    halves = [
        {name: each[part] for name, each in columns.items()}
        for part in (slice(0, ROWS // 2), slice(ROWS // 2, None))
    ]
    first, second = (
        devices.rosbag2_folder(half, tmp_path, "MCAP", name=f"half{k}")
        for k, half in enumerate(halves)
    )
    (second / "half1.mcap").rename(first / "half1.mcap")
    told(first, lambda said: said["relative_file_paths"].append("half1.mcap"))
    reader = Reader(first, LAYOUT)
    found = [recording.applied for recording in reader]
    np.testing.assert_allclose(np.concatenate(found), cases.wrench(columns), rtol=1e-9)
    says = [note for note in reader.notes if "says that it has" in note]
    assert any("4 messages of /left/wrench, and has 8" in note for note in says)


def test_the_table_is_written_beside_the_folder(tmp_path):
    summary = decompose_file(bag(tmp_path), layout=LAYOUT, picture=False)
    assert summary.table == tmp_path / "bag.decomposed.csv"
    assert summary.table.is_file()
    assert sorted(each.name for each in (tmp_path / "bag").iterdir()) == [
        "bag.mcap",
        "metadata.yaml",
    ]


def test_a_folder_is_looked_through_and_its_layout_reads_it(tmp_path, capsys):
    path, layout = bag(tmp_path), tmp_path / "first.toml"
    main(["inspect", str(path), "--write", str(layout)])
    assert f"{path}, /left/wrench: 8 rows" in capsys.readouterr().out
    assert Layout.load(layout, grips=cases.BEAM, space="plane").files["/left/wrench"]


def test_a_folder_may_be_the_file_of_a_device(tmp_path):
    columns = recorded()
    bag(tmp_path)
    csv = cases.save(
        {name: columns[name] for name in ("time", "f1x", "f1y", "t1z")}, tmp_path / "l.csv"
    )
    start = devices.START / 1e9
    right = {"path": "bag", "part": "/right/wrench", "delay": start}
    names = {"f2x": "wrench/force/x", "f2y": "wrench/force/y", "t2z": "wrench/torque/z"}
    layout = Layout(grips=cases.BEAM, space="plane", columns=names, files={"right": right})
    with pytest.raises(InvalidInput, match="devices must have samples at the same time"):
        read(csv, layout)  # a clock that begins in 1970, and one that begins with the trial
    found = read(
        csv,
        Layout(
            grips=cases.BEAM, space="plane", columns=names, files={"right": {**right, "delay": 0.0}}
        ),
    )
    np.testing.assert_allclose(found.applied, cases.wrench(columns), rtol=1e-6)


WRONG: dict[str, tuple[Callable[[Path], object], str]] = {
    "no metadata": (
        lambda path: (path / "metadata.yaml").unlink(),
        r"bag must have a metadata.yaml like every rosbag2 folder, got none; name bag.mcap in it",
    ),
    "nothing at all": (
        lambda path: [each.unlink() for each in path.iterdir()],
        r"must be a file or a rosbag2 folder with a metadata.yaml, got the folder .*; name a file",
    ),
    "a file is missing": (
        lambda path: (path / "bag.mcap").unlink(),
        r"bag must have the files that its metadata.yaml names, got none called 'bag.mcap'",
    ),
    "no YAML": (
        lambda path: (path / "metadata.yaml").write_text("a: [1,"),
        r"metadata.yaml must be YAML that tells of a bag, got .*; run ros2 bag reindex",
    ),
    "no text": (
        lambda path: (path / "metadata.yaml").write_bytes(b"\xff\xfe\x00"),
        r"metadata.yaml must be YAML that tells of a bag, got UnicodeDecodeError",
    ),
    "another table": (
        lambda path: (path / "metadata.yaml").write_text("a: 1"),
        r"metadata.yaml must be YAML that tells of a bag, got KeyError",
    ),
    "a list": (
        lambda path: (path / "metadata.yaml").write_text(f"{TOLD}: [1]"),
        r"metadata.yaml must be a table of what is in the bag, got \[1\]",
    ),
    "aliases": (
        lambda path: (path / "metadata.yaml").write_text(f"a: &a [x]\n{TOLD}: {{b: [*a, *a]}}"),
        r"metadata.yaml must be a table of what is in the bag, got an alias in it",
    ),
    "too large": (
        lambda path: (path / "metadata.yaml").write_text("#" * (1 << 20) + "\n"),
        r"metadata.yaml must be at most 1,048,576 bytes, got more",
    ),
    "no names": (
        lambda path: told(path, lambda said: said.pop("relative_file_paths")),
        r"must name the files of the bag under relative_file_paths, got 'None'",
    ),
    "a name twice": (
        lambda path: told(path, lambda said: said["relative_file_paths"].append("bag.mcap")),
        r"must name each file once, got 'bag.mcap' twice",
    ),
    "another storage": (
        lambda path: told(path, lambda said: said.update(storage_identifier="tape")),
        r"bag must be a whole ROS bag, got .*'tape' not supported",
    ),
    "a duration that is none": (
        lambda path: told(path, lambda said: said.update(duration={"nanoseconds": "long"})),
        r"bag must be a whole ROS bag, got",
    ),
    "half a file": (
        lambda path: (path / "bag.mcap").write_bytes((path / "bag.mcap").read_bytes()[:700]),
        r"bag must be a whole ROS bag, got .*; record or convert it again",
    ),
    "a name of ROS 1": (
        lambda path: path.rename(path.with_name("bag.bag")),
        r"bag.bag must not end in .bag, which ROS 1 files do, got a folder; rename it",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_with_a_folder_is_said(what, tmp_path):
    spoil, says = WRONG[what]
    spoil(bag(tmp_path))
    (path,) = tmp_path.iterdir()
    with pytest.raises(InvalidInput, match=says) as raised:
        read(path, LAYOUT)
    assert "\n" not in str(raised.value)


def test_what_inflates_to_more_than_may_be_read_at_once_is_refused(tmp_path):
    path = bag(tmp_path, "SQLITE3", compressed="FILE")
    layout = Layout(grips=cases.BEAM, **devices.OF_TOPICS, max_block_bytes=1000)
    with pytest.raises(
        InvalidInput, match=r"at most 1,000 bytes to be read at once.*smaller files"
    ):
        read(path, layout)


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="looks like 3.14, which this is")
def test_from_python_3_14_on_its_own_zstandard_inflates(tmp_path, monkeypatch):
    from backports import zstd

    path = bag(tmp_path, "SQLITE3", compressed="FILE")
    inflated = []

    def opened(file, mode):
        inflated.append(Path(file).name)
        return zstd.open(file, mode)

    monkeypatch.setattr(sys, "version_info", (3, 14, 0))
    monkeypatch.setitem(
        sys.modules, "compression", SimpleNamespace(zstd=SimpleNamespace(open=opened))
    )
    monkeypatch.setitem(sys.modules, "backports", None)
    require_whole(path, Limits())
    assert inflated == [each.name for each in path.iterdir() if each.suffix == ".zstd"]
