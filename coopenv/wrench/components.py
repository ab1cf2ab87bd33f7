"""Components of an effector's wrench and its torque at the centre of mass, in three dimensions."""

from math import sqrt

from coopenv.compiled import compiled, inlined


@compiled
def components(wrench, i):
    """Force and torque of effector i in three dimensions."""
    if wrench.shape[1] == 3:
        return wrench[i, 0], wrench[i, 1], 0.0, 0.0, 0.0, wrench[i, 2]
    return wrench[i, 0], wrench[i, 1], wrench[i, 2], wrench[i, 3], wrench[i, 4], wrench[i, 5]


@compiled
def moment(grips, i, fx, fy, fz):
    """Torque about the centre of mass, r_i × f."""
    x, y = grips[i, 0], grips[i, 1]
    z = grips[i, 2] if grips.shape[1] == 3 else 0.0
    return y * fz - z * fy, z * fx - x * fz, x * fy - y * fx


@compiled
def norm(x, y, z):
    """Length of a vector."""
    return sqrt(x * x + y * y + z * z)


@compiled
def at_centre(applied, grips, i):
    """Force, and torque at the centre of mass, of effector i (eq. 4)."""
    fx, fy, fz, tx, ty, tz = components(applied, i)
    mx, my, mz = moment(grips, i, fx, fy, fz)
    return fx, fy, fz, mx + tx, my + ty, mz + tz


@inlined
def torque_in_plane(applied, grips, i):
    """Torque at the centre of mass of effector i (eq. 4)."""
    return grips[i, 0] * applied[i, 1] - grips[i, 1] * applied[i, 0] + applied[i, 2]
