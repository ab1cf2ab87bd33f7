"""The page on recordings says what the code does."""

import inspect
import re
from dataclasses import fields, replace

import numpy as np

from benchmarks import recordings
from benchmarks.pages import cells
from benchmarks.speed.log_files import ALL
from coopenv.logs import Layout, analyse, command, read
from coopenv.logs.calibration import Body, Filters, Load, Pose, Sensor
from coopenv.logs.calibration.meaning import MEANING
from coopenv.logs.columns import is_documented
from coopenv.logs.formats import FORMATS
from tests.docs.snippets import snippets
from tests.logs import cases

TABLES = {
    one.code.split(".toml")[0].removeprefix("# "): one.code
    for one in snippets(recordings.PAGE)
    if one.language == "toml"
}
TEXT = recordings.PAGE.read_text(encoding="utf-8")


def test_the_tables_are_what_the_code_prints():
    # else: python -m benchmarks.recordings --write
    assert recordings.page() == TEXT


def test_every_format_is_on_the_page_and_in_the_help():
    for name in (known.suffixes[0] for known in FORMATS):
        assert f"| {name} | {name} |" in TEXT
        assert name in inspect.getsource(command)


def test_every_kind_of_file_that_is_measured_is_on_the_page():
    # else: python -m benchmarks.speed.logs --only NAME --write
    assert [line[0] for line in cells(recordings.PAGE, "speed")[1:]] == [each.name for each in ALL]


def test_every_column_of_the_page_is_understood():
    table = TEXT.split("<!-- columns -->")[1]
    named = {name for row in table.splitlines()[3:] for name in re.findall(r"`(\w+)`", row)}
    named -= {"pair", "condition", "trial"}
    assert len(named) > 24
    assert all(is_documented(name) for name in named)


def test_every_result_is_on_the_page_and_in_the_table(tmp_path):
    columns = cases.planar(3)
    path = cases.save(columns, tmp_path / "a.npz")
    made = set(analyse(read(path, Layout(grips=cases.BEAM))).columns)
    made -= set(columns) | {"r1x", "r1y", "r2x", "r2y"}
    table = TEXT.split("<!-- results -->")[1]
    named = re.findall(r"^\| `(\w+)`( …)?", table, flags=re.MULTILINE)
    for name, more in named:
        assert name in made
        pattern = name.replace("f1x", r"[ft]\d[xyz]").replace("share_1", r"share_\d")
        assert (pattern != name) == bool(more)
        made = {each for each in made if not re.fullmatch(pattern, each)}
    assert not made


def test_the_layout_of_the_page_reads_such_a_file(tmp_path):
    (tmp_path / "lab.toml").write_text(TABLES["lab"])
    layout, columns = Layout.load(tmp_path / "lab.toml"), cases.planar(20)
    theirs = {"time": "t", "f1x": "Fx_left", "t1z": "Mz_left"}
    renamed = {theirs.get(name, name): values for name, values in columns.items()}
    recording = read(cases.save(renamed, tmp_path / "b.npz"), layout)
    np.testing.assert_allclose(recording.applied[:, 0, 2], -columns["t1z"])


def test_the_layout_of_devices_on_the_page_is_one(tmp_path):
    (tmp_path / "devices.toml").write_text(TABLES["devices"])
    motion, left, right = Layout.load(tmp_path / "devices.toml").devices("motion")
    assert (motion.path, left.unit, left.delay, left.dialect.skip_lines) == ("", "ms", 0.1, 3)
    assert (right.rate, right.start, right.dialect.skip_lines) == (1000.0, 0.0, 0)


def test_the_calibration_of_the_page_reads_such_a_file(tmp_path):
    (tmp_path / "sensors.toml").write_text(TABLES["sensors"])
    layout = replace(Layout.load(tmp_path / "sensors.toml"), angle="deg", max_rows=10**6)
    columns = cases.spatial(300)
    columns |= {f"q{j}": columns.pop(f"q{axis}") for j, axis in enumerate("xyzw")}
    columns["time"] = np.arange(300) * 0.01
    recording = read(cases.save(columns, tmp_path / "a.npz"), layout)
    np.testing.assert_allclose(recording.applied[:201, 0].mean(axis=0), 0.0, atol=2.0)
    assert len(recording.done) == 5
    assert recording.done[-1] == "delay: for 4 rows at ends of trials no pose came: no results"


def test_every_key_of_the_calibration_is_on_the_page():
    kinds = {"sensors.1": Sensor, "sensors.1.load": Load, "pose": Pose, "filters": Filters,
             "body": Body}  # fmt: skip
    names = {f"{table}.{entry.name}" for table, kind in kinds.items() for entry in fields(kind)}
    assert names - {"sensors.1.load"} == set(MEANING)
