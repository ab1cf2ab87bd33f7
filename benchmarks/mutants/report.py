"""Score of a sample of mutants by folder and by operator, and the survivors."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from benchmarks.mutants.results import CAUGHT, EQUIVALENT, SURVIVED, Result

COLUMNS = ("mutants", "caught", "survived", "equivalent", "score")


def score(results: Iterable[Result]) -> float:
    """Percentage that was caught of those that change behaviour; NaN of none."""
    counts = Counter(result.status for result in results)
    judged = counts[CAUGHT] + sum(counts[status] for status in SURVIVED)
    return 100 * counts[CAUGHT] / judged if judged else float("nan")


def table(
    results: Sequence[Result], title: str, kind: Callable[[Result], str]
) -> tuple[Sequence[str], list[list[str]]]:
    """Headings and rows, one for each kind and one for all."""
    kinds = sorted({kind(result) for result in results})
    rows = [_row(name, [each for each in results if kind(each) == name]) for name in kinds]
    return (title, *COLUMNS), [*rows, _row("all", results)]


def _row(name: str, results: Sequence[Result]) -> list[str]:
    counts = Counter(result.status for result in results)
    survived = sum(counts[status] for status in SURVIVED)
    judged = counts[CAUGHT] + survived
    cells = (len(results), counts[CAUGHT], survived, counts[EQUIVALENT])
    return [name, *map(str, cells), f"{score(results):.0f} %" if judged else "—"]


def survivors(results: Iterable[Result]) -> list[str]:
    """Each survivor as file and line, the lines before and after, and which tests ran."""
    return [
        "\n".join(
            (
                f"{result.file}:{result.line}  {result.operator}",
                f"  - {result.before}",
                f"  + {result.after}",
                f"  {_tests(result)}",
            )
        )
        for result in results
        if result.status in SURVIVED
    ]


def _tests(result: Result) -> str:
    if not result.ran:
        return "no test reaches it"
    rest = result.reached_by - result.ran
    beyond = f"; {rest} more reach it" if rest else ""
    return f"passed: {', '.join(_short(result.tests))}{beyond}"


def _short(tests: Sequence[str]) -> list[str]:
    """Files, with how many of their tests ran."""
    counts = Counter(test.partition("::")[0] for test in tests)
    return [f"{file} ({count})" for file, count in counts.items()]
