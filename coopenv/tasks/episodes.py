"""Episodes under way in every world: their clocks, their success and their time limit."""

from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray, with_rows
from coopenv.compiled import compiled
from coopenv.conditions import Conditions
from coopenv.errors import ResetNeeded
from coopenv.geometry import frames
from coopenv.tasks.base import Task, overrides
from coopenv.tasks.pose import PoseClock, PoseTask
from coopenv.transition import State


class Episodes:
    """Which worlds have an episode under way, for how long, and how well it went on the whole.

    Parameters
    ----------
    task
        Whose episodes they are.
    num_worlds
        Worlds stepped together; none has an episode yet.
    dt
        Control step [s].
    horizon
        Control steps after which an episode is truncated.
    """

    def __init__(self, task: Task, num_worlds: int, *, dt: float, horizon: int):
        self._task, self._dt, self._horizon = task, dt, horizon
        # A neutral answer is not asked for: it would cost an array operation a step.
        self._may_be_early, self._is_judged = overrides(task, "due"), overrides(task, "accepts")
        self._may_fail = overrides(task, "failure")
        self._moves = task.moves
        self._clock = None
        if isinstance(task, PoseTask) and PoseClock.applies(task):
            self._clock = PoseClock(task, dt=dt, horizon=horizon)
        self._steps = np.zeros(num_worlds, dtype=np.int64)
        self._distances = np.zeros(num_worlds)  # [m] sum over the steps of the episode
        self._ended, self._any_ended = np.ones(num_worlds, dtype=np.bool_), True

    def begin(self, worlds: IntArray) -> None:
        """Start an episode in ``worlds``."""
        self._steps[worlds], self._distances[worlds], self._ended[worlds] = 0, 0.0, False
        self._any_ended = bool(self._ended.any())

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """How far the episodes of ``worlds`` are, one row each."""
        return {
            "steps": self._steps[worlds],
            "distances": self._distances[worlds],
            "ended": self._ended[worlds],
        }

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._steps = with_rows(self._steps, worlds, state["steps"])
        self._distances = with_rows(self._distances, worlds, state["distances"])
        self._ended = with_rows(self._ended, worlds, state["ended"])
        self._any_ended = bool(self._ended.any())

    def check_running(self, restart: BoolArray | None) -> None:
        """Raise `ResetNeeded` where a world that does not ``restart`` has no episode under way."""
        if not self._any_ended:
            return
        ended = np.flatnonzero(self._ended if restart is None else self._ended & ~restart)
        if len(ended):
            raise ResetNeeded(
                "worlds whose episode has ended must be reset before the next step, got a step "
                f"with {len(ended)} ended (the first: {ended[0]}); "
                "call reset(mask=terminated | truncated)"
            )

    def arrive(
        self, conditions: Conditions, pose: FloatArray, twist: FloatArray, goal: FloatArray
    ) -> tuple[State, BoolArray, BoolArray, BoolArray]:
        """Go on by one control step, which led to ``pose`` (not wrapped) and ``twist``.

        ``goal`` is that before it, where it does not move. The state, and as of `judge`.
        """
        if self._clock is not None:
            state, success, truncated, self._any_ended = self._clock.arrive(
                pose, twist, goal, self._steps, self._ended
            )
            return state, success, success, truncated
        task, plan, time = self._task, conditions.plan, self.tick()
        if self._moves:
            goal = frames.wrap_pose(task.goal_at(plan, time))
        pose = frames.wrap_pose(pose)
        distance = task.way(plan, pose, goal)
        # The world makes its arrays anew in every step, so they need no copy.
        state = State(pose=pose, twist=twist, goal=goal, distance=distance, time=time)
        return state, *self.judge(conditions, state)

    def tick(self) -> FloatArray:
        """Go on by one control step; the time ``(world,)`` since each episode began [s]."""
        time = np.empty(len(self._steps))
        _tick(self._steps, self._dt, time)
        return time

    def judge(self, conditions: Conditions, state: State) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Which worlds ``(world,)`` are done, which ended by that or by failure, which by time."""
        task = self._task
        # A copy: infos are read later, when a task may have written to its array again.
        success = task.success(state.pose, state.twist, state.goal).copy()
        if self._may_be_early:
            success = success & task.due(conditions.plan, state.time)
        if self._is_judged:
            self._distances = self._distances + state.distance
            success = success & task.accepts(self._distances / self._steps)
        terminated = success
        if self._may_fail:
            failed = task.failure(state.pose, state.twist, state.goal)
            success, terminated = success & ~failed, success | failed
        truncated = np.empty(len(self._steps), dtype=np.bool_)
        self._any_ended = _end(terminated, self._steps, self._horizon, truncated, self._ended)
        return success, terminated, truncated


@compiled
def _tick(steps, dt, time):
    """Steps since the episode began, one later and in place; writes the time [s]."""
    for k in range(len(steps)):
        steps[k] += 1
        time[k] = steps[k] * dt


@compiled
def _end(terminated, steps, horizon, truncated, ended):
    """Write which worlds ran out of time and which ended either way; return whether any did.

    Expressions of arrays would take ten times as long to compile.
    """
    if len(terminated) != len(steps):
        raise ValueError("a task must judge every world")
    some = False
    for k in range(len(steps)):
        truncated[k] = steps[k] >= horizon and not terminated[k]
        ended[k] = truncated[k] or terminated[k]
        some |= ended[k]
    return some
