"""Beam transport: the simulation of the paper's section V-B."""
