"""What is tried in the search of each algorithm's settings, mostly one factor at a time."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from coopenv.agents.algorithms import SACConfig

SEED = 100  # of trainings that no table has

Searched = Literal["ppo", "sac", "mappo", "recurrent"]  # modules beside this one
KEPT = (("ppo", "BeamLift"),)  # others than the search takes: all of five seeds pass with them
Changed = Mapping[str, Any]  # settings of a trial that are not those of the start


@dataclass(frozen=True, kw_only=True)
class Space:
    """Trials of an algorithm; their length is of the environment, and some are of one alone."""

    steps_name: str  # of the setting that says how long a training is
    steps: Mapping[str, int]  # control steps of a trial, by environment
    start: Mapping[str, Any]
    changes: tuple[Changed, ...]  # in every environment
    more: Mapping[str, tuple[Changed, ...]] = field(default_factory=dict)  # in some, by name

    def changes_in(self, env: str) -> tuple[Changed, ...]:
        """All that is tried in an environment."""
        return (*self.changes, *self.more.get(env, ()))

    def settings(self, env: str, changed: Changed) -> dict[str, Any]:
        """Those of a trial."""
        return {**self.start, self.steps_name: self.steps[env], **changed}


OF: Mapping[Searched, Space] = {
    "ppo": Space(
        steps_name="steps",
        steps={
            "BeamTransport": 300_000,
            "BeamTracking": 300_000,
            "WalkerTurn": 400_000,
            "BeamDoorway": 900_000,
            "WalkerAvoid": 400_000,
            "BeamLift": 900_000,
        },
        start={
            "num_worlds": 64,
            "rollout": 128,
            "epochs": 10,
            "batch_size": 2048,
            "learning_rate": 1e-3,
        },
        changes=(
            {},
            {"num_worlds": 256, "rollout": 32, "epochs": 5},
        ),
        more={"BeamTransport": ({"batch_size": 512},)},
    ),
    "sac": Space(
        steps_name="steps",
        steps={
            "BeamTransport": 60_000,
            "BeamTracking": 60_000,
            "WalkerTurn": 200_000,
            "BeamDoorway": 300_000,
            "WalkerAvoid": 200_000,
            "BeamLift": 200_000,
        },
        start={
            **{name: value for name, value in asdict(SACConfig()).items() if name != "steps"},
            "gradient_steps": 2,
        },
        changes=({}, {"discount": 0.99}, {"gradient_steps": 4}),
    ),
    "mappo": Space(
        steps_name="total_steps",
        steps={
            "BeamTransport": 200_000,
            "BeamTracking": 200_000,
            "WalkerTurn": 600_000,
            "BeamDoorway": 800_000,
            "WalkerAvoid": 600_000,
            "BeamLift": 600_000,
        },
        start={
            "num_worlds": 256,
            "rollout": 32,
            "epochs": 5,
            "minibatch": 512,
            "learning_rate": 1e-3,
        },
        changes=({}, {"minibatch": 2048}),
        more=dict.fromkeys(
            ("BeamTransport", "BeamTracking", "BeamDoorway"), ({"learning_rate": 5e-4},)
        ),
    ),
    "recurrent": Space(
        steps_name="steps",
        steps={
            "BeamTransport": 200_000,
            "BeamTracking": 200_000,
            "WalkerTurn": 400_000,
            "BeamDoorway": 700_000,
            "WalkerAvoid": 500_000,
            "BeamLift": 900_000,
        },
        start={
            "num_worlds": 256,
            "rollout": 32,
            "epochs": 5,
            "batch_size": 2048,
            "learning_rate": 1e-3,
            "units": 64,
            "residual": False,
        },
        changes=(
            {},
            {"num_worlds": 64, "rollout": 128, "epochs": 10},
            {"residual": True},
        ),
        more={
            "BeamTransport": ({"batch_size": 512}, {"epochs": 10}),
            "BeamLift": ({"residual": True, "num_worlds": 64, "rollout": 128},),
        },
    ),
}
