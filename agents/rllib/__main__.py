"""Multi-agent PPO of RLlib, here or on a Ray cluster, and its evaluation as of any other policy.

python -m coopenv.agents.rllib --steps 400000
python -m coopenv.agents.rllib --environment.env coopenv/BeamDoorway-v0 --policies own
python -m coopenv.agents.rllib --address auto --runners 32    # the same on a cluster
"""

import sys

import tyro
from rich.console import Console

from coopenv.errors import CoopenvError

from ..evaluate import table
from .settings import RLlibConfig
from .training import POLICY, train


def main() -> int:
    """Train, print progress and the table; 1 if something was refused."""
    config = tyro.cli(RLlibConfig, description=__doc__)
    console = Console()

    def tell(row: dict[str, float]) -> None:
        said = f"{row['steps']:,.0f} of {config.steps:,} control steps, return {row['return']:.2f}"
        console.print(said, highlight=False)

    try:
        _, seen = train(config, tell)
    except CoopenvError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    console.print(table([seen], f"{config.environment.env}, {config.episodes} held-out episodes"))
    console.print(
        f"in {config.out}: {POLICY}, for coopenv evaluate and coopenv replay",
        highlight=False,
        soft_wrap=True,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
