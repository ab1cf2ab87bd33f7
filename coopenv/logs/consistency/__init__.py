"""Consistency of a recording with its motion: whether the applied wrenches explain it."""

from coopenv.logs.consistency.check import Check, Consistency, Fit

__all__ = ["Check", "Consistency", "Fit"]
