"""World: batches of bodies in rooms, simulated by pymunk. The only file that imports it.

`pymunk.batch` is marked experimental upstream; everything used of it is in `_Shard`.
"""

import weakref
from collections.abc import Sequence

import numpy as np
import pymunk
import pymunk.batch as batch

from coopenv.arrays import FloatArray, IntArray, has_items, with_items
from coopenv.errors import BodyLost, InvalidInput
from coopenv.physics import motion
from coopenv.physics.body import Body
from coopenv.physics.scene import WALL_THICKNESS, Scene
from coopenv.physics.threads import side_by_side

SHARD_SIZE = 256  # worlds in one pymunk space; the broad phase degrades in the thousands
SOLVER_ITERATIONS = 10
COLLISION_SLOP = 1e-3  # [m] overlap left alone; pymunk's default of 0.1 is meant for pixels
# Substeps without contact after which its impulse is forgotten. In the first substep of a contact
# pymunk does not apply a remembered impulse but takes it back all the same, friction's part too:
# under the default of 3 a body that touched a wall again was pulled or pushed by an old impact.
COLLISION_PERSISTENCE = 1

_STATE = ("pose", "twist", "contact_impulse", "contact_shift")
_REPORT = (
    batch.BodyFields.POSITION
    | batch.BodyFields.ANGLE
    | batch.BodyFields.VELOCITY
    | batch.BodyFields.ANGULAR_VELOCITY
)
_COMMAND = (
    batch.BodyFields.VELOCITY
    | batch.BodyFields.ANGULAR_VELOCITY
    | batch.BodyFields.FORCE
    | batch.BodyFields.TORQUE
)


