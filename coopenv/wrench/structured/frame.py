"""Orthonormal frames in which one axis is given, for the structured solver; compiled."""

from math import sqrt

from coopenv.compiled import fused, fused_inlined
from coopenv.wrench.structured.tolerances import RADIAL


@fused_inlined
def norm3(x, y, z):
    """Return the length of a vector."""
    return sqrt(x * x + y * y + z * z)


@fused
def set_frame(frame, x, y, z, px, py, pz):
    """Write the axes of a frame: (x, y, z), the direction of p across it, and their product.

    (x, y, z) has the length 1. Where p has no part across it, any direction across is taken.
    """
    size = norm3(px, py, pz)
    px, py, pz = _across(x, y, z, px, py, pz)
    if norm3(px, py, pz) <= RADIAL * size:  # what is left is rounding, and no direction
        if abs(x) + abs(y) > 0.1:  # any direction across, in the plane z = 0 if (x, y, z) is
            px, py, pz = -y, x, 0.0
        else:
            px, py, pz = 0.0, z, -y
    for _ in range(2):
        size = norm3(px, py, pz)
        px, py, pz = _across(x, y, z, px / size, py / size, pz / size)
    frame[0, 0], frame[0, 1], frame[0, 2] = x, y, z
    frame[1, 0], frame[1, 1], frame[1, 2] = px, py, pz
    frame[2, 0], frame[2, 1], frame[2, 2] = y * pz - z * py, z * px - x * pz, x * py - y * px


@fused
def _across(x, y, z, px, py, pz):
    """Return the part of p across the unit vector (x, y, z)."""
    along = x * px + y * py + z * pz
    return px - along * x, py - along * y, pz - along * z
