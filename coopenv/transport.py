"""The core: many worlds reset and stepped together. Every environment is a view of it."""

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding

from coopenv.arrays import BoolArray, FloatArray, IntArray, finite_array, whole
from coopenv.compiled import compiled
from coopenv.conditions import Team
from coopenv.config import ACTIONS, TransportConfig
from coopenv.draws import Draws
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.geometry import frames
from coopenv.info import Info, copied, replaced, start_info, step_info, with_worlds
from coopenv.observation import Observation
from coopenv.partner import Company
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.physics.world import World
from coopenv.resets import Seed, check_free, given_pose, marked_worlds, world_seeds
from coopenv.rewards import find_reward
from coopenv.tasks.base import overrides
from coopenv.transition import State, Transition
from coopenv.wrench.grasp import sum_at_centre


class Transport:
    """A batch of worlds in which a team carries an object; numpy in and out, no autoreset.

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
        Read from the configuration.
    learners
        Numbers of the agents that actions, observations and rewards are of, in this order: all,
        or those that ``config.partner`` does not drive. Infos are of all agents, but
        ``reward_terms``.
    transition
        The last step, or the start; ``None`` before the first reset.
    generators
        One `numpy.random.Generator` a world, going on from episode to episode.

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
        self.num_worlds = whole(num_worlds, "num_worlds", at_least=1)
        self.num_agents = self.config.num_agents
        self.learners = self.config.learners
        self.action_size = ACTIONS[self.config.action]
        self.dt, self.substeps = self.config.dt, self.config.substeps
        self.horizon = self.config.horizon
        self.reward = find_reward(self.config.reward)
        self.observation = Observation(self.config.observe, self.num_agents, self.num_worlds)
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
        partnered = self.config.partner is not None
        self._company = Company(self.config, self.num_worlds) if partnered else None
        self.generators: list[np.random.Generator | None] = [None] * self.num_worlds
        self.transition: Transition | None = None
        task = self.config.task
        self._has_moving_goal = task.moves
        self._may_be_early, self._is_judged = overrides(task, "due"), overrides(task, "accepts")
        self._distances = np.zeros(self.num_worlds)  # [m] sum over the steps of the episode
        self._steps = np.zeros(self.num_worlds, dtype=np.int64)
        self._ended, self._any_ended = np.ones(self.num_worlds, dtype=np.bool_), True
        self._obs = np.zeros((0,), dtype=np.float32)
        self._info: Info = {}

    def __reduce__(self):
        """Copies and pickles of a transport that was not reset yet are made from its configuration.

        Raises
        ------
        TypeError
            If episodes are under way: pymunk does not tell what it remembers of contacts, and the
            copy would go on differently.
        """
        if self.transition is not None:
            raise TypeError(
                "a Transport must not have been reset to be copied or pickled, got one with "
                "episodes under way; copy it before its first reset, or make another from its "
                "config"
            )
        return _made, (type(self), self.num_worlds, self.config)

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
        self._seed(seed, worlds)
        drawn, drawn_pose, drawn_goal = self._draws.next(self.conditions, self.generators, worlds)
        check_free(worlds, given, drawn.scenes)
        self.conditions = drawn
        start = self._start(
            worlds,
            drawn_pose if pose is None else pose[worlds],
            drawn_goal if goal is None else goal[worlds],
        )
        company = self._company
        obs, info = self.observation(start, worlds), start_info(start, tuple(self.reward))
        if company is not None:
            company.begin(worlds, self.generators, start)
            obs = company.of_learners(obs)
            info["reward_terms"] = company.terms_of_learners(info["reward_terms"])
        if self.transition is None or len(worlds) == self.num_worlds:
            self.transition = start
        else:
            self.transition = self.transition.with_worlds(worlds, start, self.conditions)
            obs = replaced(self._obs, worlds, obs)
            info = with_worlds({name: self._info[name] for name in info}, worlds, info)
        if company is not None:
            info.update(company.info(self.transition))
        self._obs, self._info = obs, info
        return obs.copy(), copied(info)

    def step(
        self, action: npt.ArrayLike, *, restart: BoolArray | None = None
    ) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray, Info]:
        """Advance every world by one control step.

        Parameters
        ----------
        action
            ``(world, learner, action_size)``, agent frame; clipped to [−1, 1].
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
            If the action has the wrong shape or is not finite; nothing has moved then.
        ResetNeeded
            If a world has ended, or never started.
        """
        obs, reward, terminated, truncated, info = self.advance(action, restart=restart)
        return obs.copy(), reward, terminated.copy(), truncated.copy(), copied(info)

    def advance(
        self, action: npt.ArrayLike, *, restart: BoolArray | None = None
    ) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray, Info]:
        """`step` for views that copy what they hand out: these arrays are the core's own."""
        if self._any_ended or restart is not None:
            self._check_running(restart)
        clipped, applied = self._applied(action, restart)
        before = self.transition
        assert before is not None
        self.world.step(sum_at_centre(applied, self.team.grips))
        self._steps, time = _tick(self._steps, self.dt)
        next_state = self._state(before.next_state.goal, time)
        success = self._success(next_state)
        truncated, self._ended, self._any_ended = _ends(success, self._steps, self.horizon)
        self.transition = transition = Transition(
            state=before.next_state,
            next_state=next_state,
            conditions=self.conditions,
            action=clipped,
            previous_action=before.action,
            applied=applied,
            contact_impulse=self.world.contact_impulse,
            success=success,
            terminated=success,
            truncated=truncated,
            dt=self.dt,
            horizon=self.horizon,
        )
        reward, parts = self.reward(transition)
        self._obs = self.observation(transition)
        company = self._company
        if company is not None:
            self._obs, reward = company.of_learners(self._obs), company.of_learners(reward)
            parts = company.terms_of_learners(parts)
        self._info = step_info(transition, parts)
        if company is not None:
            self._info.update(company.info(transition))
        if restart is None or not restart.any():
            return self._obs, reward, success, truncated, self._info
        obs, info = self.reset(mask=restart)
        reward[restart] = 0
        return obs, reward, success & ~restart, truncated & ~restart, info

    def _applied(
        self, action: npt.ArrayLike, restart: BoolArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Clipped actions, and the wrenches in the object frame that they stand for."""
        wanted = (self.num_worlds, len(self.learners), self.action_size)
        try:
            given = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            given = finite_array(action, "action")
        if given.shape != wanted:
            raise InvalidInput(
                f"action must have shape (world, agent, {self.action_size}) = {wanted}, "
                f"got {given.shape}; stack one row an agent that learns"
            )
        if restart is not None:
            given = np.where(restart[:, None, None], 0.0, given)
        if self._company is not None:
            assert self.transition is not None
            given = self._company.joint(given, self.transition, restart)
        clipped, applied, finite = frames.wrenches_from_actions(
            given, self.team.frame, self.team.limits
        )
        if not finite:
            finite_array(given, "action")  # raises, naming the place
        return clipped, applied

    def _success(self, state: State) -> BoolArray:
        task = self.config.task
        success = task.success(state.pose, state.twist, state.goal)
        if self._may_be_early:
            success = success & task.due(self.conditions.plan, state.time)
        if self._is_judged:
            self._distances = self._distances + state.distance
            success = success & task.accepts(self._distances / self._steps)
        return success

    def _state(self, goal: FloatArray, time: FloatArray) -> State:
        task, plan = self.config.task, self.conditions.plan
        if self._has_moving_goal:
            goal = frames.wrap_pose(task.goal_at(plan, time))
        pose = frames.wrap_pose(self.world.pose)
        distance = task.way(plan, pose, goal)
        return State(
            pose=pose, twist=self.world.twist.copy(), goal=goal, distance=distance, time=time
        )

    def _start(self, worlds: IntArray, pose: FloatArray, goal: FloatArray) -> Transition:
        """Put ``worlds`` at the start of an episode; the transition that led to nothing yet."""
        count = len(worlds)
        conditions = self.conditions
        if count < self.num_worlds:
            conditions = conditions.take(worlds)
        if self._draws.changing:
            self.world.furnish(worlds, conditions.bodies, conditions.scenes)
        self.world.place(worlds, pose)
        self._steps = self._steps.copy()
        self._steps[worlds], self._ended[worlds] = 0, False
        self._distances = replaced(self._distances, worlds, 0.0)
        self._any_ended = bool(self._ended.any())
        pose, goal = frames.wrap_pose(pose), frames.wrap_pose(goal)
        state = State(
            pose=pose,
            twist=np.zeros((count, 3)),
            goal=goal,
            distance=self.config.task.way(conditions.plan, pose, goal),
            time=np.zeros(count),
        )
        action = np.zeros((count, self.num_agents, self.action_size))
        no = np.zeros(count, dtype=np.bool_)
        return Transition(
            state=state,
            next_state=state,
            conditions=conditions,
            action=action,
            previous_action=action,
            applied=np.zeros((count, self.num_agents, 3)),
            contact_impulse=np.zeros(count),
            success=no,
            terminated=no,
            truncated=no,
            dt=self.dt,
            horizon=self.horizon,
        )

    def _seed(self, seed: Seed, worlds: IntArray) -> None:
        chosen = worlds.tolist()
        for k, own in zip(chosen, world_seeds(seed, chosen, self.num_worlds), strict=True):
            if own is not None or self.generators[k] is None:
                self.generators[k] = seeding.np_random(own)[0]

    def _check_running(self, restart: BoolArray | None) -> None:
        """Raise `ResetNeeded` where a world that does not restart has no episode under way."""
        if self.transition is None:
            raise ResetNeeded(
                "reset must be called before the first step, got a step; call reset()"
            )
        ended = np.flatnonzero(self._ended if restart is None else self._ended & ~restart)
        if len(ended):
            raise ResetNeeded(
                "worlds whose episode has ended must be reset before the next step, got a step "
                f"with {len(ended)} ended (the first: {ended[0]}); "
                "call reset(mask=terminated | truncated)"
            )


def _made(kind: type[Transport], num_worlds: int, config: TransportConfig) -> Transport:
    return kind(num_worlds=num_worlds, config=config)


@compiled
def _tick(steps, dt):
    """Steps and time [s] since the episode began, one step later."""
    later = steps + 1
    return later, later * dt


@compiled
def _ends(success, steps, horizon):
    """Which worlds ran out of time, which ended either way, and whether any did."""
    truncated = (steps >= horizon) & ~success
    ended = truncated | success
    return truncated, ended, ended.any()
