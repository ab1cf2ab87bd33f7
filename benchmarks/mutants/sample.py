"""A seeded sample of mutants: by chance a folder, a place in it, and a change of that place.

Small folders count as much as large ones. However many are drawn, the first n of a seed are the
same.
"""

from collections import defaultdict
from collections.abc import Iterator
from itertools import islice
from pathlib import PurePath
from random import Random

from benchmarks.mutants.places import is_another_program, places
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.tree import Project

Place = tuple[Source, list[Change]]


def sample(project: Project, count: int, seed: int) -> list[tuple[Source, Change]]:
    """``count`` mutants with the files they stand in, or as many as there are places."""
    return list(islice(drawn(project, Random(seed)), count))


def drawn(project: Project, random: Random) -> Iterator[tuple[Source, Change]]:
    """Mutants one by one, never two of one place."""
    left = _by_folder(project)

    def draw(count: int) -> int:
        return int(random.random() * count)  # one number, so that the rest does not depend on it

    while left:
        folder = [*left][draw(len(left))]
        source, changes = left[folder].pop(draw(len(left[folder])))
        if not left[folder]:
            del left[folder]
        change = changes[draw(len(changes))]
        if is_another_program(source, change):
            yield source, change


def _by_folder(project: Project) -> dict[str, list[Place]]:
    found: dict[str, list[Place]] = defaultdict(list)
    for file in project.modules():
        source = Source(file, (project.root / file).read_bytes())
        folder = PurePath(file).parent.as_posix()
        found[folder] += [(source, changes) for changes in places(source)]
    return {folder: each for folder, each in found.items() if each}
