"""Corrections of a file that is read some rows at a time are those of the whole of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from coopenv.errors import InvalidInput
from coopenv.logs import read
from tests.logs import cases, motions
from tests.logs.calibration.lab import declared

BEAM = ((-0.9, 0.1), (0.9, -0.2))
FIELDS = ("time", "applied", "position", "orientation", "twist", "good", "trial")


def _read(*path: Any, **said: Any) -> Any:
    return read(*path, **said)


def two_trials(rows=600):
    columns = motions.planar(2, duration=rows / 100)
    columns = {name: each for name, each in columns.items() if name[0] not in "vo"}
    trial = np.where(np.arange(rows) < rows // 3, 1, 2)
    columns["time"] = columns["time"] - np.where(trial == 2, columns["time"][rows // 3], 0.0)
    columns["time"][-100:] += 3.0  # a gap
    return columns | {"trial": trial}


def everything(**filters) -> Any:
    sensors = {1: {"load": {"mass": 0.3, "center": [0.0, 0.05], "inertia": 0.001, "window": 0.06}}}
    return declared(
        grips=BEAM,
        sensors=sensors,
        pose={"delay": 0.025, "com": [0.1, -0.05]},
        filters={"wrench": 12.0, "pose": 8.0, "twist": 8.0, "twist_window": 0.08, **filters},
        body={"gravity": [0.0, -9.81]},
    )


@pytest.mark.parametrize("rate", [None, 37.0])
def test_how_many_rows_are_read_at_once_does_not_matter(rate, tmp_path, monkeypatch):
    columns = two_trials()
    columns["f1x"][400] = np.nan  # a bad row parts what comes before from what comes after
    path = cases.save(columns, tmp_path / "a.npz")
    whole = _read(path, everything(rate=rate), bad_rows="skip")
    for rows in (13, 64):
        cases.set_chunk(rows, monkeypatch)
        parts = _read(path, everything(rate=rate), bad_rows="skip")
        assert len(parts) == len(whole)
        for name in FIELDS:
            one, other = getattr(parts, name), getattr(whole, name)
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-9, err_msg=name)


def test_a_filtered_run_is_what_scipy_makes_of_the_whole_run(tmp_path, monkeypatch):
    columns = {name: each for name, each in two_trials().items() if name != "trial"}
    columns["time"] = np.arange(600) * 0.01
    cases.set_chunk(50, monkeypatch)
    said = declared(grips=BEAM, filters={"wrench": 10.0, "order": 3})
    seen = _read(cases.save(columns, tmp_path / "a.npz"), said)
    sections = butter(3, 10.0, output="sos", fs=100.0)
    wanted = sosfiltfilt(sections, columns["f1x"])
    np.testing.assert_allclose(seen.applied[:, 0, 0], wanted, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(seen.position[:, 0], columns["x"])


def test_uneven_times_are_filtered_as_even_ones_of_the_same_motion(tmp_path):
    time = np.arange(900) * 0.01
    uneven = time + 0.003 * np.sin(np.arange(900))
    slow = {}
    for name, at in (("even", time), ("uneven", uneven)):
        columns = cases.planar(900)
        columns |= {f"f{i}x": np.sin(2 * at + i) for i in (1, 2)} | {"time": at}
        said = declared(grips=BEAM, filters={"wrench": 10.0})
        slow[name] = _read(cases.save(columns, tmp_path / f"{name}.npz"), said)
    wanted = np.sin(2 * uneven + 1)
    np.testing.assert_allclose(slow["uneven"].applied[50:-50, 0, 0], wanted[50:-50], atol=2e-3)


def test_rows_between_rows_are_on_the_line_and_carry_what_was_before(tmp_path):
    columns = cases.planar(11) | {"note": np.array(list("abcdefghijk"))}
    columns["f1x"] = np.arange(11.0)
    said = declared(grips=BEAM, filters={"rate": 250.0})
    seen = _read(cases.save(columns, tmp_path / "a.npz"), said)
    assert len(seen) == 26
    np.testing.assert_allclose(seen.time, np.arange(26) * 0.004)
    np.testing.assert_allclose(seen.applied[:, 0, 0], np.arange(26) * 0.4)
    assert "".join(seen.carried["note"][[0, 2, 3, 25]]) == "aabk"


def test_a_tracked_origin_is_moved_to_the_centre_of_mass(tmp_path):
    """Position, twist and grips about another point say the same of the centre of mass."""
    columns = cases.planar(30)
    com = np.array([0.2, -0.1])
    c, s = np.cos(columns["theta"]), np.sin(columns["theta"])
    tracked = dict(columns)
    tracked["x"] = columns["x"] - (c * com[0] - s * com[1])
    tracked["y"] = columns["y"] - (s * com[0] + c * com[1])
    tracked["vx"] = columns["vx"] + columns["omega"] * com[1]  # v_origin = v − ω × com
    tracked["vy"] = columns["vy"] - columns["omega"] * com[0]
    wanted = _read(cases.save(columns, tmp_path / "a.npz"), declared(grips=BEAM))
    grips = tuple(tuple(grip) for grip in (np.array(BEAM) + com).tolist())
    said = declared(grips=grips, pose={"com": com.tolist()})
    seen = _read(cases.save(tracked, tmp_path / "b.npz"), said)
    for name in ("position", "twist", "grips", "applied"):
        one, other = getattr(seen, name), getattr(wanted, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12, err_msg=name)


def test_y_down_turns_what_is_declared_over_too(tmp_path):
    """The same laboratory, seen from below the table."""
    columns = two_trials()
    tare = [1.0, -2.0, 0.3]
    matrix = [[1.0, 0.1, 0.0], [0.02, 0.9, 0.3], [0.0, 0.05, 1.1]]
    sensor = {"rotation": 0.4, "offset": [0.05, 0.02], "tare": tare, "cross_talk": matrix,
              "load": {"mass": 0.3, "center": [0.01, 0.06]}}  # fmt: skip
    up = everything()
    up = replace(up, sensors={1: sensor}, filters={})
    down = {name: -each if name in ("f1y", "f2y", "t1z", "t2z", "y", "theta") else each
            for name, each in columns.items()}  # fmt: skip
    over = np.diag([1.0, -1.0, -1.0])
    load = {"mass": 0.3, "center": [0.01, -0.06]}
    sensor = {"rotation": -0.4, "offset": [0.05, -0.02], "tare": (over @ tare).tolist(),
              "cross_talk": (over @ matrix @ over).tolist(), "load": load}  # fmt: skip
    said = replace(
        up,
        grips=((-0.9, -0.1), (0.9, 0.2)),
        y="down",
        sensors={1: sensor},
        pose={"delay": 0.025, "com": [0.1, 0.05]},
        body={"gravity": [0.0, 9.81]},
    )
    one = _read(cases.save(columns, tmp_path / "a.npz"), up)
    other = _read(cases.save(down, tmp_path / "b.npz"), said)
    for name in ("applied", "grips", "position", "orientation"):
        got, wanted = getattr(other, name), getattr(one, name)
        np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-9, err_msg=name)


def test_a_handle_that_is_swung_costs_the_hand_what_its_particles_do(tmp_path):
    """At the end of an arm on a turning body; its acceleration is found from the pose."""
    time = np.arange(600) / 200
    spin, mass, arm = 1.5, 0.5, 0.9
    zero = np.zeros(600)
    columns = {"time": time, "x": zero, "y": zero, "theta": spin * time}
    columns |= {name: zero for name in ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z")}
    sensors = {2: {"load": {"mass": mass, "center": [0.1, 0.0], "window": 0.05}}}
    said = declared(grips=(-arm, 0.0, arm, 0.0), sensors=sensors)
    seen = _read(cases.save(columns, tmp_path / "a.npz"), said)
    # the hand draws the handle inwards: towards −x of the object
    wanted = [-mass * spin**2 * (arm + 0.1), 0.0, 0.0]
    np.testing.assert_allclose(seen.applied[10:-10, 1], np.tile(wanted, (580, 1)), atol=1e-6)
    assert not seen.applied[:, 0].any()


def test_a_filter_that_would_hold_too_many_rows_is_refused(tmp_path):
    path = cases.save(cases.planar(50), tmp_path / "a.npz")
    said = declared(grips=BEAM, filters={"wrench": 0.0001})
    with pytest.raises(InvalidInput, match="filters must reach over at most 200,000 rows"):
        _read(path, said)
    with pytest.raises(InvalidInput, match="cutoff must be below half the rate of 100 Hz"):
        _read(path, declared(grips=BEAM, filters={"wrench": 60.0}))
