"""Exact solvers for two effectors in the plane, on and off a line through the centre of mass."""
