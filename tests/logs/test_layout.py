"""However a file is laid out, the same trial gives the same answer."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pyarrow")

from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs import Layout, analyse, read
from coopenv.logs.layout import UNITS, parse_mapping
from tests.logs import cases

GRIPS = ((-0.9, 0.0), (0.9, 0.0))
INVARIANT = (
    "relative_cost", "internal_force_level", "internal_torque_level", "cost", "internal_power",
    "force_load_share_1", "torque_load_share_1", "energy_share_1", "linear_energy_share_1",
)  # fmt: skip


def analysed(trial, path, **said):
    return analyse(read(cases.save(trial, path), Layout(**said)))


def same(one, other, names=INVARIANT):
    for name in names:
        np.testing.assert_allclose(one[name], other[name], atol=1e-9, err_msg=name)


def turned(columns, names, angle):
    """Planar vectors turned from the object frame to the world."""
    made = dict(columns)
    for x, y in names:
        made[x] = np.cos(angle) * columns[x] - np.sin(angle) * columns[y]
        made[y] = np.sin(angle) * columns[x] + np.cos(angle) * columns[y]
    return made


FORCES = (("f1x", "f1y"), ("f2x", "f2y"))


def test_forces_and_twist_may_be_in_the_world_frame(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.npz", grips=GRIPS)
    world = turned(columns, (*FORCES, ("vx", "vy")), columns["theta"])
    seen = analysed(world, tmp_path / "b.npz", grips=GRIPS, frame="world")
    same(plain, seen, (*INVARIANT, "internal_f1x", "internal_f2y", "manipulation_t1z"))
    mixed = turned(columns, (("vx", "vy"),), columns["theta"])
    seen = analysed(mixed, tmp_path / "c.npz", grips=GRIPS, twist_frame="world")
    same(plain, seen)
    mixed = turned(columns, FORCES, columns["theta"])
    seen = analysed(mixed, tmp_path / "d.npz", grips=GRIPS, frame="world", twist_frame="object")
    same(plain, seen)


def test_grips_may_be_in_the_world_frame(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.npz", grips=GRIPS)
    for i, (x, y) in enumerate(GRIPS):
        columns[f"r{i + 1}x"], columns[f"r{i + 1}y"] = np.full(40, x), np.full(40, y)
    names = (("r1x", "r1y"), ("r2x", "r2y"))
    world = turned(columns, names, columns["theta"])
    for x, y in names:
        world[x], world[y] = world[x] + columns["x"], world[y] + columns["y"]
    # off the axis by rounding: another solver answers, to its own tolerance
    seen = analysed(world, tmp_path / "b.npz", grip_frame="world")
    for name in ("relative_cost", "cost", "force_load_share_1", "r2x"):
        np.testing.assert_allclose(seen[name], plain[name], atol=1e-6, err_msg=name)


def test_y_down_mirrors_the_internal_wrench_and_changes_no_measure(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.npz", grips=((-0.9, 0.1), (0.9, -0.1)))
    down = {
        name: -values if name in ("f1y", "f2y", "t1z", "t2z", "y", "vy", "theta", "omega")
        else values
        for name, values in columns.items()
    }  # fmt: skip
    grips = ((-0.9, -0.1), (0.9, 0.1))
    seen = analysed(down, tmp_path / "b.npz", grips=grips, y="down")
    same(plain, seen, (*INVARIANT, "internal_f1x", "internal_f1y", "internal_t2z", "r1y"))
    world = turned(down, (*FORCES, ("vx", "vy")), down["theta"])
    seen = analysed(world, tmp_path / "c.npz", grips=grips, y="down", frame="world")
    same(plain, seen, (*INVARIANT, "internal_f1y", "y", "theta"))


def test_space_may_be_in_the_world_frame_and_measures_do_not_depend_on_it(tmp_path):
    columns = cases.spatial()
    plain = analysed(columns, tmp_path / "a.npz")
    rotation = Rotation.from_quat(np.stack([columns[f"q{a}"] for a in "xyzw"], axis=-1))
    world = dict(columns)
    triples = [[f"{kind}{i}{a}" for a in "xyz"] for kind in "ft" for i in (1, 2)]
    triples += [["vx", "vy", "vz"], ["omega_x", "omega_y", "omega_z"]]
    for names in triples:
        vectors = rotation.apply(np.stack([columns[name] for name in names], axis=-1))
        world.update(zip(names, vectors.T, strict=True))
    seen = analysed(world, tmp_path / "b.npz", frame="world")
    np.testing.assert_allclose(seen["f2y"], plain["f2y"], atol=1e-12)
    for name in ("relative_cost", "cost", "internal_power", *INVARIANT[5:]):
        np.testing.assert_allclose(seen[name], plain[name], atol=1e-6, err_msg=name)
    for name in ("internal_f1z", "internal_t2y"):  # flat optima: the solver's tolerance
        np.testing.assert_allclose(seen[name], plain[name], atol=1e-2, err_msg=name)


def test_units_are_converted(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.npz", grips=GRIPS)
    units = {
        "time": "ms", "length": "mm", "force": "kN", "torque": "N·mm", "angle": "deg",
        "velocity": "cm/s", "angular_velocity": "deg/s",
    }  # fmt: skip
    factors = {"time": 1e3, "theta": 180 / np.pi, "omega": 180 / np.pi, "vx": 100, "vy": 100,
               "x": 1e3, "y": 1e3}  # fmt: skip
    other = {
        name: values * factors.get(name, 1e-3 if name[0] == "f" else 1e3)
        for name, values in columns.items()
    }
    seen = analysed(other, tmp_path / "b.npz", grips=((-900, 0), (900, 0)), **units)
    same(plain, seen, (*INVARIANT, "time", "theta", "x", "vx", "omega", "internal_f1x", "r2x"))


@pytest.mark.parametrize(
    ("quantity", "unit", "factor"),
    [("force", "lbf", 4.44822), ("torque", "lbf*ft", 1.355818), ("torque", "lbf*in", 0.1129848),
     ("angular_velocity", "rpm", 2 * np.pi / 60), ("length", "ft", 0.3048)],
)  # fmt: skip
def test_units_have_their_factors(quantity, unit, factor):
    assert Layout(**{quantity: unit}).factor(quantity) == pytest.approx(factor, rel=1e-6)
    assert all(next(iter(known.values())) == 1.0 for known in UNITS.values())


def test_columns_may_have_other_names_and_signs(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.csv", grips=GRIPS)
    theirs = {"f1x": "Fx left", "f1y": "Fy_left", "t1z": "Mz", "time": "t"}
    renamed = {theirs.get(name, name): values for name, values in columns.items()}
    renamed["Mz"] = -renamed["Mz"]  # of the reaction on the sensor
    renamed["f1x"] = np.full(40, 99.0)  # what is mapped wins over the name
    mapping = parse_mapping(["f1x=Fx left", "f1y=Fy_left", "t1z=-Mz", "time=t", "vx="])
    mapping |= dict.fromkeys(("vy", "omega"), "")
    seen = analysed(renamed, tmp_path / "b.csv", grips=GRIPS, columns=mapping)
    same(plain, seen, ("relative_cost", "internal_f1x", "internal_t1z", "time"))
    assert "energy_share_1" not in seen.columns
    assert "vx" not in seen.columns  # it would make half a twist where the table is read again


def test_a_layout_is_read_from_a_file_and_options_win(tmp_path):
    content = {"frame": "world", "grips": [[-1, 0], [1, 0]], "columns": {"f1x": "Fx", "f1y": "Fy"}}
    (tmp_path / "a.json").write_text(json.dumps(content))
    (tmp_path / "a.toml").write_text(
        'frame = "world"\ngrips = [[-1, 0], [1, 0]]\n[columns]\nf1x = "Fx"\nf1y = "Fy"\n'
    )
    for name in ("a.json", "a.toml"):
        layout = Layout.load(tmp_path / name, frame="object", columns={"f1y": "F_y"})
        assert layout == Layout(grips=((-1, 0), (1, 0)), columns={"f1x": "Fx", "f1y": "F_y"})
    (tmp_path / "b.toml").write_text('fram = "world"')
    with pytest.raises(UnknownName, match="did you mean 'frame'"):
        Layout.load(tmp_path / "b.toml")
    (tmp_path / "c.toml").write_text("frame = world")
    for name in ("c.toml", "none.toml", "c.yaml"):
        with pytest.raises(InvalidInput, match="layout must be"):
            Layout.load(tmp_path / name)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"frame": "wrold"}, "did you mean 'world'"),
        ({"force": "kg"}, "unit of force"),
        ({"y": "left"}, "known: down, up"),
        ({"grips": ((1.0,),)}, "grips must be of shape"),
        ({"grips": ((np.nan, 0.0),)}, "grips must be finite"),
        ({"columns": {"g1x": "a"}}, "got 'g1x'"),
    ],
)
def test_a_wrong_layout_is_explained(said, message):
    with pytest.raises((InvalidInput, UnknownName), match=message):
        Layout(**said)


def test_a_mapping_is_name_equals_column():
    assert parse_mapping(["f1x=a=b"]) == {"f1x": "a=b"}
    for wrong in (["f1x"], ["f1x=a", "f1x=b"]):
        with pytest.raises(InvalidInput, match="map must"):
            parse_mapping(wrong)


def test_arrays_of_several_columns_are_understood(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.npz", grips=GRIPS)
    applied = cases.wrench(columns)
    blocks = {
        "time": columns["time"],
        "force": np.asfortranarray(applied[..., :2]),
        "torque": applied[..., 2],
        "grips": np.array(GRIPS),
        "pose": np.stack([columns[name] for name in ("x", "y", "theta")], axis=-1),
        "twist": np.stack([columns[name] for name in ("vx", "vy", "omega")], axis=-1),
        "comment": np.array("a trial"),
    }
    seen = analysed(blocks, tmp_path / "b.npz")
    same(plain, seen, (*INVARIANT, "theta", "internal_f2x"))
    blocks["grips"] = np.broadcast_to(GRIPS, (40, 2, 2))
    same(plain, analysed(blocks, tmp_path / "c.npz"))
    columns = cases.spatial()
    plain = analysed(columns, tmp_path / "d.npz")
    applied = cases.wrench(columns)
    blocks = {
        "force": applied[..., :3],
        "torque": applied[..., 3:],
        "grips": [[columns[f"r{i}{a}"][0] for a in "xyz"] for i in (1, 2)],
        "pose": np.stack([columns[k] for k in ("x", "y", "z", "qw", "qx", "qy", "qz")], -1),
    }
    seen = analysed(blocks, tmp_path / "e.npz")
    np.testing.assert_array_equal(seen["internal_f2z"], plain["internal_f2z"])
    np.testing.assert_array_equal(seen["qy"], plain["qy"])


def test_the_plane_can_be_cut_out_of_six_axis_sensors(tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.csv", grips=GRIPS)
    columns |= {name: np.ones(40) for name in ("f1z", "t1x", "t1y", "f2z", "t2x", "t2y", "heat")}
    seen = analysed(columns, tmp_path / "b.csv", grips=GRIPS, space="plane")
    same(plain, seen)
    assert "t1x" not in seen.columns
    assert seen["heat"].tolist() == [1.0] * 40  # carried


def test_effectors_counted_from_zero_are_refused_or_mapped(tmp_path):
    columns = cases.planar()
    zero = {name.replace("1", "0").replace("2", "1"): values for name, values in columns.items()}
    with pytest.raises(InvalidInput, match="effectors are numbered from 1, got column 'f0x'"):
        analysed(zero, tmp_path / "a.csv", grips=GRIPS)
    names = ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z")
    mapping = dict(zip(names, ("f0x", "f0y", "t0z", "f1x", "f1y", "t1z"), strict=True))
    seen = analysed(zero, tmp_path / "a.csv", grips=GRIPS, columns=mapping)
    same(seen, analysed(columns, tmp_path / "b.csv", grips=GRIPS))


def test_effectors_without_torque_are_said_to_be_so(tmp_path):
    columns = {k: v for k, v in cases.planar().items() if not k.endswith("z")}
    with pytest.raises(InvalidInput, match=r"column t1z must be there.*--forces-only"):
        analysed(columns, tmp_path / "a.csv", grips=GRIPS)
    seen = analysed(columns, tmp_path / "a.csv", grips=GRIPS, forces_only=True)
    columns |= {"t1z": np.zeros(40), "t2z": np.zeros(40)}
    same(seen, analysed(columns, tmp_path / "b.csv", grips=GRIPS))


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (
            {"tare": (1.0, -2.0, 0.5)},
            "tare must be of forces alone with forces_only, got .*write 0",
        ),
        ({"tare": (1.0, -2.0, 3.0, 0.0, 0.1, 0.0)}, "tare must be of forces alone"),
        ({"cross_talk": ((1, 0, 0), (0, 1, 0), (0.1, 0, 1))}, "cross_talk must not mix forces"),
        ({"cross_talk": ((1, 0, 0.1), (0, 1, 0), (0, 0, 1))}, "cross_talk must not mix forces"),
        ({"cross_talk": np.eye(6) + np.eye(6, k=3)}, "cross_talk must not mix forces"),
    ],
)
def test_corrections_by_torques_are_refused_where_there_are_none(sensor, message):
    assert Layout.load(sensors={"2": sensor})
    with pytest.raises(InvalidInput, match=rf"sensors\.2\.{message}"):
        Layout.load(sensors={"2": sensor}, forces_only=True)


def test_forces_alone_are_corrected_by_a_tare_and_a_matrix_of_forces(tmp_path):
    columns = {k: v for k, v in cases.planar().items() if not k.endswith("z")}
    path = cases.save(columns, tmp_path / "a.npz")
    sensor = {"tare": (1.0, -2.0, 0.0), "cross_talk": ((2, 0.1, 0), (0, 3, 0), (0, 0, 1))}
    layout = Layout.load(grips=GRIPS, forces_only=True, sensors={"1": sensor})
    wrench = read(path, layout).applied[:, 0]
    x, y = columns["f1x"] - 1.0, columns["f1y"] + 2.0
    np.testing.assert_allclose(wrench, np.stack([2 * x + 0.1 * y, 3 * y, 0 * x], axis=-1))


@pytest.mark.parametrize(("separator", "decimal"), [(";", "."), (";", ","), ("\t", ",")])
def test_separators_are_found_and_decimal_commas_may_be_said(separator, decimal, tmp_path):
    columns = cases.planar()
    plain = analysed(columns, tmp_path / "a.csv", grips=GRIPS)
    text = (tmp_path / "a.csv").read_text().replace(",", separator).replace(".", decimal)
    (tmp_path / "b.txt").write_text("\ufeff" + text.replace("\n", "\r\n\r\n"), encoding="utf-8")
    recording = read(tmp_path / "b.txt", Layout(grips=GRIPS, decimal=decimal))
    same(plain, analyse(recording))


def test_a_point_where_commas_separate_decimals_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    text = "time;f1x;f1y;t1z\n0;1,5;2;3\n1;1.234;2;3\n"
    path.write_text(text)
    layout = Layout(grips=(0.0, 0.0), decimal=",")
    with pytest.raises(InvalidInput, match=r"line 3, column 'f1x' must be .* without a point"):
        read(path, layout)
    assert read(path, layout, bad_rows="skip").good.tolist() == [True, False]
    path.write_text(text.replace("1.234", "1,234").replace("\n", ";7,5\n").replace("z;7,5", "z;a"))
    assert read(path, layout).carried["a"].tolist() == [7.5, 7.5]
    path.write_text(text.replace("1.234", "1").replace("\n", ";7.5\n").replace("z;7.5", "z;a"))
    assert read(path, layout).carried["a"].tolist() == ["7.5", "7.5"]


def test_masked_arrays_are_refused_where_something_is_masked(tmp_path):
    recording = read(cases.save(cases.planar(), tmp_path / "a.npz"), Layout(grips=GRIPS))
    masked = np.ma.masked_greater(recording.applied, 1.0)
    with pytest.raises(InvalidInput, match="applied must have no masked values, got"):
        replace(recording, applied=masked)
    with pytest.raises(InvalidInput, match="'note' must have no masked values"):
        replace(recording, carried={"note": np.ma.masked_less(np.arange(40), 3)})
    with pytest.raises(InvalidInput, match="grips must have no masked values"):
        Layout.load(grips=np.ma.masked_equal(GRIPS, 0.9))
    plain = replace(recording, applied=np.ma.masked_array(recording.applied))
    assert type(plain.applied) is np.ndarray
    same(analyse(plain), analyse(recording))


def test_the_advice_for_a_missing_orientation_is_about_frames(tmp_path):
    columns = {k: v for k, v in cases.planar().items() if k != "theta" and not k.endswith("z")}
    with pytest.raises(
        InvalidInput, match=r"column theta must be there.*say --frame object"
    ) as told:
        analysed(columns, tmp_path / "a.csv", grips=GRIPS, forces_only=True, frame="world")
    assert "forces-only" not in str(told.value)
