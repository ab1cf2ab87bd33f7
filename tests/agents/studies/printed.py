"""What a study prints at its end."""

from pathlib import Path


def files_named(printed: str, out: Path) -> set[str]:
    """The files that it says it left in ``out``."""
    listed = printed.partition(f"in {out}:")[2].split(",")
    return {name.strip() for name in listed}
