"""Observations: named blocks, the agents' view that most are parts of, imperfect sensors."""

from coopenv.observation.block import Block, EachOther
from coopenv.observation.blocks import BLOCKS, DEFAULT_BLOCKS, FELT, SENSING, sensed
from coopenv.observation.observation import Entry, Observation, find_blocks
from coopenv.observation.ranges import RangeReading, ranges
from coopenv.observation.sensor import Sensor

__all__ = [
    "BLOCKS",
    "DEFAULT_BLOCKS",
    "FELT",
    "SENSING",
    "Block",
    "EachOther",
    "Entry",
    "Observation",
    "RangeReading",
    "Sensor",
    "find_blocks",
    "ranges",
    "sensed",
]
