"""Shard: worlds far apart in one pymunk space. The only file that imports pymunk.

`pymunk.batch` is marked experimental upstream; everything used of it is here. So is what stands
behind it, without which each substep would ask for the interpreter's lock six times: functions of
pymunk's library, by their addresses, and the two structures that they take.
"""

import atexit
import ctypes
import weakref
from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
import numpy.typing as npt
import pymunk
import pymunk.batch as batch
from pymunk._chipmunk import ffi, lib

from coopenv.arrays import FloatArray, IntArray
from coopenv.physics.advance import Memory
from coopenv.physics.body import Body
from coopenv.physics.coefficients import CONTACT, coefficients
from coopenv.physics.friction import held
from coopenv.physics.native import EACH_BODY, GET_BODY, NUM_CALLS, SET_BODY, STEP
from coopenv.physics.scene import WALL_THICKNESS, Scene

SOLVER_ITERATIONS = 10
COLLISION_SLOP = 1e-3  # [m] overlap left alone; pymunk's default of 0.1 is meant for pixels
# Substeps without contact after which its impulse is forgotten. In the first substep of a contact
# pymunk does not apply a remembered impulse but takes it back all the same, friction's part too:
# under the default of 3 a body that touched a wall again was pulled or pushed by an old impact.
COLLISION_PERSISTENCE = 1

Space = pymunk.Space  # for annotations elsewhere

_FUNCTIONS = {
    STEP: "cpSpaceStep",
    EACH_BODY: "cpSpaceEachBody",
    SET_BODY: "pmSpaceBodySetIteratorFuncBatched",
    GET_BODY: "pmSpaceBodyGetIteratorFuncBatched",
}

_COMMANDS = (
    batch.BodyFields.VELOCITY
    | batch.BodyFields.ANGULAR_VELOCITY
    | batch.BodyFields.FORCE
    | batch.BodyFields.TORQUE
)
_REPORTS = (
    batch.BodyFields.POSITION
    | batch.BodyFields.ANGLE
    | batch.BodyFields.VELOCITY
    | batch.BodyFields.ANGULAR_VELOCITY
)


def calls() -> IntArray:
    """``(NUM_CALLS,)`` addresses of what `coopenv.physics.native` calls, in this process."""
    found = [ffi.addressof(lib, _FUNCTIONS[number]) for number in range(NUM_CALLS)]
    return np.array([_address(function) for function in found])


def _address(of: Any) -> int:
    return int(ffi.cast("uintptr_t", of))


