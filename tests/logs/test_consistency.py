"""What is declared wrongly of a recording is told by its motion, and what is right is let pass."""

import json
from importlib import import_module

import numpy as np
import pytest

from coopenv import logs
from coopenv.logs import Layout
from coopenv.logs.consistency import Check, Consistency
from coopenv.logs.recording import Reader
from tests.logs import cases, motions

RIGHT = {"grips": motions.BEAM, "twist_frame": "world"}
TWIST = ("vx", "vy", "omega")
ENVIRONMENTS = (
    "beam_transport_v0", "beam_doorway_v0", "beam_tracking_v0", "walker_turn_v0", "walker_avoid_v0",
)  # fmt: skip


def seen(columns, tmp_path, **layout) -> Consistency:
    path = cases.save(columns, tmp_path / "a.npz")
    check = Check(Layout(**layout))
    for recording in Reader(path, Layout(**layout), bad_rows="skip"):
        check.add(recording)
    return check.result()


def only_warning(columns, tmp_path, **layout) -> str:
    (warning,) = seen(columns, tmp_path, **layout).warnings
    return warning


def turned(columns, angle, *pairs):
    made = dict(columns)
    c, s = np.cos(angle), np.sin(angle)
    for x, y in pairs:
        made[x] = c * columns[x] - s * columns[y]
        made[y] = s * columns[x] + c * columns[y]
    return made


def forces_in_world(columns):
    return turned(columns, columns["theta"], ("f1x", "f1y"), ("f2x", "f2y"))


def scaled(columns, factor, *names):
    return {k: factor * v if k in names or k[:2] in names else v for k, v in columns.items()}


def without(columns, *names):
    return {name: values for name, values in columns.items() if name not in names}


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(
    "how", [{}, {"noise": 5}, {"rate": 1000}, {"rate": 20}, {"duration": 3.5, "noise": 2}]
)
def test_right_recordings_pass_with_noise(how, seed, tmp_path):
    columns = motions.planar(seed, **how)
    found = seen(columns, tmp_path, **RIGHT)
    assert found.warnings == ()
    assert not found.unchecked
    assert min(found.fit) > 0.9
    assert seen(without(columns, *TWIST), tmp_path, grips=motions.BEAM).warnings == ()
    assert seen(without(columns, "x", "y"), tmp_path, **RIGHT).warnings == ()
    world = forces_in_world(columns)
    assert seen(world, tmp_path, grips=motions.BEAM, frame="world").warnings == ()


@pytest.mark.parametrize("seed", range(4))
def test_right_recordings_in_space_pass(seed, tmp_path):
    found = seen(motions.spatial(seed), tmp_path)
    assert found.warnings == ()
    assert min(found.fit) > 0.9


@pytest.mark.parametrize("seed", range(3))
def test_what_is_pushed_by_walls_and_wheels_too_is_no_evidence(seed, tmp_path):
    from coopenv import beam_doorway_v0, walker_avoid_v0, walker_turn_v0

    for environment in (beam_doorway_v0, walker_turn_v0, walker_avoid_v0):
        columns, grips = motions.carried(seed, steps=300, **environment.DEFAULTS)
        assert seen(columns, tmp_path, grips=grips, twist_frame="world").warnings == ()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("spoil", ["late", "biased", "random"])
def test_bad_sensors_are_no_wrong_declaration(spoil, seed, tmp_path):
    columns = motions.planar(seed)
    names = [name for name in columns if name[0] == "f" or name in ("t1z", "t2z")]
    for name in names:
        if spoil == "late":  # 0.1 s
            columns[name] = np.roll(columns[name], 10)
        else:
            columns[name] = columns[name] + 4 if spoil == "biased" else cases.planar(1200)["f1x"]
    for said in seen(columns, tmp_path, **RIGHT).warnings:
        assert spoil == "random"
        assert "no other frame, unit or sign that was tried explains them" in said


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("twist", [True, False])
def test_the_wrong_frame_of_forces_is_named(seed, twist, tmp_path):
    columns = motions.planar(seed, noise=2)
    left_out = () if twist else TWIST
    also = " --twist-frame world" if twist else ""
    world = without(forces_in_world(columns), *left_out)
    assert only_warning(world, tmp_path, **RIGHT).endswith(f"say --frame world{also}")
    own = without(columns, *left_out)
    said = only_warning(own, tmp_path, **RIGHT | {"frame": "world"})
    assert said.endswith(f"say --frame object{also}")


