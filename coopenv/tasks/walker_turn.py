"""Walker task: drive a body on wheels along a straight, an arc and a straight to their end."""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from coopenv.arrays import Range, positive, positive_range
from coopenv.compiled import compiled
from coopenv.conditions import Room
from coopenv.errors import InvalidInput
from coopenv.geometry.clearance import ways_to_boxes, ways_to_walls
from coopenv.geometry.frames import wrapped
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.rolling import RollingTask
from coopenv.tasks.transport import TransportTask

_TRIES, _BLOCK = 20_000, 50
_STEPS = 32  # points of a way at which the body must have room


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerTurnTask(RollingTask):
    """Reach a pose that lies at the end of a random straight, an arc and another straight.

    The goal can be reached by driving forwards and turning along that way, which is free of walls
    and obstacles.

    Parameters
    ----------
    path_length
        Shortest and longest way from start to goal [m].
    turn
        Smallest and largest angle of the arc, to either side [rad].

    Raises
    ------
    InvalidInput
        If a range is not two numbers in order, or another value breaks its rule.
    """

    path_length: Range = (2.0, 4.0)  # [m]
    turn: Range = (0.4, 1.8)  # [rad]

    def __post_init__(self) -> None:
        TransportTask.__post_init__(self)
        _set = object.__setattr__
        for name, most in (("path_length", inf), ("turn", 2 * pi)):
            ends = positive_range(getattr(self, name), f"task.{name}", or_zero=True, at_most=most)
            positive(ends[1], f"task.{name}")
            _set(self, name, ends)

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless the object can turn freely and finds a way."""
        TransportTask.check(self, body, scene)
        self.sample(np.random.default_rng(0), body, scene)

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """A free start whose way leads to a free goal."""
        room = Room.of([scene], len(scene.obstacles))
        outline = np.array(body.outline)[None]
        for _ in range(_TRIES // _BLOCK):
            draws = generator.random((_BLOCK, 8))
            way = _first_clear(
                draws, self.path_length, self.turn, self.clearance, outline,
                room.size, room.boxes, room.count,
            )  # fmt: skip
            if len(way) and self.distance(way[:1], way[-1:])[0] >= self.min_distance:
                (x, y, angle), goal = way[0].tolist(), way[-1].tolist()
                return (x, y, angle), (goal[0], goal[1], wrapped(goal[2]))
        raise InvalidInput(
            f"task.path_length must leave room for a way, got {self.path_length} m in a room of "
            f"{scene.size} m with {len(scene.obstacles)} obstacles; shorten it or enlarge the room"
        )


@compiled
def _first_clear(draws, path_length, turn, clearance, outline, size, boxes, count):
    """The first of the drawn ways on which the body has room, ``(point, 3)``; empty if none."""
    for draw in draws:
        length = path_length[0] + draw[3] * (path_length[1] - path_length[0])
        angle = turn[0] + draw[4] * (turn[1] - turn[0])
        arc = 0.3 + 0.4 * draw[6]  # of the length
        way = _way(
            size[0, 0] * (draw[0] - 0.5), size[0, 1] * (draw[1] - 0.5), np.pi * (1 - 2 * draw[2]),
            length, angle if draw[5] < 0.5 else -angle, arc, draw[7] * (1 - arc),
        )  # fmt: skip
        if _has_room(way, clearance, outline, size, boxes, count):
            return way
    return np.empty((0, 3))


@compiled
def _way(x, y, angle, length, turn, arc, before):
    """Poses along a straight, an arc that begins at ``before`` of the length, and a straight."""
    way = np.empty((_STEPS + 1, 3))
    way[0, 0], way[0, 1], way[0, 2] = x, y, angle
    for i in range(_STEPS):
        middle = angle + turn * min(max(((i + 0.5) / _STEPS - before) / arc, 0.0), 1.0)
        way[i + 1, 0] = way[i, 0] + np.cos(middle) * length / _STEPS
        way[i + 1, 1] = way[i, 1] + np.sin(middle) * length / _STEPS
        way[i + 1, 2] = angle + turn * min(max(((i + 1) / _STEPS - before) / arc, 0.0), 1.0)
    return way


@compiled
def _has_room(way, clearance, outline, size, boxes, count):
    for i in range(len(way)):
        pose = way[len(way) - 1 - i : len(way) - i]  # from its end, which is most often outside
        if ways_to_walls(outline, pose, size).min() < clearance:
            return False
        if boxes.shape[1] and ways_to_boxes(outline, pose, boxes, count)[0, :, 0].min() <= 0.0:
            return False
    return True
