"""Record a trial of two controllers that want different things, then decompose the file.

The same as: coopenv decompose trial.csv --grips -0.9 0 0.9 0 --twist-frame world
"""

import csv

import numpy as np

import coopenv
from coopenv import logs
from coopenv.agents.controllers import ImpedanceController, RandomPolicy

core = coopenv.Transport(num_worlds=1)
leader, partner = ImpedanceController(core.config), RandomPolicy(core.config, seed=1)
names = ["time", "f1x", "f1y", "t1z", "f2x", "f2y", "t2z"]  # object frame [s, N, N·m]
names += ["x", "y", "theta", "vx", "vy", "omega"]  # world frame [m, rad, m/s, rad/s]

obs, info = core.reset(seed=0)
step = core.transition
assert step is not None  # there is one after every reset
with open("trial.csv", "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(names)
    for _ in range(100):
        action = leader(obs, step)
        action[:, 1] += 0.8 * partner(obs, step)[:, 1]  # the second effector is restless
        obs, reward, terminated, truncated, info = core.step(action)
        step = core.transition or step
        time, pose, twist = step.state.time[0], step.state.pose[0], step.state.twist[0]
        writer.writerow([time, *step.applied[0].ravel(), *pose, *twist])
        if terminated.any():
            break

layout = logs.Layout(grips=((-0.9, 0.0), (0.9, 0.0)), twist_frame="world")
summary = logs.decompose_file("trial.csv", layout=layout)
print(f"wrote {summary.table} and {summary.picture}")
for measure in summary.measures:
    print(f"{measure.name:>22}: mean {measure.mean:6.3f}, median {measure.median:6.3f}")

recording = logs.read("trial.csv", layout)  # the same as arrays
for method in ("optimal", "moore_penrose"):
    analysis = logs.analyse(recording, coopenv.wrench.Settings(method=method))
    print(f"{method:>22}: mean F_I {np.mean(analysis['internal_force_level']):.3f} N")
