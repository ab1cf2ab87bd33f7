"""Whatever is wrong with a file, a folder, the disk or a number, one sentence says it."""

import os
import subprocess
import sys
import zipfile
from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("pyarrow")
pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.logs import Layout, decompose_file, read
from coopenv.logs.formats import FORMATS
from tests.logs import cases

BEAM = Layout(grips=cases.BEAM)


def complaint(capsys, *arguments) -> str:
    """What the command says, which is one line."""
    given = [str(argument) for argument in ("decompose", *arguments, "--grips", *cases.BEAM)]
    assert cli.main(given) == 1
    printed = capsys.readouterr()
    assert printed.err.startswith("coopenv: ")
    assert printed.err.count("\n") == 1
    assert not printed.out.strip()
    return printed.err


def refusal(do: Callable[[], object]) -> str:
    """What our error says; nothing where all goes well."""
    try:
        do()
    except CoopenvError as error:
        return str(error)
    return ""


def test_a_folder_is_no_recording(tmp_path, capsys):
    (tmp_path / "trials.csv").mkdir()
    for folder in (tmp_path, tmp_path / "trials.csv"):
        said = complaint(capsys, folder)
        assert f"got the folder '{folder}'; name a file in it" in said


def test_names_that_the_system_refuses_are_named(tmp_path, capsys):
    long = tmp_path / f"{300 * 'a'}.csv"
    assert "must be readable, got: File name too long; check its name" in complaint(capsys, long)
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    said = complaint(capsys, path, "--out", long)
    assert f"{long} must be writable, got: File name too long" in said
    said = complaint(capsys, path, "--out", path / "table.csv")
    assert "table.csv must be writable, got: " in said
    assert "--out" in said


