"""Conic solver: any number of effectors through Clarabel; slow, and the check on the others."""
