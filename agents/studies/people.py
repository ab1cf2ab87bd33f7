"""The people of `coopenv.agents.studies.dyads.people`, under the name they had first."""

from .dyads.people import People, Traits

__all__ = ["People", "Traits"]
