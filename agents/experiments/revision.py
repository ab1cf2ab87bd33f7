"""Revision of the code that runs: the commit of a checkout, and whether files differ from it."""

import subprocess
from functools import cache
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]  # of a checkout; of a wheel, the folder of packages
PATIENCE = 10  # [s] for git


@cache
def revision() -> str | None:
    """``COMMIT``, or ``COMMIT-dirty``; ``None`` without a checkout or without git."""
    if not (HOME / "pyproject.toml").is_file():  # somebody else's repository may lie above
        return None
    command = ["git", "-C", str(HOME), "describe", "--always", "--dirty", "--abbrev=40"]
    command += ["--exclude=*"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    except (OSError, subprocess.SubprocessError):
        return None
    return said.stdout.strip() or None if said.returncode == 0 else None
