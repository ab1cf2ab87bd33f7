"""Settings of the tests of agents."""

from tests.agents.undrawn import undrawn

__all__ = ["undrawn"]
