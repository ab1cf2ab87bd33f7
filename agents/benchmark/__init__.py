"""The benchmark: versioned suites of scenarios, what is entered in them, what came of it."""

from .conduct import Outcome, Plan, conduct, plan
from .entries import Entry, read_entry
from .scenario import Scenario, Suite
from .suites import SUITES, find_suites
from .summary import Result, Summary, read_summary

__all__ = [
    "SUITES",
    "Entry",
    "Outcome",
    "Plan",
    "Result",
    "Scenario",
    "Suite",
    "Summary",
    "conduct",
    "find_suites",
    "plan",
    "read_entry",
    "read_summary",
]