class World:
    """``len(bodies)`` worlds, each with its own body and scene, none touching another.

    Parameters
    ----------
    bodies, scenes
        One entry a world.
    dt
        Control step [s].
    substeps
        Physics steps in a control step.
    reach
        Distance of the farthest point of any body there may ever be from its centre of mass [m];
        ``None``: of those given.

    Attributes
    ----------
    pose, twist
        ``(world, 3)``: (x, y, θ) [m, rad], not wrapped, and its rate; world frame.
    contact_impulse
        ``(world,)`` [N·s] what walls and obstacles gave the body during the last `step`; see
        `coopenv.physics.motion.collect`.
    contact_shift
        ``(world,)`` [m] how far the parting of overlaps moved the body during the last `step`, its
        farthest point at most; no impulse tells of that. See the same.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        *,
        dt: float,
        substeps: int,
        reach: float | None = None,
    ):
        self.bodies, self.scenes = tuple(bodies), tuple(scenes)
        self.num_worlds = len(self.bodies)
        self.substeps, self.substep = substeps, dt / substeps
        self.pose = np.zeros((self.num_worlds, 3))
        self.twist = np.zeros((self.num_worlds, 3))
        self.contact_impulse = np.zeros(self.num_worlds)
        self.contact_shift = np.zeros(self.num_worlds)
        reach = max(body.reach for body in self.bodies) if reach is None else reach
        self._shards = [
            _Shard(
                self.bodies[start : start + SHARD_SIZE],
                self.scenes[start : start + SHARD_SIZE],
                self.substep,
                reach,
            )
            for start in range(0, self.num_worlds, SHARD_SIZE)
        ]

    @property
    def spaces(self) -> list[pymunk.Space]:
        """The pymunk spaces, for measurements; worlds may be stored in any order in them."""
        return [shard.space for shard in self._shards]

    def furnish(self, worlds: IntArray, bodies: Sequence[Body], scenes: Sequence[Scene]) -> None:
        """Give ``worlds`` other bodies and obstacles, one entry each; call `place` afterwards.

        Rooms keep their size. No body may reach farther than those the world was made with.
        """
        self.bodies = with_items(self.bodies, worlds, bodies)
        self.scenes = with_items(self.scenes, worlds, scenes)
        for number, shard in enumerate(self._shards):
            inside = np.flatnonzero(worlds // SHARD_SIZE == number).tolist()
            if inside:
                shard.furnish(
                    worlds[inside] - number * SHARD_SIZE,
                    [bodies[j] for j in inside],
                    [scenes[j] for j in inside],
                )

    def place(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put the bodies of ``worlds`` at ``pose`` ``(len(worlds), 3)``, at rest and untouched."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.contact_impulse = self.contact_impulse.copy()
        self.contact_shift = self.contact_shift.copy()
        self.pose[worlds], self.twist[worlds] = pose, 0
        self.contact_impulse[worlds] = self.contact_shift[worlds] = 0
        for number, shard in enumerate(self._shards):
            inside = worlds // SHARD_SIZE == number
            if inside.any():
                shard.place(worlds[inside] - number * SHARD_SIZE, pose[inside])

    def get_state(self, worlds: IntArray) -> dict[str, FloatArray]:
        """Where the bodies of ``worlds`` are and how they move, one row each."""
        return {name: getattr(self, name)[worlds] for name in _STATE}

    def check_rooms(self, worlds: IntArray, scenes: Sequence[Scene]) -> None:
        """Raise `InvalidInput` where a world's walls are not those of the scene it is given."""
        for k, scene in zip(worlds.tolist(), scenes, strict=True):
            if scene is self.scenes[k]:
                continue
            mine, given = _walls(self.scenes[k]), _walls(scene)
            if mine != given:
                raise InvalidInput(
                    f"state must be of a room with the walls of its new world, {mine} (size [m], "
                    f"friction) in world {k}, got {given}; put it into a world with such walls"
                )

    def set_state(
        self,
        state: dict[str, FloatArray],
        worlds: IntArray,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        *,
        anew: bool,
    ) -> None:
        """Go on in ``worlds`` from what `get_state` returned, with bodies and scenes of then.

        What pymunk remembers of contacts is not in it, so that nothing has been touched. Positions
        are exact in the worlds they were read from: there, pymunk's own differ from them by the
        world's origin without rounding.

        Only bodies that touched something in the last step, in which pymunk would remember that,
        or that are others now, are made ``anew``; or all, if that step broke off.
        """
        if not (has_items(self.bodies, worlds, bodies) and has_items(self.scenes, worlds, scenes)):
            self.furnish(worlds, bodies, scenes)
            anew = True
        touched = (self.contact_impulse[worlds] != 0) | (self.contact_shift[worlds] != 0) | anew
        self.place(worlds[touched], state["pose"][touched])
        self._move(worlds[~touched], state["pose"][~touched])
        for name in _STATE:
            getattr(self, name)[worlds] = state[name]

    def _move(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put bodies that remember no contact elsewhere, which is quicker than to make others."""
        for number, shard in enumerate(self._shards):
            inside = worlds // SHARD_SIZE == number
            shard.move(worlds[inside] - number * SHARD_SIZE, pose[inside])

    def step(self, wrench: FloatArray) -> None:
        """Advance one control step under ``wrench`` ``(world, 3)`` [N, N·m], held in object frame.

        `pose`, `twist`, `contact_impulse` and `contact_shift` become fresh arrays; the old ones
        stay as they were.

        Raises
        ------
        BodyLost
            If a body is too fast for its substeps and got through a wall.
        """
        before = self.pose, self.twist, wrench
        self.pose, self.twist = np.empty((self.num_worlds, 3)), np.empty((self.num_worlds, 3))
        self.contact_impulse = np.zeros(self.num_worlds)
        self.contact_shift = np.zeros(self.num_worlds)
        reached = self.pose, self.twist, self.contact_impulse, self.contact_shift
        if len(self._shards) == 1:  # as below, without slicing, which one world would feel
            self._shards[0].step(before, reached, self.substeps)
            return

        def advance(number: int) -> None:
            part = slice(number * SHARD_SIZE, (number + 1) * SHARD_SIZE)
            own = tuple(array[part] for array in before), tuple(array[part] for array in reached)
            self._shards[number].step(*own, self.substeps)

        # pymunk and the compiled kernels release the interpreter lock, so shards run in parallel.
        side_by_side(advance, len(self._shards))


class _Shard:
    """Worlds far apart on a grid in one pymunk space."""

    def __init__(
        self, bodies: Sequence[Body], scenes: Sequence[Scene], substep: float, reach: float
    ):
        self._bodies, self._scenes, self._substep = list(bodies), list(scenes), substep
        self._table = _table(bodies, substep)
        self.space = pymunk.Space()
        self.space.iterations = SOLVER_ITERATIONS
        self.space.collision_slop = COLLISION_SLOP
        self.space.collision_persistence = COLLISION_PERSISTENCE
        self._origin = _grid(scenes, reach)
        bounds = np.array([scene.size for scene in scenes]) / 2 + WALL_THICKNESS
        self._rooms = np.concatenate([self._origin, bounds], axis=1)
        for scene, origin in zip(scenes, self._origin, strict=True):
            self._build(scene.walls(), origin, scene.friction)
        self._obstacles = [
            self._build([box.vertices for box in scene.obstacles], origin, scene.friction)
            for scene, origin in zip(scenes, self._origin, strict=True)
        ]
        self._ids = np.zeros(len(bodies), dtype=np.int64)
        self._shapes = [self._add(k, x, y, 0.0) for k, (x, y) in enumerate(self._origin.tolist())]
        self._expected = np.zeros((len(bodies), 6))
        self._command, self._commands = _array_of(_buffer(self), len(bodies))
        self._report, self._reports = _array_of(_buffer(self), len(bodies))
        self._names = _buffer(self)
        self._rows = self._find_rows()

    def furnish(self, worlds: IntArray, bodies: Sequence[Body], scenes: Sequence[Scene]) -> None:
        self._table[worlds] = _table(bodies, self._substep)
        for k, body, scene in zip(worlds.tolist(), bodies, scenes, strict=True):
            self._bodies[k] = body
            if scene == self._scenes[k]:
                continue
            self._scenes[k] = scene
            for obstacle in self._obstacles[k]:
                self.space.remove(obstacle)
                obstacle.body = None  # else the static body keeps it for good
            boxes = [box.vertices for box in scene.obstacles]
            self._obstacles[k] = self._build(boxes, self._origin[k], scene.friction)

    def place(self, worlds: IntArray, pose: FloatArray) -> None:
        # A new body as well as a new shape: the correction velocity of the last contact stays
        # with the body, the impulses that warm-start the next one with the shape.
        position = (pose[:, :2] + self._origin[worlds]).tolist()
        for k, (x, y), angle in zip(worlds.tolist(), position, pose[:, 2].tolist(), strict=True):
            old = self._shapes[k]
            assert old.body is not None
            self.space.remove(old, old.body)
            self._shapes[k] = self._add(k, x, y, angle)
        # A step of no time moves nothing. It lets go of the shapes that were removed, which the
        # space otherwise keeps until it steps, however often worlds are placed meanwhile.
        self.space.step(0.0)
        self._rows = self._find_rows()

    def move(self, worlds: IntArray, pose: FloatArray) -> None:
        position = (pose[:, :2] + self._origin[worlds]).tolist()
        for k, (x, y), angle in zip(worlds.tolist(), position, pose[:, 2].tolist(), strict=True):
            body = self._shapes[k].body
            assert body is not None
            body.position, body.angle = (x, y), angle

    def step(
        self,
        before: tuple[FloatArray, ...],
        reached: tuple[FloatArray, ...],
        substeps: int,
    ) -> None:
        """Go on from pose and twist under a wrench; writes pose, twist, impulse and shift."""
        rows, table, expected, substep = self._rows, self._table, self._expected, self._substep
        pose, wrench, buffers = reached[0], before[2], (self._report, self._command)
        motion.drive(rows, table, *before, substep, self._command, expected)
        for _ in range(substeps - 1):
            self._move()
            lost = motion.collect_and_drive(
                rows, table, self._rooms, buffers, expected, reached, wrench, substep
            )
            self._check_held(lost, pose)
        self._move()
        lost = motion.collect(rows, table, self._rooms, self._report, expected, *reached)
        self._check_held(lost, pose)

    def _move(self) -> None:
        """Let pymunk read the commands, step, and report."""
        batch.set_space_bodies(self.space, _COMMAND, self._commands)
        self.space.step(self._substep)
        self._reports.clear()
        batch.get_space_bodies(self.space, _REPORT, self._reports)

    def _check_held(self, lost: int, pose: FloatArray) -> None:
        """Raise `BodyLost` for the world ``lost``, if it is one."""
        if lost >= 0:
            x, y = pose[lost, :2]
            raise BodyLost(
                f"the body must stay in its room, got ({x:.1f}, {y:.1f}) m, beyond the walls; "
                "use more substeps, a heavier body, more drag or weaker agents"
            )

    def _build(
        self, solids: Sequence[FloatArray], origin: FloatArray, friction: float
    ) -> list[pymunk.Poly]:
        """Put solids into the space where nothing moves them."""
        built = []
        for solid in solids:
            shape = pymunk.Poly(self.space.static_body, (solid + origin).tolist())
            shape.friction = friction
            self.space.add(shape)
            built.append(shape)
        return built

    def _add(self, k: int, x: float, y: float, angle: float) -> pymunk.Poly:
        body = pymunk.Body(self._bodies[k].mass, self._bodies[k].inertia or 0.0)
        body.position, body.angle = (x, y), angle
        shape = pymunk.Poly(body, self._bodies[k].outline)
        shape.friction = self._bodies[k].friction
        self.space.add(body, shape)
        self._ids[k] = body.id
        return shape

    def _find_rows(self) -> IntArray:
        """The row of each world in pymunk's order, which changes when a body is replaced."""
        self._names.clear()
        batch.get_space_bodies(self.space, batch.BodyFields.BODY_ID, self._names)
        listed = np.frombuffer(self._names.int_buf(), dtype=np.uintp).astype(np.int64)
        order = np.argsort(listed)
        return order[np.searchsorted(listed, self._ids, sorter=order)]


def _walls(scene: Scene) -> tuple[tuple[float, float], float]:
    return scene.size, scene.friction


def _table(bodies: Sequence[Body], substep: float) -> FloatArray:
    return motion.coefficients(
        np.array([body.mass for body in bodies]),
        np.array([body.inertia for body in bodies]),
        np.array([body.linear_drag for body in bodies]),
        np.array([body.angular_drag for body in bodies]),
        substep,
        np.array([body.nonholonomic for body in bodies]),
        np.array([body.reach for body in bodies]),
    )


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


def _array_of(buffer: batch.Buffer, num_bodies: int) -> tuple[FloatArray, batch.Buffer]:
    """An array of six columns that pymunk reads and writes in place through ``buffer``.

    The static body takes a row after the others. One more stays empty: pymunk reallocates a
    buffer as soon as it is full, and this memory is NumPy's.
    """
    array = np.zeros((num_bodies + 2, 6))
    buffer.set_float_buf(array)
    return array, buffer


def _grid(scenes: Sequence[Scene], reach: float) -> FloatArray:
    """Centres of the worlds ``(world, 2)`` [m], too far apart for anything to reach over."""
    farthest = max(np.abs(solid).max() for scene in scenes for solid in scene.solids())  # [m]
    pitch = 2 * farthest + 2 * reach
    columns = int(np.ceil(np.sqrt(len(scenes))))
    index = np.arange(len(scenes))
    return pitch * np.stack([index % columns, index // columns], axis=-1).astype(np.float64)
