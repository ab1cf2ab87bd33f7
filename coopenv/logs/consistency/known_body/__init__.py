"""A body whose mass and inertia are known: whether it moves as the wrenches say, and what is wrong."""

from coopenv.logs.consistency.known_body.balance import Balance

__all__ = ["Balance"]
