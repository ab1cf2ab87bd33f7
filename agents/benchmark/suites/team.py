"""Suite of whole teams: every environment as its id has it, all agents entered."""

from ..scenario import Scenario, Suite

TEAM = Suite(
    name="team",
    version=1,
    title="A whole team in every environment",
    scenarios=tuple(
        Scenario(name=env, env=env)
        for env in (
            *("BeamTransport", "BeamDoorway", "BeamTracking", "BeamLift"),
            *("WalkerTurn", "WalkerAvoid"),
        )
    ),
)
