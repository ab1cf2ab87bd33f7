"""Agents: scripted controllers, learned policies, partners, training and evaluation.

``policy``, ``controllers`` and `load` of what the package brings need nothing beyond the core;
``sb3`` and ``train`` need the extra ``train``.
"""

from .pretrained import load

__all__ = ["load"]
