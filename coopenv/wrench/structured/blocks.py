"""Blocks of the structured solver: how forces and torques of a sample lie in memory; compiled.

Block 2i is the force of effector i, block 2i + 1 its pure torque. A block holds a vector v, its
internal part g and the columns G that carry them to the resultant. v and g are in a frame of the
block's own: that of a force has the lever first and the part of the force across the lever second,
that of a torque has the torque's direction first. The first ``FREE`` coordinates of g are unknown,
the others are 0. Units are such that no force, torque or lever of the sample exceeds 1, and that
its applied cost is 1. A block has up to four cones, in this order:

0  cost        (τ, v − g), at the price c of τ
1  ball        (‖v‖/2, g − v/2)                              eqs. 19 and 21
2  disc        the same without the first coordinate         eq. 20
3  disc cost   (τ, v − g) without the first coordinate, for the cost of induced torque if s = 1

Four effectors make two chunks in memory, one of their forces and one of their torques (`lanes`).
Where there are fewer than four, blocks without free coordinates fill the lanes.
"""

from typing import Any, NamedTuple

from coopenv.arrays import FloatArray
from coopenv.compiled import TINY, anywhere, fused, fused_inlined
from coopenv.compiled.lanes.memory import after, lane
from coopenv.compiled.lanes.vectors import LANES, largest
from coopenv.wrench.structured.cones import CONE
from coopenv.wrench.structured.frame import norm3, set_frame
from coopenv.wrench.structured.tolerances import CHEAP, NEGLIGIBLE, NEGLIGIBLE_DEAR, RADIAL

FREE, CONES = 0, 1  # fields: how many coordinates are free, how many cones there are
RADIUS = 2  # ‖v‖/2
PRICE, DISC_PRICE = 3, 4  # c of the cost and of the disc cost
V, G, REST = 5, 8, 11  # v, g, v − g
ANSWER, KEPT = 14, 20  # the candidate for g, and the best so far
STEP = 17  # dg
COLUMNS = 23  # G, six numbers a column
PENDING = 41  # coordinates left free by a proposal, see `facial_reduction`
SEEN, RIGHT, FACTOR = 42, 45, 48  # Gᵀν, ρ, L D Lᵀ, see `newton`
FIRST_CONE = 54
WIDTH = FIRST_CONE + 4 * CONE  # fields in all


class Sample(NamedTuple):
    """A sample's blocks in memory."""

    fields: Any  # of the first chunk; the others follow
    num_chunks: int


class Options(NamedTuple):
    """What is asked for all samples of a batch."""

    torque_weight: float  # w
    induced: float  # s, 0 or 1
    tolerance: float  # wanted gap, relative to J(h)


class Units(NamedTuple):
    """Units of a sample."""

    force: float  # [N]
    length: float  # [m]
    cost: float  # J(h), in units of force


class Spare(NamedTuple):
    """Memory for passing use."""

    full: FloatArray  # an effector's wrench in three dimensions (6,)
    grip: FloatArray  # and its grip (3,)
    frame: FloatArray  # a block's frame, one axis a row (3, 3)
    middle: FloatArray  # of the grips (3,), see `alignment`
    turn: FloatArray  # rotation of the frame in which torques are balanced (3, 3), see `alignment`


