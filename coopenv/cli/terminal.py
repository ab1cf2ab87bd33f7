"""Standard output: what a terminal cannot show, a pipe that was closed, a disk that is full."""

import codecs
import contextlib
import os
import sys
from typing import Any

PLAIN = {  # one letter for one, so that tables stay in line
    "γ": "g", "Σ": "S", "α": "a", "β": "b", "Δ": "D", "θ": "t", "ω": "w",
    "·": "*", "×": "x", "−": "-", "–": "-", "—": "-", "±": "~", "≈": "~", "→": ">", "↔": "-",
    "≤": "<", "≥": ">", "≠": "!", "²": "2", "³": "3", "½": "h", "‖": "|", "°": "o", "…": ".",
    "’": "'", "‘": "'", "“": '"', "”": '"', "━": "-", "╸": "-", "╺": "-", "─": "-", "•": "*",
}  # fmt: skip


def make_legible() -> None:
    """Let both outputs replace what their encoding lacks, instead of raising an error."""
    codecs.register_error("coopenv.plain", _plain)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None and _is_narrow(stream.encoding):
            reconfigure(errors="coopenv.plain")


def flush() -> None:
    """Write what is still on its way, so that trouble shows here and not after the end."""
    sys.stdout.flush()


def close() -> None:
    """Give up standard output: nothing more is written, and Python's end does not complain."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
    except (OSError, ValueError):  # no file behind it, as in a notebook
        return
    with contextlib.suppress(OSError):
        os.close(nowhere)


def _is_narrow(encoding: str) -> bool:
    return not codecs.lookup(encoding).name.startswith("utf")


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    missing: Any = error.object[error.start : error.end]
    return "".join(PLAIN.get(letter, "?") for letter in missing), error.end
