"""Configuration of an environment: one description for every view."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from coopenv.arrays import FloatArray, positive, whole
from coopenv.config.actuators import actuators_for
from coopenv.config.agreement import (
    check_partner,
    check_ranges,
    check_strength,
    check_task,
    check_team_size,
)
from coopenv.config.described import Described
from coopenv.config.hands import BY_HANDS, check_integrable, check_senses, hands_for
from coopenv.config.keywords import (
    built,
    one_or_more,
    read_agents,
    read_flag,
    read_limit,
    read_observe,
    read_partner,
    read_task,
)
from coopenv.config.worlds import each, spread
from coopenv.errors import UnknownName
from coopenv.observation import DEFAULT_BLOCKS, Entry
from coopenv.observation.bounds import Bounds
from coopenv.partner import Partner
from coopenv.physics.actuators import Actuators
from coopenv.physics.body import Body
from coopenv.physics.hands import Hands
from coopenv.physics.scene import Scene
from coopenv.pushes import read_pushes, table_of
from coopenv.randomisation import Ranges
from coopenv.rewards import RewardSum, find_cost, find_reward
from coopenv.tasks import Task, TransportTask
from coopenv.wrench import Settings

# name -> numbers of an agent's action
ACTIONS = {"wrench": 3, "force": 2, "discrete": 3, "motion": 3, "impedance": 5}

LONGEST_HORIZON = 10**9  # [control steps]
STEPS = 1e-9, 1e4  # [s], shortest and longest
MOST_SUBSTEPS = 10**4  # with more, a control step of one world takes a second


@dataclass(frozen=True, slots=True, kw_only=True)
class TransportConfig(Described):
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
    cost
        What is to be bounded rather than traded against the reward, told in the infos: the same,
        or a name of `coopenv.rewards.COSTS`. What a term takes costs, so a penalty costs as much
        here as it takes from a reward. ``None``: nothing.
    observe
        Names of observation blocks (`coopenv.observation.BLOCKS`) or `Block` objects, as they are
        or in a `coopenv.Sensor` that adds noise, a bias and a delay.
    sensing
        A word for ``observe``, which it sets: ``"own"``, what an agent feels and sees by itself,
        or ``"shared"``, that of its partners and the decomposition too; either with the blocks that
        the task brings, and with what hands feel where these carry out the actions. Reads ``None``
        afterwards.
    bounded
        Whether every feature of the observation has a finite bound, from room, limits, drag and
        horizon. A reading beyond it is clipped, and ``info["observation_clipped"]`` says so.
    action
        ``"wrench"`` (fx, fy, tz) or ``"force"`` (fx, fy), each in [−1, 1], agent frame; or
        ``"discrete"``, the number of one of ``pushes``. ``"motion"`` (vx, vy, ω) moves a hand that
        holds its grip through springs and dampers, and ``"impedance"`` has two numbers more, how
        stiff and how damped they are in this step.
    pushes
        What an agent can choose from if its actions are discrete: the name of a table in
        `coopenv.pushes.PUSHES`, or rows (fx, fy, tz) in [−1, 1], agent frame.
    hands
        Springs and dampers with ``action="motion"`` or ``"impedance"``, a `Hands`; ``None``: the
        default ones, if there are to be any.
    actuators
        Delay, lag and rate limit behind every agent's action, a partner's too, an `Actuators`;
        ``None``: none, unless ``randomise`` draws some.
    force_limit, torque_limit
        What an action of 1 stands for, one number or one an agent; and the most that hands give.
    horizon
        Control steps after which an episode is truncated.
    dt
        Control step [s]; the wrench is held in the object frame over it, the velocity of a hand in
        the world.
    substeps
        Physics steps in a control step (`docs/accuracy.md` has the table behind the default).
    decomposition
        Settings of the decomposition that observations, info and rewards use.
    informed
        Agents that are told the goal, by number; ``None``: all of them, as far as the task tells
        it. To the others the goal reads 0, and so does the ``known`` block.
    randomise
        What episodes draw anew of body, team and gravity, a `Ranges`; infos then say what it was,
        under ``body``. ``None``: nothing.
    partner
        Who drives some of the agents, so that the others learn with somebody: a
        `coopenv.partner.Partner`, the name of one in `coopenv.agents.partners.PARTNERS`, the file
        of a trained policy (`coopenv.agents.partners.LearnedPartner`), or anything that is called
        as a `coopenv.agents.policy.Policy` (`coopenv.agents.partners.PolicyPartner`). Whatever
        ``informed`` says, a scripted one knows its own plan; a policy is told what its agents are.
    partner_agents
        The agents it drives, by number; ``None``: those that the task names, which is the last
        one of a beam, and of a walker the human.

    Raises
    ------
    InvalidInput, UnknownName
        If a value breaks its rule; the message names it.
    """

    task: Task = field(default_factory=TransportTask)
    body: Body | Sequence[Body] = field(default_factory=Body)
    scene: Scene | Sequence[Scene] = field(default_factory=Scene)
    reward: RewardSum | str = "task"
    cost: RewardSum | str | None = None
    observe: Sequence[Entry] = DEFAULT_BLOCKS
    sensing: str | None = None
    bounded: bool = False
    action: str = "wrench"
    pushes: Sequence[Sequence[float]] | str = "axes"
    hands: Hands | None = None
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
    actuators: Actuators | None = None

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "task", read_task(self.task))
        _set(self, "body", one_or_more(self.body, "body", Body))
        _set(self, "scene", one_or_more(self.scene, "scene", Scene))
        _set(self, "reward", find_reward(self.reward))
        if self.cost is not None:
            _set(self, "cost", find_cost(self.cost))
        if not isinstance(self.action, str) or self.action not in ACTIONS:
            raise UnknownName("action", self.action, ACTIONS)
        by_hands = self.action in BY_HANDS
        observe = read_observe(self.sensing, self.observe, self.task, by_hands=by_hands)
        _set(self, "observe", observe)
        _set(self, "sensing", None)
        _set(self, "pushes", read_pushes(self.pushes))
        _set(self, "bounded", read_flag(self.bounded, "bounded"))
        _set(self, "horizon", whole(self.horizon, "horizon", at_least=1, at_most=LONGEST_HORIZON))
        _set(self, "dt", positive(self.dt, "dt", unit="s", at_least=STEPS[0], at_most=STEPS[1]))
        _set(self, "substeps", whole(self.substeps, "substeps", at_least=1, at_most=MOST_SUBSTEPS))
        _set(self, "decomposition", built(self.decomposition, "decomposition", Settings))
        if self.randomise is not None:
            _set(self, "randomise", built(self.randomise, "randomise", Ranges))
        hands = None if self.hands is None else built(self.hands, "hands", Hands)
        _set(self, "hands", hands_for(self.action, hands, self.randomise))
        if self.actuators is not None:
            _set(self, "actuators", built(self.actuators, "actuators", Actuators))
        _set(self, "partner", read_partner(self.partner))
        self._read_team()
        self._check_agreement()

    @property
    def num_agents(self) -> int:
        """Effectors in every world."""
        return each(self.body)[0].num_agents

    @property
    def driven(self) -> tuple[int, ...]:
        """Agents that the partner drives; none without one."""
        if self.partner is None:
            return ()
        agents = self.partner_agents
        return self.task.partner_agents(self.num_agents) if agents is None else tuple(agents)

    @property
    def learners(self) -> tuple[int, ...]:
        """Agents that nobody drives from inside: those who learn."""
        return tuple(agent for agent in range(self.num_agents) if agent not in self.driven)

    def bodies(self, num_worlds: int) -> tuple[Body, ...]:
        """One body a world."""
        return spread(self.body, "body", num_worlds)

    def scenes(self, num_worlds: int) -> tuple[Scene, ...]:
        """One scene a world."""
        return spread(self.scene, "scene", num_worlds)

    def limits(self) -> FloatArray:
        """``(agent, 2)``: force [N] and torque [N·m] that an action of 1 stands for."""
        limits = np.empty((self.num_agents, 2))
        limits[:, 0], limits[:, 1] = self.force_limit, self.torque_limit
        return limits

    def strengths(self) -> FloatArray:
        """``(agent, column)``: `limits`, and the tables of hands and of actuators if there are any.

        `coopenv.physics.strengths` says which column is what.
        """
        there = [each for each in (self.hands, self.actuators) if each is not None]
        tables = [each.table(self.num_agents) for each in there]
        return np.concatenate([self.limits(), *tables], axis=1)

    @property
    def terms(self) -> RewardSum:
        """The reward as a sum of named terms, in whichever form it was given."""
        return cast(RewardSum, self.reward)  # read when the configuration was made

    @property
    def costs(self) -> RewardSum | None:
        """The cost as a sum of named terms, in whichever form it was given; ``None`` without."""
        return cast(RewardSum | None, self.cost)

    @property
    def table(self) -> FloatArray | None:
        """``(push, 3)``: what the numbers of discrete actions stand for; ``None`` without them."""
        return table_of(self.pushes) if self.action == "discrete" else None

    def bounds(self) -> Bounds | None:
        """What bounds the observations, if they are to be ``bounded``."""
        if not self.bounded:
            return None
        bodies, scenes = each(self.body), each(self.scene)
        softest = (
            1.0 if self.action != "impedance" else cast(Hands, self.hands).stiffness_factors[0]
        )
        return Bounds.of(
            bodies,
            scenes,
            self.strengths(),
            self.randomise,
            self.horizon * self.dt,
            dt=self.dt,
            softest=softest,
        )

    def _read_team(self) -> None:
        """Read what depends on the number of agents."""
        check_team_size(each(self.body))
        _set, count = object.__setattr__, self.num_agents
        for name in ("force_limit", "torque_limit"):
            _set(self, name, read_limit(getattr(self, name), name, count))
        for name in ("informed", "partner_agents"):
            _set(self, name, read_agents(getattr(self, name), name, count))
        _set(self, "actuators", actuators_for(self.actuators, self.randomise, count))

    def _check_agreement(self) -> None:
        """Raise where fields that are right by themselves do not go together."""
        bodies, scenes, count = each(self.body), each(self.scene), self.num_agents
        if self.hands is not None:
            self.hands.check(count)
        if self.randomise is not None:
            check_ranges(self.randomise, self.task, bodies, scenes, self.strengths())
        read_agents(self.driven, "partner_agents of the task", count)
        check_partner(self.partner, self.partner_agents, self.driven, count)
        if self.hands is not None:
            check_integrable(
                self.hands,
                self.action,
                list(dict.fromkeys(bodies)),
                self.strengths(),
                self.randomise,
                self.dt,
                self.substeps,
            )
        check_senses(self.hands, self.observe, reward=self.terms, cost=self.costs)
        check_task(self.task, bodies, scenes)
        check_strength(self.task, bodies, scenes, self.strengths(), self.randomise)
        for terms in (self.terms, self.costs):
            if terms is not None:
                terms.check(count)
