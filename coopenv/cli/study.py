"""``coopenv study``: the paper's simulations and human study."""

from dataclasses import dataclass

from coopenv.agents.studies.commands import Beam, Dyads, Snapshots, WalkerAvoid, WalkerTurn
from coopenv.files import require_folder


@dataclass(frozen=True, kw_only=True)
class Study:
    """Run a study of the paper and check its claims, or analyse recorded trials the same way."""

    study: WalkerTurn | WalkerAvoid | Beam | Dyads | Snapshots

    def run(self) -> None:
        """Run it, if its folder can be written."""
        require_folder(self.study.out)
        self.study.run()
