"""Reports of experiments: results, statistics of a few runs, page, pictures."""

from .page import estimates_of, summary
from .results import Results, is_experiment, save
from .write import report_folder, write_report

__all__ = [
    "Results",
    "estimates_of",
    "is_experiment",
    "report_folder",
    "save",
    "summary",
    "write_report",
]
