"""Worlds of one configuration: how episodes begin in them, and one control step of all."""

from threading import RLock
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, whole, with_rows
from coopenv.compiled.parallel import cores
from coopenv.conditions import Conditions, Team
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.geometry import frames
from coopenv.info import CLIPPED, Info, cost_info, start_info, step_info, with_worlds
from coopenv.observation import Observation
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.physics.surroundings import WHEEL
from coopenv.physics.world import World
from coopenv.pushes import pushed
from coopenv.resets import Draws
from coopenv.snapshot import generator_states, put_generators, take_rows
from coopenv.stepping.actuation import behind_actuators
from coopenv.stepping.driven import driven_agents, read_action
from coopenv.stepping.handling import handling_of
from coopenv.tasks.episodes import Episodes
from coopenv.transition import State, Transition

MOST_WORLDS = 10**6  # more take hours to make, and more memory than there is
MOST_THREADS = 1024
WORTH_A_THREAD = 256  # worlds; fewer gain nothing from another one


class SteppedWorlds:
    """What is stepped, and how; `coopenv.Transport` is what callers have of it.

    Its methods hand out the worlds' own arrays, which nobody else may change.
    """

    def __init__(
        self,
        *,
        num_worlds: int = 1,
        config: TransportConfig | None = None,
        threads: int | None = None,
        **keywords: Any,
    ):
        if config is not None and keywords:
            raise InvalidInput(
                f"config must come alone, got also {sorted(keywords)}; "
                "change it with dataclasses.replace"
            )
        self.config = config if config is not None else TransportConfig.parse(keywords)
        self.num_worlds = whole(num_worlds, "num_worlds", at_least=1, at_most=MOST_WORLDS)
        self.threads = threads_for(self.num_worlds) if threads is None else _threads(threads)
        self.num_agents = self.config.num_agents
        self.learners = self.config.learners
        self.action_size = ACTIONS[self.config.action]
        self.dt, self.substeps = self.config.dt, self.config.substeps
        self.horizon = self.config.horizon
        self.table = self.config.table
        shape = self.num_worlds, len(self.learners)
        self.action_shape = shape if self.table is not None else (*shape, self.action_size)
        self.reward, self.cost = self.config.terms, self.config.costs
        self.observation = Observation(
            self.config.observe, self.num_agents, self.num_worlds, self.config.bounds()
        )
        self._draws = Draws(self.config, self.num_worlds)
        self.conditions = self._draws.first()
        self.team.decomposer()  # raises here rather than in a step
        self.world = World(
            self.bodies,
            self.scenes,
            dt=self.dt,
            substeps=self.substeps,
            reach=self._draws.reach,
        )
        self.driven = driven_agents(self.config, self.num_worlds)
        has_hand = self.driven.have_hands(self.num_agents)
        handling = handling_of(self.config, self.num_worlds, has_hand)
        self.handling = behind_actuators(handling, self.config, self.num_worlds)
        self.generators: list[np.random.Generator | None] = [None] * self.num_worlds
        self.transition: Transition | None = None
        self._task, self._has_moving_goal = self.config.task, self.config.task.moves
        self._episodes = Episodes(self._task, self.num_worlds, dt=self.dt, horizon=self.horizon)
        self._obs = np.zeros((0,), dtype=np.float32)
        self._info = Info()
        self.turn = RLock()

    @property
    def bodies(self) -> tuple[Body, ...]:
        """What is carried, one a world."""
        return self.conditions.bodies

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """Where, one a world."""
        return self.conditions.scenes

    @property
    def team(self) -> Team:
        """Who carries."""
        return self.conditions.team

    def _begin(
        self, worlds: IntArray, conditions: Conditions, pose: FloatArray, goal: FloatArray
    ) -> None:
        """Start an episode in ``worlds``; ``conditions`` are those of all worlds from now on."""
        self.conditions = conditions
        before, self.transition = self.transition, None  # until this is done, no step may follow
        start = self._start(worlds, pose, goal)
        seen, clipped = self.observation.read(start, worlds)
        obs = self.driven.of_learners(seen)
        info = start_info(start, self.reward, len(self.learners), self.cost)
        if clipped is not None:
            info[CLIPPED] = clipped
        self.driven.begin(worlds, self.generators, start)
        if before is None or len(worlds) == self.num_worlds:
            self.transition = start
        else:
            self.transition = before.with_worlds(worlds, start, self.conditions)
            obs = with_rows(self._obs, worlds, obs)
            info = with_worlds(Info({name: self._info[name] for name in info}), worlds, info)
        facts = self._facts(self.transition)
        if facts:
            info.update(facts)
        self._obs, self._info = obs, info

    def _facts(self, transition: Transition) -> dict[str, Any]:
        """What a partner tells: copies, since infos are read later and it may be its own memory."""
        told = self.driven.info(transition)
        return {name: fact.copy() for name, fact in told.items()} if told else told

    def _parts(self, worlds: IntArray) -> dict[str, Any]:
        """All that decides how ``worlds`` go on, one row each."""
        assert self.transition is not None
        return {
            "conditions": self.conditions.get_state(worlds),
            "world": self.world.get_state(worlds),
            "handling": self.handling.get_state(worlds),
            "episodes": self._episodes.get_state(worlds),
            "transition": self.transition.get_state(worlds),
            "partner": self.driven.get_state(worlds),
            "observation": self.observation.get_state(worlds),
            "generators": generator_states(self.generators, worlds),
            "obs": self._obs[worlds],
            "info": take_rows(dict(self._info), worlds),
        }

    def _go_on(self, worlds: IntArray, parts: dict[str, Any]) -> None:
        """Go on in ``worlds`` from what `_parts` returned."""
        bodies, scenes = parts["conditions"]["bodies"], parts["conditions"]["scenes"]
        self.world.check_rooms(worlds, scenes)
        before, self.transition = self.transition, None  # until this is done, no step may follow
        self.conditions = self.conditions.with_state(parts["conditions"], worlds)
        self.world.set_state(parts["world"], worlds, bodies, scenes, anew=before is None)
        self.handling.set_state(parts["handling"], worlds)
        self._episodes.set_state(parts["episodes"], worlds)
        self.driven.set_state(parts["partner"], worlds)
        self.observation.set_state(parts["observation"], worlds)
        put_generators(self.generators, parts["generators"], worlds)
        obs, info = parts["obs"], Info(parts["info"])
        if before is not None and len(worlds) < self.num_worlds:
            obs, info = with_rows(self._obs, worlds, obs), with_worlds(self._info, worlds, info)
        self.transition = Transition.restored(
            parts["transition"],
            self.conditions,
            beside=before,
            worlds=worlds,
            dt=self.dt,
            horizon=self.horizon,
        )
        self._obs, self._info = obs, info

    def _step(
        self, action: npt.ArrayLike, restart: BoolArray | None
    ) -> tuple[FloatArray, BoolArray, BoolArray]:
        """Go on by one control step; rewards ``(world, learner)``, terminated and truncated."""
        before = self._running(restart)
        joint = self._joint(action, before, restart)
        self.transition = None  # from the middle of a step no episode goes on
        given = self.handling.move(self.world, joint, self.team)
        next_state, success, terminated, truncated = self._episodes.arrive(
            self.conditions, self.world.pose, self.world.twist, before.next_state.goal
        )
        self.transition = transition = Transition.of_step(
            state=before.next_state,
            next_state=next_state,
            conditions=self.conditions,
            action=given.action,
            previous_action=before.action,
            applied=given.applied,
            contact_impulse=self.world.contact_impulse,
            contact_shift=self.world.contact_shift,
            surroundings_wrench=self.world.given[:, :3],
            wheel_force=self.world.given[:, WHEEL],
            success=success,
            terminated=terminated,
            truncated=truncated,
            dt=self.dt,
            horizon=self.horizon,
            stretch=given.stretch,
            felt_wrench=given.felt_wrench,
            stored_energy=given.stored_energy,
        )
        driven = self.driven
        reward, parts = self.reward(transition)
        reward = driven.of_learners(reward)
        seen, clipped = self.observation.read(transition)
        self._obs = driven.of_learners(seen)
        more: dict[str, Any] = {}
        if self.cost is not None:
            taken, costs = self.cost(transition, what="cost")
            more = cost_info(driven.of_learners(taken), driven.terms_of_learners(costs))
        if clipped is not None:
            more[CLIPPED] = clipped
        facts = self._facts(transition)
        if facts:
            more.update(facts)
        self._info = step_info(transition, driven.terms_of_learners(parts), more)
        return reward, terminated, truncated

    def _running(self, restart: BoolArray | None) -> Transition:
        """The last transition; raises `ResetNeeded` unless a step may follow in every world."""
        if self.transition is None:
            raise ResetNeeded(
                "reset must be called before the first step and after a call that broke off, got "
                "a step; call reset()"
            )
        self._episodes.check_running(restart)
        return self.transition

    def _joint(
        self, action: npt.ArrayLike, before: Transition, restart: BoolArray | None
    ) -> FloatArray:
        """Actions of all agents ``(world, agent, a)``, finite."""
        if self.table is None:
            given = read_action(action, self.action_shape, restart)
        else:
            given = pushed(action, self.action_shape, self.table, restart)
        return self.driven.joint(given, before, restart)

    def _start(self, worlds: IntArray, pose: FloatArray, goal: FloatArray) -> Transition:
        """Put ``worlds`` at the start of an episode; the transition that led to nothing yet."""
        count = len(worlds)
        conditions = self.conditions
        if count < self.num_worlds:
            conditions = conditions.take(worlds)
        if self._draws.changing:
            self.world.furnish(worlds, conditions.bodies, conditions.scenes)
        self.world.place(worlds, pose)
        self.handling.begin(worlds, pose, conditions.team)
        self._episodes.begin(worlds)
        pose, goal = (  # steps alone are worth a kernel
            np.column_stack((one[:, :2], frames.wrapped(one[:, 2]))) for one in (pose, goal)
        )
        state = State(
            pose=pose,
            twist=np.zeros((count, 3)),
            goal=goal,
            distance=self._task.way(conditions.plan, pose, goal),
            time=np.zeros(count),
        )
        return Transition.start(
            state,
            conditions,
            action_size=self.action_size,
            dt=self.dt,
            horizon=self.horizon,
        )


def threads_for(num_worlds: int) -> int:
    """How many threads step so many worlds fastest: one a core, if each has enough to do."""
    return min(cores(), max(1, num_worlds // WORTH_A_THREAD))


def _threads(given: int) -> int:
    return whole(given, "threads", at_least=1, at_most=MOST_THREADS)
