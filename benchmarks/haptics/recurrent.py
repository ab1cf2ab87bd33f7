"""A recurrent policy that goes over a whole sequence at once, as `coopenv experiment` has it."""

from coopenv.agents.learned.sequences import WholeSequences

__all__ = ["WholeSequences"]
