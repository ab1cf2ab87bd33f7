"""Tables of other algorithms' runs, beside those of PPO."""

from collections.abc import Iterable, Sequence
from statistics import median

from benchmarks.learning import baselines
from benchmarks.learning.algorithms.runs import NAMES, Run
from benchmarks.learning.run import Outcome
from benchmarks.learning.tables import FIGURES, NONE, REACHED, figures
from benchmarks.pages import DOCS, markdown

PAGE = DOCS / "training" / "algorithms.md"
TITLES = {"ppo": "PPO", "sac": "SAC", "mappo": "MAPPO", "recurrent": "recurrent PPO"}
COLUMNS = ("environment", "algorithm", *FIGURES, *REACHED)


def table(runs: Sequence[Run]) -> str:
    """One row a run with the environment's own actions; a sentence where there is none."""
    return _rows(run for run in runs if run.action is None)


def hands(runs: Sequence[Run]) -> str:
    """One row a run of teams that move hands; a sentence where there is none."""
    return _rows(run for run in runs if run.action == "motion")


def _rows(runs: Iterable[Run]) -> str:
    shown = placed([*runs])
    return markdown(COLUMNS, [row(run) for run in shown]) if shown else NONE


def placed(runs: Sequence[Run]) -> list[Run]:
    """Runs by environment, algorithm and seed."""
    order = baselines.names()

    def place(run: Run) -> tuple[int, int, int]:
        return order.index(run.env), NAMES.index(run.algorithm), run.seed

    return sorted(runs, key=place)


def row(run: Run) -> tuple[str, ...]:
    """Cells of a run."""
    return (run.env, TITLES[run.algorithm], *figures(run))


def cost(runs: Sequence[Run]) -> str:
    """Seconds until 98 %, one row an environment, PPO's beside the others'."""
    shown = [one for one in runs if one.action is None]
    if not shown:
        return NONE
    columns = ("environment", "PPO, joint", "PPO, shared", *(TITLES[name] for name in NAMES))
    rows = []
    for env in baselines.names():
        mine = [one for one in shown if one.env == env]
        rows.append(
            (
                env,
                *(_until(baselines.saved(f"{env}_{control}")) for control in ("joint", "shared")),
                *(_until([one for one in mine if one.algorithm == name]) for name in NAMES),
            )
        )
    return markdown(columns, rows)


def _until(runs: Iterable[Outcome]) -> str:
    """The median over runs until the last level; how many got there where not all did."""
    times = [run.reached[-1] for run in runs]
    there = [at for at in times if at is not None]
    if not times:
        return "not run"
    if not there:
        return "–"
    some = f" ({len(there)} of {len(times)})" if len(there) < len(times) else ""
    return f"{median(there):.0f}{some}"
