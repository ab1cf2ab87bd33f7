"""World: batches of bodies in rooms, a shard of them in each pymunk space."""

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from coopenv.arrays import FloatArray, IntArray, has_items, with_items
from coopenv.compiled.parallel import sharing
from coopenv.errors import BodyLost, InvalidInput
from coopenv.physics.advance import Memory, hold_shards, step_shards
from coopenv.physics.body import Body
from coopenv.physics.coefficients import SPECIAL
from coopenv.physics.compliance import Hold
from coopenv.physics.scene import Scene
from coopenv.physics.shard import Shard, Space, calls
from coopenv.physics.surroundings import NUM_GIVEN

SHARD_SIZE = 256  # worlds in one pymunk space; the broad phase degrades in the thousands

_STATE = ("pose", "twist", "contact_impulse", "contact_shift", "given")


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
        `coopenv.physics.collect.collect`.
    contact_shift
        ``(world,)`` [m] how far the parting of overlaps moved the body during the last `step`, its
        farthest point at most; no impulse tells of that. See the same.
    given
        ``(world, 4)`` what surroundings gave the body during the last `step`, mean over it, object
        frame: the wrench of contacts and wheels at the centre of mass, and the force of the wheels
        alone, along y [N, N, N·m, N]; see `coopenv.physics.surroundings`.
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
        self.substeps, self.substep, self._dt = substeps, dt / substeps, dt
        self.pose = np.zeros((self.num_worlds, 3))
        self.twist = np.zeros((self.num_worlds, 3))
        self.contact_impulse = np.zeros(self.num_worlds)
        self.contact_shift = np.zeros(self.num_worlds)
        self.given = np.zeros((self.num_worlds, NUM_GIVEN))
        reach = max(body.reach for body in self.bodies) if reach is None else reach
        self._size = min(SHARD_SIZE, self.num_worlds)
        self._memory, self._calls = Memory.of(self.num_worlds, self._size), calls()
        self._shards = [
            Shard(
                self.bodies[start : start + SHARD_SIZE],
                self.scenes[start : start + SHARD_SIZE],
                self.substep,
                reach,
                self._memory.shard(start // SHARD_SIZE, self._size),
            )
            for start in range(0, self.num_worlds, SHARD_SIZE)
        ]
        self._lost = np.full(len(self._shards), -1)
        self._special: Literal[True] | None = None
        self._held = self._calls, (*self._memory, True)  # as kernels take them
        self._look_for_special()

    @property
    def spaces(self) -> list[Space]:
        """The pymunk spaces, for measurements; worlds may be stored in any order in them."""
        return [shard.space for shard in self._shards]

    def furnish(self, worlds: IntArray, bodies: Sequence[Body], scenes: Sequence[Scene]) -> None:
        """Give ``worlds`` other bodies and obstacles, one entry each; call `place` afterwards.

        Rooms keep their size. No body may reach farther than those the world was made with.
        """
        self.bodies = with_items(self.bodies, worlds, bodies)
        self.scenes = with_items(self.scenes, worlds, scenes)
        try:
            for number, shard in enumerate(self._shards):
                inside = np.flatnonzero(worlds // SHARD_SIZE == number).tolist()
                if inside:
                    shard.furnish(
                        worlds[inside] - number * SHARD_SIZE,
                        [bodies[j] for j in inside],
                        [scenes[j] for j in inside],
                    )
        finally:  # also where Ctrl-C comes in between
            self._look_for_special()

    def _look_for_special(self) -> None:
        """Tell kernels whether any body has, or ever had, what most have not."""
        if self._memory.table[:, SPECIAL].any():
            self._special = True
        self._moved = self._calls, (*self._memory, self._special)

    def place(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put the bodies of ``worlds`` at ``pose`` ``(len(worlds), 3)``, at rest and untouched."""
        self.pose, self.twist = self.pose.copy(), self.twist.copy()
        self.contact_impulse = self.contact_impulse.copy()
        self.contact_shift, self.given = self.contact_shift.copy(), self.given.copy()
        self.pose[worlds], self.twist[worlds] = pose, 0
        self.contact_impulse[worlds] = self.contact_shift[worlds] = self.given[worlds] = 0
        for number, shard in enumerate(self._shards):
            inside = worlds // SHARD_SIZE == number
            if inside.any():
                shard.place(worlds[inside] - number * SHARD_SIZE, pose[inside])

    def get_state(self, worlds: IntArray) -> dict[str, FloatArray]:
        """Where the bodies of ``worlds`` are, how they move and what bears them, one row each."""
        lasting = np.concatenate([shard.lasting for shard in self._shards])
        return {name: getattr(self, name)[worlds] for name in _STATE} | {"lasting": lasting[worlds]}

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

        What pymunk remembers of contacts is not in it, so that nothing has been touched; what bears
        a body that has weight is (`coopenv.physics.motion.supported`), so that it goes on resting.
        Positions are exact in the worlds they were read from: there, pymunk's own differ from them
        by the world's origin without rounding.

        Only bodies that touched something in the last step, in which pymunk would remember that,
        or that are others now, are made ``anew``; or all, if that step broke off.
        """
        same = has_items(self.bodies, worlds, bodies) and has_items(self.scenes, worlds, scenes)
        if anew or not same:
            self.furnish(worlds, bodies, scenes)
            anew = True
        touched = (self.contact_impulse[worlds] != 0) | (self.contact_shift[worlds] != 0) | anew
        self.place(worlds[touched], state["pose"][touched])
        self._move(worlds[~touched], state["pose"][~touched])
        for name in _STATE:
            getattr(self, name)[worlds] = state[name]
        for number, shard in enumerate(self._shards):
            inside = worlds // SHARD_SIZE == number
            shard.lasting[worlds[inside] - number * SHARD_SIZE] = state["lasting"][inside]

    def _move(self, worlds: IntArray, pose: FloatArray) -> None:
        """Put bodies that remember no contact elsewhere, which is quicker than to make others."""
        for number, shard in enumerate(self._shards):
            inside = worlds // SHARD_SIZE == number
            shard.move(worlds[inside] - number * SHARD_SIZE, pose[inside])

    def step(self, wrench: FloatArray) -> None:
        """Advance one control step under ``wrench`` ``(world, 3)`` [N, N·m], held in object frame.

        `pose`, `twist`, `contact_impulse`, `contact_shift` and `given` become fresh arrays; the
        old ones stay as they were.

        Raises
        ------
        BodyLost
            If a body is too fast for its substeps and got through a wall; of which world is its
            ``world``.
        """
        self._advance(step_shards, wrench, self._moved)

    def hold(self, hands: Hold) -> None:
        """`step` under what hands give in place of a wrench; their references go on too.

        Parameters
        ----------
        hands
            Its ``applied`` has to be zero, and becomes the mean wrench; ``reference`` is changed in
            place, and ``stretch``, ``felt`` and ``energy`` are written.
        """
        self._advance(hold_shards, tuple(hands), self._held)

    def _advance(
        self,
        kernel: Callable[..., int],
        under: FloatArray | tuple[FloatArray, ...],
        moved: tuple[IntArray, tuple[Any, ...]],
    ) -> None:
        """Step every shard ``under`` what its worlds are moved by, one row a world."""
        begin = self.pose, self.twist
        self.pose, self.twist = np.empty((self.num_worlds, 3)), np.empty((self.num_worlds, 3))
        self.contact_impulse = np.zeros(self.num_worlds)
        self.contact_shift = np.zeros(self.num_worlds)
        self.given = np.zeros((self.num_worlds, NUM_GIVEN))
        reached = self.pose, self.twist, self.contact_impulse, self.contact_shift, self.given
        lost = kernel(
            *sharing(len(self._shards)), *moved, begin, under, reached, self._lost,
            self._size, self._dt, self.substeps,
        )  # fmt: skip
        if lost >= 0:
            x, y = self.pose[lost, :2]
            raise BodyLost(
                f"the body of world {lost} must stay in its room, got ({x:.1f}, {y:.1f}) m, beyond "
                "the walls; use more substeps, a heavier body, more drag or weaker agents",
                lost,
            )


def _walls(scene: Scene) -> tuple[tuple[float, float], float]:
    return scene.size, scene.friction
