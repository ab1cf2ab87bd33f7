"""Rendering: pictures and windows of the worlds; needs the extra ``render``."""

from coopenv.render.pictures import save_gif, save_png
from coopenv.render.renderer import Renderer

__all__ = ["Renderer", "save_gif", "save_png"]
