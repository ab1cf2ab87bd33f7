"""Point and frame of the balance of torque in the structured solver's second attempt; compiled.

Wrenches that balance about one point and in one frame balance about all points and in all frames.
The choice matters only for rounding. With grips on one line the torque about the line can be
balanced by pure torques alone, which may be small. About the centre of mass it is a difference of
large numbers, namely forces times long levers. About the middle of the grips, in a frame along
their line, it is not.
"""

from coopenv.compiled import fused
from coopenv.wrench.structured.blocks import COLUMNS, block
from coopenv.wrench.structured.frame import norm3, set_frame
from coopenv.wrench.structured.tolerances import NEGLIGIBLE

POWERS = 3  # iterations


@fused
def align(sample, wrench, grips, units, spare):
    """Write the rows of torque of G about the middle of the grips, in a frame along their line."""
    arm, middle, turn = spare.grip, spare.middle, spare.turn
    _find_middle(wrench, grips, units.force, middle)
    _find_line(wrench, grips, units.force, spare)
    for i in range(wrench.shape[0]):
        _arm(grips, i, middle, arm)
        force, torque = block(sample, 2 * i), block(sample, 2 * i + 1)
        for j in range(3):
            at = COLUMNS + 6 * j
            x, y, z = force[at], force[at + 1], force[at + 2]
            force[at + 3] = (arm[1] * z - arm[2] * y) / units.length
            force[at + 4] = (arm[2] * x - arm[0] * z) / units.length
            force[at + 5] = (arm[0] * y - arm[1] * x) / units.length
            _turn(force, at + 3, turn)
            _turn(torque, at + 3, turn)


@fused
def turn_back(sample, wrench, spare):
    """Write the directions of the torques as they were before `align`."""
    turn = spare.turn
    for r in range(3):
        for t in range(r):
            turn[r, t], turn[t, r] = turn[t, r], turn[r, t]
    for i in range(wrench.shape[0]):
        for j in range(3):
            _turn(block(sample, 2 * i + 1), COLUMNS + 6 * j + 3, turn)


@fused
def _turn(row, at, turn):
    """Turn the three numbers of a row from ``at`` on."""
    x, y, z = row[at], row[at + 1], row[at + 2]
    for r in range(3):
        row[at + r] = turn[r, 0] * x + turn[r, 1] * y + turn[r, 2] * z


@fused
def _pushes(wrench, i, force):
    """Whether an effector has a force that counts, ``force`` being the largest."""
    third = wrench[i, 2] if wrench.shape[1] == 6 else 0.0
    return norm3(wrench[i, 0], wrench[i, 1], third) > NEGLIGIBLE * force


@fused
def _arm(grips, i, middle, arm):
    """Write the position of a grip from the middle."""
    arm[2] = 0.0
    for r in range(grips.shape[1]):
        arm[r] = grips[i, r] - middle[r]


@fused
def _find_middle(wrench, grips, force, middle):
    """Write the mean of the grips that have forces that count."""
    number = 0
    for r in range(3):
        middle[r] = 0.0
    for i in range(wrench.shape[0]):
        if _pushes(wrench, i, force):
            number += 1
            for r in range(grips.shape[1]):
                middle[r] += grips[i, r]
    for r in range(3):
        middle[r] /= max(number, 1)


@fused
def _find_line(wrench, grips, force, spare):
    """Write the frame along the line that the grips are closest to; in the plane no rotation.

    The line is the widest direction of the grips' scatter, by power iteration.
    """
    vector, arm, scatter = spare.full, spare.grip, spare.frame
    middle, turn = spare.middle, spare.turn
    for r in range(3):
        vector[r], vector[3 + r] = 0.0, 0.0
        for t in range(3):
            scatter[r, t], turn[r, t] = 0.0, 1.0 if r == t else 0.0
    if grips.shape[1] == 2:
        return
    for i in range(wrench.shape[0]):
        if _pushes(wrench, i, force):
            _arm(grips, i, middle, arm)
            for r in range(3):
                for t in range(3):
                    scatter[r, t] += arm[r] * arm[t]
    widest = 0
    for r in range(1, 3):
        if scatter[r, r] > scatter[widest, widest]:
            widest = r
    if not scatter[widest, widest] > 0.0:
        return
    vector[widest] = 1.0
    for _ in range(1 + POWERS):
        for r in range(3):
            vector[3 + r] = 0.0
            for t in range(3):
                vector[3 + r] += scatter[r, t] * vector[t]
        size = norm3(vector[3], vector[4], vector[5])
        for r in range(3):
            vector[r] = vector[3 + r] / size
    set_frame(turn, vector[0], vector[1], vector[2], 0.0, 0.0, 0.0)
