"""Trained policies whatever their library: what files say of them, and networks in NumPy."""

from .archive import NOTES, read_notes
from .form import SUFFIX
from .policy import PlainPolicy

__all__ = ["NOTES", "SUFFIX", "PlainPolicy", "read_notes"]
