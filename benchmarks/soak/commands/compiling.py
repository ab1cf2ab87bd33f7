"""A module whose kernels are compiled and cached beside it, of every kind that coopenv has."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.soak.commands.server import Ended, Task, server

MODULE = "soaked_kernels"
ANSWER = "[1.0, 3.0, 6.0, 10.0] 34.0 7.0\n"
SOURCE = """
import numpy as np
from coopenv.compiled import compiled, fused, fused_entry, gufunc, inlined

@inlined
def twice(number):
    return number + number

@gufunc("(n)->(n)", "void(float64[:], float64[:])")
def running_sum(numbers, out):
    total = 0.0
    for i in range(len(numbers)):
        total += numbers[i]
        out[i] = total

@compiled
def weighted(numbers):
    total = 0.0
    for number in numbers:
        total += twice(number) + number * number * 0.0 + number
    return total + 4.0

@fused
def product(a, b):
    return a * b + 1.0

@fused_entry
def entry(a, b):
    return product(a, b)

numbers = np.arange(1.0, 5.0)
print(running_sum(numbers).tolist(), weighted(numbers), entry(2.0, 3.0))
"""


def task(folder: Path) -> Task:
    """Import the module, which is written into the folder, with its cache."""
    (folder / f"{MODULE}.py").write_text(SOURCE)
    return Task(folder=str(folder), arguments=("import", MODULE), module=MODULE)


def check(ended: Ended) -> None:
    """Raise unless the kernels said what they should."""
    assert ended.code == 0, f"compiled code does not start: {ended}"
    assert ended.out == ANSWER, f"compiled code says {ended.out!r}"
    assert not ended.err, f"compiled code complains: {ended}"


@cache
def seconds() -> float:
    """Processor time that compiling takes."""
    with TemporaryDirectory() as name:
        ended = server().run(task(Path(name)))
        check(ended)
        return ended.seconds


def cache_files(folder: Path) -> list[Path]:
    """What numba keeps of the module."""
    return sorted((folder / "__pycache__").glob(f"{MODULE}.*.nb[ic]"))
