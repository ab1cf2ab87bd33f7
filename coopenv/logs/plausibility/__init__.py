"""Plausibility of a recording: whether what was applied explains how the object moved."""

from coopenv.logs.plausibility.check import Check, Fit, Plausibility

__all__ = ["Check", "Fit", "Plausibility"]
