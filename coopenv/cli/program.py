"""The program ``coopenv``: its commands, reading of their options, exit codes.

A command is a dataclass whose fields are its options and whose ``run`` does it and returns what
came of it; `COMMANDS` lists them. What needs an extra is imported when it runs.
"""

import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Protocol

from coopenv.agents.pretrained.command import Export
from coopenv.bench.command import Bench
from coopenv.cli import terminal, version
from coopenv.cli.benchmark import Benchmark
from coopenv.cli.evaluate import Evaluate
from coopenv.cli.experiment import Report, RunExperiment, Sweep
from coopenv.cli.options.reading import PROGRAM, completion, read
from coopenv.cli.replay import Replay
from coopenv.cli.show import Show
from coopenv.cli.signals import TERMINATED, Termination, interrupted_by_termination
from coopenv.cli.study import Study
from coopenv.cli.train import Train
from coopenv.cli.warmup import Warmup
from coopenv.errors import CoopenvError
from coopenv.files import document, file_trouble, nothing_left
from coopenv.logs.command import Decompose
from coopenv.logs.inspected.command import Inspect
from coopenv.options import POSITIONAL

INTERRUPTED = 130  # exit code


class Command(Protocol):
    """What the command line can run."""

    def run(self) -> Any:
        """Do it, printing for people and writing files; what came of it, for ``--json``."""
        ...


@dataclass(frozen=True, kw_only=True)
class Completion:
    """Print the script by which a shell completes commands, options and their choices."""

    shell: Annotated[Literal["bash", "zsh", "fish"], POSITIONAL]
    """Which shell."""
    examples: ClassVar[tuple[str, ...]] = (
        'eval "$(coopenv completion bash)"',
        "coopenv completion zsh > ~/.zfunc/_coopenv",
        "coopenv completion fish > ~/.config/fish/completions/coopenv.fish",
    )

    def run(self) -> None:
        """Print it."""
        print(completion(self.shell, COMMANDS), end="")


COMMANDS: dict[str, type[Command]] = {
    "train": Train,
    "evaluate": Evaluate,
    "export": Export,
    "experiment": RunExperiment,
    "sweep": Sweep,
    "report": Report,
    "benchmark": Benchmark,
    "show": Show,
    "replay": Replay,
    "study": Study,
    "decompose": Decompose,
    "inspect": Inspect,
    "bench": Bench,
    "warmup": Warmup,
    "completion": Completion,
}
GROUPS: dict[str, tuple[str, ...]] = {  # in the help of the program
    "learn": ("train", "evaluate", "export", "experiment", "sweep", "report", "benchmark"),
    "look": ("show", "replay", "study"),
    "recordings": ("decompose", "inspect"),
    "machine": ("bench", "warmup", "completion"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that ``arguments`` (by default those of the process) name.

    What a user can mend is told in one line; an error of the package's own shows its traceback.
    SIGTERM interrupts it as Ctrl-C does, if this is the main thread.

    Returns
    -------
    0 if it is done; 1 if it was refused or failed, for the reason that is printed, or if nobody
    reads the output any more; 130 if it was interrupted, 143 by SIGTERM.

    Raises
    ------
    SystemExit
        With 0 after help, with 2 where the options make no sense.
    """
    terminal.make_legible()
    given = list(sys.argv[1:] if arguments is None else arguments)
    with nothing_left(), interrupted_by_termination() as told:
        code = _answered(given, told)
    return code if told.since is None or code != INTERRUPTED else TERMINATED


def _answered(given: Sequence[str], told: Termination) -> int:
    """Run a command; the exit code.

    Compiled code may make an error of its own of an interruption: what breaks off a command that
    was told to end is one, and is named.
    """
    try:
        _run(given)
        terminal.flush()
    except BrokenPipeError:  # the reader, such as head, has had enough
        terminal.close()
        return 1
    except CoopenvError as error:
        return _failed(str(error))
    except OSError as error:
        return _failed(str(file_trouble(error)))
    except KeyboardInterrupt as stop:
        return _interrupted(str(stop) or "interrupted")
    except Exception as error:
        if told.is_told:
            return _interrupted(_named(error, told))
        if not _is_out_of_memory(error):
            raise
        return _failed(f"memory must suffice, got: {error}; use fewer worlds, steps or units")
    return 0


def _interrupted(said: str) -> int:
    print(f"{PROGRAM}: {said}", file=sys.stderr)
    return INTERRUPTED


def _named(error: Exception, told: Termination) -> str:
    """What to say of an error that took the place of an interruption."""
    word = "interrupted" if told.since is None else "terminated"
    first = str(error).partition("\n")[0]
    return f"{word}, while {type(error).__name__}: {first}" if first else word


def _run(arguments: Sequence[str]) -> None:
    if arguments[:1] in (["--version"], ["-V"]):
        in_json = "--json" in arguments
        print(document(version.versions()) if in_json else version.report())
        return
    command = read(arguments, COMMANDS, GROUPS)
    common = getattr(command, "common", None)
    if common is None or not common.json:
        command.run()
        return
    with redirect_stdout(sys.stderr):
        found = command.run()
    print(document(found))


def _failed(why: str) -> int:
    """Say why, and what else can be written of the output."""
    print(f"{PROGRAM}: {why}", file=sys.stderr)
    try:
        terminal.flush()
    except OSError:
        terminal.close()
    return 1


def _is_out_of_memory(error: Exception) -> bool:
    """Whether memory did not suffice; torch says so by a RuntimeError."""
    of_torch = isinstance(error, RuntimeError) and "t allocate memory" in str(error)
    return of_torch or isinstance(error, MemoryError)
