"""Ablation: what of the partner helps to sense, beside a partner whose plan is hidden?

python -m benchmarks.learning.partner_ablation          # five seeds a row; --help for the rest
python -m benchmarks.learning.partner_ablation --write  # and puts the table into docs/studies.md

The partner alone knows the goal (``informed`` names nobody who learns), and a learner without
memory holds the other end. In this setting sensing could matter: the goal shows only in what the
partner does, and of that the learner sees the object's motion and its own wrench, but neither the
partner's wrench nor a load share, which it would have to compute from a motion it has forgotten.
(If the learner were told a goal of its own and the partner had another one, the partner would have
to be overpowered or given in to, and success would say which, not what was understood.)

The rows have the same budget, seeds, hidden layers and reward, and differ in the observation alone:
the plausible internal wrenches and γ, which say how much of its push the partner works against; the
internal wrenches of the pseudoinverse, which with its own wrench determine the partner's; or the
partner's wrench itself. What the last two add is what the plausible part leaves out. Idle and
informed policies bracket all: the partner by itself, and one who needs no sense of it.

Every row is measured by the plausible decomposition, whatever its learner sees.
"""

import csv
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import tyro
from rich.console import Console
from rich.table import Table
from scipy.stats import bootstrap

from benchmarks.learning.settings import of_tables
from benchmarks.pages import DOCS, fill, markdown
from coopenv import wrench
from coopenv.agents.controllers.impedance import ImpedanceController
from coopenv.agents.curves import Row, draw
from coopenv.agents.evaluate import Evaluation, evaluate, save
from coopenv.agents.policy import Policy
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, UnknownName
from coopenv.files import written
from coopenv.observation.observation import Observation
from coopenv.transition import Transition
from coopenv.wrench.settings import Method

PAGE = DOCS / "studies.md"


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """What a row's learner sees."""

    observe: tuple[str, ...]
    method: Method = "optimal"  # of the decomposition that the internal wrenches are read from


MOTION = ("twist", "own_wrench")
INTERNAL = ("own_internal", "partner_internal")
ROWS: dict[str, Sight] = {
    "without": Sight(observe=MOTION),
    "plausible": Sight(observe=(*MOTION, *INTERNAL, "relative_cost")),
    "Moore-Penrose": Sight(observe=(*MOTION, *INTERNAL), method="moore_penrose"),
    "partner's wrench": Sight(observe=(*MOTION, "partner_wrench")),
}
CONTRASTS = (
    ("plausible", "without"),
    ("Moore-Penrose", "plausible"),
    ("partner's wrench", "Moore-Penrose"),
)
MEASURES = {  # attribute of an evaluation -> heading
    "success_rate": "success",
    "reward": "return",
    "success_time": "time [s]",
    "relative_cost": "γ",
    "internal_force_level": "F_I [N]",
}


@dataclass(frozen=True, kw_only=True)
class Ablation:
    """Train beside a partner with different senses of what it does."""

    partner: str = "impedance"
    """Who alone knows the goal (coopenv.agents.partners)."""
    rows: tuple[str, ...] = tuple(ROWS)
    """What learners see, by name."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs of each row."""
    episodes: int = 500
    """Held-out episodes for each policy."""
    horizon: int = 100
    """Control steps of an episode; the partner by itself needs most of them."""
    out: Path = Path("runs/partner_ablation")
    """Folder for policies, table and curves."""
    write: bool = False
    """Put the table into docs/studies.md."""
    training: TrainConfig = field(
        default_factory=lambda: of_tables(control="partner", steps=300_000)
    )

    def check(self) -> None:
        """Raise unless there are seeds for an interval, and every row is known."""
        if len(self.seeds) < 2:
            raise InvalidInput(
                f"seeds must be at least two for an interval, got {self.seeds}; give five"
            )
        for row in self.rows:
            if row not in ROWS:
                raise UnknownName("rows", row, ROWS)

    def environment(self, row: str) -> TransportConfig:
        """What a row's learner is trained in."""
        sight = ROWS[row]
        chosen = EnvironmentChoice(
            partner=self.partner, observe=sight.observe, horizon=self.horizon, reward="task"
        )
        settings = wrench.Settings(method=sight.method)
        return replace(chosen.config(), informed=(), decomposition=settings)

    def measured(self, row: str) -> TransportConfig:
        """What a row's learner is tested in: as it was trained, γ and levels by eqs. 28-29."""
        return replace(self.environment(row), decomposition=wrench.Settings())


