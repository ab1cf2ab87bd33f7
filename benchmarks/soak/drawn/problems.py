"""Wrenches and grips to decompose: every family, two to eight effectors, any scale."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from tests.wrench.cases import pair_families
from tests.wrench.structured.cases import GRIPS, families, grips_of_kind

CLOSEST = 1e-6  # [m] from each other or a line, to which all solvers tell; `pair` tells closer ones
FEW, MANY = 2, 8  # effectors


class Problem(NamedTuple):
    """A batch of one family at one set of grips."""

    name: str
    applied: FloatArray  # (sample, n, k)
    grips: FloatArray  # (n, d)
    ordinary: bool  # whether levers are of about a metre, and torques of what forces make there
    apart: bool  # whether all solvers tell its grips from one place and from a line

    @property
    def is_pair(self) -> bool:
        """Whether it is of two effectors in the plane."""
        return self.grips.shape == (2, 2)


def any_problems(rng: np.random.Generator, count: int) -> Iterator[Problem]:
    """All families of ``count`` wrenches, with a number of effectors, a dimension and a scale."""
    dimension = int(rng.choice([2, 3]))
    effectors = FEW if rng.random() < 0.4 else int(rng.integers(FEW, MANY + 1))
    ordinary = bool(rng.random() < 0.5)
    lever, twisted = (0.0, 0.0) if ordinary else rng.uniform(-6.0, 6.0, 2)  # decades
    force = rng.uniform(-12.0, 12.0)
    made = families(rng, count, effectors, dimension)
    if (effectors, dimension) == (2, 2):
        made |= pair_families(rng, count)
    for family, applied in made.items():
        kind = str(rng.choice([*GRIPS, "close", "nearly a line", "one at the centre"]))
        grips, apart = any_grips(rng, kind, effectors, dimension)
        scaled = applied * 10.0**force
        scaled[..., dimension:] *= 10.0**twisted
        name = f"{family}, grips {kind}, n={effectors}, {dimension}D, 1e{force:.0f} N"
        if not ordinary:
            name += f", levers 1e{lever:.0f}, torques 1e{twisted:.0f}"
        yield Problem(name, scaled, grips * 10.0**lever, ordinary and family != "uneven", apart)


def any_grips(
    rng: np.random.Generator, kind: str, effectors: int, dimension: int
) -> tuple[FloatArray, bool]:
    """Grips ``(n, d)`` [m] of that kind, and whether all solvers can tell them apart."""
    if kind in GRIPS:
        return grips_of_kind(rng, kind, effectors, dimension), True
    grips = rng.normal(size=(effectors, dimension))
    if kind == "close":
        distance = 10.0 ** rng.uniform(-16.0, -1.0)  # [m]
        grips[1] = grips[0] + distance * grips[1]
        return grips, distance > CLOSEST
    if kind == "nearly a line":
        distance = 10.0 ** rng.uniform(-14.0, -1.0)  # [m]
        grips[:, 1:] *= distance
        return grips, distance > CLOSEST
    grips[0] = 0.0
    return grips, True
