"""Policies that come with the package, and files of others, read by one function."""

from .catalogue import load, names, read, row_of

__all__ = ["load", "names", "read", "row_of"]
