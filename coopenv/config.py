"""The one description of an environment, and the one place that reads keywords."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from importlib import import_module
from itertools import product
from typing import Any, Self

import numpy as np

from coopenv.arrays import FloatArray, finite_array, positive, whole
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import DEFAULT_BLOCKS, SENSING, Entry, Observation, find_blocks
from coopenv.observation.block import Block
from coopenv.observation.sensor import Sensor
from coopenv.partner import Partner
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene
from coopenv.randomisation import Ranges
from coopenv.rewards import RewardSum, find_reward
from coopenv.tasks import TASKS, Task, TransportTask
from coopenv.variations import Variations
from coopenv.wrench import Settings

ALIASES = ("max_episode_steps", "max_cycles")  # of the horizon: Gymnasium's word, PettingZoo's
ACTIONS = {"wrench": 3, "force": 2}  # name -> numbers an agent gives


@dataclass(frozen=True, slots=True, kw_only=True)
class TransportConfig:
    """Everything that defines a `coopenv.Transport` but its number of worlds.

    Parameters
    ----------
    task
        Start, goal and success.
    body, scene
        What is carried and where; a sequence gives each world its own, and all the bodies must
        have the same number of grips.
    reward
        A `coopenv.rewards.RewardSum`, one term, or the name of a preset.
    observe
        Names of observation blocks (`coopenv.observation.BLOCKS`) or `Block` objects, as they are
        or in a `coopenv.Sensor` that adds noise, a bias and a delay.
    sensing
        A word for ``observe``, which it sets: ``"own"``, what an agent feels and sees by itself,
        or ``"shared"``, that of its partners and the decomposition too; either with the blocks that
        the task brings. Reads ``None`` afterwards.
    action
        ``"wrench"`` (fx, fy, tz) or ``"force"`` (fx, fy), each in [−1, 1], agent frame.
    force_limit, torque_limit
        What an action of 1 stands for, one number or one an agent.
    horizon
        Control steps after which an episode is truncated.
    dt
        Control step [s]; the wrench is held in the object frame over it.
    substeps
        Physics steps in a control step (`docs/accuracy.md` has the table behind the default).
    decomposition
        Settings of the decomposition that observations, info and rewards use.
    informed
        Agents that are told the goal, by number; ``None``: all of them, as far as the task tells
        it. To the others the goal reads 0, and so does the ``known`` block.
    randomise
        What of body and team every episode draws anew, a `Ranges`; infos then say what was drawn,
        under ``body``. ``None``: nothing.
    partner
        Who drives some of the agents, so that the others learn with somebody: a
        `coopenv.partner.Partner`, or the name of one in `coopenv.agents.partners.PARTNERS`.
        Whatever ``informed`` says, it knows its own plan.
    partner_agents
        The agents it drives, by number; ``None``: the last one.

    Raises
    ------
    InvalidInput, UnknownName
        If a value breaks its rule; the message names it.
    """

    task: Task = field(default_factory=TransportTask)
    body: Body | Sequence[Body] = field(default_factory=Body)
    scene: Scene | Sequence[Scene] = field(default_factory=Scene)
    reward: RewardSum | str = "task"
    observe: Sequence[Entry] = DEFAULT_BLOCKS
    sensing: str | None = None
    action: str = "wrench"
    force_limit: float | Sequence[float] = 10.0  # [N]
    torque_limit: float | Sequence[float] = 5.0  # [N·m]
    horizon: int = 200  # [control steps]
    dt: float = 0.05  # [s]
    substeps: int = 2
    decomposition: Settings = field(default_factory=Settings)
    informed: Sequence[int] | None = None
    randomise: Ranges | None = None
    partner: Partner | str | None = None
    partner_agents: Sequence[int] | None = None

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "task", _task(self.task, TransportTask))
        _set(self, "body", _one_or_more(self.body, "body", Body))
        _set(self, "scene", _one_or_more(self.scene, "scene", Scene))
        _set(self, "reward", find_reward(self.reward))
        seen = _sensed(self.sensing, self.observe, self.task)
        _set(self, "observe", find_blocks(_with_blocks_of(self.task, seen)))
        _set(self, "sensing", None)
        if not isinstance(self.action, str) or self.action not in ACTIONS:
            raise UnknownName("action", self.action, ACTIONS)
        _set(self, "horizon", whole(self.horizon, "horizon", at_least=1))
        _set(self, "dt", positive(self.dt, "dt", unit="seconds"))
        _set(self, "substeps", whole(self.substeps, "substeps", at_least=1))
        _set(self, "decomposition", _built(self.decomposition, "decomposition", Settings))
        if self.randomise is not None:
            _set(self, "randomise", _built(self.randomise, "randomise", Ranges))
        _set(self, "partner", _partner(self.partner))
        self._check_agreement()

    @classmethod
    def parse(cls, keywords: Mapping[str, Any], defaults: Mapping[str, Any] | None = None) -> Self:
        """The configuration that ``keywords`` describe; an unknown name raises `UnknownName`.

        ``defaults`` stand for what the keywords leave out, unless these bring a task of another
        kind than theirs.

        ``max_episode_steps`` (Gymnasium's word) and ``max_cycles`` (PettingZoo's) stand for
        ``horizon`` and override it.
        """
        _check_one_sight(keywords)
        known = _filled(keywords, defaults or {})
        if keywords.get("sensing") is not None:  # what is given overrides the other's default
            known.pop("observe", None)
        elif "observe" in keywords:
            known.pop("sensing", None)
        for alias in ALIASES:
            steps = known.pop(alias, None)
            if steps is not None:
                known["horizon"] = steps
        names = {entry.name for entry in fields(cls)}
        for name in known:
            if name not in names:
                raise UnknownName("environment keyword", name, names)
        return cls(**known)

    @property
    def num_agents(self) -> int:
        """Effectors in every world."""
        return (self.body if isinstance(self.body, Body) else self.body[0]).num_agents

    @property
    def driven(self) -> tuple[int, ...]:
        """Agents that the partner drives; none without one."""
        if self.partner is None:
            return ()
        agents = self.partner_agents
        return (self.num_agents - 1,) if agents is None else tuple(agents)

    @property
    def learners(self) -> tuple[int, ...]:
        """Agents that nobody drives from inside: those who learn."""
        return tuple(agent for agent in range(self.num_agents) if agent not in self.driven)

    def bodies(self, num_worlds: int) -> tuple[Body, ...]:
        """One body a world."""
        return _spread(self.body, "body", num_worlds)

    def scenes(self, num_worlds: int) -> tuple[Scene, ...]:
        """One scene a world."""
        return _spread(self.scene, "scene", num_worlds)

    def limits(self) -> FloatArray:
        """``(agent, 2)``: force [N] and torque [N·m] that an action of 1 stands for."""
        limits = np.empty((self.num_agents, 2))
        limits[:, 0], limits[:, 1] = self.force_limit, self.torque_limit
        return limits

    def _check_agreement(self) -> None:
        bodies = (self.body,) if isinstance(self.body, Body) else tuple(self.body)
        scenes = (self.scene,) if isinstance(self.scene, Scene) else tuple(self.scene)
        counts = sorted({body.num_agents for body in bodies})
        if len(counts) > 1:
            raise InvalidInput(
                f"body.grips must be as many in every world, got {counts}; "
                "one batch holds teams of one size"
            )
        for name in ("force_limit", "torque_limit"):
            limit = _limit(getattr(self, name), name, self.num_agents)
            object.__setattr__(self, name, limit)
        object.__setattr__(self, "informed", _agents(self.informed, "informed", self.num_agents))
        Observation(self.observe, self.num_agents)  # raises where numbers and features do not match
        if self.randomise is not None:
            self._check_ranges(self.randomise, bodies, scenes)
        self._check_partner()
        for body, scene in set(_pairs(bodies, scenes)):
            self.task.check(body, scene)
        find_reward(self.reward).check(self.num_agents)

    def _check_partner(self) -> None:
        agents = _agents(self.partner_agents, "partner_agents", self.num_agents)
        object.__setattr__(self, "partner_agents", agents)
        if self.partner is None and agents is not None:
            raise InvalidInput(
                f"partner_agents must come with a partner, got {agents} without; "
                "pass for example partner='follower'"
            )
        if self.partner is not None and not (self.driven and self.learners):
            raise InvalidInput(
                f"partner_agents must name at least one of {self.num_agents} agents and leave at "
                f"least one to learn, got {self.driven}; change them, or give body another grip"
            )

    def _check_ranges(
        self, ranges: Ranges, bodies: Sequence[Body], scenes: Sequence[Scene]
    ) -> None:
        """Raise where the task cannot be done with what may be drawn."""
        for body in set(bodies):
            ranges.check(body)
        for body, scene in set(_pairs(bodies, scenes)):
            for extreme in Variations(ranges, body, self.limits()).extremes():
                try:
                    self.task.check(extreme, scene)
                except InvalidInput as error:
                    raise InvalidInput(
                        f"randomise must leave the task possible: {error}"
                    ) from error


def _sensed(sensing: str | None, observe: Sequence[Any], task: Task) -> Sequence[Any]:
    """The blocks that ``sensing`` and the task stand for, if it is given, else ``observe``."""
    if sensing is None:
        return observe
    if not isinstance(sensing, str) or sensing not in SENSING:
        raise UnknownName("sensing", sensing, SENSING)
    own = tuple(task.blocks)
    sets = (DEFAULT_BLOCKS, *SENSING.values())
    if observe not in (*sets, *((*names, *own) for names in sets)):  # else nobody chose it by hand
        _check_one_sight({"sensing": sensing, "observe": observe})
    return (*SENSING[sensing], *own)


def _check_one_sight(given: Mapping[str, Any]) -> None:
    if given.get("sensing") is not None and "observe" in given:
        raise InvalidInput(
            f"sensing must come without observe, got sensing={given['sensing']!r} beside "
            f"observe={given['observe']!r}; give one of them"
        )


def _filled(keywords: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """``keywords`` over ``defaults``, which are dropped where the task is of another kind."""
    if "task" not in keywords or "task" not in defaults:
        return {**defaults, **keywords}
    kind, task = type(defaults["task"]), keywords["task"]
    task = _task(task, kind)
    return {**(defaults if isinstance(task, kind) else {}), **keywords, "task": task}


def _task(value: Any, kind: type) -> Any:
    """The task itself, or the one that a mapping, the form in which JSON has it, describes.

    That is the package's task with exactly these fields, else one of ``kind``.
    """
    if isinstance(value, Mapping):
        exact = [task for task in TASKS if {entry.name for entry in fields(task)} == set(value)]
        return _built(value, "task", exact[0] if exact and kind not in exact else kind)
    if not isinstance(value, Task):
        made = isinstance(value, type) and issubclass(value, Task)
        remedy = f"pass {value.__name__}(...)" if made else "write class Mine(coopenv.Task)"
        raise InvalidInput(f"task must be a coopenv.Task, got {value!r}; {remedy}")
    return value


def _with_blocks_of(task: Task, observe: Any) -> Any:
    """``observe`` with the names of the task's own blocks, in sensors too, replaced by these."""
    own = {block.name: block for block in task.blocks}
    if not own or isinstance(observe, str) or not isinstance(observe, Sequence):
        return observe
    return tuple(_of_task(entry, own) for entry in observe)


