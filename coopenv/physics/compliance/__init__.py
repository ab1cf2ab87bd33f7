"""Compliant hold: springs and dampers between the references of hands and the grips of a body.

Hand i has a reference in the world; s is the way to it from the grip, φ the turn. It gives

    f = P(K s + B ṡ),    t = P(κ φ + β φ̇)

with P the nearest force, or torque, within the agent's limit. The reference is on a leash: where
K s or κ φ alone would exceed the limit, it is drawn along.

A substep takes the force in the middle, constant in the world frame, and the torque constant:

    f = P(K (s + Δs / 2) + B Δs / h),    t = P(κ (φ + Δφ / 2) + β Δφ / h)

where Δs, Δφ are what really comes of it: a small system of equations, solved by Newton's method.
A free body moves under it as exactly as without hands, drag included; of its turn Δθ the grip at g
makes the chord 2 sin(Δθ / 2) ẑ × R(θ + Δθ / 2) g. With the torque of f taken at the lever of that
chord, Σ f · Δp + t Δθ is the work done on the body. What moves the references, at u and Ω, does
Σ f · u h + t Ω h; the difference is the change of K s² / 2 + κ φ² / 2, and what dampers, limits and
leash take, which is never negative. So under references at rest no substep adds energy, as far as
the equations are solved. Friction on the ground is solved with them (`sliding`).

On wheels the grip follows the chord of a circle, and what the body's path differs from it by (of
third order in h) the reference is moved along.
"""

from coopenv.physics.compliance.felt import feel
from coopenv.physics.compliance.substep import Hold, hold

__all__ = ["Hold", "feel", "hold"]
