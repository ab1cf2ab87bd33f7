"""The tables of docs/mutants.md."""

from collections.abc import Sequence

from benchmarks.mutants.report import score, table
from benchmarks.mutants.results import SURVIVED, Result
from benchmarks.pages import DOCS, fill, markdown

PAGE = DOCS / "mutants.md"
COLUMNS = ("place", "before", "after", "tests that passed")


def tables(results: Sequence[Result], seed: int) -> dict[str, str]:
    """The page's tables by the names of their marks."""
    return {
        "score": f"{score(results):.1f} % of {len(results)} mutants of seed {seed} were caught, "
        "of those that change behaviour.",
        "folders": markdown(*table(results, "folder", lambda result: f"`{result.folder}`")),
        "operators": markdown(*table(results, "operator", lambda result: result.operator)),
        "survivors": markdown(COLUMNS, survivors(results)),
    }


def survivors(results: Sequence[Result]) -> list[list[str]]:
    """A row for each survivor."""
    return [
        [
            f"`{result.file}:{result.line}`",
            _code(result.before),
            _code(result.after),
            f"{result.ran} of {result.reached_by}",
        ]
        for result in results
        if result.status in SURVIVED
    ]


def _code(text: str) -> str:
    return f"`{text}`".replace("|", "\\|")


def write(results: Sequence[Result], seed: int) -> None:
    """Put the tables on the page."""
    fill(PAGE, tables(results, seed))
