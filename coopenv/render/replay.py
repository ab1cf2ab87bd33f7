"""Films of episodes and of recorded trials: the scene, and beside it its time series."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray, whole
from coopenv.errors import InvalidInput
from coopenv.render.canvas import Picture
from coopenv.render.film import PAUSE, Frames, beside, mosaic, rows_at
from coopenv.render.renderer import Renderer
from coopenv.render.series import Series, measure_panels
from coopenv.render.space import SpaceStage
from coopenv.render.stage import Stage
from coopenv.transition import Transition

WIDTH = 480  # [px] of the scene
SERIES = 0.85  # width of the series, per the scene's
LEAST, MOST = 160, 4096  # [px]


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
    steps: Sequence[Transition], *, pace: Pace = LIFE, width: int = WIDTH, world: int = 0
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
    """
    width = whole(width, "width", at_least=LEAST, at_most=MOST)
    renderer = _renderer(steps, width, world)
    time = np.array([step.next_state.time[world] for step in steps])
    first = renderer.picture(steps[0])
    series = _series(time, _measures_of(steps, world), width, len(first))

    def draw(row: int) -> Picture:
        return beside(renderer.picture(steps[row]), series.picture(row))

    return Frames(draw, rows_at(time, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def film_of_episodes(
    episodes: Sequence[Sequence[Transition]], *, pace: Pace = LIFE, width: int = WIDTH
) -> Frames:
    """Pictures of several episodes in a mosaic; those that have ended wait for the others."""
    width = whole(width, "width", at_least=LEAST, at_most=MOST)
    if not episodes:
        raise InvalidInput("episodes must be at least one, got none; run one first")
    renderers = [_renderer(steps, width, 0) for steps in episodes]
    times = [np.array([step.next_state.time[0] for step in steps]) for steps in episodes]
    longest = max(times, key=lambda time: time[-1])

    def draw(row: int) -> Picture:
        moment = longest[row]
        tiles = []
        for renderer, steps, time in zip(renderers, episodes, times, strict=True):
            now = int(np.searchsorted(time, moment + 1e-9, side="right")) - 1
            tiles.append(renderer.picture(steps[now]))
        return mosaic(tiles)

    return Frames(draw, rows_at(longest, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def film_of_recording(
    time: FloatArray,
    stage: Stage | SpaceStage,
    measures: Measures,
    *,
    pace: Pace = LIFE,
) -> Frames:
    """Pictures of a recorded trial, its time series beside it; ``time`` ``(T,)`` [s]."""
    height, width = stage.size
    series = _series(time, measures, width, height)

    def draw(row: int) -> Picture:
        return beside(stage.picture(row), series.picture(row))

    return Frames(draw, rows_at(time, fps=pace.fps, speed=pace.speed, pause=PAUSE))


def _renderer(steps: Sequence[Transition], width: int, world: int) -> Renderer:
    conditions = steps[0].conditions
    return Renderer(conditions.bodies, conditions.scenes, width=width, world=world)


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
