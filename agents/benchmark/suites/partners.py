"""Suite of partners that nobody trained with: other kinds, numbers, delays, plans, and policies.

What is entered may be trained beside anything but these: the ``population`` of
`coopenv.agents.partners` is what they are unlike.
"""

from typing import Any

from ...partners import (
    Compliant,
    Follower,
    Guiding,
    Impedance,
    Kind,
    Lagging,
    Leader,
    LearnedPartner,
    LoadSharing,
    Noisy,
    Population,
    Robot,
    Stubborn,
    Switching,
    Walking,
)
from ..scenario import Scenario, Suite

SEEN = {"population": Population()}  # for comparison
OTHER_NUMBERS: dict[str, Kind] = {  # than members of the population have
    "impedance, plans farther off": Impedance(offset=(0.6, 0.9), turn=(0.6, 0.9)),
    "leader, stronger": Leader(strength=3.0),
    "follower, heavier": Follower(heaviness=(0.75, 1.0)),
    "lagging, later": Lagging(delay=(6, 10)),
    "noisy, noisier": Noisy(force=(3.0, 5.0), torque=(1.5, 2.5)),
    "stubborn, plans farther off": Stubborn(offset=(0.6, 0.9), turn=(0.6, 0.9)),
    "load sharing, more": LoadSharing(share=(0.65, 0.85)),
    "switching, faster": Switching(mean_time=0.5),
}
OTHER_KINDS: dict[str, Kind] = {"walking": Walking(), "robot": Robot()}
HANDS: dict[str, Kind] = {"compliant, by hands": Compliant(), "guiding, by hands": Guiding()}
ELSEWHERE = ("BeamDoorway", "BeamTracking", "WalkerTurn")
POLICIES = (  # of the package, each in the environment that it learned in
    *("BeamTransport/joint", "BeamTransport/shared"),
    *("BeamDoorway/joint", "BeamTracking/joint", "WalkerTurn/joint"),
)
HAND = "scripted hand"
CROSS_PLAY = (HAND, *POLICIES[:2])  # scenarios of one environment, for the matrix


def _beside(name: str, partner: Any, env: str = "BeamTransport", **settings: Any) -> Scenario:
    return Scenario(name=name, env=env, settings={"partner": partner, **settings})


PARTNERS = Suite(
    name="partners",
    version=1,
    title="Beside partners that nobody trained with",
    scenarios=(
        *(_beside(name, kind) for name, kind in {**SEEN, **OTHER_NUMBERS, **OTHER_KINDS}.items()),
        *(_beside(name, kind, action="motion") for name, kind in HANDS.items()),
        *(_beside(f"walking, {env}", Walking(), env) for env in ELSEWHERE),
        _beside(HAND, Impedance()),
        *(
            _beside(name, LearnedPartner(path=f"pretrained:{name}"), name.partition("/")[0])
            for name in POLICIES
        ),
    ),
)