def test_a_file_without_permission_is_named(tmp_path, capsys, monkeypatch):
    path = cases.save(cases.planar(), tmp_path / "a.csv")

    def refused(*_, **__):
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patch:
        patch.setattr("pathlib.Path.open", refused)
        assert f"{path} must be readable, got: Permission denied" in complaint(capsys, path)
    with monkeypatch.context() as patch:
        patch.setattr("coopenv.files.checks.begin", refused)
        said = complaint(capsys, path)
        assert "a.decomposed.csv must be writable, got: Permission denied" in said
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_outputs_are_tried_before_the_work(tmp_path, capsys, monkeypatch):
    def worked(*_):
        raise AssertionError("rows were decomposed")

    monkeypatch.setattr("coopenv.logs.run.analyse", worked)
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    for name in ("a.decomposed.csv", "a.decomposed.png", "a.decomposed.summary.json"):
        place = tmp_path / name
        place.write_text("")
        with monkeypatch.context() as patch:
            patch.setattr("os.access", lambda given, _, place=place: given != place)
            assert f"{name} is write-protected" in complaint(capsys, path)
        place.unlink()
        place.mkdir()
        assert f"out must be a file, got a folder '{place}'" in complaint(capsys, path)
        place.rmdir()
    assert "out must not be the input" in complaint(capsys, path, "--out", path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_a_full_disk_leaves_nothing_behind(suffix, tmp_path, capsys):
    resource = pytest.importorskip("resource")  # of Unix
    path = cases.save(cases.planar(4000), tmp_path / f"a{suffix}")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))  # stands in for the disk
    try:
        said = complaint(capsys, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert f"a.decomposed{suffix} must be writable, got: " in said
    assert "make room" in said
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_damaged_files_are_answered_with_a_sentence(suffix, tmp_path):
    path = cases.save(cases.planar(300), tmp_path / f"a{suffix}")
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for trial in range(150):
        data = bytearray(whole)
        if trial % 3 == 0:
            data = data[: rng.integers(len(data))]
        else:
            for place in rng.integers(len(data), size=1 if trial % 3 == 1 else 60):
                data[place] = rng.integers(256)
        path.write_bytes(bytes(data))
        said = refusal(lambda: read(path, BEAM))
        if said:
            refused += 1
            assert ";" in said  # there is a remedy
            assert f"a{suffix}" in said
    assert refused > 50


def test_archives_that_numpy_does_not_write_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    for entry, content in (("f1x.npy", b""), ("f1x.npy", b"\x93NUMPY\x09\x00"), ("f1x.txt", b"1")):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(entry, content)
        with pytest.raises(InvalidInput, match=r"a\.npz"):
            read(path, BEAM)


def test_binary_rubbish_is_no_text_table(tmp_path):
    rng = np.random.default_rng(1)
    path = tmp_path / "a.csv"
    rubbish = [
        rng.bytes(5000),
        b"\0" * 5000,
        b'f1x,f1y\n"' + b"a" * 200_000 + b"\n",
        b"\xff\xfe1\0",
    ]
    for content in rubbish:
        path.write_bytes(content)
        with pytest.raises(InvalidInput, match=r"a\.csv"):
            read(path, Layout(grips=(0.0, 0.0), forces_only=True))


def test_a_file_with_a_header_alone_leaves_nothing(tmp_path, capsys):
    path = tmp_path / "a.csv"
    path.write_text(",".join(cases.planar()) + "\n")
    assert f"{path} must have rows of data, got none; record some" in complaint(capsys, path)
    path.write_text("")
    assert f"{path}, line 1 must name the columns, got an empty file" in complaint(capsys, path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("size", [1e300, 1e200, 1e-200, 1e-308])
def test_numbers_beyond_all_measure_are_answered_or_refused(size, tmp_path):
    columns = cases.planar(20)
    for name in columns:
        if name != "time":
            columns[name] = columns[name] * size
    path = cases.save(columns, tmp_path / "a.npz")
    said = refusal(lambda: decompose_file(path, layout=BEAM, picture=False))
    assert ("must be at most 1e+50 in SI units" in said) == (size > 1)


@pytest.mark.parametrize(
    "content",
    ["grips = 3", "columns = 3", "forces_only = 'no'", "trial_columns = 3", "frame = [1]",
     "trial_columns = [1]", "[columns]\nf1x = 1", "force = {}", "grips = 'a'"],
)  # fmt: skip
def test_a_layout_of_other_types_is_explained(content, tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(content)
    with pytest.raises(CoopenvError, match=r"must|known"):
        Layout.load(path)


@pytest.mark.parametrize("field", ['"o\rk"', "o\rk", '"ok"\r', "\rok"])
def test_a_carriage_return_within_a_line_is_a_bad_row(field, tmp_path):
    path = tmp_path / "a.csv"
    good = "1,2,3,4,5,6,ok\r\n"
    content = f"f1x,f1y,t1z,f2x,f2y,t2z,note\r\n{good}1,2,3,4,5,6,{field}x\r\n{good}"
    path.write_bytes(content.encode())
    said = refusal(lambda: read(path, BEAM))
    assert f"{path}, line 3 must have 7 fields like the header, got a carriage return" in said
    assert read(path, BEAM, bad_rows="skip").good.tolist() == [True, False, True]


def test_text_that_is_not_utf_8_is_named_by_its_line(tmp_path):
    lines = [b"f1x,f1y,t1z,f2x,f2y,t2z,note", *[b"1,2,3,4,5,6,ok"] * 50]
    lines[37] = b"1,2,3,4,5,6,K\xf6ln"
    path = tmp_path / "a.csv"
    path.write_bytes(b"\n".join(lines))
    assert f"{path}, line 38 must be CSV in UTF-8" in refusal(lambda: read(path, BEAM))


@pytest.mark.parametrize("suffix", [".toml", ".json"])
def test_a_layout_nested_too_deeply_or_too_large_is_refused(suffix, tmp_path):
    path = tmp_path / f"lab{suffix}"
    begin, end = ("grips = ", "") if suffix == ".toml" else ('{"grips": ', "}")
    for value, says in (
        ("[" * 100_000 + "]" * 100_000, "must be a readable file"),
        ("[" * 20 + "]" * 20, "must be nested at most 8 deep"),
        ('"' + "é" * 2000 + '"', "must have texts of at most 1,000 characters, got 2,000"),
        ("[" + "1," * 600_000 + "1]", "must be a layout of at most 1,048,576 bytes"),
        ("[" + "1," * 3000 + '"a"]', "grips must be an array of numbers, got"),
    ):
        path.write_text(begin + value + end, encoding="utf-8")
        said = refusal(lambda: Layout.load(path))
        assert says in said
        assert str(path) in said
        assert ";" in said
        assert len(said) < 1000


@pytest.mark.parametrize("content", ["frame = [1]", "angle = 3", "grips = ['a']", "max_rows = -1"])
def test_what_is_wrong_in_a_layout_names_its_file(content, tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(content)
    assert str(path) in refusal(lambda: Layout.load(path))
    path.write_text("")
    assert str(path) not in refusal(lambda: Layout.load(path, force="kn"))


def test_grips_that_do_not_go_with_the_columns_name_the_recording(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.npz")
    said = refusal(lambda: read(path, Layout(grips=(1.0, 2.0, 3.0))))
    assert said.startswith(f"{path}: grips must be 2 or 3 numbers for each of 2 effectors")


def test_a_layout_saved_with_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "lab.json"
    path.write_text('{"force": "kN"}', encoding="utf-8-sig")
    assert Layout.load(path).force == "kN"


def test_a_column_called_like_a_measure_is_no_measure(tmp_path):
    names = ("internal_power", "force_load_share_7")
    columns = cases.planar() | dict.fromkeys(names, np.array(["a"] * 40))
    columns = {name: values for name, values in columns.items() if name[0] not in "vo"}
    summary = decompose_file(cases.save(columns, tmp_path / "a.csv"), layout=BEAM, picture=False)
    assert not set(names) & {measure.name for measure in summary.measures}


def test_a_name_of_a_file_is_no_formula_in_the_picture(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a $\\frac$.csv")
    assert decompose_file(path, layout=BEAM).picture == path.with_suffix(".decomposed.png")


def test_a_name_that_is_no_text_is_written_and_printed(tmp_path, capfd):
    path = tmp_path / os.fsdecode(b"\xff.csv")
    try:
        cases.save(cases.planar() | {"f1x": np.full(40, np.nan)}, path)
    except OSError:
        pytest.skip("this file system takes no such names")
    given = ("--grips", *map(str, cases.BEAM), "--bad-rows", "skip")
    assert cli.main(["decompose", str(path), *given]) == 0
    printed = capfd.readouterr().out
    assert "\\xff.decomposed.csv" in printed
    assert "\\xff.csv,line2" in "".join(printed.split())  # long lines are broken anywhere


def test_what_no_unit_can_hold_is_a_bad_row_without_a_warning(tmp_path):
    columns = cases.planar(5) | {"note": np.array(["1e300", "2", "3", "4", "5"])}
    columns["f1x"][2], columns["x"][3] = 1e308, 1e308
    path = cases.save(columns, tmp_path / "a.csv")
    layout = Layout(grips=cases.BEAM, force="kN", length="ft", frame="world")
    recording = read(path, layout, bad_rows="skip")
    assert recording.good.tolist() == [True, True, False, True, True]
    assert recording.carried["note"][0] == 1e300


def test_quaternions_of_any_size_are_compared_without_a_warning(tmp_path):
    columns = cases.spatial(40) | {"time": np.arange(40.0)}
    columns["qw"][7] = 1e300
    path = cases.save(columns, tmp_path / "a.npz")
    assert decompose_file(path, picture=False).bad_rows == 0
    layout = Layout(frame="world")
    assert decompose_file(path, layout=layout, bad_rows="skip", picture=False).bad_rows == 1


@pytest.mark.parametrize("hidden", ["tyro", "rich.console", "pyarrow.csv", "matplotlib.figure"])
def test_a_bare_install_asks_for_the_extra_of_recordings(hidden, tmp_path, capsys, monkeypatch):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    monkeypatch.setitem(sys.modules, hidden, None)
    assert "pip install 'coopenv[analysis]'" in complaint(capsys, path)


def test_the_command_can_be_asked_for_where_nothing_optional_is_installed():
    hide = "import sys; sys.modules.update(dict.fromkeys(['tyro', 'rich', 'pyarrow', 'pandas']));"
    run = "from coopenv import cli; sys.exit(cli.main(['decompose', 'a.csv']))"
    done = subprocess.run([sys.executable, "-c", hide + run], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.startswith("coopenv: the command line needs an optional package")
    assert "coopenv[analysis]" in done.stderr


def test_no_format_is_left_out_here():
    assert [known.suffixes[0] for known in FORMATS] == list(cases.FORMATS)
