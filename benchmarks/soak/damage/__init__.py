"""Damaged files of every format that coopenv reads."""
