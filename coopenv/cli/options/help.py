"""Pages of help: the commands in groups, each with examples; no line wider than the terminal."""

import io
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from inspect import cleandoc
from textwrap import fill
from typing import Any

from coopenv.cli.options.files import parts

ABOUT = "Learn to carry things together."
CODES = (
    "Exit codes: 0 done; 1 refused or failed, with the reason; 2 options that make no sense; "
    "130 interrupted by Ctrl-C; 143 by SIGTERM."
)
COLORS = re.compile(r"\x1b\[[0-9;]*m")
LEAST = 40  # letters of a line, however narrow the terminal


class Caught(io.StringIO):
    """What would be printed, for a stream that tells as much of itself as the real one."""

    def __init__(self, stream: Any):
        super().__init__()
        self._stream = stream

    @property
    def encoding(self) -> Any:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Of the real stream."""
        return getattr(self._stream, "encoding", None)

    def isatty(self) -> bool:
        """Whether the real stream is a terminal, which shows colours."""
        return self._stream.isatty()


def page_of_program(
    program: str, commands: Mapping[str, type], groups: Mapping[str, Sequence[str]]
) -> str:
    """Commands in groups with what each does, in one sentence."""
    width = _width()
    longest = max(map(len, commands))
    lines = [f"usage: {program} COMMAND [OPTIONS]", "", ABOUT]
    for title, names in groups.items():
        lines += ["", title]
        for name in names:
            does = " ".join(cleandoc(commands[name].__doc__ or "").split("\n\n")[0].split())
            lines.append(_hung(does, f"  {name:{longest}}  ", width))
    more = (
        f"{program} COMMAND --help lists the options of a command, with examples.",
        f"{program} --version says which libraries are used.",
        CODES,
    )
    return "\n".join([*lines, "", *(fill(line, width) for line in more)])


def page_of_command(told: str, arguments: Sequence[str], commands: Mapping[str, type]) -> str:
    """Help of a command as its reader tells it, no line too wide, and its examples behind it."""
    width = _width()
    lines = [line for each in told.rstrip().splitlines() for line in _fitted(each, width)]
    examples = _examples(arguments, commands)
    if examples:
        lines += ["", "examples:"]
        lines += [_hung(example, "  ", width, mark=" \\") for example in examples]
    return "\n".join(lines)


def _examples(arguments: Sequence[str], commands: Mapping[str, type]) -> Sequence[str]:
    """Those of the command, or of the one below it that is named."""
    kind = commands.get(arguments[0])
    if kind is None:
        return ()
    below = parts(kind)
    named = next((below[each] for each in arguments[1:2] if each in below), kind)
    return getattr(named, "examples", ())


def _fitted(line: str, width: int) -> Iterator[str]:
    """A line in several where it is too wide; what stands in a frame fits already."""
    bare = COLORS.sub("", line)
    if len(bare) <= width or bare.startswith("│"):
        yield line.rstrip()
    else:
        yield fill(bare, width, subsequent_indent="    " if bare.startswith("usage") else "")


def _hung(text: str, head: str, width: int, mark: str = "") -> str:
    """A text behind a head, on as many lines as it needs, below each other; they end by a mark."""
    inner = len(head) + (2 if mark else 0)
    filled = fill(
        text,
        width - len(mark),
        initial_indent=head,
        subsequent_indent=" " * inner,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace("\n", f"{mark}\n")


def _width() -> int:
    return max(shutil.get_terminal_size().columns, LEAST)
