"""Suite of feeling alone: one agent is told the goal, and each has what it senses by itself."""

from coopenv.physics.body import Body

from ..scenario import Scenario, Suite

BEAMS = {"7.7 kg": (7.7, 200), "20 kg": (20.0, 300)}  # mass [kg], control steps

HAPTICS = Suite(
    name="haptics",
    version=1,
    title="The goal known to one",
    scenarios=tuple(
        Scenario(
            name=f"{action}, {beam}",
            env="BeamTransport",
            settings={
                "action": action,
                "sensing": "own",
                "informed": (0,),
                "body": Body(mass=mass),
                "horizon": horizon,
            },
        )
        for action in ("motion", "wrench")
        for beam, (mass, horizon) in BEAMS.items()
    ),
)
