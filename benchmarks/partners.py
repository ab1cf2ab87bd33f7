"""Every partner in every environment, beside the scripted controller: docs/partners.md.

python -m benchmarks.partners                     # prints the tables; minutes of one core
python -m benchmarks.partners --write             # and writes docs/partners.md
python -m benchmarks.partners --write BeamLift    # measures these columns, keeps the others
python -m benchmarks.partners --hands             # the table of hands alone, with --write too
python -m benchmarks.partners --hands compliant   # measures these rows of it, keeps the others
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from rich.progress import track

from benchmarks.pages import DOCS, cells, markdown, show
from coopenv import TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.partners import PARTNERS, Kind, LoadSharing, default_partner
from coopenv.agents.seeds import evaluation_seeds
from coopenv.envs.registry import find_config
from coopenv.errors import UnknownName
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
    "BeamLift": Place(env="BeamLift"),
    "WalkerTurn, drive": Place(env="WalkerTurn", agents=(1,)),
    "WalkerAvoid, drive": Place(env="WalkerAvoid", agents=(1,)),
}
BEAMS = ("BeamTransport", "BeamDoorway", "BeamTracking")
DRIVES = ("WalkerTurn, drive", "WalkerAvoid, drive")
HUMANS = ("WalkerTurn", "WalkerAvoid")
HELD = (*BEAMS, "BeamLift", *HUMANS)  # columns of the table of hands

REASONS = {  # why a kind is not meant to succeed in a place
    "a": "It does nothing; what the scripted learner brings about with its own part alone.",
    "b": "It heads straight for the goal, which leads it against the wall beside the gap, or "
    "against the obstacle, where the beam leans.",
    "c": "It does not know that a body on wheels has to be turned first, and which way.",
    "d": "It has no plan and answers what it feels, while the scripted drive only turns: nobody "
    "pushes.",
    "e": "It has no plan and answers what it feels, while the scripted human only pushes: nobody "
    "turns.",
    "f": "It wants the object elsewhere and does not give in, so that it comes to rest in between.",
    "g": "As b, c, d or j, while it leads or follows.",
    "h": "Some of its members are not meant to succeed here.",
    "i": "It does not turn the walker exactly enough against its drag: a drive is a robot.",
    "j": "It has no plan and answers what it feels, so that its end rises after the other's: the "
    "beam leans, and has failed or hangs there.",
    "k": "It bears 0.6 to 1.4 times its part of a weight, and lets it sink or rise.",
}
_STRAIGHT = ("impedance", "leader", "lagging", "noisy")
_PLANLESS = ("follower", "load_sharing")
NOT_MEANT: dict[tuple[str, str], str] = {
    **{(NOBODY, place): "a" for place in PLACES},
    **{(kind, place): "b" for kind in _STRAIGHT for place in ("BeamDoorway", "BeamLift")},
    **{(kind, place): "c" for kind in _STRAIGHT for place in DRIVES},
    **{(kind, place): "d" for kind in _PLANLESS for place in HUMANS},
    **{(kind, place): "e" for kind in _PLANLESS for place in DRIVES},
    **{(kind, "BeamLift"): "j" for kind in _PLANLESS},
    **{("stubborn", place): "f" for place in PLACES},
    **{("switching", place): "g" for place in ("BeamDoorway", "BeamLift", *HUMANS, *DRIVES)},
    **{("population", place): "h" for place in PLACES},
    **{("walking", place): "i" for place in DRIVES},
    ("walking", "BeamLift"): "k",
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


def measure_all(places: Sequence[str]) -> dict[tuple[str, str], Cell]:
    """Every kind in these places."""
    asked = [(kind, place) for kind in KINDS for place in places]
    return {cell: measure(*cell) for cell in track(asked, "kind, place")}


def hands_table(kinds: Sequence[str], episodes: int = HANDS_EPISODES) -> str:
    """Success and γ beside these kinds, all by hands: the scripted controller as the learner.

    What was not measured stays as it is on the page.
    """
    rows = {row[0]: row for row in cells(PAGE, "by hands")[1:]}
    for name in track(kinds, "kind, by hands"):
        configs = [Place(env=env).config(PARTNERS[name], "motion") for env in HELD]
        seen = [run_episodes(find_controller(each), each, episodes=episodes) for each in configs]
        shown = [f"{100 * one.success.mean():.1f}, {one.relative_cost.mean():.3f}" for one in seen]
        rows[name] = [name, *shown]
    return markdown(("partner", *HELD), [rows[name] for name in PARTNERS if name in rows])


def tables(measured: Measured) -> dict[str, str]:
    """The page's tables of wrenches by the names of their marks.

    What was not measured stays as it is there.
    """
    return {
        "success": _table("success", measured, _success),
        "reasons": reasons(),
        "relative cost": _table(
            "relative cost", measured, lambda _, cell: f"{cell.relative_cost:.3f}"
        ),
        "disagreement": _table(
            "disagreement", measured, lambda _, cell: f"{cell.disagreement:.2f}"
        ),
    }


def reasons() -> str:
    """What the letters in the table of success mean."""
    return "\n".join(f"- ({letter}) {reason}" for letter, reason in REASONS.items())


def on_page(name: str) -> dict[tuple[str, str], str]:
    """What stands in each cell of a table of the page, by kind and place."""
    (_, *places), *rows = cells(PAGE, name)
    return {
        (kind, place): shown
        for kind, *line in rows
        for place, shown in zip(places, line, strict=True)
    }


def _table(name: str, measured: Measured, show: Callable[[tuple[str, str], Cell], str]) -> str:
    shown = {**on_page(name), **{at: show(at, cell) for at, cell in measured.items()}}
    rows = [[kind, *(shown[kind, place] for place in PLACES)] for kind in KINDS]
    return markdown(("partner", *PLACES), rows)


def _success(at: tuple[str, str], cell: Cell) -> str:
    """Per cent; bold where the kind is the default, with a letter where it is not meant to."""
    (kind, place), shown = at, f"{cell.success:.1f}"
    if PLACES[place].agents is None and default_partner(PLACES[place].config(None)) == kind:
        shown = f"**{shown}**"
    letter = NOT_MEANT.get((kind, place))
    return f"{shown} ({letter})" if letter else shown


def main() -> None:
    """Print the tables; with ``--write`` also put them on the page."""
    asked = [word for word in sys.argv[1:] if word not in ("--write", "--hands")]
    by_hand = "--hands" in sys.argv[1:]
    what, known = ("row", PARTNERS) if by_hand else ("column", PLACES)
    for name in asked:
        if name not in known:
            raise UnknownName(what, name, known)
    made = {} if by_hand else tables(measure_all(asked or [*PLACES]))
    if by_hand or not asked:
        made["by hands"] = hands_table(asked if by_hand and asked else [*PARTNERS])
    show(PAGE, made)


if __name__ == "__main__":
    main()
