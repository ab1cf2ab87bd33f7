"""Synthesis of wrenches with a wanted resultant, load shares and internal wrench."""
