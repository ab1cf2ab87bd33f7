"""Cross-play: policies that learned apart, each with each other in the two seats of a beam.

python -m benchmarks.learning.cross_play            # measures pairs that lack; prints the table
python -m benchmarks.learning.cross_play --write    # and puts it into docs/training/partners.md
python -m benchmarks.learning.cross_play --policies population_0 population_1

A policy is named by the partner beside whom it learned and its seed, or is joint_0 and the like.
It is the one that `benchmarks.learning.baselines` left in its folder for runs, and is trained if
that has none. Who is entered sits where it learned, at agent 0; the other one is its partner. Pairs
are kept in docs/training/cross_play.json with the digest of either file; ``--no-measure --write``
writes the table of these alone.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.learning.run import configured
from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.benchmark.seated import Seated
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.partners import LearnedPartner
from coopenv.agents.pretrained import read
from coopenv.agents.train import train
from coopenv.envs.registry import PREFIX, find_config
from coopenv.errors import InvalidInput
from coopenv.files import written

FILE, PAGE = DOCS / "training" / "cross_play.json", DOCS / "training" / "partners.md"
ENV = "BeamTransport"
EVALUATION, EPISODES = 19, 200  # number of the evaluation; held-out episodes of a pair
TEAMS = ("joint", "shared")  # controls that no partner is beside
NONE = "None of these pairs is measured yet."
POLICIES = ("population_1", "impedance_0", "leader_0", "follower_0")


@dataclass(frozen=True, kw_only=True)
class Pair:
    """What two policies did together."""

    entered: str
    beside: str
    files: tuple[str, str]  # SHA-256 of either
    success: float
    relative_cost: float  # γ


@dataclass(frozen=True, kw_only=True)
class CrossPlay:
    """Every policy with every other."""

    policies: tuple[str, ...] = POLICIES
    """Names such as population_0: the partner beside whom it learned, or joint or shared, and its
    seed."""
    runs: Path = Path("runs/baselines")
    """Folder of the runs."""
    measure: bool = True
    """Measure pairs that lack, and train policies that do; else the table is of what is there."""
    write: bool = False
    """Put the table into docs/training/partners.md."""


def policy_file(name: str, runs: Path) -> Path:
    """The file of a policy, which is trained if it is not there.

    Raises
    ------
    InvalidInput, UnknownName
        If the name has no seed, or there is no partner of that name.
    """
    kind, _, seed = name.rpartition("_")
    if not kind or not seed.isdigit():
        raise InvalidInput(f"policies must be partner_seed, got {name!r}; write population_0")
    control = kind if kind in TEAMS else "partner"
    partner = None if kind in TEAMS else kind
    config = configured(ENV, control, int(seed), runs, partner=partner)
    path = config.out / "policy.zip"
    if not path.exists():
        train(config)
    return path


def together(entered: str, beside: str, runs: Path, episodes: int = EPISODES) -> Pair:
    """Held-out episodes of a policy beside another."""
    mine, theirs = (policy_file(name, runs) for name in (entered, beside))
    config = find_config(f"{PREFIX}{ENV}-v0", {"partner": LearnedPartner(path=str(theirs))})
    seen = run_episodes(Seated(read(mine), config), config, episodes=episodes, seed=EVALUATION)
    return Pair(
        entered=entered,
        beside=beside,
        files=(digest(mine), digest(theirs)),
        success=float(seen.success.mean()),
        relative_cost=round(float(seen.relative_cost.mean()), 4),
    )


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return sha256(path.read_bytes()).hexdigest()


def saved() -> dict[tuple[str, str], Pair]:
    """What was measured so far, by names."""
    given = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else []
    pairs = [Pair(**{**each, "files": tuple(each["files"])}) for each in given]
    return {(pair.entered, pair.beside): pair for pair in pairs}


def save(pairs: Sequence[Pair]) -> None:
    """Write all pairs, one a line."""
    lines = ",\n".join(json.dumps(asdict(pair)) for pair in pairs)
    with written(FILE) as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def measure_all(asked: CrossPlay, tell: Callable[[str], None] = print) -> None:
    """Measure the pairs that lack, or are of other files than are there now."""
    files = {name: digest(policy_file(name, asked.runs)) for name in asked.policies}
    for entered in asked.policies:
        for beside in asked.policies:
            kept, names = saved(), (entered, beside)
            known = kept.get(names)
            if known is None or known.files != (files[entered], files[beside]):
                kept[names] = together(entered, beside, asked.runs)
                save([*kept.values()])
                tell(json.dumps(asdict(kept[names])))


def table(pairs: dict[tuple[str, str], Pair]) -> str:
    """A row who is entered, a column who is beside: success and γ; a sentence without pairs."""
    if not pairs:
        return NONE
    entered, beside = (list(dict.fromkeys(each)) for each in zip(*pairs, strict=True))
    rows = [
        [f"`{name}`", *(_cell(pairs.get((name, other))) for other in beside)] for name in entered
    ]
    return markdown(("entered", *(f"beside `{name}`" for name in beside)), rows)


def _cell(pair: Pair | None) -> str:
    return "–" if pair is None else f"{100 * pair.success:.1f}, {pair.relative_cost:.3f}"


def main() -> None:
    """Measure what the command line asks for."""
    asked, console = tyro.cli(CrossPlay), Console()

    def tell(line: str) -> None:
        console.print(line, markup=False, soft_wrap=True)

    if asked.measure:
        measure_all(asked, tell)
    made = table(saved())
    tell(made)
    if asked.write:
        fill(PAGE, {"cross-play": made})


if __name__ == "__main__":
    main()
