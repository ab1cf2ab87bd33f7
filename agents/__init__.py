"""Agents: scripted controllers, learned policies, partners, training and evaluation.

``policy`` and ``controllers`` need nothing beyond the core; ``sb3`` and ``train`` need the extra
``train``.
"""