@pytest.mark.parametrize("seed", range(5))
def test_the_wrong_frame_of_the_twist_is_named(seed, tmp_path):
    columns = motions.planar(seed)
    said = only_warning(columns, tmp_path, grips=motions.BEAM)
    assert "the twist goes with the pose in the world frame: say --twist-frame world" in said
    said = only_warning(without(columns, "x", "y"), tmp_path, grips=motions.BEAM)
    assert "if the twist is in the world frame" in said


@pytest.mark.parametrize("seed", range(5))
def test_forces_of_reaction_are_named(seed, tmp_path):
    columns = scaled(motions.planar(seed), -1.0, "f1", "f2", "t1", "t2")
    said = seen(columns, tmp_path, **RIGHT).warnings
    assert len(said) == 1
    assert "goes against the acceleration" in said[0]
    assert "--map f1x=-f1x" in said[0]
    columns = turned(columns, -columns["theta"], ("vx", "vy"))
    said = only_warning(without(columns, "x", "y", "theta"), tmp_path, grips=motions.BEAM)
    assert "the power goes against the change of kinetic energy" in said


@pytest.mark.parametrize("seed", range(5))
def test_exchanged_grips_are_named(seed, tmp_path):
    said = only_warning(
        motions.planar(seed), tmp_path, grips=motions.BEAM[::-1], twist_frame="world"
    )
    assert "if the grips of effectors 1 and 2 are exchanged" in said


@pytest.mark.parametrize("seed", range(5))
def test_torques_in_another_unit_are_named(seed, tmp_path):
    columns = motions.planar(seed)
    said = only_warning(scaled(columns, 1e3, "t1", "t2"), tmp_path, **RIGHT)
    assert "1000 times too large; look at their unit, such as --torque N*mm" in said
    said = only_warning(columns, tmp_path, **RIGHT, torque="N*mm")
    assert "1000 times too small; look at their unit, such as --torque N*m" in said
    assert "N*mm" not in said


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("wrapped", [True, False])
def test_degrees_as_radians_are_named(seed, wrapped, tmp_path):
    columns = motions.planar(seed)
    degrees = scaled(columns, 180 / np.pi, "theta")
    if wrapped:
        degrees["theta"] = (degrees["theta"] + 180) % 360 - 180
    assert "say --angle deg" in only_warning(degrees, tmp_path, **RIGHT)
    assert "say --angle deg" in only_warning(without(degrees, *TWIST), tmp_path, grips=motions.BEAM)
    assert "say --angle rad" in only_warning(columns, tmp_path, **RIGHT, angle="deg")
    faster = scaled(columns, 180 / np.pi, "omega")
    assert "say --angular-velocity deg/s" in only_warning(faster, tmp_path, **RIGHT)
    faster["theta"] = degrees["theta"]  # as it is declared, so that either may be the wrong one
    said = only_warning(faster, tmp_path, **RIGHT, angle="deg")
    assert "say --angle rad or --angular-velocity deg/s" in said


