"""Advance: a whole control step of many shards in one call, on as many cores as there are.

Of each shard pymunk reads the commands, steps, and reports, once a substep.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.compiled import compiled, inlined
from coopenv.compiled.parallel import spread
from coopenv.physics.coefficients import NUM_COEFFICIENTS, NUM_EXPECTED
from coopenv.physics.collect import collect
from coopenv.physics.compliance import feel, hold
from coopenv.physics.motion import drive
from coopenv.physics.native import (
    COMMANDS,
    EACH_BODY,
    GET_BODY,
    NUM_HANDLES,
    REPORTS,
    SET_BODY,
    SPACE,
    STEP,
    each_body,
    step_space,
)


class Memory(NamedTuple):
    """What kernels keep of worlds from step to step; those of a shard are its part of it.

    The engine takes rows for the static body and one that stays empty, as it makes room anew as
    soon as what it writes to is full.
    """

    rows: IntArray  # (world,) in the reports and commands of its shard
    table: FloatArray  # (world, NUM_COEFFICIENTS)
    rooms: FloatArray  # (world, 4), see `coopenv.physics.collect.collect`
    expected: FloatArray  # (world, NUM_EXPECTED)
    handles: IntArray  # (shard, NUM_HANDLES) addresses
    cursors: npt.NDArray[np.int32]  # (shard, 2, 4) headers of commands and reports
    commands: FloatArray  # (shard, row, 6), see `coopenv.physics.motion.drive`
    reports: FloatArray  # (shard, row, 6), see `coopenv.physics.collect.collect`

    @classmethod
    def of(cls, num_worlds: int, size: int) -> "Memory":
        """For shards of ``size`` worlds, and a last one of what is left."""
        count = -(-num_worlds // size)
        return cls(
            rows=np.zeros(num_worlds, dtype=np.int64),
            table=np.zeros((num_worlds, NUM_COEFFICIENTS)),
            rooms=np.zeros((num_worlds, 4)),
            expected=np.zeros((num_worlds, NUM_EXPECTED)),
            handles=np.zeros((count, NUM_HANDLES), dtype=np.int64),
            cursors=np.zeros((count, 2, 4), dtype=np.int32),
            commands=np.zeros((count, size + 2, 6)),
            reports=np.zeros((count, size + 2, 6)),
        )

    def shard(self, number: int, size: int) -> "Memory":
        """The part of a shard, with axes as all have them."""
        worlds, shards = slice(number * size, (number + 1) * size), slice(number, number + 1)
        return Memory(
            rows=self.rows[worlds],
            table=self.table[worlds],
            rooms=self.rooms[worlds],
            expected=self.expected[worlds],
            handles=self.handles[shards],
            cursors=self.cursors[shards],
            commands=self.commands[shards],
            reports=self.reports[shards],
        )


@inlined
def _move(s, calls, handles, cursors, substep):
    """Let the engine read the commands of shard ``s``, step, and report."""
    space = handles[s, SPACE]
    cursors[s, 0, 0] = 0
    each_body(calls[EACH_BODY], space, calls[SET_BODY], handles[s, COMMANDS])
    step_space(calls[STEP], space, substep)
    cursors[s, 1, 0] = 0
    each_body(calls[EACH_BODY], space, calls[GET_BODY], handles[s, REPORTS])


@inlined
def _average(around, dt):
    """Make of what was given over a step its mean."""
    for k in range(len(around)):
        for i in range(around.shape[1]):
            around[k, i] /= dt


@inlined
def _part_of_shard(s, size, memory, begin, reached):
    """Rows of shard ``s``: where they begin and end, and its part of what all worlds have.

    Of ``memory`` rows, table, rooms and expected; of ``begin`` and ``reached`` everything.
    """
    rows, table, rooms, expected = memory[0], memory[1], memory[2], memory[3]
    a, b = s * size, min((s + 1) * size, len(rows))
    kept = rows[a:b], table[a:b], rooms[a:b], expected[a:b]
    free = begin[0][a:b], begin[1][a:b]
    pose, twist, impulse, shift, around = reached
    come = pose[a:b], twist[a:b], impulse[a:b], shift[a:b], around[a:b]
    return a, b, kept, free, come


@compiled
def _step_shards(start, stop, calls, memory, begin, wrench, reached, lost, size, dt, substeps):
    handles, cursors, commands, reports = memory[4], memory[5], memory[6], memory[7]
    special = memory[8]
    substep = dt / substeps
    for s in range(start, stop):
        a, b, kept, free, come = _part_of_shard(s, size, memory, begin, reached)
        rows, table, rooms, expected = kept
        pose, twist, impulse, shift, around = come
        under, step = wrench[a:b], commands[s]
        drive(rows, table, free[0], free[1], under, substep, step, expected, around, special)
        for left in range(substeps - 1, -1, -1):
            _move(s, calls, handles, cursors, substep)
            lost[s] = collect(
                rows, table, rooms, reports[s], expected, pose, twist, impulse, shift, around,
                special,
            )  # fmt: skip
            if left == 0 or lost[s] >= 0:
                break
            drive(rows, table, pose, twist, under, substep, step, expected, around, special)
        _average(around, dt)


@compiled
def _hold_shards(start, stop, calls, memory, begin, hands, reached, lost, size, dt, substeps):
    handles, cursors, commands, reports = memory[4], memory[5], memory[6], memory[7]
    special = memory[8]
    substep, share = dt / substeps, 1 / substeps
    for s in range(start, stop):
        a, b, kept, free, come = _part_of_shard(s, size, memory, begin, reached)
        rows, table, rooms, expected = kept
        pose, twist, impulse, shift, around = come
        under = (
            hands[0][a:b], hands[1][a:b], hands[2][a:b], hands[3][a:b], hands[4][a:b],
            hands[5][a:b], hands[6][a:b], hands[7][a:b], hands[8][a:b], hands[9][a:b],
        )  # fmt: skip
        step = commands[s]
        hold(rows, table, free[0], free[1], under, substep, share, step, expected, around)
        for left in range(substeps - 1, -1, -1):
            _move(s, calls, handles, cursors, substep)
            lost[s] = collect(
                rows, table, rooms, reports[s], expected, pose, twist, impulse, shift, around,
                special,
            )  # fmt: skip
            if left == 0 or lost[s] >= 0:
                break
            hold(rows, table, pose, twist, under, substep, share, step, expected, around)
        feel(pose, twist, under)
        _average(around, dt)


@inlined
def _first_lost(lost, size):
    for s in range(len(lost)):
        if lost[s] >= 0:
            return s * size + lost[s]
    return -1


@compiled
def step_shards(board, parts, calls, memory, begin, wrench, reached, lost, size, dt, substeps):
    """Advance all shards by a control step of ``dt`` [s] under a held wrench.

    Parameters
    ----------
    board, parts
        As in `coopenv.compiled.parallel.spread`; no part is smaller than a shard.
    calls
        ``(NUM_CALLS,)`` addresses of the engine's functions.
    memory
        `Memory`, as a tuple, and ``special`` of `coopenv.physics.motion.drive`.
    begin
        Pose and twist ``(world, 3)`` at the beginning.
    wrench
        ``(world, 3)`` object frame [N, N·m].
    reached
        Pose, twist, impulse, shift and around, as `coopenv.physics.collect.collect` has them; what
        is added has to be zero. ``around`` becomes a mean over the step.
    lost
        ``(shard,)`` written: a world of the shard that left its room, or −1.
    size
        Worlds of a shard.
    dt, substeps
        Of a control step [s], and how often pymunk steps in it.

    Returns
    -------
    The first world that left its room, or −1.
    """
    arguments = (calls, memory, begin, wrench, reached, lost, size, dt, substeps)
    spread(board, parts, len(lost), _step_shards, arguments)
    return _first_lost(lost, size)


@compiled
def hold_shards(board, parts, calls, memory, begin, hands, reached, lost, size, dt, substeps):
    """`step_shards` under what hands give: the fields of a `coopenv.physics.compliance.Hold`."""
    arguments = (calls, memory, begin, hands, reached, lost, size, dt, substeps)
    spread(board, parts, len(lost), _hold_shards, arguments)
    return _first_lost(lost, size)
