"""Tables of the baselines: of whole teams, beside partners, and by hands."""

from collections.abc import Sequence

import gymnasium

from benchmarks.learning.run import Outcome, Run
from benchmarks.pages import markdown
from coopenv.agents.partners import PARTNERS
from coopenv.envs.registry import PREFIX

NONE = "None of these runs is finished yet."  # in the place of a table without rows
FIGURES = ("seed", "success", "sampled", "time [s]", "γ", "control steps", "CPU s")
REACHED = ("to 90 %", "to 98 %")
COLUMNS = ("environment", "policy", *FIGURES, *REACHED)
BESIDE = ("environment", "actions", "beside", *FIGURES, *REACHED)


def names() -> list[str]:
    """Of all environments, without prefix and version."""
    mine = (name for name in gymnasium.registry if name.startswith(PREFIX))
    return [name.removeprefix(PREFIX).partition("-")[0] for name in mine]


def placed(runs: Sequence[Run]) -> list[Run]:
    """Runs by environment, action, control, partner and seed."""
    order, kinds = names(), [None, *PARTNERS]

    def place(run: Run) -> tuple[int, bool, str, int, int]:
        by_hands = run.action is not None
        kind = kinds.index(run.partner)
        return order.index(run.env), by_hands, run.control, kind, run.seed

    return sorted(runs, key=place)


def table(runs: Sequence[Run]) -> str:
    """One row a run of whole teams with the environment's own actions; a sentence without one."""
    shown = [run for run in runs if run.is_plain]
    return markdown(COLUMNS, [row(run) for run in placed(shown)]) if shown else NONE


def hands(runs: Sequence[Run]) -> str:
    """One row a run of whole teams that move hands; a sentence without one."""
    shown = [run for run in runs if run.partner is None and run.action == "motion"]
    return markdown(COLUMNS, [row(run) for run in placed(shown)]) if shown else NONE


def partners(runs: Sequence[Run]) -> str:
    """One row a run beside a partner; a sentence without one."""
    shown = [run for run in runs if run.partner is not None]
    rows = [
        (run.env, run.action or "wrench", run.partner or "", *figures(run)) for run in placed(shown)
    ]
    return markdown(BESIDE, rows) if rows else NONE


def row(run: Run) -> tuple[str, ...]:
    """Cells of a run of a whole team."""
    return (run.env, run.control, *figures(run))


def figures(run: Outcome) -> tuple[str, ...]:
    """Cells of what a run did."""
    return (
        f"{run.seed}",
        f"{run.success:.1%}",
        f"{run.sampled:.1%}",
        "–" if run.time is None else f"{run.time:.1f}",
        f"{run.relative_cost:.3f}",
        f"{run.steps:,}",
        f"{run.seconds:.0f}",
        *("–" if at is None else f"{at:.0f}" for at in run.reached),
    )
