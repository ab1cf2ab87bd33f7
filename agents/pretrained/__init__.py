"""Policies that come with the package, and files of others, read by one function."""

from .catalogue import load, names, read, row_of
from .naming import file_of

__all__ = ["file_of", "load", "names", "read", "row_of"]
