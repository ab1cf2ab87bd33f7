"""``coopenv study``: the paper's simulations and human study."""

from dataclasses import dataclass
from typing import Any, ClassVar

from coopenv.agents.studies.commands import Beam, Dyads, Snapshots, WalkerAvoid, WalkerTurn
from coopenv.files import require_folder
from coopenv.options import Common


@dataclass(frozen=True, kw_only=True)
class Study:
    """Run a study of the paper and check its claims, or analyse recorded trials the same way."""

    study: WalkerTurn | WalkerAvoid | Beam | Dyads | Snapshots
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv study snapshots",
        "coopenv study walker-turn --json",
        "coopenv study beam --help",
    )

    @property
    def common(self) -> Common:
        """That of the study."""
        return self.study.common

    def run(self) -> dict[str, Any]:
        """Run it, if its folder can be written."""
        require_folder(self.study.out)
        return self.study.run()
