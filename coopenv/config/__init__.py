"""Configuration of an environment: the description itself, and how keywords are read into it."""

from coopenv.config.environment import ACTIONS, TransportConfig
from coopenv.config.keywords import ALIASES

__all__ = ["ACTIONS", "ALIASES", "TransportConfig"]
