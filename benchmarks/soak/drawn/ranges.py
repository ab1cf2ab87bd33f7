"""Ranges drawn at random: what episodes draw anew."""

from typing import Any

import numpy as np

from coopenv import Ranges, Scene, TransportConfig


def any_ranges(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Ranges of about half of what there is to be drawn."""
    length = (0.9, 1.1) if rng.random() < 0.5 else (1.4, 2.2)
    every: dict[str, Any] = {
        "mass": (3.0, 30.0),
        "inertia": (0.5, 6.0),
        "linear_drag": (0.0, 20.0),
        "angular_drag": (0.0, 20.0),
        "friction": (0.0, 1.0),
        "length": length,
        "grips": ((-0.04, 0.04), (-0.02, 0.02) if rng.random() < 0.5 else (0.0, 0.0)),
        "force_limit": (1.0, 20.0),
        "torque_limit": (0.5, 10.0),
    }
    if "Walker" not in env:  # wheels do not rub
        every["ground_friction"] = (0.0, 0.5)
    if config.hands is not None:
        every |= {"stiffness": (50.0, 300.0), "damping": (5.0, 60.0)}
    if isinstance(config.scene, Scene) and any(config.scene.gravity):
        strength = float(np.hypot(*config.scene.gravity))
        every["gravity"] = (rng.uniform(0.0, 1.0) * strength, rng.uniform(1.0, 1.5) * strength)
    if rng.random() < 0.5:
        every |= {
            "delay": (int(rng.integers(3)), int(rng.integers(3, 9))),
            "time_constant": (0.0, rng.uniform(0.01, 0.5)),
            "rate_limit": (rng.uniform(0.5, 2.0), rng.uniform(2.0, 20.0)),
        }
    kept = {name: value for name, value in every.items() if rng.random() < 0.5}
    logarithmic = ("mass",) if "mass" in kept and rng.random() < 0.5 else ()
    return {"randomise": Ranges(**kept, logarithmic=logarithmic)}
