"""Learned policies: models of Stable-Baselines3 and sb3-contrib, as they were trained."""

from ..trained.archive import NOTES, read_notes
from ..trained.normalization import Normalization
from .files import load_model, save_model
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
