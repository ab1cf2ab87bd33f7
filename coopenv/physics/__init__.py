"""Rigid-body physics: the carried body, the scene around it, and the worlds that move it."""
