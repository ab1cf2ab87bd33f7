"""A body of known mass and inertia: whether it moves as the wrenches say, and what is wrong."""

from coopenv.logs.consistency.known_body.balance import Balance

__all__ = ["Balance"]
