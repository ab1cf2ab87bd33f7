"""Scene: the walled room in which the object is carried, and the box obstacles in it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import TypeGuard

import numpy as np

from coopenv.arrays import FARTHEST, FloatArray, number, positive, stated_array
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import moved
from coopenv.physics.body import Body

WALL_THICKNESS = 2.0  # [m]; a beam at full force passes thin walls between two substeps


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A solid rectangular obstacle."""

    center: tuple[float, float]  # [m], world frame
    size: tuple[float, float]  # [m], along its own axes
    angle: float = 0.0  # [rad]

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", _pair(self.center, "obstacle.center"))
        width, height = _pair(self.size, "obstacle.size")
        size = (positive(width, "obstacle.size"), positive(height, "obstacle.size"))
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "angle", number(self.angle, "obstacle.angle"))

    @property
    def row(self) -> tuple[float, float, float, float, float]:
        """Centre x, y, width, height [m] and angle [rad], as kernels have boxes."""
        return (*self.center, *self.size, self.angle)

    def lies_within(self, far: Sequence[float]) -> bool:
        """Whether no corner is farther than ``far`` (x, y) [m] from the world's origin."""
        (x, y), half = self.center, hypot(*self.size) / 2
        if abs(x) + half < far[0] and abs(y) + half < far[1]:  # however it is turned
            return True
        return not (np.abs(self.vertices) > far).any()

    @property
    def vertices(self) -> FloatArray:
        """Corners ``(4, 2)`` [m], world frame, counter-clockwise."""
        half = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.array(self.size) / 2
        return moved(half, (*self.center, self.angle))


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A rectangular room centred on the world's origin, with walls all round and obstacles in it.

    Parameters
    ----------
    size
        Inner width (x) and height (y) [m].
    obstacles
        Boxes in it.
    friction
        Coulomb coefficient of walls and obstacles; a contact takes the product with the body's.
    gravity
        Acceleration in the plane [m/s²], as (0, −9.81) where the plane stands upright and the lower
        wall is its floor. Zero in a plane that is seen from above.
    normal_gravity
        Acceleration onto the plane [m/s²], which presses the body on the ground; what
        ``Body.ground_friction`` goes by. Zero where the plane stands upright.

    Raises
    ------
    InvalidInput
        If a value breaks its rule.
    """

    size: tuple[float, float] = (6.0, 6.0)  # [m]
    obstacles: tuple[Box, ...] = ()
    friction: float = 1.0
    gravity: tuple[float, float] = (0.0, 0.0)  # [m/s²]
    normal_gravity: float = 9.81  # [m/s²]

    def __post_init__(self) -> None:
        width, height = _pair(self.size, "scene.size")
        size = (positive(width, "scene.size", unit="m"), positive(height, "scene.size", unit="m"))
        object.__setattr__(self, "size", size)
        friction = positive(self.friction, "scene.friction", or_zero=True)
        object.__setattr__(self, "friction", friction)
        object.__setattr__(
            self, "gravity", _pair(self.gravity, "scene.gravity", "(x, y) in m/s²", "m/s²")
        )
        normal = positive(self.normal_gravity, "scene.normal_gravity", unit="m/s²", or_zero=True)
        object.__setattr__(self, "normal_gravity", normal)
        if not isinstance(self.obstacles, Sequence) or not all(
            isinstance(obstacle, Box) for obstacle in self.obstacles
        ):
            raise InvalidInput(
                f"scene.obstacles must be a sequence of Box objects, got {self.obstacles!r}; "
                "pass (coopenv.Box(center=..., size=...), ...)"
            )
        object.__setattr__(self, "obstacles", tuple(self.obstacles))

    @property
    def has_weight(self) -> bool:
        """Whether there is gravity in the plane."""
        return self.gravity != (0.0, 0.0)

    def with_gravity(self, strength: float) -> "Scene":
        """A copy with gravity of ``strength`` [m/s²] in the plane, along the scene's own.

        Raises
        ------
        InvalidInput
            If there is none in it, which has no direction.
        """
        if not self.has_weight:
            raise InvalidInput(
                "scene.gravity must have a direction for another strength to be drawn along it, "
                f"got {self.gravity}; pass for example scene=Scene(gravity=(0.0, -9.81))"
            )
        part = strength / float(np.hypot(*self.gravity))
        return replace(self, gravity=(part * self.gravity[0], part * self.gravity[1]))

    def check(self, body: Body) -> None:
        """Raise `InvalidInput` where the body cannot be in this room: wheels need a level one."""
        if self.has_weight and body.nonholonomic:
            raise InvalidInput(
                f"scene.gravity must be (0, 0) for a body on wheels, got {self.gravity}; its "
                "wheels stand on a level ground: take a body without, or gravity away"
            )

    def solids(self) -> list[FloatArray]:
        """Every wall and obstacle as the vertices ``(4, 2)`` of a convex polygon [m]."""
        return self.walls() + [obstacle.vertices for obstacle in self.obstacles]

    def walls(self) -> list[FloatArray]:
        """The four walls, each as the vertices ``(4, 2)`` of a convex polygon [m]."""
        half_x, half_y = self.size[0] / 2, self.size[1] / 2
        far_x, far_y = half_x + WALL_THICKNESS, half_y + WALL_THICKNESS
        return [  # each as long as the corners, or a body deep in one would slip out along it
            _rectangle(-far_x, -far_y, far_x, -half_y),
            _rectangle(-far_x, half_y, far_x, far_y),
            _rectangle(-far_x, -far_y, -half_x, far_y),
            _rectangle(half_x, -far_y, far_x, far_y),
        ]

    def is_clear(self, outline: FloatArray) -> bool:
        """Whether a convex outline ``(v, 2)`` [m] keeps off every obstacle; walls are not asked."""
        return all(_apart(outline, obstacle.vertices) for obstacle in self.obstacles)

    def is_free(self, x: float, y: float) -> bool:
        """Whether a point [m] lies in the room and in no obstacle."""
        in_room = abs(x) < self.size[0] / 2 and abs(y) < self.size[1] / 2
        return in_room and self.is_clear(np.array([(x, y)]))


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def _apart(first: FloatArray, second: FloatArray) -> bool:
    """Whether an edge of one of two convex polygons separates them (separating axes)."""
    for polygon in (first, second):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.stack([edges[:, 1], -edges[:, 0]])  # (2, edge)
        a, b = first @ normals, second @ normals  # (vertex, edge)
        if ((a.max(axis=0) < b.min(axis=0)) | (b.max(axis=0) < a.min(axis=0))).any():
            return True
    return False


def _is_plain_pair(value: object) -> TypeGuard[tuple[float, float]]:
    """Whether nothing has to be looked at: two floats in bounds, as tasks give them."""
    if type(value) is not tuple or len(value) != 2:
        return False
    x, y = value
    plain = type(x) is float and type(y) is float
    return plain and abs(x) <= FARTHEST and abs(y) <= FARTHEST


def _pair(
    value: object, name: str, how: str = "(x, y) in metres", unit: str = "m"
) -> tuple[float, float]:
    if _is_plain_pair(value):
        return value
    array = stated_array(value, name)
    if array.shape != (2,):
        raise InvalidInput(f"{name} must be two numbers, got {value!r}; pass {how}")
    if (np.abs(array) > FARTHEST).any():
        raise InvalidInput(f"{name} must be within {FARTHEST:g} {unit}, got {value!r}; pass {how}")
    return float(array[0]), float(array[1])
