"""Text of modules that tests write to a file and import."""

TWO_KERNELS = """
from coopenv.compiled import compiled, gufunc

@compiled
def twice(x):
    return 2.0 * x

@gufunc("(n)->()", "void(float64[:], float64[:])")
def total(values, result):
    result[0] = 0.0
    for i in range(values.shape[0]):
        result[0] += values[i]
"""

OWN_REWARD = """
from dataclasses import dataclass
import numpy as np

@dataclass(frozen=True)
class Mine:
    weight: float = 1.0

    def __call__(self, transition):
        return self.weight * np.ones(transition.applied.shape[:2])
"""
