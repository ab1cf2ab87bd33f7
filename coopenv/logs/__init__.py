"""Recorded trials: read them from files, decompose every row, write and draw what comes out."""

from coopenv.logs.analysis import Analysis, analyse
from coopenv.logs.layout import Layout
from coopenv.logs.recording import Recording, read
from coopenv.logs.run import decompose_file
from coopenv.logs.summary import Summary

__all__ = ["Analysis", "Layout", "Recording", "Summary", "analyse", "decompose_file", "read"]
