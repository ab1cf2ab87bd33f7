"""Summaries: what an entry came to in a suite, as a small file that others can be compared with."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from typing_extensions import Self

from coopenv.arrays import whole
from coopenv.errors import InvalidInput
from coopenv.files import plain, reading, written

from .measures import MEASURES, SUCCESS, Estimate
from .trained import Trained

KIND = "coopenv.benchmark"
FORMAT = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What came of a scenario."""

    digest: str
    """Of the scenario."""
    sha256: str | None
    """Of the file that was entered."""
    measures: Mapping[str, Estimate | None]
    trained: Trained | None = None
    """How much training is behind it; ``None`` where it is not told."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """What an entry came to in a suite of one version."""

    suite: str
    version: int
    entry: str
    given: str
    sees: str
    versions: Mapping[str, str]
    revision: str | None
    results: Mapping[str, Result] = field(default_factory=dict)
    """By scenario."""

    @property
    def trained(self) -> tuple[Trained | None, ...]:
        """How much training is behind the result of each scenario."""
        return tuple(result.trained for result in self.results.values())

    def with_result(self, scenario: str, result: Result) -> Self:
        """A copy with what came of one more scenario."""
        return replace(self, results={**self.results, scenario: result})

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        content = {"kind": KIND, "format": FORMAT, **asdict(self)}
        results = content.pop("results")
        lines = [
            f"  {json.dumps(name)}: {json.dumps(plain(_listed(one)))}"
            for name, one in results.items()
        ]
        head = json.dumps(plain(content), indent=1).removesuffix("\n}")
        path.parent.mkdir(parents=True, exist_ok=True)
        with written(path) as part:
            text = f'{head},\n "results": {{\n' + ",\n".join(lines) + "\n }\n}\n"
            part.write_text(text, encoding="utf-8")


def read_summary(path: Path) -> Summary:
    """What `Summary.save` wrote.

    Raises
    ------
    InvalidInput
        If it is something else.
    """
    with reading(path):
        text = path.read_text(encoding="utf-8")
    try:
        given: dict[str, Any] = json.loads(text)
        if (given.pop("kind"), given.pop("format")) != (KIND, FORMAT):
            raise ValueError("another kind of file")
        results = {name: _result(one) for name, one in given.pop("results").items()}
        return Summary(**given, results=results)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InvalidInput(
            f"{path} must be a summary of coopenv benchmark, got something else ({error}); remove "
            "it, or name another folder by --out"
        ) from error


def _result(given: Mapping[str, Any]) -> Result:
    read = {"measures": _measures(given["measures"]), "trained": _trained(given.get("trained"))}
    return Result(**{**given, **read})


def _measures(given: Mapping[str, Any]) -> dict[str, Estimate | None]:
    found = {name: None if one is None else Estimate(*one) for name, one in given.items()}
    if set(found) != set(MEASURES) or found[SUCCESS] is None:
        raise ValueError(f"measures {sorted(found)}")
    for name, one in found.items():
        if one is not None and not one.low <= one.value <= one.high:
            raise ValueError(f"{name} is outside of its interval")
    return found


def _trained(given: Any) -> Trained | None:
    if given is None:  # of a summary of before, or not told
        return None
    told = Trained(**given)
    whole(told.steps, "trained.steps", at_least=0)
    whole(told.seeds, "trained.seeds", at_least=1)
    return told


def _listed(result: dict[str, Any]) -> dict[str, Any]:
    """Estimates as lists, which are shorter; a training that is not told is left out."""
    measures = {
        name: None if one is None else list(one) for name, one in result["measures"].items()
    }
    told = {**result, "measures": measures}
    return {name: value for name, value in told.items() if (name, value) != ("trained", None)}
