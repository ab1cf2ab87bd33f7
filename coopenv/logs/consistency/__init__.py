"""Consistency of a recording with its motion: whether the applied wrenches explain it."""

from coopenv.logs.consistency.check import Check, Consistency, Fit
from coopenv.logs.consistency.known_body.otherwise import Again

__all__ = ["Again", "Check", "Consistency", "Fit"]
