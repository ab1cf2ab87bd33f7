"""Recorded trials of bodies that obey the laws of motion, as labs would measure them."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import coopenv
from coopenv.agents.controllers import ImpedanceController, RandomPolicy
from coopenv.arrays import FloatArray

BEAM = ((-0.9, 0.1), (0.9, -0.2))
MASS, INERTIA = 6.0, 2.0  # [kg], [kg m²]
NOISE = {"f": 0.3, "t": 0.05, "x": 5e-4, "y": 5e-4, "theta": 1e-3, "v": 0.01, "omega": 0.01}


def planar(
    seed: int,
    *,
    rate: float = 100.0,
    duration: float = 12.0,
    noise: float = 1.0,
    stiffness: float = 0.0,
) -> dict:
    """Two effectors move a beam to and fro; columns in the object frame, twist in the world's.

    A spring of some stiffness [N/m] may hold it to the middle of the room.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(0, duration, 1 / rate)
    pose, twist, acceleration = _smooth(rng, time, (0.6, 0.6, 0.9))
    pose[:, 2] += rng.uniform(-3, 3)
    force = MASS * acceleration[:, :2] + 2.0 * twist[:, :2] + stiffness * pose[:, :2]
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    force = np.stack([c * force[:, 0] + s * force[:, 1], c * force[:, 1] - s * force[:, 0]], -1)
    torque = INERTIA * acceleration[:, 2] + 0.3 * twist[:, 2]
    squeeze = _smooth(rng, time, (10.0, 5.0))[0]
    share = 0.5 + 0.2 * np.sin(time)[:, None]
    forces = [share * force + squeeze, (1 - share) * force - squeeze]
    left = torque - sum(_cross(r, f) for r, f in zip(BEAM, forces, strict=True))
    own = _smooth(rng, time, (0.5,))[0][:, 0]
    # what torques do not do, a couple of forces across the beam does
    arm = np.subtract(BEAM[1], BEAM[0])
    torques = [own + 0.3 * left, 0.3 * left - own]
    across = np.array([-arm[1], arm[0]]) / (arm @ arm)
    couple = 0.4 * left[:, None] * across
    forces = [forces[0] - couple, forces[1] + couple]
    columns = {"time": time}
    for i, (f, t) in enumerate(zip(forces, torques, strict=True)):
        columns |= {f"f{i + 1}x": f[:, 0], f"f{i + 1}y": f[:, 1], f"t{i + 1}z": t}
    columns |= dict(zip(("x", "y", "theta"), pose.T, strict=True))
    columns |= dict(zip(("vx", "vy", "omega"), twist.T, strict=True))
    return noisy(columns, rng, noise)


def spatial(seed: int, *, rate: float = 100.0, duration: float = 12.0, noise: float = 1.0) -> dict:
    """The same in space, with weight; everything in the object frame."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, duration, 1 / rate)
    inertia = np.array([0.3, 2.0, 2.2])
    position, velocity, acceleration = _smooth(rng, time, (0.6, 0.6, 0.4))
    rotation = Rotation.from_rotvec(_smooth(rng, time, (0.8, 0.8, 0.8))[0])
    turned = (rotation[:-1].inv() * rotation[1:]).as_rotvec() * rate
    spin = np.concatenate([turned[:1], (turned[1:] + turned[:-1]) / 2, turned[-1:]])
    change = np.gradient(spin, 1 / rate, axis=0)
    force = rotation.inv().apply(MASS * (acceleration + np.array([0, 0, 9.81])))
    torque = inertia * change + np.cross(spin, inertia * spin)
    grips = np.array([[-0.9, 0.1, 0.0], [0.9, -0.2, 0.1]])
    squeeze = _smooth(rng, time, (5.0, 5.0, 5.0))[0]
    forces = [0.4 * force + squeeze, 0.6 * force - squeeze]
    left = torque - sum(np.cross(r, f) for r, f in zip(grips, forces, strict=True))
    columns = {"time": time}
    for i in range(2):
        for j, axis in enumerate("xyz"):
            columns[f"f{i + 1}{axis}"] = forces[i][:, j]
            columns[f"t{i + 1}{axis}"] = left[:, j] / 2
            columns[f"r{i + 1}{axis}"] = np.full(len(time), grips[i, j])
    velocity = rotation.inv().apply(velocity)
    columns |= dict(zip("xyz", position.T, strict=True))
    columns |= dict(
        zip(("qw", "qx", "qy", "qz"), np.roll(rotation.as_quat(), 1, -1).T, strict=True)
    )
    columns |= dict(zip(("vx", "vy", "vz"), velocity.T, strict=True))
    columns |= dict(zip(("omega_x", "omega_y", "omega_z"), spin.T, strict=True))
    return noisy(columns, rng, noise)


def noisy(columns: dict[str, FloatArray], rng: np.random.Generator, scale: float) -> dict:
    """With the noise of sensors and of motion capture."""
    made = {}
    for name, values in columns.items():
        size = next((NOISE[k] for k in (name, name[0], name[:5]) if k in NOISE), 0.0)
        size = {"z": 5e-4, "q": 5e-4}.get(name[0], size) if name != "time" else 0.0
        made[name] = values + scale * size * rng.normal(size=len(values))
    return made


def carried(seed: int, steps: int = 200, **config: Any) -> tuple[dict, tuple]:
    """A trial of the simulator, a controller and a restless partner; and its grips."""
    core = coopenv.Transport(num_worlds=1, **config)
    leader, partner = ImpedanceController(core.config), RandomPolicy(core.config, seed=seed)
    rows = []
    obs, _ = core.reset(seed=seed)
    step = core.transition
    assert step is not None
    for _ in range(steps):
        action = leader(obs, step)
        action[:, 1] += 0.8 * partner(obs, step)[:, 1]
        obs, _, terminated, truncated, _ = core.step(action)
        step = core.transition or step
        state = step.state
        rows.append([state.time[0], *step.applied[0].ravel(), *state.pose[0], *state.twist[0]])
        if terminated.any() or truncated.any():
            break
    names = [
        "time",
        "f1x",
        "f1y",
        "t1z",
        "f2x",
        "f2y",
        "t2z",
        "x",
        "y",
        "theta",
        "vx",
        "vy",
        "omega",
    ]
    columns = dict(zip(names, np.array(rows).T, strict=True))
    grips = tuple(tuple(grip) for grip in step.team.grips.reshape(-1, 2).tolist())
    return noisy(columns, np.random.default_rng(seed), 1.0), grips


def _smooth(rng: np.random.Generator, time: FloatArray, sizes: tuple) -> tuple:
    """Sums of sines ``(T, len(sizes))``, and their first and second derivative."""
    shape = (4, len(sizes))
    frequency = 2 * np.pi * rng.uniform(0.1, 0.7, shape)
    phase, size = rng.uniform(0, 2 * np.pi, shape), np.array(sizes) / 2
    at = frequency * time[:, None, None] + phase
    return tuple((size * frequency**n * np.sin(at + n * np.pi / 2)).sum(axis=1) for n in range(3))


def _cross(r: tuple[float, float], f: FloatArray) -> FloatArray:
    return r[0] * f[:, 1] - r[1] * f[:, 0]
