"""Warming up: everything compiled ahead of time, into the cache that later processes read."""

from coopenv.warming.warming import Warmed, warmup

__all__ = ["Warmed", "warmup"]
