"""What agents see: blocks of numbers, the view they are taken from, and what sensors do to them."""

from coopenv.observation.block import Block, EachOther
from coopenv.observation.blocks import BLOCKS, DEFAULT_BLOCKS, SENSING
from coopenv.observation.observation import Entry, Observation, find_blocks
from coopenv.observation.ranges import RangeReading, ranges
from coopenv.observation.sensor import Sensor

__all__ = [
    "BLOCKS",
    "DEFAULT_BLOCKS",
    "SENSING",
    "Block",
    "EachOther",
    "Entry",
    "Observation",
    "RangeReading",
    "Sensor",
    "find_blocks",
    "ranges",
]
