"""A laboratory's habits, declared in one layout, leave the measures as they are."""

from typing import Any

import numpy as np
import pytest

from coopenv.logs import Layout, analyse, read
from tests.logs import cases
from tests.logs.calibration import lab

MEASURES = ("internal_force_level", "internal_torque_level", "relative_cost")
HABITS = ("rotation", "offset", "bias", "handle", "order", "units")


def recorded(columns, path, **layout) -> Any:
    return lab.seen_in(cases.save(columns, path), **layout)


def measured(recording, every):
    return analyse(recording.take(slice(100, -100, every)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("lab")


@pytest.fixture(scope="module")
def truth(folder):
    return recorded(dict(lab.spatial()), folder / "truth.npz")


@pytest.mark.parametrize("habits", [*((each,) for each in HABITS), HABITS])
def test_what_a_laboratory_does_to_wrenches_in_space_is_undone(habits, truth, folder):
    columns = lab.written_in_space(*habits)
    seen = recorded(columns, folder / "a.npz", **lab.layout_in_space(*habits))
    np.testing.assert_allclose(seen.applied, truth.applied, rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.orientation, truth.orientation, rtol=0, atol=1e-12)
    if len(habits) > 1:  # of a solver, to its own tolerance
        got, wanted = measured(seen, 500), measured(truth, 500)
        for name in MEASURES:
            np.testing.assert_allclose(got[name], wanted[name], atol=1e-5, err_msg=name)


def test_one_layout_undoes_all_in_the_plane(folder):
    columns, grips = lab.planar()
    wanted = recorded(dict(columns), folder / "b.npz", grips=grips)
    seen = recorded(lab.written_in_the_plane(), folder / "c.npz", **lab.layout_in_the_plane())
    late = ~seen.good
    assert late.sum() == 40  # no pose was recorded for the last 40 ms
    assert late[-40:].all()
    np.testing.assert_allclose(seen.applied[:-40], wanted.applied[:-40], rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.position[:-40], wanted.position[:-40], rtol=0, atol=1e-9)
    got, right = measured(seen, 10), measured(wanted, 10)
    for name in MEASURES:
        np.testing.assert_allclose(got[name], right[name], rtol=0, atol=1e-9, err_msg=name)


def test_with_noise_a_slow_camera_and_resampling_the_measures_are_right_to_a_hundredth(
    truth, folder
):
    habits = (*HABITS, "delay")
    columns, rng = lab.written_in_space(*habits), np.random.default_rng(1)
    time = columns["time"]
    for name in ("x", "y", "z", "q0", "q1", "q2", "q3"):  # 100 Hz, joined on the sensors' time
        seen = columns[name][::10] + 2e-4 * rng.normal(size=len(time[::10]))
        columns[name] = np.interp(time, time[::10], seen)
    for name in (f"{kind}{i}{axis}" for kind in "ft" for i in (1, 2) for axis in "xyz"):
        columns[name] = columns[name] + 0.02 * rng.normal(size=len(time))
    said = lab.layout_in_space(*habits)
    filters = {"wrench": 15.0, "pose": 10.0, "rate": 50.0}
    seen = recorded(columns, folder / "d.npz", **said, filters=filters)
    got = measured(seen.take(slice(25, -25)), 10)
    at = np.searchsorted(truth.time, got["time"] - 1e-6)
    right = analyse(truth.take(at))
    for name in MEASURES:
        size = np.abs(right[name]).max()
        assert np.abs(got[name] - right[name]).mean() < 0.01 * size, name
    done = " ".join(seen.done)
    for words in (
        "delay: pose and twist taken 0.04 s",
        "turned by euler (30, 20, -50) ZYX",
        "0.4 kg on the hand's side",
        "moved by (0.05, 0, 0) m",
        "15 Hz",
        "50 rows a second",
    ):
        assert words in done


def test_a_rest_gives_the_bias_though_a_handle_hangs_there(truth, folder):
    """The first second of each trial nobody holds; bias and weight are told apart."""
    habits = ("rotation", "offset", "bias", "handle")
    still = dict(lab.spatial())
    names = [f"{kind}{i}{axis}" for kind in "ft" for i in (1, 2) for axis in "xyz"]
    for name in names:
        still[name] = np.where(still["time"] < 1.0, 0.0, still[name])
    said = lab.layout_in_space(*habits)
    hands_off = lab.written_in_space(*habits)
    bare = lab.written_in_space("rotation", "offset")
    for name in names:  # what the hands add is not there
        hands_off[name] = hands_off[name] - np.where(still["time"] < 1.0, bare[name], 0.0)
    wanted = np.stack([still[name] for name in names], axis=-1)
    for tare, words in (
        ({"first": 0.99}, "bias ("),
        ({"rests": [[0.0, 0.5]]}, "bias ("),
        ({"rests": [[0.0, 0.3], [0.5, 0.9]]}, "bias from"),
    ):
        for sensor in said["sensors"].values():
            sensor["tare"] = tare
        seen = recorded(hands_off, folder / "e.npz", **said)
        force, torque = seen.applied[..., :3].reshape(-1, 6), seen.applied[..., 3:].reshape(-1, 6)
        np.testing.assert_allclose(np.hstack([force, torque]), wanted, rtol=0, atol=1e-9)
        assert words in seen.done[0]
    zero = {name: each[:500] for name, each in hands_off.items()}
    cases.save(zero, folder / "zero.npz")
    (folder / "lab.toml").write_text(
        '[sensors.1.tare]\nfile = "zero.npz"\n[sensors.2.tare]\nfile = "zero.npz"\n'
    )
    plain = Layout.load(folder / "lab.toml")
    seen = read(cases.save(hands_off, folder / "f.npz"), plain)
    np.testing.assert_allclose(seen.applied[:500].mean(axis=0), 0.0, atol=1e-9)


def test_a_drift_between_two_rests_is_taken_off(folder):
    columns, grips = lab.planar()
    columns = {name: each.copy() for name, each in columns}
    time = columns["time"]
    rest = (time < 0.5) | (time > 5.5)
    for i in (1, 2):
        for name in (f"f{i}x", f"f{i}y", f"t{i}z"):
            columns[name][rest] = 0.0
    wanted = recorded(columns, folder / "g.npz", grips=grips)
    drifting = {**columns, "f1x": columns["f1x"] + 2.0 - 0.7 * time}
    tare = {"1": {"tare": {"rests": [[0.0, 0.45], [5.55, 6.0]]}}}
    seen = recorded(drifting, folder / "h.npz", grips=grips, sensors=tare)
    np.testing.assert_allclose(seen.applied, wanted.applied, rtol=0, atol=1e-9)
    # the biases of rests, in words: half way through each
    assert "bias from (1.842" in seen.done[0]
