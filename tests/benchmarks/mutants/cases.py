"""A toy package with its tests, and changes of texts."""

from pathlib import Path
from textwrap import dedent

from benchmarks.mutants.places import places
from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.tree import Project

TOY = {
    "toy/__init__.py": "",
    "toy/beam.py": '''
        """A beam."""

        import math

        LIMIT = 2.0  # [m]


        def reach(x, y):
            """Distance of a point, at most the limit."""
            if x < 0.0:
                raise ValueError("x must be at least 0, got " + str(x))
            return min(math.hypot(x, y), LIMIT)


        def endless(steps):
            while steps > 0:
                steps -= 1
            return steps
        ''',
    "toy/inner/__init__.py": "",
    "toy/inner/sums.py": "def total(a, b):\n    return a + 2 * b\n",
    "tests/test_beam.py": """
        import pytest

        from toy.beam import reach


        def test_a_point_within_the_limit_has_its_distance():
            assert reach(0.6, 0.8) == 1.0


        def test_what_lies_beyond_is_at_the_limit():
            assert reach(3.0, 4.0) == 2.0
        """,
    "tests/inner/test_sums.py": """
        from toy.inner.sums import total


        def test_a_total_is_a_number():
            assert isinstance(total(1, 0), int)
        """,
}


def toy(folder: Path) -> Project:
    for name, text in TOY.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text).lstrip("\n"), encoding="utf-8")
    return Project(root=folder, folders=("toy",))


def source(text: str) -> Source:
    return Source("toy/text.py", dedent(text).lstrip("\n").encode())


def edited(text: str) -> set[tuple[str, str]]:
    """Operator and whole changed text of each mutant."""
    made = source(text)
    return {
        (change.operator, change.applied(made.text).decode().strip())
        for changes in places(made)
        for change in changes
    }


def change_of(found: Source, old: str, new: str) -> Change:
    """The change of a file that puts ``new`` where ``old`` stands."""
    wanted = found.text.replace(old.encode(), new.encode())
    (made,) = (
        change
        for changes in places(found)
        for change in changes
        if change.applied(found.text) == wanted
    )
    return made
