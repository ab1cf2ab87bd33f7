"""Rendering: pictures, films and windows of the worlds; needs the extra ``render``."""

from coopenv.render.film import mosaic, save_film
from coopenv.render.pictures import save_gif, save_png
from coopenv.render.renderer import Renderer

__all__ = ["Renderer", "mosaic", "save_film", "save_gif", "save_png"]
