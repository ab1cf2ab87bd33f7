"""Range readings: how far the walls and obstacles are, along rays and at their nearest point."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from coopenv.arrays import FloatArray, number, positive, whole
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput, UnknownName
from coopenv.geometry.frames import placed, rotated, rotated_back, seen_from
from coopenv.observation.block import Block, EachOther
from coopenv.transition import Transition

PLACES = ("grip", "centre")
OWNERS = ("own", "partners")
NEAREST = 3  # features after the rays: the way to the nearest point, and its length
_LEVEL = 1e-300  # in place of a smaller component of a ray, so that it divides


def ranges(
    *,
    num_rays: int = 12,
    reach: float = 3.0,
    field_of_view: float = 2 * np.pi,
    heading: float = 0.0,
    where: str = "grip",
    whose: str = "own",
    name: str | None = None,
) -> Block:
    """A block of range readings: how far walls and obstacles are from each agent.

    Features [m]: the way along each ray to the first wall or obstacle, then the vector to the
    nearest point of one (x, y in the agent's frame) and its length. What is farther than ``reach``
    reads ``reach``, and the vector is cut to that length. From inside something solid all of it
    reads 0. The object and the partners hide nothing.

    Parameters
    ----------
    num_rays
        At equal angles, counter-clockwise.
    reach
        Farthest that is seen [m].
    field_of_view
        Angle over which the rays are spread [rad]. 2π: all round, the first ray along ``heading``;
        less: from end to end, the middle along ``heading``.
    heading
        In the agent's frame [rad]: 0 looks along its x, from a grip towards the centre of mass.
    where
        The rays start at the agent's ``"grip"`` or at the object's ``"centre"`` of mass.
    whose
        ``"own"``: what the agent's own instrument reads. ``"partners"``: what those of the other
        agents read, in turn, each in its own agent's frame.
    name
        Of the block; ``None``: ``obstacles`` or ``partner_obstacles``.

    Raises
    ------
    InvalidInput, UnknownName
        If a value breaks its rule.
    """
    read = RangeReading(
        num_rays=num_rays,
        reach=reach,
        field_of_view=field_of_view,
        heading=heading,
        where=where,
        whose=whose,
    )
    own, size = read.whose == "own", read.num_rays + NEAREST
    return Block(
        name=name or ("obstacles" if own else "partner_obstacles"),
        size=size if own else EachOther(size),
        describe=f"{'' if own else 'of each other agent: '}way along {read.num_rays} rays to walls "
        "and obstacles, then the vector to the nearest point of one and its length; "
        f"{read.reach:g} m where farther, 0 from inside something solid",
        read=read,
        low=(*[0.0] * read.num_rays, -read.reach, -read.reach, 0.0),
        high=read.reach,
        unit="m",
        frame="agent" if own else "the other agent's",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeReading:
    """What a block of `ranges` reads of a transition; parameters as there."""

    num_rays: int = 12
    reach: float = 3.0  # [m]
    field_of_view: float = 2 * np.pi  # [rad]
    heading: float = 0.0  # [rad]
    where: str = "grip"
    whose: str = "own"

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "num_rays", whole(self.num_rays, "num_rays", at_least=1, at_most=1000))
        _set(self, "reach", positive(self.reach, "reach", unit="m"))
        _set(self, "field_of_view", positive(self.field_of_view, "field_of_view", unit="rad"))
        _set(self, "heading", number(self.heading, "heading"))
        if self.field_of_view > 2 * np.pi:
            raise InvalidInput(
                f"field_of_view must be at most 2π, got {self.field_of_view}; give it in rad"
            )
        for name, known in (("where", PLACES), ("whose", OWNERS)):
            if getattr(self, name) not in known:
                raise UnknownName(name, getattr(self, name), known)

    @property
    def rays(self) -> FloatArray:
        """``(2, ray)``: x and y of unit vectors in the agent's frame."""
        return _rays(self.num_rays, self.field_of_view, self.heading)

    def __call__(self, transition: Transition) -> FloatArray:
        """Readings ``(world, agent, feature)`` after ``transition``."""
        team, room = transition.team, transition.conditions.room
        grips = np.zeros_like(team.grips) if self.where == "centre" else team.grips
        seen = read_ranges(
            transition.next_state.pose,
            grips,
            team.frame,
            (room.size, room.boxes, room.axes, room.count),
            self.rays,
            self.reach,
        )
        return seen if self.whose == "own" else _of_the_others(seen)


@lru_cache(maxsize=64)
def _rays(num_rays: int, field_of_view: float, heading: float) -> FloatArray:
    if field_of_view == 2 * np.pi:  # the last ray would fall on the first
        angles = heading + field_of_view * np.arange(num_rays) / num_rays
    elif num_rays == 1:
        angles = np.array([heading])
    else:
        angles = heading + np.linspace(-field_of_view / 2, field_of_view / 2, num_rays)
    rays = np.stack([np.cos(angles), np.sin(angles)])
    rays.flags.writeable = False  # every reading shares it
    return rays


def _of_the_others(seen: FloatArray) -> FloatArray:
    """What the other agents read, in turn, for each agent: ``(world, agent, others · feature)``."""
    num_worlds, num_agents, size = seen.shape
    first, step = np.arange(num_agents)[:, None], np.arange(1, num_agents)
    return seen[:, (first + step) % num_agents].reshape(
        num_worlds, num_agents, (num_agents - 1) * size
    )


# The loops over rays hold no branch and no call that LLVM would not turn into vector instructions.


class _Place(NamedTuple):
    """Where rays begin, and the direction of the x axis that they are given along."""

    x: float  # [m]
    y: float
    c: float
    s: float


class _Solids(NamedTuple):
    """What is solid in one world; see `coopenv.conditions.Room`."""

    half: Any  # [m], of the room's size
    boxes: Any
    axes: Any


@compiled
def _to_walls(place, half, rays, reach, out):
    """Ways from inside a rectangle about the origin to its edge, at most ``reach``."""
    for j in range(rays.shape[1]):
        dx, dy = rotated(place.c, place.s, rays[0, j], rays[1, j])
        dx = dx if abs(dx) > _LEVEL else _LEVEL
        dy = dy if abs(dy) > _LEVEL else _LEVEL
        to_x = ((half[0] if dx > 0.0 else -half[0]) - place.x) / dx
        to_y = ((half[1] if dy > 0.0 else -half[1]) - place.y) / dy
        way = to_x if to_x < to_y else to_y
        out[j] = way if way < reach else reach


@compiled
def _to_box(place, half, rays, out):
    """Shorten ``out`` to the ways to a box about the origin, from outside of it (slabs)."""
    for j in range(rays.shape[1]):
        dx, dy = rotated(place.c, place.s, rays[0, j], rays[1, j])
        per_x = 1.0 / (dx if abs(dx) > _LEVEL else _LEVEL)
        per_y = 1.0 / (dy if abs(dy) > _LEVEL else _LEVEL)
        left, right = (-half[0] - place.x) * per_x, (half[0] - place.x) * per_x
        low, high = (-half[1] - place.y) * per_y, (half[1] - place.y) * per_y
        in_x, out_x = (left, right) if left < right else (right, left)
        in_y, out_y = (low, high) if low < high else (high, low)
        enter = in_x if in_x > in_y else in_y
        leave = out_x if out_x < out_y else out_y
        hit = (enter <= leave) & (enter >= 0.0) & (enter < out[j])
        out[j] = enter if hit else out[j]


@compiled
def _nearest_wall(px, py, half):
    """Vector from a point in the room to the nearest point of a wall, and its length."""
    left_x, left_y = half[0] - abs(px), half[1] - abs(py)
    if left_x <= left_y:
        return np.copysign(left_x, px), 0.0, left_x
    return 0.0, np.copysign(left_y, py), left_y


@compiled
def _read_one(place, solids, rays, reach, out):
    """Readings at a place in the room, world frame."""
    num_rays, boxes = rays.shape[1], solids.boxes
    to_x, to_y, nearest = _nearest_wall(place.x, place.y, solids.half)
    if nearest > 0.0:
        _to_walls(place, solids.half, rays, reach, out)
    for b in range(len(boxes)):
        if nearest <= 0.0:
            break
        c, s = solids.axes[b, 0], solids.axes[b, 1]
        half = (0.5 * boxes[b, 2], 0.5 * boxes[b, 3])
        px, py = seen_from(boxes[b, 0], boxes[b, 1], c, s, place.x, place.y)
        qx = min(max(px, -half[0]), half[0]) - px
        qy = min(max(py, -half[1]), half[1]) - py
        away = np.sqrt(qx * qx + qy * qy)
        if away < nearest:
            to_x, to_y = rotated(c, s, qx, qy)
            nearest = away
        if 0.0 < away < reach:
            ahead, aside = rotated_back(c, s, place.c, place.s)
            _to_box(_Place(px, py, ahead, aside), half, rays, out)
    if nearest <= 0.0:
        out[:] = 0.0
        return
    shrink = min(reach / nearest, 1.0)
    along, across = rotated_back(place.c, place.s, to_x, to_y)
    out[num_rays] = min(max(along * shrink, -reach), reach)
    out[num_rays + 1] = min(max(across * shrink, -reach), reach)
    out[num_rays + 2] = min(nearest, reach)


@compiled
def read_ranges(pose, grips, frame, room, rays, reach):
    """Ways along rays to walls and obstacles, and the nearest point of one.

    Parameters
    ----------
    pose
        ``(world, 3)``, world frame.
    grips, frame
        ``(world, agent, 2)``: where the rays start, object frame [m]; see
        `coopenv.geometry.frames`.
    room
        Size, boxes, axes and count, ``(world, 2)``, ``(world, box, 5)``, ``(world, box, 2)`` and
        ``(world,)``: see `coopenv.conditions.Room`.
    rays
        ``(2, ray)``: x and y of unit vectors in the agent's frame.
    reach
        Beyond it nothing is seen [m].

    Returns
    -------
    ``(world, agent, ray + 3)`` [m]: the way along each ray, at most ``reach``; then the vector to
    the nearest point of a wall or obstacle, agent frame, no longer than ``reach``, and its length.
    All are 0 from inside something solid. What is carried, and who carries it, hides nothing.
    """
    size, boxes, axes, count = room
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, rays.shape[1] + NEAREST))
    for k in range(num_worlds):
        half = (0.5 * size[k, 0], 0.5 * size[k, 1])
        solids = _Solids(half, boxes[k, : count[k]], axes[k, : count[k]])
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            gx, gy = grips[k, i, 0], grips[k, i, 1]
            x, y = placed(pose[k, 0], pose[k, 1], cos_object, sin_object, gx, gy)
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            _read_one(_Place(x, y, c, s), solids, rays, reach, seen[k, i])
    return seen
