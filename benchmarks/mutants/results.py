"""Results of mutants, kept line by line in a file, so that a run that was broken off goes on."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.mutants.source import Change, Source
from benchmarks.mutants.trial import Verdict

CAUGHT = "caught"
SURVIVED = ("survived", "unreached")
EQUIVALENT = "equivalent"


@dataclass(frozen=True, kw_only=True)
class Result:
    """A mutant as people read it, and what came of it."""

    key: str
    file: str
    line: int
    operator: str
    before: str
    after: str
    status: str  # caught, survived, unreached, equivalent
    by: str = ""  # the test that caught it, or why it is equivalent
    how: str = ""
    ran: int = 0
    reached_by: int = 0
    tests: tuple[str, ...] = ()
    cpu: float = 0.0

    @classmethod
    def made(cls, change: Change, source: Source, verdict: Verdict) -> "Result":
        """What came of a change."""
        before, after = change.lines(source.text)
        return cls(
            key=change.key,
            file=change.file,
            line=change.line,
            operator=change.operator,
            before=before,
            after=after,
            **verdict.as_json(),
        )

    @property
    def folder(self) -> str:
        """Where its file lies."""
        return self.file.rpartition("/")[0]


class Results:
    """A file of results, a line of JSON each; of two of one mutant the later counts."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.of: dict[str, Result] = {}
        if path.exists():
            text = path.read_text(encoding="utf-8")
            whole = text[: text.rfind("\n") + 1]
            if whole != text:  # a run was killed while it wrote
                path.write_text(whole, encoding="utf-8")
            for line in whole.splitlines():
                self._take(json.loads(line))

    def add(self, result: Result) -> None:
        """Keep a result, at once."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(result)) + "\n")
        self.of[result.key] = result

    def _take(self, entry: Mapping[str, object]) -> None:
        fields = dict(entry)
        fields["tests"] = tuple(fields["tests"])  # type: ignore[arg-type]
        result = Result(**fields)  # type: ignore[arg-type]
        self.of[result.key] = result