def _of_task(entry: Any, own: Mapping[str, Block]) -> Any:
    """The task's block of that name, or in that sensor; anything else as it is."""
    if isinstance(entry, str):
        return own.get(entry, entry)
    if isinstance(entry, Sensor):
        return replace(entry, block=_of_task(entry.block, own))
    if isinstance(entry, Mapping) and isinstance(entry.get("block"), str):  # as JSON has a sensor
        return {**entry, "block": _of_task(entry["block"], own)}
    return entry


def _partner(value: Any) -> Any:
    """The partner of that name; anything else has to be one, or None."""
    if isinstance(value, str):  # names live with the agents, which the core imports on demand only
        return import_module("coopenv.agents.partners").find_partner(value)
    if value is not None and (isinstance(value, type) or not isinstance(value, Partner)):
        raise InvalidInput(
            f"partner must be a name or have a method player(config, num_worlds, agents), got "
            f"{value!r}; see coopenv.agents.partners"
        )
    return value


def _built(value: Any, name: str, kind: type) -> Any:
    """Build ``kind`` from a mapping, the form in which JSON brings a dataclass back."""
    if not isinstance(value, Mapping):
        if not isinstance(value, kind):
            raise InvalidInput(
                f"{name} must be a {kind.__name__}, got {value!r}; pass {kind.__name__}(...)"
            )
        return value
    known = [entry.name for entry in fields(kind)]
    for key in value:
        if key not in known:
            raise UnknownName(f"keyword of {name}", key, known)
    if kind is Scene:
        boxes = tuple(_built(box, "scene.obstacles", Box) for box in value.get("obstacles", ()))
        value = {**value, "obstacles": boxes}
    return kind(**value)


