"""Every partner in every environment, beside the scripted controller: docs/partners.md.

python -m benchmarks.partners            # prints the tables; a few minutes of one core
python -m benchmarks.partners --write    # and writes docs/partners.md
python -m benchmarks.partners --hands    # the table of hands alone, with --write too
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rich.progress import track

from benchmarks.pages import DOCS, markdown, show
from coopenv import TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.partners import PARTNERS, Kind, LoadSharing, default_partner
from coopenv.agents.seeds import evaluation_seeds
from coopenv.envs.registry import find_config
from coopenv.transport import Transport

PAGE = DOCS / "partners.md"
EPISODES = 500  # a cell
NOBODY = "nobody"  # a reference, no name of a partner
KINDS: dict[str, Kind] = {
    NOBODY: LoadSharing(share=0.0),
    **{name: kind for name, kind in PARTNERS.items() if not kind.needs_hands},
}
HANDS_EPISODES = 200  # a cell of the table of hands


@dataclass(frozen=True, kw_only=True)
class Place:
    """An environment, and which of its agents the partner is."""

    env: str
    agents: tuple[int, ...] | None = None  # None: those that the task names

    def config(self, partner: Kind | None, action: str = "wrench") -> TransportConfig:
        """The environment with that partner."""
        agents = self.agents if partner is not None else None
        keywords = {"partner": partner, "partner_agents": agents, "action": action}
        return find_config(f"coopenv/{self.env}-v0", keywords)


PLACES = {
    "BeamTransport": Place(env="BeamTransport"),
    "BeamDoorway": Place(env="BeamDoorway"),
    "BeamTracking": Place(env="BeamTracking"),
    "WalkerTurn": Place(env="WalkerTurn"),
    "WalkerAvoid": Place(env="WalkerAvoid"),
    "WalkerTurn, drive": Place(env="WalkerTurn", agents=(1,)),
    "WalkerAvoid, drive": Place(env="WalkerAvoid", agents=(1,)),
}
BEAMS = ("BeamTransport", "BeamDoorway", "BeamTracking")
DRIVES = ("WalkerTurn, drive", "WalkerAvoid, drive")
HUMANS = ("WalkerTurn", "WalkerAvoid")
HELD = (*BEAMS, "BeamLift", *HUMANS)  # columns of the table of hands

REASONS = {  # why a kind is not meant to succeed in a place
    "a": "It does nothing; what the scripted learner brings about with its own part alone.",
    "b": "It heads straight for the goal, which leads it against the wall beside the gap.",
    "c": "It does not know that a body on wheels has to be turned first, and which way.",
    "d": "It has no plan and answers what it feels, while the scripted drive only turns: nobody "
    "pushes.",
    "e": "It has no plan and answers what it feels, while the scripted human only pushes: nobody "
    "turns.",
    "f": "It wants the object elsewhere and does not give in, so that it comes to rest in between.",
    "g": "As b, c or d, while it leads or follows.",
    "h": "Some of its members are not meant to succeed here.",
    "i": "It does not turn the walker exactly enough against its drag: a drive is a robot.",
}
_STRAIGHT = ("impedance", "leader", "lagging", "noisy")
_PLANLESS = ("follower", "load_sharing")
NOT_MEANT: dict[tuple[str, str], str] = {
    **{(NOBODY, place): "a" for place in PLACES},
    **{(kind, "BeamDoorway"): "b" for kind in _STRAIGHT},
    **{(kind, place): "c" for kind in _STRAIGHT for place in DRIVES},
    **{(kind, place): "d" for kind in _PLANLESS for place in HUMANS},
    **{(kind, place): "e" for kind in _PLANLESS for place in DRIVES},
    **{("stubborn", place): "f" for place in PLACES},
    **{("switching", place): "g" for place in ("BeamDoorway", *HUMANS, *DRIVES)},
    **{("population", place): "h" for place in PLACES},
    **{("walking", place): "i" for place in DRIVES},
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Means over the episodes of one kind in one place."""

    success: float  # [%]
    relative_cost: float  # γ
    disagreement: float  # [m] when an episode begins


Measured = Mapping[tuple[str, str], Cell]


def measure(kind: str, place: str, episodes: int = EPISODES) -> Cell:
    """Held-out episodes of the scripted controller as the learner beside a partner."""
    config = PLACES[place].config(KINDS[kind])
    seen = run_episodes(find_controller(config), config, episodes=episodes)
    starts = Transport(num_worlds=episodes, config=config)
    _, info = starts.reset(seed=[*evaluation_seeds(0, episodes)])
    return Cell(
        success=100 * float(seen.success.mean()),
        relative_cost=float(seen.relative_cost.mean()),
        disagreement=float(info["disagreement"].mean()),
    )


def measure_all() -> dict[tuple[str, str], Cell]:
    """Every kind in every place."""
    cells = [(kind, place) for kind in KINDS for place in PLACES]
    return {cell: measure(*cell) for cell in track(cells, "kind, place")}


def hands_table(episodes: int = HANDS_EPISODES) -> str:
    """Success and γ beside every kind, all by hands: the scripted controller as the learner."""
    rows = []
    for name, kind in track(PARTNERS.items(), "kind, by hands"):
        configs = [Place(env=env).config(kind, "motion") for env in HELD]
        seen = [run_episodes(find_controller(each), each, episodes=episodes) for each in configs]
        cells = [f"{100 * one.success.mean():.1f}, {one.relative_cost.mean():.3f}" for one in seen]
        rows.append([name, *cells])
    return markdown(("partner", *HELD), rows)


def tables(measured: Measured) -> dict[str, str]:
    """The page's tables of wrenches by the names of their marks."""
    return {
        "success": _table(measured, _success),
        "reasons": reasons(),
        "relative cost": _table(measured, lambda kind, place, cell: f"{cell.relative_cost:.3f}"),
        "disagreement": _table(measured, lambda kind, place, cell: f"{cell.disagreement:.2f}"),
    }


def reasons() -> str:
    """What the letters in the table of success mean."""
    return "\n".join(f"- ({letter}) {reason}" for letter, reason in REASONS.items())


def _table(measured: Measured, show: Callable[[str, str, Cell], str]) -> str:
    rows = [
        [kind, *(show(kind, place, measured[kind, place]) for place in PLACES)] for kind in KINDS
    ]
    return markdown(("partner", *PLACES), rows)


def _success(kind: str, place: str, cell: Cell) -> str:
    """Per cent; bold where the kind is the default, with a letter where it is not meant to."""
    shown = f"{cell.success:.1f}"
    if PLACES[place].agents is None and default_partner(PLACES[place].config(None)) == kind:
        shown = f"**{shown}**"
    letter = NOT_MEANT.get((kind, place))
    return f"{shown} ({letter})" if letter else shown


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    wanted = sys.argv[1:]
    made = {} if "--hands" in wanted else tables(measure_all())
    show(PAGE, {**made, "by hands": hands_table()})


if __name__ == "__main__":
    main()
