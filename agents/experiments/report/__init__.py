"""Reports of experiments: results, statistics of a few runs, page, pictures."""

from .page import summary
from .results import Results, save
from .write import write_report

__all__ = ["Results", "save", "summary", "write_report"]
