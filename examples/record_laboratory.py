"""Write what a laboratory records of two people who carry a table: a file a device, and a rest.

Two six-axis sensors at 1 kHz, each with axes of its own, beside the grip, under a handle that
weighs something, with a bias, in pounds. A motion capture at 100 Hz, in millimetres, whose stamps
are 40 ms late. The folder ``zero`` has the same of a table on its trestles that nobody holds.

``docs/recordings.md`` goes from these files to a picture.
"""

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

SENSORS, CAMERAS = 1000, 100  # [Hz]
MASS, INERTIA = 7.0, np.array([0.3, 2.0, 2.2])  # of table and handles [kg], [kg m²]
GRIPS = np.array([[-0.92, 0.03, 0.05], [0.88, 0.03, 0.05]])  # from the centre of mass [m]
CENTER = np.array([0.02, -0.03, -0.05])  # centre of mass in the tracked frame [m]
MOUNTED = (30.0, -150.0)  # axes of the sensors about the table's z axis [deg]
OFFSET = np.array([0.05, 0.0, 0.0])  # from a sensor to the grip, the sensor's axes [m]
HANDLE, HANGS = 0.4, np.array([0.01, 0.0, 0.06])  # [kg], centre from the sensor's origin [m]
BIAS = np.array([[4.0, -3.0, 2.0, 0.5, -0.3, 0.2], [-2.0, 5.0, -3.0, -0.4, 0.2, 0.6]])  # [N, N·m]
LATE = 0.04  # [s]
POUND, INCH = 4.4482216152605, 0.0254  # [N], [m]
GRAVITY = np.array([0.0, 0.0, -9.80665])


def carried(seconds: float, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Motion at 1 kHz, and the wrenches ``(T, 2, 6)`` of both hands, the table's axes."""
    step = 1 / SENSORS
    time = np.arange(-0.5, seconds + 0.5, step)  # a little more, for the late cameras
    position, _, acceleration = swaying(rng, time, (0.5, 0.4, 0.15))
    turned = Rotation.from_rotvec(swaying(rng, time, (0.25, 0.25, 0.8))[0])
    between = (turned[:-1].inv() * turned[1:]).as_rotvec() / step
    spin = np.vstack([between[:1], (between[1:] + between[:-1]) / 2, between[-1:]])
    force = MASS * turned.inv().apply(acceleration - GRAVITY)
    change = np.gradient(spin, step, axis=0)
    torque = INERTIA * change + np.cross(spin, INERTIA * spin)
    share = 0.5 + 0.03 * np.sin(0.7 * time)[:, None]
    pull = swaying(rng, time, (25.0, 2.0, 3.0))[0]  # what they do against each other
    forces = np.stack([share * force - pull, (1 - share) * force + pull], axis=1)
    rest = torque - np.cross(GRIPS, forces).sum(axis=1)
    twist = swaying(rng, time, (0.8, 0.3, 0.3))[0]
    torques = np.stack([rest / 2 + twist, rest / 2 - twist], axis=1)
    return {
        "time": time,
        "position": position,
        "quaternion": turned.as_quat(),  # x, y, z, w
        "felt": turned.inv().apply(GRAVITY - acceleration),  # by what is carried along [m/s²]
        "spin": spin,
        "change": change,
        "wrenches": np.concatenate([forces, torques], axis=-1),
    }


def resting(seconds: float, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The same of a table that lies level and is not touched."""
    still = {name: np.zeros_like(each) for name, each in carried(seconds, rng).items()}
    still["time"] = np.arange(len(still["time"])) / SENSORS - 0.5
    still["quaternion"][:, 3] = 1.0
    return still | {"felt": np.broadcast_to(GRAVITY, still["felt"].shape)}


def swaying(rng: np.random.Generator, time: np.ndarray, sizes: tuple) -> list[np.ndarray]:
    """Sums of slow sines ``(T, 3)``, and their first and second derivative."""
    rate = 2 * np.pi * rng.uniform(0.1, 0.6, (4, 3))
    at = rate * time[:, None, None] + rng.uniform(0, 2 * np.pi, (4, 3))
    return [
        (np.array(sizes) / 2 * rate**n * np.sin(at + n * np.pi / 2)).sum(axis=1) for n in range(3)
    ]


def sensed(trial: dict[str, np.ndarray], hand: int, rng: np.random.Generator) -> np.ndarray:
    """What the sensor of a hand reads ``(T, 6)`` [N, N·m]: along its axes, about its origin."""
    axes = Rotation.from_euler("z", MOUNTED[hand], degrees=True)
    wrench = trial["wrenches"][:, hand]
    force, torque = (axes.inv().apply(each) for each in np.split(wrench, 2, axis=-1))
    torque = torque + np.cross(OFFSET, force)
    place = GRIPS[hand] + axes.apply(HANGS - OFFSET)  # of the handle, from the centre of mass
    spin = trial["spin"]
    turning = np.cross(trial["change"], place) + np.cross(spin, np.cross(spin, place))
    weight = HANDLE * axes.inv().apply(trial["felt"] - turning)
    read = np.concatenate([force + weight, torque + np.cross(HANGS, weight)], axis=-1)
    return read + BIAS[hand] + rng.normal(size=read.shape) * ([0.05] * 3 + [0.005] * 3)


def seen(trial: dict[str, np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """What the cameras see of the tracked point ``(T, 7)``: position [mm], quaternion."""
    quaternion = trial["quaternion"]
    position = trial["position"] - Rotation.from_quat(quaternion).apply(CENTER)
    position = position + 1e-4 * rng.normal(size=position.shape)
    turned = quaternion + 1e-4 * rng.normal(size=quaternion.shape)
    turned = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    return np.concatenate([1000 * position, turned], axis=-1)


def record(folder: Path, trial: dict[str, np.ndarray], rng: np.random.Generator) -> None:
    """Write ``left.csv``, ``right.csv`` and ``mocap.csv``."""
    folder.mkdir(exist_ok=True)
    time = trial["time"]
    during = (time > -1e-9) & (time < time[-1] - 0.5)
    header = ["t", "Fx_lbf", "Fy_lbf", "Fz_lbf", "Tx_lbf-in", "Ty_lbf-in", "Tz_lbf-in"]
    for hand, name in enumerate(("left", "right")):
        read = sensed(trial, hand, rng) / np.repeat([POUND, POUND * INCH], 3)
        write(folder / f"{name}.csv", header, time[during], read[during])
    picked = np.flatnonzero(during)[:: SENSORS // CAMERAS]
    header = ["time", "x", "y", "z", "q0", "q1", "q2", "q3"]
    write(folder / "mocap.csv", header, time[picked] + LATE, seen(trial, rng)[picked])


def write(path: Path, header: list[str], time: np.ndarray, values: np.ndarray) -> None:
    """Write one device's rows."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(np.round(np.column_stack([time, values]), 6).tolist())
    print(f"wrote {path}: {len(time):,} rows")


def main(folder: Path, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Write all files, and return what truly happened."""
    record(folder / "zero", resting(3.0, rng), rng)
    trial = carried(20.0, rng)
    record(folder, trial, rng)
    return trial


if __name__ == "__main__":
    main(Path("."), np.random.default_rng(0))
