"""Mistakes that are tried by reading a recording again, as if it had been declared otherwise.

Rotations, tares and loads of a layout come after frames, units and names of columns. What is left
where one of these is another is told exactly by another reading alone.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

from coopenv.errors import CoopenvError
from coopenv.logs.columns import EFFECTOR
from coopenv.logs.consistency.known_body.collected import Collected
from coopenv.logs.consistency.known_body.found import Explanation
from coopenv.logs.consistency.known_body.known import Windows
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording

MOST_EXCHANGED = 4  # effectors of which every pair is exchanged
RANK = 1


class Declared(NamedTuple):
    """Another layout, and the mistake that it mends."""

    kind: str
    text: str  # "if" goes before it
    remedy: str
    layout: Layout
    rank: int = RANK


class Again(NamedTuple):
    """How to read a recording again."""

    layout: Layout  # as it was given
    names: Collection[str]  # documented columns that are read
    read: Callable[[Layout], Iterable[Recording]]

    def windows(self, layout: Layout) -> list[Windows]:
        """Of the recording as another layout has it; none where that does not go with the file."""
        with suppress(CoopenvError):
            return Collected.of(self.read(layout)).windows()
        return []

    def explanations(
        self, declared: Iterable[Declared], reach: float = 0.0
    ) -> Iterator[Explanation]:
        """What each leaves; ``reach`` is that of grips as they were declared [m]."""
        for each in declared:
            windows = self.windows(each.layout)
            if not windows:
                continue
            misfit = Misfit.of(windows, each.layout.body, windows[0].motion.dimension, reach)
            if not misfit.is_still():
                yield Explanation(each.kind, each.text, each.remedy, misfit.share(), each.rank)


def declared_otherwise(again: Again, count: int) -> Iterator[Declared]:
    """The other frame, and sensors or grips of two of ``count`` effectors exchanged."""
    layout = again.layout
    yield _in_other_frame(layout)
    for i, j in combinations(range(1, 1 + count * (count <= MOST_EXCHANGED)), 2):
        columns = _exchanged(again, "ft", i, j)
        yield Declared(
            "sensors",
            f"sensors {i} and {j} are taken one for the other",
            f"exchange their columns, {_said(columns, f'f{i}x', f'f{j}x')}",
            replace(layout, columns=columns),
        )
        text = f"the grips of effectors {i} and {j} are exchanged"
        columns = _exchanged(again, "r", i, j)
        if layout.grips is not None:
            grips = [list(grip) for grip in layout.rows_of_grips(count)]
            grips[i - 1], grips[j - 1] = grips[j - 1], grips[i - 1]
            other = replace(layout, grips=tuple(map(tuple, grips)))
            yield Declared("grips", text, f"exchange them, grips = {grips}", other)
        elif f"r{i}x" in again.names:
            remedy = f"exchange them, {_said(columns, f'r{i}x', f'r{j}x')}"
            yield Declared("grips", text, remedy, replace(layout, columns=columns))


def _in_other_frame(layout: Layout) -> Declared:
    """Of forces and torques; the twist goes with them, unless it is said to be in another."""
    frame = "world" if layout.frame == "object" else "object"
    with_forces = layout.twist_frame == layout.frame
    twist = frame if with_forces else layout.twist_frame
    also = "" if with_forces else f" --twist-frame {twist}"
    return Declared(
        "frame",
        f"forces and torques are in the {frame} frame",
        f"--frame {frame}{also}",
        replace(layout, frame=frame, twist_frame=twist),
    )


def _exchanged(again: Again, kinds: str, i: int, j: int) -> dict[str, str]:
    """Columns of a layout, those of two effectors exchanged."""
    said, other = again.layout.columns, {f"{i}": f"{j}", f"{j}": f"{i}"}
    made = dict(said)
    for name in again.names:
        effector = EFFECTOR.fullmatch(name)
        if effector is not None and effector[1] in kinds and effector[2] in other:
            theirs = f"{effector[1]}{other[effector[2]]}{name[-1]}"
            made[name] = said.get(theirs, theirs)
    return made


def _said(columns: dict[str, str], *names: str) -> str:
    """The first columns of such an exchange, as an option."""
    return "--map " + " ".join(f"{name}={columns.get(name, name)} …" for name in names)
