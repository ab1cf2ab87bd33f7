"""Recorded files that pages speak of: of a laboratory, and of the makers of its devices."""

import contextlib
import io
from functools import cache
from pathlib import Path

import numpy as np

from examples import record_laboratory
from tests.logs.makers import MAKERS

LABORATORY = ("mocap.csv", "laboratory.toml")  # who names one of them has its files


def lay_out(code: str, folder: Path) -> None:
    """Write the files that some code names: those of makers in a folder each."""
    for name, make in MAKERS.items():
        if f"{name}/" in code:
            (folder / name).mkdir()
            make(folder / name)
    if any(name in code for name in LABORATORY):
        for name, content in laboratory().items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)


@cache
def laboratory() -> dict[str, bytes]:
    """What ``examples/record_laboratory.py`` writes: name → content."""
    import tempfile

    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()):
        folder, chance = Path(name), np.random.default_rng(0)
        record_laboratory.main(folder, chance)
        files = [path for path in folder.rglob("*") if path.is_file()]
        return {str(path.relative_to(folder)): path.read_bytes() for path in files}