@pytest.mark.parametrize("seed", range(4))
def test_degrees_of_theta_and_omega_alike_are_named(seed, tmp_path):
    columns = motions.planar(seed)
    degrees = scaled(columns, 180 / np.pi, "theta", "omega")
    said = only_warning(degrees, tmp_path, **RIGHT)
    assert said.endswith("if theta is in deg: say --angle deg --angular-velocity deg/s")
    declared = {"angle": "deg", "angular_velocity": "deg/s"}
    assert seen(degrees, tmp_path, **RIGHT, **declared).warnings == ()
    said = only_warning(columns, tmp_path, **RIGHT, **declared)
    assert said.endswith("say --angle rad --angular-velocity rad/s")
    world = scaled(forces_in_world(columns), 180 / np.pi, "theta", "omega")
    said = only_warning(world, tmp_path, grips=motions.BEAM, frame="world")
    assert said.endswith("if theta is in deg; say --angle deg --angular-velocity deg/s")


@pytest.mark.parametrize("seed", range(5))
def test_degrees_of_theta_and_omega_alike_are_named_without_a_position(seed, tmp_path):
    columns = motions.planar(seed)
    degrees = scaled(without(columns, "x", "y"), 180 / np.pi, "theta", "omega")
    said = only_warning(degrees, tmp_path, **RIGHT)
    assert said.endswith("if theta is in deg; say --angle deg --angular-velocity deg/s")
    declared = {"angle": "deg", "angular_velocity": "deg/s"}
    assert seen(degrees, tmp_path, **RIGHT, **declared).warnings == ()


@pytest.mark.parametrize("seed", range(5))
def test_a_twist_that_contradicts_the_pose_is_told(seed, tmp_path):
    columns = motions.planar(seed)
    against = "the position moves against the velocity: turn the sign of one of them"
    otherwise = "the position moves otherwise than the velocity says: one of them has the wrong"
    turned_round = "the orientation turns against the angular velocity: turn the sign of one"
    for twist_frame in ("world", "object"):  # a wrong frame hides no wrong sign
        layout = {"grips": motions.BEAM, "twist_frame": twist_frame}
        said = seen(scaled(columns, -1.0, *TWIST), tmp_path, **layout).warnings
        assert against in said[0]
        assert turned_round in said[1]
    assert against in only_warning(scaled(columns, -1.0, "vx", "vy"), tmp_path, **RIGHT)
    assert turned_round in only_warning(scaled(columns, -1.0, "omega"), tmp_path, **RIGHT)
    assert otherwise in only_warning(scaled(columns, -1.0, "vx"), tmp_path, **RIGHT)
    exchanged = columns | {"x": columns["y"], "y": columns["x"]}
    assert otherwise in only_warning(exchanged, tmp_path, **RIGHT)


@pytest.mark.parametrize("seed", range(3))
def test_degrees_that_jump_and_turn_against_the_twist_are_told_to_do_so(seed, tmp_path):
    columns = motions.planar(seed, rate=20)  # turns by more than pi degrees from row to row
    columns["theta"] = np.rad2deg(columns["theta"] + np.pi) % 360 - 180
    said = seen(scaled(columns, -1.0, "omega"), tmp_path, **RIGHT).warnings
    assert any("the orientation turns against the angular velocity: turn" in each for each in said)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("stiffness", [20.0, 100.0, 500.0])
def test_a_spring_that_pushes_too_is_no_wrong_declaration(stiffness, seed, tmp_path):
    columns = motions.planar(seed, stiffness=stiffness)
    assert seen(columns, tmp_path, **RIGHT).warnings == ()
    wrong = scaled(columns, -1.0, "f2", "t2")
    assert "a spring or a cable" in only_warning(wrong, tmp_path, **RIGHT)


@pytest.mark.parametrize("seed", range(2))
def test_right_trials_of_every_environment_are_not_warned_of(seed, tmp_path):
    for name in ENVIRONMENTS:
        environment = import_module(f"coopenv.{name}")
        columns, grips = motions.carried(seed, steps=300, **environment.DEFAULTS)
        assert seen(columns, tmp_path, grips=grips, twist_frame="world").warnings == ()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("turned_round", [("f1y", "f2y"), ("f1", "t1"), ("f2",)])
