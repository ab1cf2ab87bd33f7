"""The core of every environment: many worlds reset and stepped together."""

from collections.abc import Sequence
from threading import RLock
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, booleans, whole, with_rows
from coopenv.conditions import Team
from coopenv.config import ACTIONS, TransportConfig
from coopenv.driven import driven_agents, read_action
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.geometry import frames
from coopenv.info import CLIPPED, Info, copied, cost_info, start_info, step_info, with_worlds
from coopenv.observation import Observation
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.physics.threads import one_thread_at_a_time
from coopenv.physics.world import World
from coopenv.pushes import pushed
from coopenv.resets import (
    Draws,
    Seed,
    all_or_nothing,
    check_free,
    given_pose,
    marked_worlds,
    seed_worlds,
)
from coopenv.snapshot import (
    VERSION,
    Snapshot,
    chosen_worlds,
    fitting,
    generator_states,
    put_generators,
    take_rows,
)
from coopenv.tasks.episodes import Episodes
from coopenv.transition import State, Transition
from coopenv.wrench.grasp import sum_at_centre

MOST_WORLDS = 10**6  # more take hours to make, and more memory than there is


class Transport:
    """A batch of worlds in which a team carries an object; numpy in and out, no autoreset.

    It belongs to one thread at a time.

    Parameters
    ----------
    num_worlds
        Worlds stepped together.
    config
        What they are; instead of it, any field of `TransportConfig` as a keyword.

    Attributes
    ----------
    config, world, observation
        The description, the physics, the observation layout.
    conditions
        Bodies, scenes, team and plans of the episodes under way.
    dt, substeps, horizon, num_worlds, num_agents, action_size
        Read from the configuration; ``action_size`` is how many numbers make a push.
    table
        ``(push, 3)``: the pushes that discrete actions are numbers of; ``None`` without these.
    action_shape
        Of the actions of a step: ``(world, learner, action_size)``, or ``(world, learner)`` if they
        are numbers of pushes.
    learners
        Numbers of the agents that actions, observations and rewards are of, in this order: all,
        or those that ``config.partner`` does not drive. Infos are of all agents, but reward terms
        and cost.
    transition
        The last step, or the start; ``None`` before the first reset, and after a step or a reset
        that broke off in the middle.
    generators
        One `numpy.random.Generator` a world, going on from episode to episode.
    turn
        Held by the thread that steps or resets.

    Examples
    --------
    >>> core = Transport(num_worlds=256)
    >>> obs, info = core.reset(seed=0)
    >>> obs.shape
    (256, 2, 22)
    >>> action = np.zeros((256, 2, 3))
    >>> obs, reward, terminated, truncated, info = core.step(action)
    >>> reward.shape, terminated.shape
    ((256, 2), (256,))
    """

    def __init__(
        self, *, num_worlds: int = 1, config: TransportConfig | None = None, **keywords: Any
    ):
        if config is not None and keywords:
            raise InvalidInput(
                f"config must come alone, got also {sorted(keywords)}; "
                "change it with dataclasses.replace"
            )
        self.config = config if config is not None else TransportConfig.parse(keywords)
        self.num_worlds = whole(num_worlds, "num_worlds", at_least=1, at_most=MOST_WORLDS)
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
        self.team.decomposer(self.config.decomposition)  # raises here rather than in a step
        self.world = World(
            self.bodies,
            self.scenes,
            dt=self.dt,
            substeps=self.substeps,
            reach=self._draws.reach,
        )
        self.driven = driven_agents(self.config, self.num_worlds)
        self.generators: list[np.random.Generator | None] = [None] * self.num_worlds
        self.transition: Transition | None = None
        self._task, self._has_moving_goal = self.config.task, self.config.task.moves
        self._episodes = Episodes(self._task, self.num_worlds, dt=self.dt, horizon=self.horizon)
        self._obs = np.zeros((0,), dtype=np.float32)
        self._info = Info()
        self.turn = RLock()

    def __reduce__(self):
        """Copies and pickles are another core of the configuration, in the state of this one.

        One that was not reset yet, or broke off, is as good as new.
        """
        made = _made, (type(self), self.num_worlds, self.config)
        return made if self.transition is None else (*made, self.get_state())

    def __setstate__(self, state: Snapshot) -> None:
        self.set_state(state)

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

    @one_thread_at_a_time
    def get_state(self, worlds: Sequence[int] | IntArray | None = None) -> Snapshot:
        """All that decides how episodes go on; `set_state` puts it back, here or elsewhere.

        Parameters
        ----------
        worlds
            Numbers of the worlds whose state is wanted, in this order; ``None``: all.

        Returns
        -------
        A copy, which no step changes.

        Raises
        ------
        InvalidInput
            If there is no such world, or the partner's player cannot tell what it remembers
            (`coopenv.partner.StatefulPlayer`).
        ResetNeeded
            Before the first reset, or if the last step or reset broke off.
        CoreInUse
            If another thread steps or resets the core.
        """
        chosen = chosen_worlds(worlds, self.num_worlds)
        if self.transition is None:
            raise ResetNeeded(
                "reset must be called before get_state and after a call that broke off, got no "
                "episode under way; call reset()"
            )
        parts = {
            "conditions": self.conditions.get_state(chosen),
            "world": self.world.get_state(chosen),
            "episodes": self._episodes.get_state(chosen),
            "transition": self.transition.get_state(chosen),
            "partner": self.driven.get_state(chosen),
            "observation": self.observation.get_state(chosen),
            "generators": generator_states(self.generators, chosen),
            "obs": self._obs[chosen],
            "info": take_rows(dict(self._info), chosen),
        }
        return Snapshot(config=self.config, version=VERSION, parts=parts)

    @one_thread_at_a_time
    def set_state(
        self, state: Snapshot, worlds: Sequence[int] | IntArray | None = None
    ) -> tuple[npt.NDArray[np.float32], Info]:
        """Go on from a state that `get_state` returned, in all worlds or in some.

        From there the same actions lead to the same bits, if the worlds are those that it was taken
        from and nothing is touched; `docs/state.md` says what holds elsewhere. Episodes that begin
        later are the same too, as the generators are put back with it.

        Parameters
        ----------
        state
            Of this core, or of another with an equal configuration and any number of worlds.
        worlds
            Numbers of the worlds that it is for, in its order; ``None``: all. A state of one world
            is put into each of them.

        Returns
        -------
        Observations and infos of all worlds, as `reset` and `step` return them.

        Raises
        ------
        InvalidInput
            If the state does not fit: it is of another configuration or version, of another number
            of worlds, or of a room that differs from that of its new world; or if a world is left
            that never started.
        CoreInUse
            If another thread steps or resets the core.
        """
        chosen = chosen_worlds(worlds, self.num_worlds, different=True)
        if self.transition is None and len(chosen) < self.num_worlds:
            raise InvalidInput(
                f"worlds must be all {self.num_worlds} before the first reset, got {len(chosen)}; "
                "call reset() or set_state of all once"
            )
        chosen, parts = fitting(state, self.config, chosen)
        bodies, scenes = parts["conditions"]["bodies"], parts["conditions"]["scenes"]
        self.world.check_rooms(chosen, scenes)
        before, self.transition = self.transition, None  # until this is done, no step may follow
        self.conditions = self.conditions.with_state(parts["conditions"], chosen)
        self.world.set_state(parts["world"], chosen, bodies, scenes, anew=before is None)
        self._episodes.set_state(parts["episodes"], chosen)
        self.driven.set_state(parts["partner"], chosen)
        self.observation.set_state(parts["observation"], chosen)
        put_generators(self.generators, parts["generators"], chosen)
        obs, info = parts["obs"], Info(parts["info"])
        if before is not None and len(chosen) < self.num_worlds:
            obs, info = with_rows(self._obs, chosen, obs), with_worlds(self._info, chosen, info)
        self.transition = Transition.restored(
            parts["transition"],
            self.conditions,
            beside=before,
            worlds=chosen,
            dt=self.dt,
            horizon=self.horizon,
        )
        self._obs, self._info = obs, info
        return obs.copy(), copied(info)

    @one_thread_at_a_time
    def reset(
        self,
        *,
        seed: Seed = None,
        mask: BoolArray | None = None,
        pose: npt.ArrayLike | None = None,
        goal: npt.ArrayLike | None = None,
    ) -> tuple[npt.NDArray[np.float32], Info]:
        """Start a new episode in every world, or in those that ``mask`` marks.

        Parameters
        ----------
        seed
            World k is seeded with ``seed + k``; a sequence gives each world its own. ``None``
            lets the generators go on (the first time, they start from the system's entropy).
        mask
            ``(world,)`` bool.
        pose, goal
            ``(3,)`` or ``(world, 3)``: start or goal instead of the drawn ones; world frame. A
            start that reaches into a wall or an obstacle is pushed out of it. Obstacles are those
            of the new episode.

        Returns
        -------
        Observations ``(world, learner, feature)`` and infos of all worlds, as after a step.

        Raises
        ------
        InvalidInput
            If an argument has the wrong shape, a start or a goal is in something solid, or a
            world is left that never started.
        CoreInUse
            If another thread steps or resets the core.
        """
        worlds = marked_worlds(mask, self.num_worlds, first=self.transition is None)
        pose = given_pose(pose, "pose", self.num_worlds)
        goal = given_pose(goal, "goal", self.num_worlds)
        if goal is not None and self._has_moving_goal:
            raise InvalidInput(
                f"goal must be left to a task whose goal moves, got {goal[0].tolist()}; give the "
                "task another reference"
            )
        given = (pose, "pose"), (goal, "goal")
        check_free(worlds, given, self._draws.scenes)
        with all_or_nothing(self.generators, pose is not None or goal is not None):
            seed_worlds(self.generators, seed, worlds)
            drawn, drawn_pose, drawn_goal = self._draws.next(
                self.conditions, self.generators, worlds
            )
            check_free(worlds, given, drawn.scenes)
        self.conditions = drawn
        before, self.transition = self.transition, None  # until this is done, no step may follow
        start = self._start(
            worlds,
            drawn_pose if pose is None else pose[worlds],
            drawn_goal if goal is None else goal[worlds],
        )
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
        info.update(self.driven.info(self.transition))
        self._obs, self._info = obs, info
        return obs.copy(), copied(info)

    def step(
        self, action: npt.ArrayLike, *, restart: BoolArray | None = None
    ) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray, Info]:
        """Advance every world by one control step.

        Parameters
        ----------
        action
            ``(world, learner, action_size)``, agent frame; clipped to [−1, 1]. With
            ``action="discrete"`` numbers of pushes ``(world, learner)``, which are not clipped.
        restart
            ``(world,)`` bool: worlds that begin a new episode in this step. Their action is
            ignored, their reward is zero and their observation is the first of the episode.

        Returns
        -------
        Observations ``(world, learner, feature)``, rewards ``(world, learner)``, terminated and
        truncated ``(world,)``, infos. A world that ended has to be reset before the next step.

        Raises
        ------
        InvalidInput
            If the action has the wrong shape, is not finite or of no real numbers, or of no push,
            or ``restart`` is not one boolean a world; nothing has moved then.
        ResetNeeded
            If a world has ended, or never started, or the last step or reset broke off.
        CoreInUse
            If another thread steps or resets the core.
        """
        obs, reward, terminated, truncated, info = self.advance(action, restart=restart)
        return obs.copy(), reward, terminated.copy(), truncated.copy(), copied(info)

    @one_thread_at_a_time
    def advance(
        self, action: npt.ArrayLike, *, restart: BoolArray | None = None
    ) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray, Info]:
        """Step like `step`, but return the core's own arrays instead of copies.

        For views, which copy before they hand anything out.
        """
        if restart is not None:
            restart = booleans(restart, "restart", self.num_worlds)
        before = self._running(restart)
        clipped, applied = self._applied(action, before, restart)
        self.transition = None  # from the middle of a step no episode goes on
        self.world.step(sum_at_centre(applied, self.team.grips))
        next_state = self._state(before.next_state.goal, self._episodes.tick())
        success, terminated, truncated = self._episodes.judge(self.conditions, next_state)
        self.transition = transition = Transition(
            state=before.next_state,
            next_state=next_state,
            conditions=self.conditions,
            action=clipped,
            previous_action=before.action,
            applied=applied,
            contact_impulse=self.world.contact_impulse,
            contact_shift=self.world.contact_shift,
            success=success,
            terminated=terminated,
            truncated=truncated,
            dt=self.dt,
            horizon=self.horizon,
        )
        driven = self.driven
        reward, parts = self.reward(transition)
        reward = driven.of_learners(reward)
        seen, clipped = self.observation.read(transition)
        self._obs = driven.of_learners(seen)
        self._info = step_info(transition, driven.terms_of_learners(parts))
        if self.cost is not None:
            taken, parts = self.cost(transition, what="cost")
            told = cost_info(driven.of_learners(taken), driven.terms_of_learners(parts))
            self._info.update(told)
        if clipped is not None:
            self._info[CLIPPED] = clipped
        self._info.update(driven.info(transition))
        if restart is None or not restart.any():
            return self._obs, reward, terminated, truncated, self._info
        obs, info = self.reset(mask=restart)
        reward[restart] = 0
        return obs, reward, terminated & ~restart, truncated & ~restart, info

    def _running(self, restart: BoolArray | None) -> Transition:
        """The last transition; raises `ResetNeeded` unless a step may follow in every world."""
        if self.transition is None:
            raise ResetNeeded(
                "reset must be called before the first step and after a call that broke off, got "
                "a step; call reset()"
            )
        self._episodes.check_running(restart)
        return self.transition

    def _applied(
        self, action: npt.ArrayLike, before: Transition, restart: BoolArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Clipped actions of all agents, and the wrenches in the object frame they stand for."""
        if self.table is None:
            given = read_action(action, self.action_shape, restart)
        else:
            given = pushed(action, self.action_shape, self.table, restart)
        joint = self.driven.joint(given, before, restart)
        return frames.wrenches_from_actions(joint, self.team.frame, self.team.limits)

    def _state(self, goal: FloatArray, time: FloatArray) -> State:
        task, plan = self._task, self.conditions.plan
        if self._has_moving_goal:
            goal = frames.wrap_pose(task.goal_at(plan, time))
        pose = frames.wrap_pose(self.world.pose)
        distance = task.way(plan, pose, goal)
        # The world makes its arrays anew in every step, so they need no copy.
        return State(pose=pose, twist=self.world.twist, goal=goal, distance=distance, time=time)

    def _start(self, worlds: IntArray, pose: FloatArray, goal: FloatArray) -> Transition:
        """Put ``worlds`` at the start of an episode; the transition that led to nothing yet."""
        count = len(worlds)
        conditions = self.conditions
        if count < self.num_worlds:
            conditions = conditions.take(worlds)
        if self._draws.changing:
            self.world.furnish(worlds, conditions.bodies, conditions.scenes)
        self.world.place(worlds, pose)
        self._episodes.begin(worlds)
        pose, goal = frames.wrap_pose(pose), frames.wrap_pose(goal)
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


def _made(kind: type[Transport], num_worlds: int, config: TransportConfig) -> Transport:
    return kind(num_worlds=num_worlds, config=config)
