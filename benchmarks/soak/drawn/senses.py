"""Observations drawn at random: any blocks in any order, imperfect sensors, range readings."""

from typing import Any

import numpy as np

from coopenv import BLOCKS, Block, Sensor, TransportConfig
from coopenv.observation import ranges


def any_senses(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Senses by their word, or some of all blocks, each perfect or not."""
    if rng.random() < 0.2:
        return {"sensing": str(rng.choice(["own", "shared"]))}
    felt = [each for each in BLOCKS.values() if config.hands is not None or not each.needs_hands]
    known = [*felt, *config.task.blocks]
    some = rng.permutation(len(known))[: rng.integers(1, len(known) + 1)]
    return {"observe": tuple(_entry(rng, known[k]) for k in some)}


def any_bounds(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """Finite ends of every feature."""
    return {"bounded": True}


def _entry(rng: np.random.Generator, block: Block) -> str | Block | Sensor:
    """The block, often in a sensor; range readings with other rays."""
    if block.name in ("obstacles", "partner_obstacles") and rng.random() < 0.5:
        block = ranges(
            num_rays=int(rng.integers(1, 20)),
            reach=rng.uniform(0.1, 10.0),
            field_of_view=rng.uniform(0.1, 2 * np.pi),
            heading=rng.uniform(-4.0, 4.0),
            where=str(rng.choice(["grip", "centre"])),
            whose="own" if block.name == "obstacles" else "partners",
        )
    if rng.random() < 0.6:
        return block.name if block.name in BLOCKS and BLOCKS[block.name] == block else block
    noise, bias = 10.0 ** rng.uniform(-4, 1, 2) * (rng.random(2) < 0.7)
    delay = int(rng.choice([0, 1, 3, 40]))
    return Sensor(block, noise=float(noise), bias=float(bias), delay=delay)
