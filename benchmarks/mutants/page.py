"""The tables of docs/mutants.md."""

from collections.abc import Mapping, Sequence
from itertools import chain

from benchmarks.mutants import equivalent
from benchmarks.mutants.report import score, table
from benchmarks.mutants.results import EQUIVALENT, SURVIVED, Result
from benchmarks.pages import DOCS, fill, markdown

PAGE = DOCS / "mutants.md"
COLUMNS = ("place", "before", "after", "tests that passed", "why it is left")


def tables(by_seed: Mapping[int, Sequence[Result]]) -> dict[str, str]:
    """The page's tables by the names of their marks, of the results of each seed."""
    together = [*chain.from_iterable(by_seed.values())]
    return {
        "score": "\n".join(_score(seed, results) for seed, results in by_seed.items()),
        "folders": markdown(*table(together, "folder", lambda result: f"`{result.folder}`")),
        "operators": markdown(*table(together, "operator", lambda result: result.operator)),
        "survivors": markdown(COLUMNS, survivors(together)),
    }


def _score(seed: int, results: Sequence[Result]) -> str:
    alike = sum(result.status == EQUIVALENT for result in results)
    return (
        f"- seed {seed}: {score(results):.1f} % of {len(results) - alike} mutants that change "
        f"behaviour were caught; {alike} more change none"
    )


def survivors(results: Sequence[Result]) -> list[list[str]]:
    """A row for each survivor."""
    left = equivalent.entries("left")
    return [
        [
            f"`{result.file}:{result.line}`",
            _code(result.before),
            _code(result.after),
            f"{result.ran} of {result.reached_by}",
            left.get((result.file, result.before, result.after), ""),
        ]
        for result in results
        if result.status in SURVIVED
    ]


def _code(text: str) -> str:
    return f"`{text}`".replace("|", "\\|")


def write(by_seed: Mapping[int, Sequence[Result]]) -> None:
    """Put the tables on the page."""
    fill(PAGE, tables(by_seed))
