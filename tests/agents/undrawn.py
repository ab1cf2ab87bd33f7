"""Trainings without a picture of their curves, which takes longer than the steps of a small one."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from coopenv.agents import curves

Draw = Callable[[Any, Any], None]


@pytest.fixture(autouse=True, scope="module")
def undrawn() -> Iterator[Draw]:
    """Leave an empty file for the picture; the function that draws it, for who looks at it."""
    draw = curves.draw
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curves, "draw", lambda runs, path: Path(path).touch())
        yield draw