class Shard:
    """Worlds far apart on a grid in one pymunk space, which compiled code steps (`advance`).

    ``memory`` is the shard's part of what that keeps; it is written here at the beginning, and
    where bodies are replaced.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        substep: float,
        reach: float,
        memory: Memory,
    ):
        self._bodies, self._scenes, self._substep = list(bodies), list(scenes), substep
        self._memory, self._table = memory, memory.table
        self._table[:] = _table(bodies, scenes, substep)
        self.space = pymunk.Space()
        _spaces.add(self.space)
        self.space.iterations = SOLVER_ITERATIONS
        self.space.collision_slop = COLLISION_SLOP
        self.space.collision_persistence = COLLISION_PERSISTENCE
        self._origin = _grid(scenes, reach)
        memory.rooms[:, :2] = self._origin
        memory.rooms[:, 2:] = np.array([scene.size for scene in scenes]) / 2 + WALL_THICKNESS
        for scene, origin in zip(scenes, self._origin, strict=True):
            self._build(scene.walls(), origin, scene.friction, [])
        self._obstacles: list[list[pymunk.Poly]] = [[] for _ in scenes]
        for scene, origin, built in zip(scenes, self._origin, self._obstacles, strict=True):
            self._build([box.vertices for box in scene.obstacles], origin, scene.friction, built)
        self._torn: set[int] = set()  # worlds that a call began to furnish, and broke off
        self._ids = np.zeros(len(bodies), dtype=np.int64)
        self._made = list(bodies)  # what the bodies in the space were made from
        self._shapes: list[pymunk.Poly] = []
        for k, (x, y) in enumerate(self._origin.tolist()):
            self._add(k, x, y, 0.0)
        self._names = _buffer(self)
        self._find_rows()
        self._views = [
            self._view(_COMMANDS, memory.commands[0], memory.cursors[0, 0]),
            self._view(_REPORTS, memory.reports[0], memory.cursors[0, 1]),
        ]
        handles = (self.space._space, *(view for view, *_ in self._views))
        memory.handles[0] = [_address(handle) for handle in handles]

    def furnish(self, worlds: IntArray, bodies: Sequence[Body], scenes: Sequence[Scene]) -> None:
        """As `World.furnish`; here as below, worlds are counted within the shard."""
        chosen = worlds.tolist()
        torn = self._torn.intersection(chosen)
        self._torn.update(chosen)  # should this break off
        moves = [
            j
            for j, k in enumerate(chosen)
            if k in torn
            or not _moves_alike((bodies[j], scenes[j]), (self._bodies[k], self._scenes[k]))
        ]
        if moves:
            others = [bodies[j] for j in moves], [scenes[j] for j in moves]
            self._table[worlds[moves]] = _table(*others, self._substep)
        for k, body, scene in zip(chosen, bodies, scenes, strict=True):
            before, self._bodies[k], self._scenes[k] = self._scenes[k], body, scene
            if k in torn or not (scene is before or scene == before):
                self._clear(k)
                boxes = [box.vertices for box in scene.obstacles]
                self._build(boxes, self._origin[k], scene.friction, self._obstacles[k])
        self._torn.difference_update(chosen)

    def place(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put the bodies of ``worlds`` at ``pose``, at rest and untouched."""
        position = (pose[:, :2] + self._origin[worlds]).tolist()
        for k, (x, y), angle in zip(worlds.tolist(), position, pose[:, 2].tolist(), strict=True):
            shape = self._shapes[k]
            body = shape.body
            assert body is not None
            if shape.space is not None:  # else the call before broke off
                # And with it the impulses that warm-start its next contact
                self.space.remove(shape)
            made, stays = self._made[k], body.space is not None and _is_sane(body)
            if stays and (made is self._bodies[k] or made == self._bodies[k]):
                _rest(body, x, y, angle)
                self.space.add(shape)
            else:
                if body.space is not None:
                    self.space.remove(body)
                self._add(k, x, y, angle)
        self._memory.expected[worlds] = 0.0  # no contact lasts
        # A step of no time moves nothing. It lets go of the shapes that were removed, which the
        # space otherwise keeps until it steps, however often worlds are placed meanwhile.
        self.space.step(0.0)
        if not self._knows_rows:
            self._find_rows()

    def move(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put bodies that remember no contact elsewhere."""
        self._memory.expected[worlds] = 0.0  # what they touched before they were there
        position = (pose[:, :2] + self._origin[worlds]).tolist()
        for k, (x, y), angle in zip(worlds.tolist(), position, pose[:, 2].tolist(), strict=True):
            body = self._shapes[k].body
            assert body is not None
            body.position, body.angle = (x, y), angle

    @property
    def lasting(self) -> FloatArray:
        """What contacts made of the twists in the last substep, ``(world, 3)``, to be read and set.

        It bears bodies with weight in the next one, and only they have any [m/s, rad/s].
        """
        return self._memory.expected[:, CONTACT : CONTACT + 3]

    def _clear(self, k: int) -> None:
        """Take the obstacles of world ``k`` out of the space, also where a call broke off."""
        while self._obstacles[k]:
            obstacle = self._obstacles[k][-1]
            if obstacle.space is not None:
                self.space.remove(obstacle)
            obstacle.body = None  # else the static body keeps it for good
            self._obstacles[k].pop()

    def _build(
        self,
        solids: Sequence[FloatArray],
        origin: FloatArray,
        friction: float,
        built: list[pymunk.Poly],
    ) -> None:
        """Put solids into the space where nothing moves them; each is noted before it is there."""
        for solid in solids:
            shape = pymunk.Poly(self.space.static_body, (solid + origin).tolist())
            shape.friction = friction
            built.append(shape)
            self.space.add(shape)

    def _add(self, k: int, x: float, y: float, angle: float) -> None:
        """Make the body of world ``k``; noted before it is in the space, should that break off."""
        body = pymunk.Body(self._bodies[k].mass, self._bodies[k].inertia or 0.0)
        body.position, body.angle = (x, y), angle
        shape = pymunk.Poly(body, self._bodies[k].outline)
        shape.friction = self._bodies[k].friction
        self._knows_rows = False
        self._shapes[k : k + 1], self._ids[k], self._made[k] = [shape], body.id, self._bodies[k]
        self.space.add(body, shape)

    def _view(
        self, names: batch.BodyFields, array: FloatArray, header: npt.NDArray[np.int32]
    ) -> tuple[Any, ...]:
        """What pymunk takes for an array that it reads or writes, and what has to live as long.

        Its header is in memory that kernels reach: the first number of it is how much of the array
        was read or written.
        """
        floats = ffi.cast("pmFloatArray *", ffi.from_buffer(header))
        floats.arr = ffi.cast("cpFloat *", ffi.from_buffer(array))
        floats.num, floats.max = 0, array.size
        none = ffi.new("pmIntArray *")
        view = ffi.new("pmBatchedData *")
        view.fields, view.floatArray, view.intArray = names.value, floats, none
        return view, none, array, header

    def _find_rows(self) -> None:
        """Note the row of each world in pymunk's order, which changes when a body is replaced."""
        self._names.clear()
        batch.get_space_bodies(self.space, batch.BodyFields.BODY_ID, self._names)
        listed = np.frombuffer(self._names.int_buf(), dtype=np.uintp).astype(np.int64)
        order = np.argsort(listed)
        self._memory.rows[:] = order[np.searchsorted(listed, self._ids, sorter=order)]
        self._knows_rows = True


def _is_sane(body: pymunk.Body) -> bool:
    """Whether a body is somewhere: one that a wall flung off its numbers cannot be put back."""
    return isfinite(sum(body.position) + sum(body.velocity) + body.angle + body.angular_velocity)


def _rest(body: pymunk.Body, x: float, y: float, angle: float) -> None:
    """Leave nothing to a body of what it did before."""
    body.velocity, body.angular_velocity = (0.0, 0.0), 0.0
    # Over no time it goes nowhere, and loses the velocity that corrects the last contact
    pymunk.Body.update_position(body, 0.0)
    body.position, body.angle = (x, y), angle


def _moves_alike(one: tuple[Body, Scene], other: tuple[Body, Scene]) -> bool:
    """Whether two bodies have the same coefficients in their scenes, where nothing is touched."""
    (body, scene), (other_body, other_scene) = one, other
    if body is not other_body and body != other_body:
        return False
    return scene is other_scene or (
        scene.gravity == other_scene.gravity and scene.normal_gravity == other_scene.normal_gravity
    )


def _table(bodies: Sequence[Body], scenes: Sequence[Scene], substep: float) -> FloatArray:
    return coefficients(
        np.array([body.mass for body in bodies]),
        np.array([body.inertia for body in bodies]),
        np.array([body.linear_drag for body in bodies]),
        np.array([body.angular_drag for body in bodies]),
        substep,
        np.array([body.nonholonomic for body in bodies]),
        np.array([body.reach for body in bodies]),
        np.array([scene.gravity for scene in scenes]),
        np.array([held(body, scene) for body, scene in zip(bodies, scenes, strict=True)]),
    )


_spaces: weakref.WeakSet[pymunk.Space] = weakref.WeakSet()


@atexit.register
def _keep_spaces() -> None:
    """Never free those that are left, since what pymunk calls to free one may be gone by then.

    It would crash a process that ends where another library still holds its environment.
    """
    for space in list(_spaces):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(space))


_spare: list[batch.Buffer] = []  # of owners that are gone; pymunk never frees the memory of one


def _buffer(owner: object) -> batch.Buffer:
    """A buffer of pymunk's, for another owner once this one is gone."""
    try:
        buffer = _spare.pop()
    except IndexError:
        buffer = batch.Buffer()
    weakref.finalize(owner, _give_back, buffer).atexit = False  # worlds may still be stepped then
    return buffer


def _give_back(buffer: batch.Buffer) -> None:
    buffer.set_float_buf(np.zeros(1))  # lets go of the owner's array
    _spare.append(buffer)


def _grid(scenes: Sequence[Scene], reach: float) -> FloatArray:
    """Centres of the worlds ``(world, 2)`` [m], too far apart for anything to reach over."""
    farthest = max(np.abs(solid).max() for scene in scenes for solid in scene.solids())  # [m]
    pitch = 2 * farthest + 2 * reach
    columns = int(np.ceil(np.sqrt(len(scenes))))
    index = np.arange(len(scenes))
    return pitch * np.stack([index % columns, index // columns], axis=-1).astype(np.float64)
