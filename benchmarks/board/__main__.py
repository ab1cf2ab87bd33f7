"""Pages of the benchmark, from the summaries in docs/benchmark: docs/benchmark.md, measures.md.

python -m benchmarks.board            # prints the tables
python -m benchmarks.board --write    # and writes the pages

The summaries are what ``coopenv benchmark ... --out docs/benchmark`` leaves there.
"""

from benchmarks.board.tables import PAGE, REST, measures, tables
from benchmarks.pages import show


def main() -> None:
    """Print the tables; with ``--write`` also put them on the pages."""
    show(PAGE, tables())
    show(REST, measures())


if __name__ == "__main__":
    main()
