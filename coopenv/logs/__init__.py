"""Recorded trials: read them from files, decompose every row, write and draw what comes out."""

from coopenv.logs.analysis import Analysis, analyse
from coopenv.logs.consistency.told import Checked
from coopenv.logs.layout import Layout
from coopenv.logs.recording import Recording, read
from coopenv.logs.run import check_file, decompose_file
from coopenv.logs.summary import Summary

__all__ = [
    "Analysis",
    "Checked",
    "Layout",
    "Recording",
    "Summary",
    "analyse",
    "check_file",
    "decompose_file",
    "read",
]
