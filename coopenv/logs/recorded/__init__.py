"""Recordings in memory, and what is done to those that come chunk by chunk, run by run."""

from coopenv.logs.recorded.rows import Recording
from coopenv.logs.recorded.runs import by_runs

__all__ = ["Recording", "by_runs"]
