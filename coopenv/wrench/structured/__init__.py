"""Structured solver: an interior-point method in time linear in the number of effectors."""
