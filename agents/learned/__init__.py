"""Learned policies: models of Stable-Baselines3 and sb3-contrib, as they were trained."""

from .files import NOTES, load_model, read_notes, save_model
from .normalization import Normalization
from .policy import SB3Policy

__all__ = ["NOTES", "Normalization", "SB3Policy", "load_model", "read_notes", "save_model"]
