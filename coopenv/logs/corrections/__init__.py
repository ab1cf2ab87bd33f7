"""Corrections of a recording as a layout asks for them, row by row and run by run."""

from coopenv.logs.corrections.chain import Corrections

__all__ = ["Corrections"]