def test_what_nothing_explains_is_told_and_not_blamed_on_grips(turned_round, seed, tmp_path):
    wrong = scaled(motions.planar(seed), -1.0, *turned_round)
    said = only_warning(wrong, tmp_path, **RIGHT)
    assert "no other frame, unit or sign that was tried explains them" in said
    assert "look first at the sign of each axis and of each sensor" in said
    assert "exchange" not in said


def test_forces_of_other_times_are_not_taken_for_those_of_reaction(tmp_path):
    columns = motions.planar(2)
    names = [name for name in columns if name[0] == "f" or name in ("t1z", "t2z")]
    late = columns | {name: np.roll(columns[name], 100) for name in names}  # by 1 s
    said = only_warning(late, tmp_path, **RIGHT)
    assert "whether forces and motion have the same times" in said


@pytest.mark.parametrize("seed", range(3))
def test_reactions_beside_walls_and_wheels_are_named(seed, tmp_path):
    from coopenv import beam_doorway_v0, walker_turn_v0

    for environment in (beam_doorway_v0, walker_turn_v0):
        columns, grips = motions.carried(seed, steps=300, **environment.DEFAULTS)
        against = scaled(columns, -1.0, "f1", "f2", "t1", "t2")
        said = only_warning(against, tmp_path, grips=grips, twist_frame="world")
        assert "forces and torques may be those on the sensors" in said


@pytest.mark.parametrize("seed", range(3))
def test_an_object_at_rest_is_no_evidence(seed, tmp_path):
    columns = motions.planar(seed, noise=0)
    still = {name: np.full_like(columns[name], 0.3) for name in ("x", "y", "theta")}
    still |= {name: np.zeros_like(columns["vx"]) for name in TWIST}
    still |= {f"f2{axis}": -columns[f"f1{axis}"] for axis in "xy"}
    held = motions.noisy(columns | still, np.random.default_rng(seed), 2.0)
    assert seen(held, tmp_path, **RIGHT).warnings == ()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("names", "factor", "ratio"),
    [
        (("x", "y"), 1e3, "1e+03"),
        (("vx", "vy"), 1e3, "0.001"),
        (("x", "y"), 1e2, "100"),
        (("time",), 1e3, "0.001"),
    ],
)
def test_a_pose_and_a_twist_in_units_that_differ_are_named(names, factor, ratio, seed, tmp_path):
    columns = scaled(motions.planar(seed), factor, *names)
    said = only_warning(columns, tmp_path, **RIGHT)
    assert f"the position moves {ratio} times as fast as the velocity says" in said
    assert "--length, --velocity and --time" in said


@pytest.mark.parametrize("seed", range(3))
def test_mistakes_in_space_are_named(seed, tmp_path):
    columns = motions.spatial(seed)
    said = " ".join(seen(columns, tmp_path, frame="world").warnings)
    assert "say --twist-frame object" in said
    assert "say --frame object" in said
    exchanged = dict(columns)
    for axis in "xyz":
        exchanged[f"r1{axis}"], exchanged[f"r2{axis}"] = columns[f"r2{axis}"], columns[f"r1{axis}"]
    assert "grips of effectors 1 and 2" in only_warning(exchanged, tmp_path)
    against = scaled(columns, -1.0, "f1", "f2", "t1", "t2")
    assert "goes against the acceleration" in seen(against, tmp_path).warnings[0]


def test_trials_of_the_simulator_tell_the_same(tmp_path):
    named = 0
    for seed in range(8):
        columns, grips = motions.carried(seed)
        right = {"grips": grips, "twist_frame": "world"}
        if seen(columns, tmp_path, **right).unchecked:
            continue  # over too soon
        named += 1
        assert seen(columns, tmp_path, **right).warnings == ()
        world = forces_in_world(columns)
        assert "say --frame world" in only_warning(world, tmp_path, **right)
        assert "twist" in only_warning(columns, tmp_path, grips=grips)
        swapped = {"grips": grips[::-1], "twist_frame": "world"}
        assert "exchanged" in only_warning(columns, tmp_path, **swapped)
    assert named > 2


