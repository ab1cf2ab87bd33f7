"""What a substep of hands comes to is what their law asks for, in extremes too."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Body
from coopenv.geometry.frames import rotated
from coopenv.physics.hands import needed_substeps
from tests.physics.held import Held

DT = 0.05  # [s]; one substep a step


def extreme(chance: np.random.Generator, count: int, friction: float, heading: float) -> Held:
    """Bodies as light as one substep allows, hands far stretched, limits that bind or do not."""
    agents = 3
    grips = chance.uniform(-0.8, 0.8, (count, agents, 2)) * [1.0, 0.3]
    springs = np.exp(chance.uniform(-3.0, 3.0, (count, agents, 4))) * [150.0, 20.0, 30.0, 5.0]
    springs[..., 1:] *= chance.choice([0.0, 1.0], (count, 1, 3), p=[0.3, 0.7])
    bodies = []
    for k in range(count):
        body = Body(
            mass=float(np.exp(chance.uniform(-2.0, 2.0))),
            inertia=float(np.exp(chance.uniform(-4.0, 1.0))),
            grips=tuple(map(tuple, grips[k].tolist())),
            ground_friction=friction * float(np.exp(chance.uniform(-4.0, 1.0))),
        )
        table, low, high = np.pad(springs[k], ((0, 0), (0, 2))), -8.0, 8.0
        for _ in range(6):  # bisection of the inertia that one substep asks for
            scale = float(np.exp((low + high) / 2))
            light = replace(body, mass=scale * body.mass, inertia=scale * (body.inertia or 0.0))
            few = needed_substeps(light, table, DT) == 1
            low, high = (low, (low + high) / 2) if few else ((low + high) / 2, high)
        scale = float(np.exp(high))
        bodies.append(replace(body, mass=scale * body.mass, inertia=scale * (body.inertia or 0.0)))
    limits = np.exp(chance.uniform(np.log(0.1), np.log(1e4), (count, agents, 2)))
    held = Held(bodies, springs, limits, pose=(0.3, -0.2, heading), dt=DT, substeps=1)
    held.world.twist = chance.normal(0.0, 1.0, held.world.twist.shape)
    apart = np.exp(chance.uniform(-5.0, 1.0, (count, 1, 1)))
    held.reference += apart * chance.normal(0.0, 1.0, held.reference.shape)
    held.velocity[:] = chance.normal(0.0, 1.0, held.velocity.shape)
    return held


def law(held: Held, before: tuple, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces ``(world, agent, 2)`` and torques of hands at the displacement since ``before``."""
    grips, angle = before
    stiff, turn_stiff, damp, turn_damp = np.moveaxis(held.springs, -1, 0)
    stretch = start[..., :2] - grips
    part = held.limit[..., 0] / np.maximum(stiff * np.linalg.norm(stretch, axis=-1), 1e-300)
    stretch = stretch * np.minimum(part, 1.0)[..., None]  # the leash
    moved = DT * held.velocity[..., :2] - (held.grips_in_world() - grips)
    force = stiff[..., None] * (stretch + moved / 2) + damp[..., None] * moved / DT
    size = np.maximum(np.linalg.norm(force, axis=-1), 1e-300)
    force *= np.minimum(held.limit[..., 0] / size, 1.0)[..., None]
    turn = start[..., 2] - angle[:, None]
    part = held.limit[..., 1] / np.maximum(turn_stiff * np.abs(turn), 1e-300)
    turn = turn * np.minimum(part, 1.0)
    more = DT * held.velocity[..., 2] - (held.world.pose[:, 2] - angle)[:, None]
    torque = turn_stiff * (turn + more / 2) + turn_damp * more / DT
    return force, np.clip(torque, -held.limit[..., 1], held.limit[..., 1])


@pytest.mark.parametrize(
    ("friction", "heading"),
    [(0.0, 0.7), (0.3, 0.7), (0.0, np.pi / 2)],
    ids=["smooth", "rough", "levers along the world's y"],
)
def test_what_hands_give_is_their_law_at_the_displacement_that_comes_of_it(friction, heading):
    held = extreme(np.random.default_rng(0), 600, friction, heading)
    saturated = 0
    for _ in range(2):
        before, start = (held.grips_in_world(), held.world.pose[:, 2]), held.reference.copy()
        held.step()
        force, torque = law(held, before, start)
        middle = ((held.world.pose[:, 2] + before[1]) / 2)[:, None]
        half = (held.world.pose[:, 2] - before[1])[:, None] / 2
        given = (
            np.stack(
                rotated(np.cos(middle), np.sin(middle), *np.moveaxis(held.applied[..., :2], -1, 0)),
                axis=-1,
            )
            / np.sinc(half / np.pi)[..., None]
        )
        scale = np.abs(force).sum(axis=(1, 2))[:, None]
        assert (np.linalg.norm(given - force, axis=-1) <= 1e-6 * scale + 1e-9).all()
        turned = np.abs(torque).sum(axis=1)[:, None] + 3 * scale
        assert (np.abs(held.applied[..., 2] - torque) <= 1e-6 * turned + 1e-9).all()
        size = np.linalg.norm(force, axis=-1)
        saturated += int((size > 0.999 * held.limit[..., 0]).sum())
    assert saturated > 200