@anywhere
def chunks_for(num_effectors):
    """Return how many chunks so many effectors need: two for every four."""
    return 2 * ((num_effectors + LANES - 1) // LANES)


@fused_inlined
def num_chunks(sample):
    """Return how many chunks a sample has."""
    return sample.num_chunks


@fused_inlined
def num_blocks(sample):
    """Return how many blocks a sample has, with those that only fill the lanes."""
    return LANES * sample.num_chunks


@fused_inlined
def chunk(sample, i):
    """Return the fields of chunk i, each of four blocks at once."""
    return after(sample.fields, WIDTH * i)


@fused_inlined
def block(sample, i):
    """Return the fields of block i, each a number."""
    return lane(chunk(sample, i // (2 * LANES) * 2 + i % 2), i // 2 % LANES)


@fused_inlined
def num_cones(b):
    """Return the most cones that a block of the chunk has."""
    return int(largest(b[CONES]))


@fused_inlined
def cone_of(b, c):
    """Return the fields of the cones c of a chunk, which `cones` names."""
    return after(b, FIRST_CONE + CONE * c)


@fused
def fill(sample, wrench, grips, options, spare):
    """Write the sample's blocks; return its `Units`."""
    full, grip, frame = spare.full, spare.grip, spare.frame
    w = options.torque_weight
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(FIRST_CONE):
            b[j] = 0.0  # the sample before may have left what is not a number
    force, length, longest = _units(wrench, grips, full, grip)
    cost = 0.0
    least = max(NEGLIGIBLE_DEAR, min(NEGLIGIBLE, CHEAP * (1.0 - w) / (w * length)))
    for i in range(wrench.shape[0]):
        _spread(wrench, grips, i, full, grip)
        for r in range(3):
            full[r] /= force
            full[r + 3] /= force * length
            grip[r] /= length
        row, torque = block(sample, 2 * i), block(sample, 2 * i + 1)
        _fill_force(row, full, grip, frame, wrench.shape[1] == 3, longest / length)
        _fill_torque(torque, full, frame, wrench.shape[1] == 3, least)
        row[PRICE], torque[PRICE] = 1.0 - w, w * length
        row[DISC_PRICE] = options.induced * w * length * norm3(grip[0], grip[1], grip[2])
        if row[CONES] == 3.0 and options.induced > 0.0:
            row[CONES] = 4.0
        cost += row[PRICE] * norm3(row[V], row[V + 1], 0.0) + row[DISC_PRICE] * abs(row[V + 1])
        cost += torque[PRICE] * abs(torque[V])
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        b[PRICE] /= max(cost, TINY)
        b[DISC_PRICE] /= max(cost, TINY)
    return Units(force, length, cost)


@fused
def _units(wrench, grips, full, grip):
    """Return units of force and length in which nothing exceeds 1, and the longest lever."""
    force, torque, length = 0.0, 0.0, 0.0
    for i in range(wrench.shape[0]):
        _spread(wrench, grips, i, full, grip)
        force = max(force, norm3(full[0], full[1], full[2]))
        torque = max(torque, norm3(full[3], full[4], full[5]))
        length = max(length, norm3(grip[0], grip[1], grip[2]))
    longest = length
    if force > 0.0:
        length = max(length, torque / force)
        return force, (length if length > 0.0 else 1.0), longest
    length = length if length > 0.0 else 1.0
    return (torque / length if torque > 0.0 else 1.0), length, longest


@fused
def _spread(wrench, grips, i, full, grip):
    """Write effector i's wrench and grip in three dimensions."""
    grip[0], grip[1] = grips[i, 0], grips[i, 1]
    if wrench.shape[1] == 3:
        full[0], full[1], full[2] = wrench[i, 0], wrench[i, 1], 0.0
        full[3], full[4], full[5] = 0.0, 0.0, wrench[i, 2]
        grip[2] = 0.0
        return
    for r in range(6):
        full[r] = wrench[i, r]
    grip[2] = grips[i, 2]


@fused
def _fill_force(row, full, grip, frame, planar, longest):
    """Write the block of a force, ``longest`` being the longest lever."""
    x, y, z = full[0], full[1], full[2]
    size, lever = norm3(x, y, z), norm3(grip[0], grip[1], grip[2])
    has_lever = lever > NEGLIGIBLE * longest
    if has_lever:
        set_frame(frame, grip[0] / lever, grip[1] / lever, grip[2] / lever, x, y, z)
    elif size > 0.0:
        set_frame(frame, x / size, y / size, z / size, 0.0, 0.0, 0.0)
    else:
        set_frame(frame, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    for j in range(2):
        row[V + j] = frame[j, 0] * x + frame[j, 1] * y + frame[j, 2] * z
    row[V + 2] = 0.0
    radial = abs(row[V + 1]) <= RADIAL * size
    if radial or not has_lever:
        row[V + 1] = 0.0
    _set_columns(row, frame, 0, lever if has_lever else 0.0)
    row[FREE], row[CONES] = (2.0 if planar else 3.0), 3.0
    if has_lever and radial:
        row[FREE], row[CONES] = 1.0, 2.0
    elif not has_lever:
        row[CONES] = 2.0
    if size <= NEGLIGIBLE:
        row[FREE], row[CONES] = 0.0, 0.0


@fused
def _fill_torque(row, full, frame, planar, least):
    """Write the block of a pure torque; one up to ``least`` is left as applied."""
    x, y, z = full[3], full[4], full[5]
    size = norm3(x, y, z)
    row[V], row[V + 1], row[V + 2] = size, 0.0, 0.0
    if size > 0.0:
        set_frame(frame, x / size, y / size, z / size, 0.0, 0.0, 0.0)
    else:
        set_frame(frame, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    _set_columns(row, frame, 3, 0.0)
    row[FREE], row[CONES] = (1.0 if planar else 3.0), 2.0
    if size <= least:
        row[FREE], row[CONES] = 0.0, 0.0


@fused
def _set_columns(row, frame, first, lever):
    """Write G: the axes of the frame from component ``first`` on, and the torques they induce."""
    for j in range(18):
        row[COLUMNS + j] = 0.0
    for j in range(3):
        for r in range(3):
            row[COLUMNS + 6 * j + first + r] = frame[j, r]
    if lever > 0.0:
        for r in range(3):
            row[COLUMNS + 9 + r] = lever * frame[2, r]
            row[COLUMNS + 15 + r] = -lever * frame[1, r]


@fused
def write(sample, wrench, units, manipulation):
    """Write the manipulation wrench h − g of the candidate answer, in newtons and metres."""
    size = wrench.shape[1]
    for i in range(wrench.shape[0]):
        for r in range(size):
            component = 5 if size == 3 and r == 2 else r
            row, unit = block(sample, 2 * i), units.force
            if component > 2:
                row, unit = block(sample, 2 * i + 1), units.force * units.length
            internal = 0.0
            for j in range(3):
                internal += row[COLUMNS + 6 * j + component] * row[ANSWER + j]
            manipulation[i, r] = wrench[i, r] - unit * internal
