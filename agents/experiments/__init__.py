"""Experiments: grids of runs that run themselves, searches, sweeps of a weight, reports."""

from .conduct import Outcome, check, conduct
from .file import load
from .grid import Experiment
from .report import Results, write_report
from .search import Search
from .sweep import sweep

__all__ = [
    "Experiment",
    "Outcome",
    "Results",
    "Search",
    "check",
    "conduct",
    "load",
    "sweep",
    "write_report",
]
