"""Compiled work on more than one core, which never waits for the interpreter.

`spread` puts it into a kernel, `Crew` has the threads that help. Between threads goes a board: a
few integers in memory, changed by atomic instructions alone.
"""

from coopenv.compiled.parallel.crew import Crew, cores, crew, shared, sharing, sharing_rows
from coopenv.compiled.parallel.spread import spread

__all__ = ["Crew", "cores", "crew", "shared", "sharing", "sharing_rows", "spread"]
