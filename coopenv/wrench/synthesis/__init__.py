"""Wrenches with a wanted resultant, shares and internal part: the decomposition turned around."""
