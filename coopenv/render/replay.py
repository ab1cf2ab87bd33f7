"""Films of episodes and of recorded trials: the scene, and beside it its time series."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray, whole
from coopenv.errors import InvalidInput
from coopenv.render.canvas import Picture
from coopenv.render.film import PAUSE, Frames, beside, mosaic, rows_at
from coopenv.render.recorded import RecordedScene
from coopenv.render.renderer import Renderer
from coopenv.render.series import Series, measure_panels
from coopenv.transition import Transition

WIDTH = 480  # [px] of the scene
SERIES = 0.85  # width of the series, per the scene's
LEAST, MOST = 160, 4096  # [px]

Draw = Callable[[int], Picture]  # the picture of a row


class Pace(NamedTuple):
    """How fast a film is: pictures a second, and how many times faster than life."""

    fps: float = 20.0
    speed: float = 1.0


LIFE = Pace()


class Measures(NamedTuple):
    """Measures of each row, ``(T,)`` and shares ``(T, n)``."""

    relative_cost: FloatArray  # γ
    internal_force_level: FloatArray  # F_I [N]
    internal_torque_level: FloatArray  # T_I [N·m]
    force_load_share: FloatArray
    torque_load_share: FloatArray


def film_of_episode(
    steps: Sequence[Transition],
    *,
    pace: Pace = LIFE,
    width: int = WIDTH,
    world: int = 0,
    series: bool = True,
) -> Frames:
    """Pictures of an episode with γ, F_I, T_I and load shares beside the scene.

    Parameters
    ----------
    steps
        From the start of the episode, which led to nothing, to its end.
    pace
        How fast.
    width
        Of the scene [px].
    world
        Of the batch.
    series
        Whether the time series stand beside the scene.
    """
    time = _times(steps, world)
    draw = _drawn(steps, time, width, world, series)
    return Frames(draw, rows_at(time, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def film_of_episodes(
    episodes: Sequence[Sequence[Transition]],
    *,
    pace: Pace = LIFE,
    width: int = WIDTH,
    series: bool = True,
) -> Frames:
    """Pictures of several episodes in a mosaic, each scene with its time series beside it.

    Those that have ended wait for the others.
    """
    if not episodes:
        raise InvalidInput("episodes must be at least one, got none; run one first")
    times = [_times(steps, 0) for steps in episodes]
    drawn = [
        _drawn(steps, time, width, 0, series) for steps, time in zip(episodes, times, strict=True)
    ]
    longest = max(times, key=lambda time: time[-1])

    def draw(row: int) -> Picture:
        moment = longest[row] + 1e-9
        now = [int(np.searchsorted(time, moment, side="right")) - 1 for time in times]
        return mosaic([one(k) for one, k in zip(drawn, now, strict=True)])

    return Frames(draw, rows_at(longest, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def film_of_recording(
    time: FloatArray,
    stage: RecordedScene,
    measures: Measures,
    *,
    pace: Pace = LIFE,
    series: bool = True,
) -> Frames:
    """Pictures of a recorded trial, its time series beside it; ``time`` ``(T,)`` [s]."""
    height, width = stage.size
    panels = _series(time, measures, width, height) if series else None
    draw = stage.picture if panels is None else _both(stage.picture, panels)
    return Frames(draw, rows_at(time, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def _drawn(
    steps: Sequence[Transition], time: FloatArray, width: int, world: int, series: bool
) -> Draw:
    """What draws a step of an episode."""
    width = whole(width, "width", at_least=LEAST, at_most=MOST)
    conditions = steps[0].conditions
    renderer = Renderer(conditions.bodies, conditions.scenes, width=width, world=world)

    def scene(row: int) -> Picture:
        return renderer.picture(steps[row])

    if not series:
        return scene
    return _both(scene, _series(time, _measures_of(steps, world), width, len(scene(0))))


def _both(scene: Draw, series: Series) -> Draw:
    """What draws a scene and its time series beside it."""
    return lambda row: beside(scene(row), series.picture(row))


def _times(steps: Sequence[Transition], world: int) -> FloatArray:
    """``(T,)`` [s]."""
    return np.array([step.next_state.time[world] for step in steps])


def _series(time: FloatArray, measures: Measures, width: int, height: int) -> Series:
    unit = min(max(width / 640, 0.6), 3.0)
    panels = measure_panels(*measures)
    return Series(time, panels, width=round(SERIES * width), height=height, unit=unit)


def _measures_of(steps: Sequence[Transition], world: int) -> Measures:
    """What the infos of the steps say; undefined shares are NaN."""
    splits = [step.decomposition for step in steps]
    shares = [step.load_share for step in steps]
    return Measures(
        np.array([split.relative_cost[world] for split in splits]),
        np.array([split.internal_force_level[world] for split in splits]),
        np.array([split.internal_torque_level[world] for split in splits]),
        np.array([share.force[world] for share in shares]),
        np.array([share.torque[world] for share in shares]),
    )
