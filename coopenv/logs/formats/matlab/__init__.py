"""MATLAB files of every version."""

from coopenv.logs.formats.matlab.matrices import MatSource

__all__ = ["MatSource"]
