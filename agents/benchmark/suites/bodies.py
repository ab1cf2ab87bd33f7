"""Suite of bodies that nobody trained with: masses, lengths, friction and grips out of range.

What is entered may be trained on bodies within `TRAINING`.
"""

from coopenv.physics.body import Body
from coopenv.randomisation import Range, Ranges

from ..scenario import Scenario, Suite

TRAINING = Ranges(
    mass=(5.0, 11.0),
    length=(1.8, 2.2),
    ground_friction=(0.0, 0.05),
    grips=((-0.08, 0.08), (-0.02, 0.02)),
)
LIGHT, HEAVY = (1.0, 3.0), (15.0, 25.0)  # [kg]
SHORT, LONG = (1.0, 1.5), (2.6, 3.2)  # [m]
RUBBING = (0.08, 0.14)  # coefficient of the ground
NEAR: tuple[Range, Range] = ((-0.1, 0.1), (-0.02, 0.02))  # [m] about the grips below
UNEVEN = Body(grips=((-0.85, 0.0), (0.25, 0.0)))  # one end, and near the middle
STEPS = 300  # for what is heavy or rubs

BODIES = Suite(
    name="bodies",
    version=1,
    title="Bodies that nobody trained with",
    scenarios=(
        *(
            Scenario(name=name, env="BeamTransport", settings=settings)
            for name, settings in {
                "within the training range": {"randomise": TRAINING},
                "light": {"randomise": Ranges(mass=LIGHT)},
                "heavy": {"randomise": Ranges(mass=HEAVY), "horizon": STEPS},
                "short": {"randomise": Ranges(length=SHORT)},
                "long": {"randomise": Ranges(length=LONG)},
                "rubbing": {"randomise": Ranges(ground_friction=RUBBING), "horizon": STEPS},
                "uneven grips": {"body": UNEVEN, "randomise": Ranges(grips=NEAR)},
                "all at once": {
                    "body": UNEVEN,
                    "randomise": Ranges(
                        mass=HEAVY, length=LONG, ground_friction=(0.02, 0.05), grips=NEAR
                    ),
                    "horizon": 400,
                },
            }.items()
        ),
        *(
            Scenario(
                name=f"heavy, {env}",
                env=env,
                settings={"randomise": Ranges(mass=HEAVY), "horizon": horizon},
            )
            for env, horizon in (("BeamDoorway", 450), ("BeamTracking", 200))
        ),
    ),
)
