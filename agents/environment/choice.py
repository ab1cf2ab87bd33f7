"""Choice of an environment: its id, and what is changed of it from the command line or a file."""

from dataclasses import asdict, dataclass, fields, replace
from typing import Annotated, Any, Literal

from coopenv.config import TransportConfig
from coopenv.envs import registry
from coopenv.errors import InvalidInput
from coopenv.observation.observation import find_block
from coopenv.rewards import COSTS

from .overrides import GROUPS, changed, entries_of

try:
    import tyro
except ImportError:  # then the command line says what is missing
    _COST: Any = None
else:
    _COST = tyro.conf.arg(
        help=f"What is told as a cost beside the reward: {', '.join(COSTS)} "
        "(coopenv.rewards.COSTS), or a preset."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvironmentChoice:
    """An environment by name, and what is most often changed of it; ``None`` keeps its own."""

    env: str = "coopenv/BeamTransport-v0"
    """Gymnasium id."""
    reward: str | None = None
    """Preset of coopenv.rewards: task, harmony, balanced, sparse, tracking."""
    cost: Annotated[str | None, _COST] = None
    observe: tuple[str, ...] | None = None
    """Observation blocks, for example: goal twist own_wrench."""
    also_observe: tuple[str, ...] | None = None
    """Blocks beside those that the environment has, or that observe or sensing says: near_goal.
    None: no others, but in a training those that its id needs, unless observe or sensing says."""
    sensing: Literal["own", "shared"] | None = None
    """Instead of observe: what an agent senses by itself, or the partners' senses too."""
    bounded: bool | None = None
    """Whether every feature has a finite bound, to which readings are clipped."""
    action: Literal["wrench", "force", "discrete", "motion", "impedance"] | None = None
    """What an agent gives: forces and torque, forces alone, the number of a push, the velocity of a
    hand that gives way, or that and how stiff and damped the hand is."""
    pushes: str | None = None
    """Which pushes there are for discrete actions: axes, fine, compass, grid."""
    horizon: int | None = None
    """Control steps after which an episode is truncated."""
    partner: str | None = None
    """Who drives the last agent of a beam, or the human of a walker: impedance, leader, follower,
    lagging, noisy, stubborn, load_sharing, switching, population, walking, robot, and with motions
    compliant, guiding (coopenv.agents.partners), or the file of a trained policy:
    path/policy.zip, or pretrained:BeamTransport/joint and the like."""

    team: int | None = None
    """How many agents hold the body, evenly round its rim; the default beam becomes a plate."""
    body: tuple[str, ...] = ()
    """Numbers of the body: mass=4 linear_drag=2 "grips=[[-0.9, 0], [0.9, 0]]"."""
    scene: tuple[str, ...] = ()
    """Of the room: size=[8,6] friction=0.5."""
    task: tuple[str, ...] = ()
    """Of the task, its tolerances for example: position_tolerance=0.1."""
    randomise: tuple[str, ...] = ()
    """What every episode draws anew, lowest and highest: mass=[4,9]."""
    hands: tuple[str, ...] = ()
    """Of hands, with action motion or impedance: stiffness=200 speed=0.5."""
    actuators: tuple[str, ...] = ()
    """Of what lies behind every action: delay=2 time_constant=0.1 rate_limit=5."""
    weights: tuple[str, ...] = ()
    """Of the reward's terms: progress=5 relative_cost=0.3."""

    def __post_init__(self) -> None:
        for name in GROUPS:
            object.__setattr__(self, name, entries_of(getattr(self, name), name))
        if isinstance(self.also_observe, str):
            raise InvalidInput(
                f"also_observe must be a list of blocks, got {self.also_observe!r}; write "
                f"[{self.also_observe!r}]"
            )

    def config(self) -> TransportConfig:
        """The environment's whole configuration.

        Raises
        ------
        UnknownName
            If the id, the preset or a block does not exist.
        """
        return self._changed(find_config(self.env, self._given()))

    def over(self, config: TransportConfig) -> TransportConfig:
        """``config`` with what this choice names but its id.

        Raises
        ------
        InvalidInput, UnknownName
            If the preset or a block does not exist, or does not go with the rest.
        """
        rest = {entry.name: getattr(config, entry.name) for entry in fields(config)}
        if self.action not in (None, config.action):
            rest["hands"] = None  # those of an action that is given up
        return self._changed(TransportConfig.parse(self._given(), rest))

    def _given(self) -> dict[str, Any]:
        return {
            name: value
            for name, value in asdict(self).items()
            if name not in ("env", "also_observe", "team", *GROUPS) and value is not None
        }

    def _changed(self, config: TransportConfig) -> TransportConfig:
        groups = {name: getattr(self, name) for name in GROUPS}
        made = changed(config, groups, team=self.team)
        there = {find_block(entry).name for entry in made.observe}
        more = tuple(name for name in self.also_observe or () if name not in there)
        return replace(made, observe=(*made.observe, *more)) if more else made

    def over_file(self, file: "EnvironmentChoice") -> "EnvironmentChoice":
        """Take the numbers of body, scene and so on in ``file`` that are not given here."""
        groups = {name: (getattr(file, name), getattr(self, name)) for name in GROUPS}
        return replace(
            self,
            **{
                name: own if own == theirs else (*theirs, *own)
                for name, (theirs, own) in groups.items()
            },
        )


def find_config(env: str | TransportConfig, keywords: dict[str, Any]) -> TransportConfig:
    """The configuration behind a Gymnasium id and keywords, or the one that is given."""
    if isinstance(env, TransportConfig):
        if keywords:
            raise InvalidInput(
                f"env must be an id to take keywords, got a configuration beside "
                f"{sorted(keywords)}; change it with dataclasses.replace"
            )
        return env
    return registry.find_config(env, keywords)
