"""Which columns of a file are read, and as what."""

from coopenv.logs.plan.made import Plan, make_plan

__all__ = ["Plan", "make_plan"]
