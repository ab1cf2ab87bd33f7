"""Settings of the tests of the command line."""

from tests.agents.undrawn import undrawn

__all__ = ["undrawn"]
