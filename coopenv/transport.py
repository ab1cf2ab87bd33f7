"""The core of every environment: many worlds reset and stepped together."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, booleans
from coopenv.compiled.parallel import shared
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.info import Info, copied, copied_when_read
from coopenv.physics.threads import in_use, one_thread_at_a_time
from coopenv.resets import Seed, all_or_nothing, check_free, given_pose, marked_worlds, seed_worlds
from coopenv.snapshot import VERSION, Snapshot, chosen_worlds, fitting
from coopenv.stepping.worlds import SteppedWorlds


class Transport(SteppedWorlds):
    """A batch of worlds in which a team carries an object; numpy in and out, no autoreset.

    It belongs to one thread at a time.

    Parameters
    ----------
    num_worlds
        Worlds stepped together.
    config
        What they are; instead of it, any field of `TransportConfig` as a keyword.
    threads
        How many step the worlds, the caller's among them; results have the same bits for any
        number. ``None``: one a core, or fewer where the batch is too small to gain from them.

    Attributes
    ----------
    config, world, observation
        The description, the physics, the observation layout.
    conditions
        Bodies, scenes, team and plans of the episodes under way.
    threads
        As given, or chosen.
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

    def __reduce__(self):
        """Copies and pickles are another core of the configuration, in the state of this one.

        One that was not reset yet, or broke off, is as good as new.
        """
        made = _made, (type(self), self.num_worlds, self.config, self.threads)
        return made if self.transition is None else (*made, self.get_state())

    def __setstate__(self, state: Snapshot) -> None:
        self.set_state(state)

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
        return Snapshot(config=self.config, version=VERSION, parts=self._parts(chosen))

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
        self._go_on(chosen, parts)
        return self._obs.copy(), copied(self._info)

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
        self._begin(
            worlds,
            drawn,
            drawn_pose if pose is None else pose[worlds],
            drawn_goal if goal is None else goal[worlds],
        )
        return self._obs.copy(), copied_when_read(self._info)

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
        return obs.copy(), reward, terminated.copy(), truncated.copy(), copied_when_read(info)

    def advance(
        self, action: npt.ArrayLike, *, restart: BoolArray | None = None
    ) -> tuple[npt.NDArray[np.float32], FloatArray, BoolArray, BoolArray, Info]:
        """Step like `step`, but return the core's own arrays instead of copies.

        For views, which copy before they hand anything out.
        """
        turn = self.turn
        if not turn.acquire(False):  # as `one_thread_at_a_time`, in less time
            raise in_use()
        try:
            if restart is not None:
                restart = booleans(restart, "restart", self.num_worlds)
            with shared(self.threads):
                reward, terminated, truncated = self._step(action, restart)
            if restart is None or not restart.any():
                return self._obs, reward, terminated, truncated, self._info
            obs, info = self.reset(mask=restart)
            reward[restart] = 0
            return obs, reward, terminated & ~restart, truncated & ~restart, info
        finally:
            turn.release()


def _made(
    kind: type[Transport], num_worlds: int, config: TransportConfig, threads: int | None = None
) -> Transport:
    return kind(num_worlds=num_worlds, config=config, threads=threads)
