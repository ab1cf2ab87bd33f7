"""What carries: scripted controllers, learned policies, training and evaluation.

``policy`` and ``controllers`` need nothing beyond the core; ``sb3`` and ``train`` need the extra
``train``.
"""
