"""A file goes in; a table, a picture and a summary come out, or nothing at all."""

from pathlib import Path

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs import Layout, analyse, decompose_file, read
from tests.logs import cases

BEAM = Layout(grips=cases.BEAM)


@pytest.fixture(autouse=True)
def _extra():
    pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")


@pytest.mark.parametrize("suffix", cases.FORMATS)
@pytest.mark.parametrize("out", cases.FORMATS)
def test_every_format_holds_what_decompose_says(suffix, out, tmp_path):
    columns = cases.planar() | {
        "trial": np.repeat([1, 2], 20),
        "who": np.repeat(["ann", "b c"], 20),
    }
    path = cases.save(columns, tmp_path / f"trial{suffix}")
    summary = decompose_file(path, tmp_path / f"out{out}", layout=BEAM, picture=False)
    table = cases.load(summary.table)
    split = wrench.decompose(cases.wrench(columns), np.reshape(cases.BEAM, (2, 2)))
    energy = split.energy_share(np.stack([columns[k] for k in ("vx", "vy", "omega")], axis=-1))
    np.testing.assert_array_equal(cases.wrench(table), split.applied)
    np.testing.assert_array_equal(cases.wrench(table, "manipulation_"), split.manipulation)
    np.testing.assert_array_equal(cases.wrench(table, "internal_"), split.internal)
    expected = {
        "internal_force_level": split.internal_force_level,
        "internal_torque_level": split.internal_torque_level,
        "relative_cost": split.relative_cost,
        "wasted_cost": split.wasted_cost,
        "force_load_share_2": split.load_share.force[:, 1],
        "torque_load_share_1": split.load_share.torque[:, 0],
        "energy_share_1": energy.total[:, 0],
        "linear_energy_share_2": energy.linear[:, 1],
        "angular_energy_share_2": energy.angular[:, 1],
        "internal_power": energy.internal_power,
        "cost": split.cost,
        "applied_cost": split.applied_cost,
        "gap": split.gap,
        "time": columns["time"],
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(table[name], values, err_msg=name)
    assert [int(number) for number in table["trial"]] == columns["trial"].tolist()
    assert list(table["who"]) == columns["who"].tolist()
    assert (summary.rows, summary.trials, summary.bad_rows) == (40, 2, 0)
    assert summary.duration == pytest.approx(0.38)


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_the_table_is_a_recording_itself(suffix, tmp_path):
    path = cases.save(cases.planar(), tmp_path / f"trial{suffix}")
    first = decompose_file(path, layout=BEAM, picture=False)
    again = decompose_file(first.table, tmp_path / f"again{suffix}", picture=False)
    one, other = cases.load(first.table), cases.load(again.table)
    assert list(one) == sorted(other, key=list(one).index)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_the_table_needs_no_option_whatever_was_left_out(suffix, tmp_path):
    columns = cases.planar() | {name: np.ones(40) for name in ("f1z", "t1x", "f0", "t2y", "r1x")}
    columns["Fx"] = columns.pop("f2x")
    mapping = {"f2x": "Fx", "vx": "", "vy": "", "omega": "", "time": "", "r1x": ""}
    layout = Layout(grips=cases.BEAM, space="plane", columns=mapping)
    path = cases.save(columns, tmp_path / f"trial{suffix}")
    first = decompose_file(path, layout=layout, picture=False)
    assert set(first.left_out) == {"f1z", "t1x", "t2y", "vx", "vy", "omega", "time", "r1x"}
    again = decompose_file(first.table, tmp_path / f"again{suffix}", picture=False)
    one, other = cases.load(first.table), cases.load(again.table)
    assert set(one) == set(other)
    assert "f0" in one
    np.testing.assert_array_equal(one["internal_f1y"], other["internal_f1y"])


def test_a_picture_of_an_earlier_table_is_pointed_out(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "trial.csv")
    assert decompose_file(path, layout=BEAM, picture=False).old_picture is None
    (tmp_path / "trial.decomposed.png").touch()
    old = decompose_file(path, layout=BEAM, picture=False).old_picture
    assert old == tmp_path / "trial.decomposed.png"


def test_the_table_stands_beside_the_file_with_its_picture(tmp_path):
    pytest.importorskip("matplotlib")
    path = cases.save(cases.planar(), tmp_path / "trial.csv")
    done = []
    summary = decompose_file(path, layout=BEAM, report=done.append)
    assert {each.name for each in tmp_path.iterdir()} == {
        "trial.csv", "trial.decomposed.csv", "trial.decomposed.png",
        "trial.decomposed.summary.json",
    }  # fmt: skip
    assert summary.picture is not None
    assert summary.picture.read_bytes().startswith(b"\x89PNG")
    assert done == [1.0]


@pytest.mark.parametrize(
    "columns",
    [cases.planar(12, 3), cases.planar(12, 1), cases.spatial(), cases.spatial(4, 5)],
    ids=["three in the plane", "one", "two in space", "five in space"],
)
def test_any_number_of_effectors_in_plane_and_space(columns, tmp_path):
    count = len(cases.wrench(columns)[0])
    grips = None if "r1x" in columns else np.random.default_rng(1).normal(size=(count, 2))
    layout = Layout() if grips is None else Layout(grips=tuple(map(tuple, grips.tolist())))
    summary = decompose_file(cases.save(columns, tmp_path / "a.npz"), layout=layout, picture=False)
    table = cases.load(summary.table)
    if grips is None:
        grips = np.array([[columns[f"r{i + 1}{a}"][0] for a in "xyz"] for i in range(count)])
    split = wrench.decompose(cases.wrench(columns), grips)
    np.testing.assert_allclose(table["relative_cost"], split.relative_cost, atol=1e-6)
    np.testing.assert_allclose(cases.wrench(table, "internal_"), split.internal, atol=1e-5)
    assert max(summary.worst) < 1e-6


def test_grips_may_move(tmp_path):
    columns = cases.planar(30)
    reach = np.linspace(0.5, 1.5, 30)
    columns |= {"r1x": -reach, "r1y": 0 * reach, "r2x": reach, "r2y": 0 * reach}
    summary = decompose_file(cases.save(columns, tmp_path / "a.csv"), picture=False)
    grips = np.stack([np.stack([-reach, 0 * reach], -1), np.stack([reach, 0 * reach], -1)], 1)
    split = wrench.decompose(cases.wrench(columns), grips)
    table = cases.load(summary.table)
    np.testing.assert_array_equal(table["relative_cost"], split.relative_cost)
    np.testing.assert_array_equal(table["r2x"], reach)


def test_what_is_undefined_is_an_empty_field(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("f1x,f1y,t1z,f2x,f2y,t2z\n1,0,0,-1,0,0\n1,0,0,1,0,0\n")
    summary = decompose_file(path, layout=BEAM, picture=False)
    header, squeeze, _ = summary.table.read_text().splitlines()
    row = dict(zip(header.split(","), squeeze.split(","), strict=True))
    assert row["force_load_share_1"] == ""
    assert float(row["relative_cost"]) == 1.0
    (share,) = [each for each in summary.measures if each.name == "force_load_share_1"]
    assert share.undefined == 0.5
    assert share.mean == share.median == 0.5


def test_the_method_and_the_cost_can_be_chosen(tmp_path):
    columns = cases.planar()
    path = cases.save(columns, tmp_path / "a.npz")
    for settings in (
        wrench.Settings(method="nonsqueezing"),
        wrench.Settings(torque_weight=0.2, include_induced=True),
    ):
        summary = decompose_file(path, layout=BEAM, settings=settings, picture=False)
        split = wrench.Decomposer(np.reshape(cases.BEAM, (2, 2)), settings)(cases.wrench(columns))
        table = cases.load(summary.table)
        np.testing.assert_array_equal(table["relative_cost"], split.relative_cost)
        assert summary.method == settings.method


def test_a_method_that_does_not_go_with_the_file_is_refused_and_nothing_is_written(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    with pytest.raises(InvalidInput, match=r"a\.csv.*net_force"):
        decompose_file(path, layout=BEAM, settings=wrench.Settings(method="net_force"))
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_surroundings_of_which_a_file_says_nothing_are_refused_and_nothing_is_written(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    asked = wrench.Settings(surroundings=True)
    with pytest.raises(InvalidInput, match=r"surroundings must be False .* one more effector"):
        decompose_file(path, layout=BEAM, settings=asked)
    with pytest.raises(InvalidInput, match="surroundings must be False"):
        analyse(read(path, layout=BEAM), asked)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_a_late_bad_row_leaves_neither_table_nor_picture(tmp_path, monkeypatch):
    monkeypatch.setattr("coopenv.logs.formats.text.BLOCK", 512)
    columns = cases.planar(100)
    columns["f2y"][90] = np.nan
    path = cases.save(columns, tmp_path / "a.csv")
    done = []
    with pytest.raises(InvalidInput, match=r"a\.csv, line 92, column 'f2y' .*'nan'"):
        decompose_file(path, layout=BEAM, report=done.append)
    assert len(done) > 3  # much of it had been done
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_a_picture_that_fails_takes_the_table_with_it(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    path = cases.save(cases.planar(), tmp_path / "a.csv")

    def broken(*_):
        raise OSError("disk full")

    monkeypatch.setattr("coopenv.logs.figure.Picture.draw", broken)
    with pytest.raises(OSError, match="disk full"):
        decompose_file(path, layout=BEAM)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_the_input_is_never_written_over(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    (tmp_path / "b").mkdir()
    with pytest.raises(InvalidInput, match="out must not be the input"):
        decompose_file(path, tmp_path / "b" / ".." / "a.csv", layout=BEAM)


def test_a_folder_of_the_name_leaves_neither_table_nor_picture(tmp_path):
    path = cases.save(cases.planar(), tmp_path / "a.csv")
    for name in ("b.csv", "c.png"):
        (tmp_path / name).mkdir()
        with pytest.raises(InvalidInput, match="out must be a file"):
            decompose_file(path, (tmp_path / name).with_suffix(".csv"), layout=BEAM)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.csv", "b.csv", "c.png"]


@pytest.mark.parametrize("missing", [2, 33])
@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_integers_of_which_some_are_missing_are_carried(suffix, missing, tmp_path, monkeypatch):
    pandas = pytest.importorskip("pandas")
    monkeypatch.setattr("coopenv.logs.formats.parquet.CHUNK_ROWS", 10)
    table = pandas.DataFrame(cases.planar(40)).assign(count=pandas.array(range(40), dtype="Int64"))
    table.loc[missing, "count"] = pandas.NA
    table.to_parquet(tmp_path / "a.parquet")
    out = tmp_path / f"out{suffix}"
    decompose_file(tmp_path / "a.parquet", out, layout=BEAM, picture=False)
    counted = np.array(list(map(float, cases.load(out)["count"])))
    expected = np.arange(40.0)
    expected[missing] = np.nan
    np.testing.assert_array_equal(counted, expected)


@pytest.mark.parametrize("chunk", [1, 7, 1000])
@pytest.mark.parametrize("suffix", cases.FORMATS)
def test_the_size_of_the_chunks_changes_nothing(suffix, chunk, tmp_path, monkeypatch):
    columns = cases.planar() | {"trial": np.repeat([1, 2, 2, 3], 10)}
    columns["time"] = np.concatenate([np.arange(length) * 0.1 for length in (10, 20, 10)])
    path = cases.save(columns, tmp_path / f"a{suffix}")
    whole = decompose_file(path, tmp_path / "whole.npz", layout=BEAM, picture=False)
    cases.set_chunk(chunk, monkeypatch)
    parts = decompose_file(path, tmp_path / "parts.npz", layout=BEAM, picture=False)
    one, other = cases.load(whole.table), cases.load(parts.table)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)
    assert whole.duration == pytest.approx(parts.duration)
    assert whole.trials == parts.trials == 3
    for a, b in zip(whole.measures, parts.measures, strict=True):
        assert a.mean == pytest.approx(b.mean)
        assert (a.median, a.low, a.high, a.largest) == (b.median, b.low, b.high, b.largest)


def test_an_analysis_is_a_data_frame_and_goes_trial_by_trial(tmp_path):
    columns = cases.planar() | {"trial": np.repeat([1, 2], 20), "who": np.repeat(["a", "b"], 20)}
    columns["time"] = np.tile(np.arange(20) * 0.1, 2)
    recording = read(cases.save(columns, tmp_path / "a.csv"), BEAM)
    assert recording.carried["trial"].tolist() == columns["trial"].tolist()  # numbers again
    parts = list(recording.trials())
    assert [len(part) for part in parts] == [20, 20]
    assert parts[1].time is not None
    assert parts[1].time[0] == 0.0
    frame = analyse(parts[1]).frame()
    assert frame["who"].tolist() == ["b"] * 20
    whole = analyse(recording)
    np.testing.assert_array_equal(frame["cost"], whole["cost"][20:])


def test_npz_needs_no_extra(tmp_path, monkeypatch):
    import sys

    for name in ("pyarrow", "pyarrow.csv", "pyarrow.parquet", "pandas"):
        monkeypatch.setitem(sys.modules, name, None)
    path = cases.save(cases.planar(), tmp_path / "a.npz")
    assert decompose_file(path, layout=BEAM, picture=False).rows == 40
    with pytest.raises(MissingExtra, match=r"coopenv\[analysis\]"):
        read(cases.save(cases.planar(), tmp_path / "a.csv"), BEAM)
    with pytest.raises(MissingExtra, match=r"coopenv\[analysis\]"):
        decompose_file(path, tmp_path / "b.parquet", layout=BEAM, picture=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[analysis\]"):
        decompose_file(path, layout=BEAM)


def test_rows_that_are_passed_over_are_nan_and_counted(tmp_path):
    columns = cases.planar(10)
    columns["f1x"][3] = np.inf
    columns["time"][6] = columns["time"][4]
    for suffix in cases.FORMATS:
        path = cases.save(columns, tmp_path / f"a{suffix}")
        summary = decompose_file(path, layout=BEAM, bad_rows="skip", picture=False)
        table = cases.load(summary.table)
        assert np.flatnonzero(np.isnan(table["relative_cost"])).tolist() == [3, 6]
        assert np.isnan(table["f2y"][[3, 6]]).all()
        assert table["time"].tolist() == columns["time"].tolist()
        assert (summary.rows, summary.bad_rows) == (10, 2)
        assert ("line 5" if suffix == ".csv" else "row 4") in summary.first_bad


def test_a_file_without_any_good_row_gives_a_table_of_nan(tmp_path):
    columns = cases.planar(5)
    columns["f1x"][:] = np.nan
    path = cases.save(columns, tmp_path / "a.npz")
    summary = decompose_file(path, layout=BEAM, bad_rows="skip", picture=False)
    assert summary.bad_rows == 5
    assert np.isnan(cases.load(summary.table)["internal_f1x"]).all()
    assert Path(summary.table).exists()
