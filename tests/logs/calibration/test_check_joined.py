"""Of devices with files of their own, the check names the one that is wrong, and its delay."""

import re
from pathlib import Path
from typing import Any

import pytest

from coopenv.logs import check_file
from tests.logs import cases, motions
from tests.logs.calibration.lab import declared

BODY = {"mass": motions.MASS, "inertia": motions.INERTIA, "drag": (2.0, 0.3)}
DEVICES = {
    "left": ("f1x", "f1y", "t1z"),
    "right": ("f2x", "f2y", "t2z"),
    "mocap": ("x", "y", "theta"),
}


def written(folder: Path, late: dict[str, float] | None = None, **changed: Any) -> Path:
    """A trial, its devices' files of which some are late [s]."""
    columns = motions.planar(0) | changed
    for name, theirs in DEVICES.items():
        time = columns["time"] + (late or {}).get(name, 0.0)
        made = {"time": time} | {each: columns[each] for each in theirs}
        cases.save(made, folder / f"{name}.npz")
    return folder / "left.npz"


def checked(path: Path, **delays: float) -> Any:
    files: dict[str, Any] = {name: {"path": f"{name}.npz"} for name in ("right", "mocap")}
    for name, delay in delays.items():
        files.setdefault(name, {})["delay"] = delay
    return check_file(path, layout=declared(grips=motions.BEAM, files=files, body=BODY))


def fits(told: Any) -> dict[str, float]:
    """Delay of each device that fits best, by its file."""
    found = re.findall(r"\((\w+)\.npz\) fits best ([+-][\d.]+) s late", "\n".join(told.lines()))
    return {name: float(delay) for name, delay in found}


def test_devices_that_are_on_time_are_found_so(tmp_path):
    told = checked(written(tmp_path))
    assert not told.consistency.warnings
    assert fits(told) == pytest.approx(dict.fromkeys(DEVICES, 0.0), abs=0.003)


@pytest.mark.parametrize(
    ("name", "who"),
    [
        ("mocap", "the pose (mocap.npz)"),
        ("right", "sensor 2 (right.npz)"),
        ("left", "sensor 1 (left.npz)"),
    ],
)
def test_a_late_device_is_named_with_its_file_and_what_mends_it_does(name, who, tmp_path):
    path = written(tmp_path, {name: 0.05})
    told = checked(path)
    (warning,) = told.consistency.warnings
    remedy = re.search(rf"\[files\.{name}\] delay = (0\.0\d+)", warning)
    assert f"if {who} is 0.0" in warning
    assert remedy is not None
    delay = float(remedy[1])
    assert delay == pytest.approx(0.05, abs=0.003)
    assert fits(told)[name] == pytest.approx(delay, abs=0.001)
    mended = checked(path, **{name: delay})
    assert not mended.consistency.warnings
    again = checked(path, **{name: 0.02}).consistency.warnings[0]  # not all of it
    assert re.search(rf"\[files\.{name}\] delay = 0\.0(4[789]|5[0123])", again)


def test_two_late_devices_are_named_together(tmp_path):
    told = checked(written(tmp_path, {"left": 0.06, "right": -0.04}))
    (warning,) = told.consistency.warnings
    assert "sensor 1 (left.npz) is 0.06" in warning
    assert "s late and sensor 2 (right.npz) is 0.04" in warning
    assert re.search(
        r"\[files\.left\] delay = 0\.0[56]\d+, \[files\.right\] delay = -0\.0", warning
    )


def test_a_wrong_sensor_is_named_with_its_file(tmp_path):
    columns = motions.planar(0)
    right = {name: -columns[name] for name in DEVICES["right"]}
    (warning, *_) = checked(written(tmp_path, **right)).consistency.warnings
    assert "the reaction on sensor 2 (right.npz) is recorded: [sensors.2] sign = -1" in warning


def test_a_wrong_pose_is_named_with_its_file(tmp_path):
    theta = motions.planar(0)["theta"] * 57.29577951308232
    (warning, *_) = checked(written(tmp_path, theta=theta)).consistency.warnings
    assert "theta (mocap.npz) is in deg: --angle deg" in warning


def test_of_two_clocks_only_the_difference_is_told(tmp_path):
    columns = motions.planar(0)
    forces = {name: columns[name] for name in columns if name[0] in "tf" and name != "theta"}
    cases.save({"time": columns["time"] + 0.05} | {n: columns[n] for n in DEVICES["mocap"]},
               tmp_path / "mocap.npz")  # fmt: skip
    path = cases.save(forces, tmp_path / "forces.npz")
    layout = declared(grips=motions.BEAM, join=(str(tmp_path / "mocap.npz"),), body=BODY)
    told = check_file(path, layout=layout)
    assert list(fits(told)) == ["mocap"]
    assert "if the pose (mocap.npz) is 0.0" in told.consistency.warnings[0]
    layout = declared(grips=motions.BEAM, twist_frame="world", body=BODY)
    alone = check_file(cases.save(columns, tmp_path / "all.npz"), layout=layout)
    assert not fits(alone)