class Idle:
    """Holds the object and does nothing."""

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, learner, action_size)``."""
        return np.zeros((*obs.shape[:2], transition.action.shape[2]))


class Sensing:
    """A policy that goes on seeing its own decomposition where another one is measured.

    Parameters
    ----------
    policy
        Trained in ``environment``.
    environment
        Its blocks and decomposition are what the policy sees.
    """

    def __init__(self, policy: Policy, environment: TransportConfig):
        self._policy, self._settings = policy, environment.decomposition
        self._learners = list(environment.learners)
        self._observation = Observation(environment.observe, len(environment.limits()))

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        conditions = transition.conditions
        team = replace(conditions.team, settings=self._settings)
        seen = self._observation(replace(transition, conditions=replace(conditions, team=team)))
        return self._policy(np.ascontiguousarray(seen[:, self._learners]), transition)


def run(study: Ablation, tell: Callable[[str], None] = print) -> dict[str, list[Evaluation]]:
    """Train and evaluate every row; write ``runs.csv``, ``table.csv`` and ``curves.png``."""
    study.check()
    seen: dict[str, list[Evaluation]] = {}
    histories: dict[str, list[list[Row]]] = {}
    for row in study.rows:
        environment = study.environment(row)
        seen[row], histories[row] = [], []
        for seed in study.seeds:
            rows: list[Row] = []
            config = replace(
                study.training,
                control="partner",
                environment=EnvironmentChoice(partner=study.partner, observe=ROWS[row].observe),
                seed=seed,
                out=study.out / f"{row.replace(' ', '_')}_{seed}",
                fresh=True,
            )
            began = time.perf_counter()
            policy = Sensing(
                train(config, environment=environment, report=rows.append), environment
            )
            tell(f"{row} {seed}: trained in {time.perf_counter() - began:.0f} s")
            seen[row].append(
                evaluate(policy, study.measured(row), episodes=study.episodes, name=f"{row} {seed}")
            )
            histories[row].append(rows)
    environment = study.environment("without")
    for name, policy in (("idle", Idle()), ("informed", ImpedanceController(environment))):
        seen[name] = [evaluate(policy, environment, episodes=study.episodes, name=name)]
    save([one for several in seen.values() for one in several], study.out / "runs.csv")
    draw(histories, study.out / "curves.png")
    with written(study.out / "table.csv") as part, part.open("w", newline="") as file:
        csv.writer(file).writerows([["learner", *MEASURES.values()], *lines(seen)])
    return seen


def lines(seen: dict[str, list[Evaluation]]) -> list[list[str]]:
    """A line for each learner and for each of `CONTRASTS`, with 95 % intervals over the seeds."""
    values = {
        row: [np.array([getattr(one, measure) for one in several]) for measure in MEASURES]
        for row, several in seen.items()
    }
    table = [[row, *(interval([value]) for value in columns)] for row, columns in values.items()]
    for more, less in CONTRASTS:
        if more in values and less in values:
            pairs = zip(values[more], values[less], strict=True)
            table.append([f"{more} − {less}", *(interval([one, other]) for one, other in pairs)])
    return table


def interval(samples: Sequence[FloatArray]) -> str:
    """Mean of one sample, or difference of two means, and its bootstrap interval over seeds.

    Seeds in which a measure is not defined (no episode succeeded) are left out.
    """
    defined = [sample[~np.isnan(sample)] for sample in samples]
    if not all(len(sample) for sample in defined):
        return "-"
    middle = float(_contrast(defined[0], defined[1] if len(defined) > 1 else None))
    if any(len(sample) < 2 for sample in defined):
        return f"{middle:.3f}"
    found = bootstrap(
        defined, _contrast, method="percentile", n_resamples=9999, rng=np.random.default_rng(0)
    ).confidence_interval
    return f"{middle:.3f} [{found.low:.3f}, {found.high:.3f}]"


def _contrast(
    first: FloatArray, second: FloatArray | None = None, axis: int = -1
) -> npt.NDArray[np.float64]:
    mean = np.mean(first, axis=axis)
    return np.asarray(mean if second is None else mean - np.mean(second, axis=axis))


def main() -> None:
    """Run the ablation that the command line describes and print its table."""
    console, study = Console(), tyro.cli(Ablation)
    seen = run(study, console.print)
    title = f"the {study.partner} partner alone knows the goal; {len(study.seeds)} seeds, 95 %"
    table = Table("learner", *MEASURES.values(), title=title, title_justify="left")
    made = lines(seen)
    for line in made:
        table.add_row(*line)
    console.print(table)
    if study.write:
        fill(PAGE, {"partner": markdown(("learner", *MEASURES.values()), made)})


if __name__ == "__main__":
    main()
