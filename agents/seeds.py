"""Seeds of worlds: which are for training and which are held out.

World k of a batch seeded with s uses s + k and goes on from there. Training number ``seed`` owns a
block of `BLOCK` world seeds, evaluation likewise, in two ranges that never meet:

==================  ======================================
training            ``[seed · 2²⁰, (seed + 1) · 2²⁰)``, below 2³¹
evaluation          ``2³¹ + [seed · 2²⁰, (seed + 1) · 2²⁰)``
==================  ======================================

The last evaluation, number `STOPPING`, is of runs that end where their policy succeeds often enough
(`coopenv.agents.settings.TrainConfig.until`).

So no episode is ever trained on and tested on, and two trainings never share a world.
"""

from coopenv.arrays import whole
from coopenv.errors import InvalidInput

BLOCK = 2**20  # world seeds of one training or one evaluation
HELD_OUT = 2**31  # the first world seed that no training uses
STOPPING = HELD_OUT // BLOCK - 1  # number of the evaluation that ends trainings


def training_seeds(seed: int, num_worlds: int) -> range:
    """World seeds of training number ``seed``, one a world."""
    return _block(seed, num_worlds, start=0)


def evaluation_seeds(seed: int, episodes: int) -> range:
    """World seeds of evaluation number ``seed``, one an episode."""
    return _block(seed, episodes, start=HELD_OUT)


def _block(seed: int, count: int, *, start: int) -> range:
    seed, count = whole(seed, "seed", at_least=0), whole(count, "number of worlds", at_least=1)
    if seed >= HELD_OUT // BLOCK or count > BLOCK:
        raise InvalidInput(
            f"seed must be below {HELD_OUT // BLOCK} and seed at most {BLOCK} worlds, got seed "
            f"{seed} for {count}; training and evaluation would share episodes otherwise"
        )
    first = start + seed * BLOCK
    return range(first, first + count)
