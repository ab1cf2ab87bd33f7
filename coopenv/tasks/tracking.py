"""Tracking task: follow a moving reference with the object."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, pi, sin

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, positive, whole
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput, UnknownName
from coopenv.geometry.frames import placed
from coopenv.observation import Block
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.pose import PoseTask, free_pose
from coopenv.tasks.reference import PEAK, Reference, minimum_jerk_motion
from coopenv.tasks.sight import ahead_in_agent_frames, twist_in_agent_frames
from coopenv.transition import Transition

KINDS = ("minimum_jerk", "rotate", "rotate_translate", "translate")
_TRIES = 200  # references
_LOOKS = 30_000  # at starts of theirs, in all: where hardly one is free, each takes thousands
_TRIES_A_SEGMENT = 20
_STRIDE = 0.1  # [m] that no point of the body moves farther between two poses looked at
_LEAST = 0.25  # of the longest way and the widest turn that a segment may have


def _read_preview(transition: Transition) -> FloatArray:
    state, conditions, task = (
        transition.next_state,
        transition.conditions,
        transition.conditions.task,
    )
    later = np.stack(
        [task.goal_at(conditions.plan, state.time + ahead) for ahead in task.preview], axis=1
    )
    return ahead_in_agent_frames(state.pose, later, conditions.team.frame, conditions.told)


def _read_reference_twist(transition: Transition) -> FloatArray:
    state, conditions = transition.next_state, transition.conditions
    twist = conditions.task.motion(conditions.plan, state.time)[:, 3:6]
    return twist_in_agent_frames(state.pose, twist, conditions.team.frame, conditions.told)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingTask(PoseTask):
    """Follow a reference from its start to its end; done once the object rests there.

    The goal is where the reference is now, so the distance is the tracking error. Success counts
    from the end of the reference on: the object has to rest at its last pose within the
    tolerances, and the mean of the distance since the episode began must not exceed
    ``mean_tolerance``. Give the episode a ``horizon`` that leaves time for it.

    Parameters
    ----------
    reference
        ``"minimum_jerk"``: ``segments`` random minimum-jerk motions one after the other, each of
        place and angle. ``"rotate"``, ``"rotate_translate"``, ``"translate"``: one such motion of
        the kind (the beam transport of the paper's section V), or a sequence of these. Or a
        `Reference`, or the path of a file of one.
    duration
        Of a random reference.
    segments
        Of ``"minimum_jerk"``.
    speed, spin
        The most that a random reference reaches.
    preview
        How far ahead the block ``preview`` looks.
    mean_tolerance
        Bound on the mean of the distance over the episode.

    Raises
    ------
    InvalidInput, UnknownName
        If a value breaks its rule; `check` says so of what depends on body and room.

    Source: Donner, Endo & Buss 2018, section V; their schedules are not printed.
    """

    reference: str | os.PathLike | Sequence[str] | Reference = "minimum_jerk"
    duration: float = 8.0  # [s]
    segments: int = 3
    speed: float = 1.0  # [m/s]
    spin: float = 1.0  # [rad/s]
    preview: tuple[float, ...] = (0.2, 0.5, 1.0)  # [s]
    mean_tolerance: float = 0.3  # [m]

    def __post_init__(self) -> None:
        PoseTask.__post_init__(self)
        self._check_positive("duration", "speed", "spin", "mean_tolerance")
        _set = object.__setattr__
        _set(self, "segments", whole(self.segments, "task.segments", at_least=1, at_most=1000))
        preview = self.preview
        if isinstance(preview, str) or not isinstance(preview, Sequence) or not preview:
            raise InvalidInput(
                f"task.preview must be a sequence of times, got {preview!r}; pass (0.5,) for one"
            )
        _set(self, "preview", tuple(positive(time, "task.preview", unit="s") for time in preview))
        _set(self, "reference", _reference(self.reference))

    @property
    def total(self) -> float:
        """How long the reference lasts [s]."""
        given = self.reference
        return given.duration if isinstance(given, Reference) else self.duration

    @property
    def blocks(self) -> tuple[Block, ...]:
        """``preview`` and ``reference_twist``."""
        times, count = ", ".join(f"{time:g}" for time in self.preview), len(self.preview)
        return (
            Block(
                name="preview",
                size=4 * count,
                describe=f"way from the object to where the reference will be in {times} s: Δx, "
                "Δy, cos Δθ, sin Δθ each; 0 where not told",
                read=_read_preview,
                unit=", ".join(["m, m, 1, 1"] * count),
                frame="agent",
                needs_told=(0, 0, 1, 1) * count,
            ),
            Block(
                name="reference_twist",
                size=3,
                describe="velocity of the reference, and its spin; 0 where not told",
                read=_read_reference_twist,
                unit="m/s, m/s, rad/s",
                frame="agent",
                needs_told=(0, 0, 1),
            ),
        )

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless the object can follow the reference in this room."""
        if not isinstance(self.reference, Reference):
            self.sample(np.random.default_rng(0), body, scene)  # raises where there is no way
            return
        times = np.array(self.reference.times)
        between = (times[:-1, None] + np.diff(times)[:, None] * np.linspace(0, 1, 4)).ravel()
        blocked = _blocked(self.reference.motion(between)[:, :3], body, scene, 0.0)
        if blocked is not None:
            at = self.reference.motion(between[[blocked]])[0, :3]
            raise InvalidInput(
                f"task.reference must keep the body inside the room of {scene.size} m and off its "
                f"obstacles, got x, y, theta = {at.round(3).tolist()} at {between[blocked]:.2f} s; "
                "shift it, or enlarge scene.size"
            )

    def sample(self, generator: np.random.Generator, body: Body, scene: Scene) -> Episode:
        """A reference; the episode starts on it, at rest."""
        if isinstance(self.reference, Reference):
            start = self.reference.motion(np.zeros(1))[0, :3]
            points: list[Pose] = []
        else:
            points = self._points(generator, body, scene)
            start = points[0]
        x, y, angle = (float(number) for number in start)
        plan = tuple(number for point in points for number in point)
        return Episode(start=(x, y, angle), goal=(x, y, angle), plan=plan)

    def motion(self, plan: FloatArray, time: FloatArray) -> FloatArray:
        """Pose, twist and acceleration of the reference, ``(world, 9)``, world frame."""
        if isinstance(self.reference, Reference):
            return self.reference.motion(time)
        return minimum_jerk_motion(plan, time, self.duration)

    def goal_at(self, plan: FloatArray, time: FloatArray) -> FloatArray:
        """Where the reference is, ``(world, 3)``."""
        return self.motion(plan, time)[:, :3]

    def due(self, plan: FloatArray, time: FloatArray) -> BoolArray:
        """Whether the reference has come to its end."""
        return time >= self.total - 1e-9  # control steps add up to it with rounding

    def accepts(self, mean_distance: FloatArray) -> BoolArray:
        """Whether the object stayed near enough on the whole."""
        return mean_distance <= self.mean_tolerance

    def markings(self, plan: FloatArray) -> list[FloatArray]:
        """The path of the object's centre."""
        time = np.linspace(0, self.total, 100)
        return [self.motion(np.tile(plan, (len(time), 1)), time)[:, :2]]

    def _points(self, generator: np.random.Generator, body: Body, scene: Scene) -> list[Pose]:
        """Poses to pass, angles not wrapped, with nothing in the way between them."""
        kinds = _kinds(self.reference, self.segments)
        x, y = (side / 2 - self.clearance for side in scene.size)
        scene = _grown(scene, self.clearance)
        looks = iter(range(_LOOKS))
        for _ in range(_TRIES):
            start = free_pose(generator, body, scene, (-x, -y), (x, y), looks)
            if start is None:
                break
            points = [start]
            for kind in kinds:
                following = self._next(kind, points[-1], generator, body, scene, len(kinds))
                if following is None:
                    break
                points.append(following)
            if len(points) == len(kinds) + 1:
                return points
        raise InvalidInput(
            f"task.reference must fit into the room, got {self.reference!r} in a room of "
            f"{scene.size} m with {len(scene.obstacles)} obstacles, where hundreds of random ones "
            "do not; enlarge scene.size, or take away scene.obstacles"
        )

    def _next(
        self,
        kind: str,
        pose: Pose,
        generator: np.random.Generator,
        body: Body,
        scene: Scene,
        count: int,
    ) -> Pose | None:
        """The end of one of ``count`` segments from ``pose`` on; ``None`` where it finds none."""
        mean = self.duration / count / PEAK  # [s] at top speed, for the same way
        longest = min(self.speed * mean, min(scene.size) / 2)  # [m]
        widest = min(self.spin * mean, pi)  # [rad]
        x, y, angle = pose
        outline, floor = np.array(body.outline), _floor(scene, self.clearance)
        for _ in range(_TRIES_A_SEGMENT):
            direction, far, round_, sign = generator.random(4).tolist()
            way = 0.0 if kind == "rotate" else longest * (_LEAST + (1 - _LEAST) * far)
            turn = 0.0 if kind == "translate" else widest * (_LEAST + (1 - _LEAST) * round_)
            turn = turn if sign < 0.5 else -turn
            end = (
                x + way * cos(2 * pi * direction),
                y + way * sin(2 * pi * direction),
                angle + turn,
            )
            looks = 2 + int((way + abs(turn) * body.reach) / _STRIDE)
            if _leaves(pose, end, looks, outline, floor):
                continue
            if not scene.obstacles or _is_clear(np.linspace(pose, end, looks), body, scene):
                return end
        return None


def _blocked(poses: FloatArray, body: Body, scene: Scene, clearance: float) -> int | None:
    """The first of ``poses`` ``(pose, 3)`` in which the body is not free, if there is one."""
    outlines = _outlines(poses, np.array(body.outline))
    blocked = _first_outside(outlines, _floor(scene, clearance))
    if blocked >= 0:
        return blocked
    for number, outline in enumerate(outlines if scene.obstacles else ()):
        if not scene.is_clear(outline):
            return number
    return None


def _is_clear(poses: FloatArray, body: Body, scene: Scene) -> bool:
    """Whether the body keeps off all obstacles in all ``poses`` ``(pose, 3)``."""
    return all(map(scene.is_clear, _outlines(poses, np.array(body.outline))))


def _floor(scene: Scene, clearance: float) -> tuple[float, float]:
    """How far from the room's centre corners of a body may be along x and y [m]."""
    width, height = scene.size
    return width / 2 - clearance + 1e-9, height / 2 - clearance + 1e-9


@compiled
def _outlines(poses, outline):
    """An outline ``(v, 2)`` of the object frame at each pose, ``(pose, v, 2)``."""
    out = np.empty((len(poses), len(outline), 2))
    for k in range(len(poses)):
        c, s = np.cos(poses[k, 2]), np.sin(poses[k, 2])
        for j in range(len(outline)):
            x, y = outline[j]
            out[k, j, 0], out[k, j, 1] = placed(poses[k, 0], poses[k, 1], c, s, x, y)
    return out


@compiled
def _leaves(start, end, looks, outline, half):
    """Whether an outline has a corner beyond ±``half`` on the way between two poses.

    Looked at are so many, to the bits of those of `numpy.linspace`.
    """
    last = looks - 1
    dx, dy, turn = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    stays = dx / last == 0.0 or dy / last == 0.0 or turn / last == 0.0
    for k in range(looks):
        x, y, angle = end
        if k < last and stays:
            part = k / last
            x, y, angle = part * dx + start[0], part * dy + start[1], part * turn + start[2]
        elif k < last:
            x, y = k * (dx / last) + start[0], k * (dy / last) + start[1]
            angle = k * (turn / last) + start[2]
        c, s = np.cos(angle), np.sin(angle)
        for j in range(len(outline)):
            corner_x, corner_y = placed(x, y, c, s, outline[j, 0], outline[j, 1])
            if abs(corner_x) > half[0] or abs(corner_y) > half[1]:
                return True
    return False


@compiled
def _first_outside(outlines, half):
    """The first outline with a corner beyond ±``half``, or −1."""
    for k in range(len(outlines)):
        for corner in outlines[k]:
            if abs(corner[0]) > half[0] or abs(corner[1]) > half[1]:
                return k
    return -1


@lru_cache
def _grown(scene: Scene, by: float) -> Scene:
    """The scene with obstacles that reach farther by so much [m] on all sides."""
    grown = (
        replace(box, size=(box.size[0] + 2 * by, box.size[1] + 2 * by)) for box in scene.obstacles
    )
    return replace(scene, obstacles=tuple(grown))


def _kinds(reference: object, segments: int) -> tuple[str, ...]:
    """The kind of each segment of a random reference."""
    if reference == "minimum_jerk":
        return ("rotate_translate",) * segments
    return (reference,) if isinstance(reference, str) else tuple(reference)  # pyright: ignore[reportArgumentType]


def _reference(value: object) -> str | tuple[str, ...] | Reference:
    """A kind, several, or a table read from where it is."""
    if isinstance(value, Reference):
        return value
    if isinstance(value, Mapping):  # as JSON brings it back
        if set(value) != {"times", "poses"}:
            raise InvalidInput(
                f"task.reference must have times and poses, got {sorted(value)}; give both"
            )
        return Reference(**value)
    if isinstance(value, os.PathLike) or (isinstance(value, str) and _is_path(value)):
        return Reference.load(value)
    if isinstance(value, str):
        if value not in KINDS:
            raise UnknownName("task.reference", value, KINDS)
        return value
    if isinstance(value, Sequence) and len(value):
        for kind in value:
            if kind not in KINDS[1:]:
                raise UnknownName("task.reference", kind, KINDS[1:])
        return tuple(value)
    raise InvalidInput(
        f"task.reference must be one of {KINDS}, a Reference or a file, got {value!r}; "
        "pass for example 'translate'"
    )


def _is_path(value: str) -> bool:
    return value.endswith((".csv", ".npz")) or os.sep in value