def test_chunks_trials_and_bad_rows_do_not_matter(tmp_path, monkeypatch):
    columns = motions.planar(3, noise=2) | {"trial": np.repeat([1, 2, 3], 400)}
    columns["f1x"][[5, 6, 800]] = np.nan
    whole = seen(columns, tmp_path, **RIGHT)
    for rows in (7, 60):
        cases.set_chunk(rows, monkeypatch)
        found = seen(columns, tmp_path, **RIGHT)
        np.testing.assert_allclose(found.fit, whole.fit, atol=0.02)
        assert found.warnings == ()
        assert "exchanged" in only_warning(
            columns, tmp_path, grips=motions.BEAM[::-1], twist_frame="world"
        )


def test_what_cannot_be_compared_says_why(tmp_path):
    columns = motions.planar(0)
    few = {name: values[:200] for name, values in columns.items()}
    for given, why in (
        (without(columns, "time"), "it has no time"),
        (without(columns, "x", *TWIST), "neither a twist nor a whole pose"),
        (few, "fewer than 2.6 seconds, or 13 rows, in sequence"),
    ):
        found = seen(given, tmp_path, grips=motions.BEAM)
        assert why in found.unchecked
        assert found.warnings == ()


def test_memory_does_not_grow(tmp_path, monkeypatch):
    cases.set_chunk(50, monkeypatch)
    path = cases.save(motions.planar(0), tmp_path / "a.npz")
    check = Check(Layout(**RIGHT))
    rest = []
    for recording in Reader(path, Layout(**RIGHT)):
        check.add(recording)
        rest.append(len(check._segments._rest or ()))
    assert max(rest) < 70


def test_the_summary_says_what_was_assumed_and_warns(tmp_path, capsys, monkeypatch):
    pytest.importorskip("tyro")
    from coopenv import cli

    monkeypatch.setenv("COLUMNS", "400")
    columns = scaled(motions.planar(0), 1e-3, "f1", "f2")
    columns["Fx"] = -columns.pop("f1x")
    path = cases.save(columns, tmp_path / "a.npz")
    grips = [str(number) for row in motions.BEAM for number in row]
    options = ["--map", "f1x=-Fx", "--force", "kN", "--grips", *grips, "--no-picture"]
    assert cli.main(["decompose", str(path), *options]) == 0
    printed = capsys.readouterr().out
    for line in (
        "assumed frames: forces and torques in the object frame (the default), twist in the object "
        "frame (that of the forces, the default), pose of the object in the world",
        "assumed signs: as applied to the object, with f1x = −Fx; y up (the default)",
        "assumed units: force kN; by default time s, length m, angle rad, velocity m/s, angular "
        "velocity rad/s, torque N*m",
        "assumed grips: (-0.9, 0.1), (0.9, -0.2) m in the object frame, as declared",
        "motion explains, as assumed, 100 % of force, 100 % of torque, ",
        "warning: the twist goes with the pose in the world frame: say --twist-frame world",
    ):
        assert line in printed
    written = json.loads((tmp_path / "a.decomposed.summary.json").read_text())
    assert written["assumed"][0].startswith("frames: forces and torques in the object frame")
    assert written["consistency"]["fit"]["force"] > 0.99
    assert "--twist-frame world" in written["consistency"]["warnings"][0]
    assert written["measures"][0]["name"] == "relative_cost"


def test_grips_in_columns_are_stated(tmp_path):
    path = cases.save(cases.spatial(), tmp_path / "a.npz")
    summary = logs.decompose_file(path, picture=False)
    assert summary.assumed[3] == "grips: in the columns r1x …, object frame (the default)"
    assert json.loads(summary.written.read_text())["duration"] == summary.duration
