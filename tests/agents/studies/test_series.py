"""Series of the studies: every column holds the numbers of its name, sample by sample."""

import csv

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.studies.beam import report as beam
from coopenv.agents.studies.beam import simulation
from coopenv.agents.studies.methods import decompose_by_methods
from coopenv.agents.studies.walker import report as walker
from coopenv.agents.studies.walker.simulations import Recording
from coopenv.wrench import decompose, energy_share, load_share


def rows_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_series_of_a_walk(tmp_path):
    generator = np.random.default_rng(0)
    steps = 5
    seen = Recording(
        time=np.linspace(0.0, 0.4, steps), pose=generator.normal(size=(steps, 3)),
        twist=generator.normal(size=(steps, 3)), applied=generator.normal(size=(steps, 2, 3)),
        planned=generator.normal(size=(steps, 3)), grips=np.array([(-0.5, 0.0), (0.3, 0.0)]),
        clearance=generator.uniform(size=steps),
    )  # fmt: skip
    walker.save_series(walker.Walk(seen), tmp_path)
    c, s = np.cos(seen.pose[:, 2]), np.sin(seen.pose[:, 2])
    along, across = (
        c * seen.twist[:, 0] + s * seen.twist[:, 1],
        c * seen.twist[:, 1] - s * seen.twist[:, 0],
    )
    twist = np.column_stack([along, across, seen.twist[:, 2]])
    energy = energy_share(seen.applied, seen.grips, twist).total[:, 0]
    split = decompose(seen.applied, seen.grips, method="moore_penrose")
    wanted = {
        "time": seen.time, "x": seen.pose[:, 0], "y": seen.pose[:, 1], "theta": seen.pose[:, 2],
        "x_planned": seen.planned[:, 0], "theta_planned": seen.planned[:, 2],
        "vx": along, "vy": across, "omega": seen.twist[:, 2],
        "f1x": seen.applied[:, 0, 0], "f1y": seen.applied[:, 0, 1], "t1z": seen.applied[:, 0, 2],
        "f2x": seen.applied[:, 1, 0], "f2y": seen.applied[:, 1, 1], "t2z": seen.applied[:, 1, 2],
        "clearance": seen.clearance,
        "force_share_1": load_share(seen.applied, seen.grips).force[:, 0],
        "torque_share_1": load_share(seen.applied, seen.grips).torque[:, 0],
        "energy_share_1": energy,
        "moore_penrose_F_I": split.internal_force_level,
        "moore_penrose_T_I": split.internal_torque_level,
        "moore_penrose_gamma": split.relative_cost,
    }  # fmt: skip
    rows = rows_of(tmp_path / "series.csv")
    for name, values in wanted.items():
        np.testing.assert_allclose(
            [float(row[name]) for row in rows], values, rtol=1e-8, err_msg=name
        )
    arrays = np.load(tmp_path / "series.npz")
    for name in ("time", "pose", "planned", "applied", "grips", "clearance"):
        np.testing.assert_array_equal(arrays[name], getattr(seen, name), err_msg=name)
    np.testing.assert_allclose(arrays["twist"], seen.twist)
    np.testing.assert_allclose(arrays["internal_moore_penrose"], split.internal)


def test_the_series_of_the_beam(tmp_path):
    run = simulation.simulate(simulation.BeamConfig(duration=1.0, dt=0.025))
    by_method = decompose_by_methods(run.applied, run.grips)
    beam.save_series(run, by_method, tmp_path)
    rows = rows_of(tmp_path / "series.csv")
    steps, motions = len(run.time), len(simulation.MOTIONS)
    assert len(rows) == 2 * motions * steps
    i, j, k = 1, 2, 7
    row = rows[(i * motions + j) * steps + k]
    share = load_share(run.applied, run.grips)
    wanted = {
        "inertia": run.inertias[i], "time": run.time[k],
        "virtual_mass": run.virtual_mass[k], "wanted_share": run.wanted_share[k],
        "x": run.pose[i, j, k, 0], "y": run.pose[i, j, k, 1], "theta": run.pose[i, j, k, 2],
        "vx": run.twist[i, j, k, 0], "omega": run.twist[i, j, k, 2],
        "f1x": run.applied[i, j, k, 0, 0], "t1z": run.applied[i, j, k, 0, 2],
        "f2y": run.applied[i, j, k, 1, 1], "t2z": run.applied[i, j, k, 1, 2],
        "force_share_1": share.force[i, j, k, 0], "torque_share_1": share.torque[i, j, k, 0],
        "energy_share_1": energy_share(run.applied, run.grips, run.twist).total[i, j, k, 0],
        "optimal_F_I": by_method["optimal"].internal_force_level[i, j, k],
        "nonsqueezing_gamma": by_method["nonsqueezing"].relative_cost[i, j, k],
    }  # fmt: skip
    assert row["motion"] == simulation.MOTIONS[j]
    for name, value in wanted.items():
        assert float(row[name]) == pytest.approx(value, rel=1e-8, abs=1e-12, nan_ok=True), name
