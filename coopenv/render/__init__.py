"""Pictures and windows of the worlds; needs the extra ``render``."""

from coopenv.render.renderer import Renderer, save_gif, save_png

__all__ = ["Renderer", "save_gif", "save_png"]
