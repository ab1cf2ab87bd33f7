"""Learned policies: models of Stable-Baselines3 and sb3-contrib, as they were trained."""

from .archive import NOTES, read_notes
from .files import load_model, save_model
from .normalization import Normalization
from .policy import SB3Policy
from .scaling import FallingRate, Scaled

__all__ = [
    "NOTES",
    "FallingRate",
    "Normalization",
    "SB3Policy",
    "Scaled",
    "load_model",
    "read_notes",
    "save_model",
]
