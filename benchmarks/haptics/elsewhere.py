"""Scripted followers in the other environments, whose leader goes as their guide does.

With the straight way blocked, the leader is `Along`: its own hand as on the object that the
environment's scripted controller would move. Walkers are left out: what their wheels give across
is nobody's, and a hand at the centre of mass turns them by torque alone. So is the lift of 20 kg,
which is more than the limits bear.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

from rich.progress import track

from benchmarks.haptics.cells import EVALUATION
from benchmarks.pages import markdown
from coopenv import Body, TransportConfig
from coopenv.agents.controllers import find_guide
from coopenv.agents.controllers.active import ActiveFollower
from coopenv.agents.controllers.follower import Follower, Still, released
from coopenv.agents.controllers.roles import Roles
from coopenv.agents.controllers.straight import Along
from coopenv.agents.evaluate import Evaluation, evaluate
from coopenv.agents.policy import Policy
from coopenv.envs.registry import find_config

PLACES = {  # environment, mass [kg], how many times its horizon
    "BeamTransport": ((7.7, 1.0), (20.0, 1.5)),
    "BeamDoorway": ((7.7, 1.0), (20.0, 1.5)),
    "BeamTracking": ((7.7, 1.0), (20.0, 1.0)),
    "BeamLift": ((7.7, 1.0),),
}
FOLLOWERS: Mapping[str, Callable[[TransportConfig], Policy]] = {
    "lets go": Still,
    "gives way": Follower,
    "assists": ActiveFollower,
    "is told": lambda config: Along(config, find_guide(config)),
}


def environment(name: str, mass: float, longer: float) -> TransportConfig:
    """The environment with hands and a beam of that mass; agent 0 alone is told."""
    plain = find_config(f"coopenv/{name}-v0", {"action": "motion"})
    assert isinstance(plain.body, Body)
    body = replace(plain.body, mass=mass, inertia=None)
    return replace(plain, body=body, informed=(0,), horizon=round(longer * plain.horizon))


def measure(config: TransportConfig, follower: str, episodes: int) -> Evaluation:
    """Held-out episodes of a follower beside the leader."""
    held = released(config, (1,)) if follower == "lets go" else config
    leader = Along(held, find_guide(held))
    team = Roles(held, {0: leader, 1: FOLLOWERS[follower](held)})
    return evaluate(team, held, episodes=episodes, seed=EVALUATION)


def table(episodes: int) -> str:
    """Success, time and γ of every follower in every place, as Markdown."""
    cells = [
        (name, mass, longer, follower)
        for name, masses in PLACES.items()
        for mass, longer in masses
        for follower in FOLLOWERS
    ]
    rows = []
    for name, mass, longer, follower in track(cells, "elsewhere"):
        seen = measure(environment(name, mass, longer), follower, episodes)
        low, high = seen.success_interval
        success = f"{100 * seen.success_rate:.1f} [{100 * low:.1f}, {100 * high:.1f}]"
        taken = f"{seen.success_time:.1f}" if seen.success_rate else "–"
        rows.append([name, f"{mass:g} kg", follower, success, taken, f"{seen.relative_cost:.3f}"])
    return markdown(("environment", "beam", "follower", "success [%]", "time [s]", "γ"), rows)
