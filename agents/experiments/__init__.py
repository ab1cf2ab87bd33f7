"""Experiments: grids of runs that run themselves, searches, sweeps of a weight, reports."""

from .conduct import Outcome, check, conduct
from .file import load
from .grid import Experiment
from .nodes import Nodes, joined
from .report import Results, write_report
from .search import Search
from .sweep import sweep

__all__ = [
    "Experiment",
    "Nodes",
    "Outcome",
    "Results",
    "Search",
    "check",
    "conduct",
    "joined",
    "load",
    "sweep",
    "write_report",
]
