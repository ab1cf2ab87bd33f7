"""All benchmarks, as tables: ``make bench`` or ``python -m benchmarks``.

Every figure is a median over repeats; what is compared ran side by side, alternating.
"""

import platform

import numba
import numpy as np
import pymunk
from rich.console import Console
from rich.table import Table

from benchmarks.speed import (
    actions,
    cold,
    environments,
    latency,
    logs,
    partners,
    senses,
    structured,
    torchrl,
    transport,
    wrench,
)


def main() -> None:
    """Print every table."""
    console = Console()
    console.print(
        f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}, "
        f"numba {numba.__version__}, pymunk {pymunk.version}"
    )
    for module in (
        *(cold, latency, wrench, structured, logs),
        *(transport, actions, senses, partners, environments, torchrl),
    ):
        for title, columns, rows in module.tables():
            table = Table(*columns, title=title, title_justify="left")
            for row in rows:
                table.add_row(*row)
            console.print(table)


if __name__ == "__main__":
    main()
