"""Contact response of a rigid body: what wheels leave of it, its energy, and how it lasts."""

from coopenv.compiled import compiled

_LOCKED = 1e-6  # part of a contact's mobility: if wheels leave less, nothing moves


@compiled
def yielded(mass, inertia, along, dx, dy, spin):
    """How a body on wheels answers contacts that would change a free body's twist as given.

    Contacts give the impulse P and the angular impulse L that stop a free body (``dx``, ``dy``,
    ``spin`` are the changes). Wheels give way only to the part of P along the heading (``along``),
    so the same P and L would not stop a body on wheels. Both are therefore scaled up by one factor,
    such that the contact loses as much speed as with a free body. That gains no energy if the free
    body loses some and rolled along its heading before; see `spent` for the rest.

    Returns
    -------
    The change of forward speed and of spin, and the factor by which the impulse is larger. Where
    neither rolling nor turning gives way, nothing changes.
    """
    turning = inertia * spin * spin
    free = mass * (dx * dx + dy * dy) + turning
    rolling = mass * along * along + turning
    if rolling <= _LOCKED * free:
        return 0.0, 0.0, 1.0
    factor = free / rolling
    return factor * along, factor * spin, factor


@compiled
def spent(mass, inertia, before, change):
    """The part of a contact's change of twist that a body takes, in [0, 1]: it gives no energy.

    With v the twist before, Δ its change and ⟨v, v⟩ / 2 the kinetic energy, the change adds
    ⟨v, Δ⟩ + ⟨Δ, Δ⟩ / 2. Where that is positive, the part is −⟨v, Δ⟩ / ⟨Δ, Δ⟩, which takes the most
    energy that a part of Δ can take: the contact stops the body along Δ. It is 0 where any part
    would add energy.

    Contacts that are solved to the end and do not bounce have ⟨v, Δ⟩ ≤ −⟨Δ, Δ⟩, and all of Δ is
    taken. Two others add energy. The solver may stop before it has taken back the impulses that it
    began with, those of the substep before. And the parting of overlaps may turn a body on wheels,
    whose velocity then seems to the solver to go sideways, into what is at its side.

    Parameters
    ----------
    mass, inertia
        Of the body [kg, kg·m²].
    before, change
        Twist ``(vx, vy, ω)`` before the contact and its change, in one frame [m/s, rad/s].
    """
    vx, vy, spin = before
    dx, dy, turning = change
    power = mass * (vx * dx + vy * dy) + inertia * spin * turning  # ⟨v, Δ⟩ [J]
    square = mass * (dx * dx + dy * dy) + inertia * turning * turning  # ⟨Δ, Δ⟩ [J]
    if not power + square / 2 > 0.0:
        return 1.0
    return 0.0 if power > 0.0 else -power / square


@compiled
def lasting(mass, inertia, contact, forced, mean):
    """The part of a contact's change of twist that is taken to last for another substep, in [0, 1].

    It answers forces only, not momentum: the contact Δ of the substep before holds back what forces
    make of the twist, F, by −⟨F, Δ⟩ / ⟨Δ, Δ⟩ of it, with ⟨v, v⟩ / 2 the kinetic energy. It lifts
    nothing off either: a mean twist v with ⟨v, Δ⟩ < 0 is brought to 0 at most.

    Parameters
    ----------
    mass, inertia
        Of the body [kg, kg·m²].
    contact, forced, mean
        Δ, F and the mean twist over the substep, ``(vx, vy, ω)`` each [m/s, rad/s].
    """
    against = -_product(mass, inertia, forced, contact)
    off = -2.0 * _product(mass, inertia, mean, contact)
    part = min(against, off) / _product(mass, inertia, contact, contact)
    return min(max(part, 0.0), 1.0)


@compiled
def _product(mass, inertia, first, second):
    """⟨first, second⟩ of two twists: half of ⟨v, v⟩ is the kinetic energy [J]."""
    linear = first[0] * second[0] + first[1] * second[1]
    return mass * linear + inertia * first[2] * second[2]