def _one_or_more(value: Any, name: str, kind: type) -> Any:
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not value:
            raise InvalidInput(f"{name} must not be empty, got {value!r}; give one, or one a world")
        return tuple(_built(entry, name, kind) for entry in value)
    return _built(value, name, kind)


def _spread(value: Any, name: str, num_worlds: int) -> tuple[Any, ...]:
    if not isinstance(value, tuple):
        return (value,) * num_worlds
    if len(value) != num_worlds:
        raise InvalidInput(
            f"{name} must be one, or one for each of the {num_worlds} worlds, got {len(value)}; "
            "repeat or drop entries"
        )
    return value


def _pairs(bodies: Sequence[Body], scenes: Sequence[Scene]) -> Iterable[tuple[Body, Scene]]:
    """Which body is in which scene; with one of either for all worlds, all combinations."""
    if len(bodies) == len(scenes):
        return zip(bodies, scenes, strict=True)
    return product(bodies, scenes)


def _limit(value: Any, name: str, num_agents: int) -> float | tuple[float, ...]:
    limits = finite_array(value, name)
    if limits.shape not in ((), (num_agents,)) or (limits <= 0).any():
        raise InvalidInput(
            f"{name} must be positive, one number or one for each of {num_agents} agents, "
            f"got {value!r}; a torque-free agent is action='force'"
        )
    return tuple(limits.tolist()) if limits.ndim else limits.item()


def _agents(value: Any, name: str, num_agents: int) -> tuple[int, ...] | None:
    """Numbers of agents, each once."""
    if value is None:
        return None
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise InvalidInput(
            f"{name} must be a sequence of agents' numbers, got {value!r}; pass for example (0,)"
        )
    agents = tuple(whole(agent, name, at_least=0) for agent in value)
    if len(set(agents)) < len(agents) or max(agents, default=0) >= num_agents:
        raise InvalidInput(
            f"{name} must name agents 0 to {num_agents - 1}, each once, got {agents}; "
            "drop what is not there"
        )
    return agents
