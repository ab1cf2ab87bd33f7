"""Scripted controllers with wrenches and with hands, in every environment: docs/tasks.md.

python -m benchmarks.scripted            # prints the table; half a minute of one core
python -m benchmarks.scripted --write    # and writes docs/tasks.md
"""

from benchmarks.pages import DOCS, markdown, show
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import evaluate
from coopenv.envs.registry import PREFIX, find_config

PAGE = DOCS / "tasks.md"
ENVS = ("BeamTransport", "BeamDoorway", "BeamTracking", "WalkerTurn", "WalkerAvoid", "BeamLift")
ACTIONS = ("wrench", "motion", "impedance")
COLUMNS = ("environment", "action", "success", "time [s]", "γ", "F_I [N]", "T_I [N·m]")


def table(episodes: int = 500) -> str:
    """A row for every environment and kind of action."""
    return markdown(COLUMNS, [_row(env, kind, episodes) for env in ENVS for kind in ACTIONS])


def _row(env: str, action: str, episodes: int) -> tuple[str, ...]:
    config = find_config(f"{PREFIX}{env}-v0", {"action": action})
    seen = evaluate(find_controller(config), config, episodes=episodes)
    return (
        env,
        action,
        f"{100 * seen.success_rate:.1f} %",
        f"{seen.success_time:.1f}",
        f"{seen.relative_cost:.4f}",
        f"{seen.internal_force_level:.3f}",
        f"{seen.internal_torque_level:.3f}",
    )


if __name__ == "__main__":
    show(PAGE, {"scripted": table()})
