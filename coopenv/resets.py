"""Validation of reset arguments, and drawing of the episodes that a reset begins."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding

from coopenv.arrays import (
    FARTHEST,
    BoolArray,
    FloatArray,
    IntArray,
    booleans,
    finite_array,
    whole,
)
from coopenv.chance import draw_keys
from coopenv.conditions import Conditions, Load, Room, Team
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.observation.sensor import Sensor
from coopenv.partner import Generators
from coopenv.physics.body import Body
from coopenv.physics.scene import WALL_THICKNESS, Scene
from coopenv.randomisation import Variations
from coopenv.tasks import Episode, Pose
from coopenv.wrench import Decomposer

Seed = int | Sequence[int | None] | None


def seed_worlds(generators: list[np.random.Generator | None], seed: Seed, worlds: IntArray) -> None:
    """Give ``worlds`` the generators of their seeds; where that is ``None``, theirs goes on."""
    chosen = worlds.tolist()
    for k, own in zip(chosen, _seeds(seed, chosen, len(generators)), strict=True):
        if own is not None or generators[k] is None:
            generators[k] = seeding.np_random(own)[0]


def _seeds(seed: Seed, worlds: list[int], num_worlds: int) -> list[int | None]:
    """The seed of each of ``worlds``."""
    if seed is None:
        return [None] * len(worlds)
    if not isinstance(seed, Sequence | np.ndarray):
        first = whole(seed, "seed", at_least=0)
        return [first + k for k in worlds]
    if isinstance(seed, str | bytes) or len(seed) != num_worlds:
        raise InvalidInput(
            f"seed must be one number or one for each of {num_worlds} worlds, "
            f"got {seed!r}; world k of seed=s is seeded with s + k"
        )
    return [None if seed[k] is None else whole(seed[k], "seed", at_least=0) for k in worlds]


def marked_worlds(mask: BoolArray | None, num_worlds: int, *, first: bool) -> IntArray:
    """The worlds that ``mask`` marks: at the ``first`` reset it has to be all of them."""
    if mask is None:
        return np.arange(num_worlds)
    marked = booleans(mask, "mask", num_worlds)
    if first and not marked.all():
        raise InvalidInput(
            f"mask must mark every world before the first step, got {marked.sum()} of "
            f"{num_worlds}; call reset() once without it"
        )
    return np.flatnonzero(marked)


@contextmanager
def all_or_nothing(generators: list[np.random.Generator | None], may_fail: bool) -> Iterator[None]:
    """Put generators back as they were if what is done with them fails.

    Where it cannot (``may_fail`` is false), nothing is kept, which would take time.
    """
    if not may_fail:
        yield
        return
    kept = list(generators)
    states = [None if each is None else each.bit_generator.state for each in kept]
    try:
        yield
    except InvalidInput:
        generators[:] = kept
        for each, state in zip(kept, states, strict=True):
            if each is not None:
                each.bit_generator.state = state  # pyright: ignore[reportAttributeAccessIssue]
        raise


def given_pose(pose: npt.ArrayLike | None, name: str, num_worlds: int) -> FloatArray | None:
    """One pose a world ``(world, 3)``, from one for all or one for each."""
    if pose is None:
        return None
    given = finite_array(pose, name)
    if given.shape not in ((3,), (num_worlds, 3)):
        raise InvalidInput(
            f"{name} must have shape (3,) or ({num_worlds}, 3), got {given.shape}; "
            "give x, y [m] and θ [rad]"
        )
    if (np.abs(given) > FARTHEST).any():
        raise InvalidInput(
            f"{name} must be within {FARTHEST:g} m and rad, got {given.tolist()}; wrap the angle"
        )
    return np.broadcast_to(given, (num_worlds, 3)).copy()


def check_free(
    worlds: IntArray,
    given: Sequence[tuple[FloatArray | None, str]],
    scenes: Sequence[Scene],
) -> None:
    """Raise where a given pose is in a wall, an obstacle or another world's room."""
    for pose, name in given:
        if pose is None:
            continue
        for k in worlds.tolist():
            if not scenes[k].is_free(*pose[k, :2].tolist()):
                raise InvalidInput(
                    f"{name} must put the centre of mass inside the room of {scenes[k].size} m "
                    f"and off its obstacles, got {pose[k].tolist()} in world {k}; the origin "
                    "is the room's centre"
                )


class Draws:
    """Draws episodes world by world, each from its own generator.

    Parameters
    ----------
    config
        What may be drawn.
    num_worlds
        Worlds drawn for.

    Attributes
    ----------
    scenes
        One a world, without what episodes bring and draw.
    changing
        Whether an episode's conditions may differ from those of the one before it.
    reach
        Distance of the farthest point of any body that may be drawn from its centre of mass [m].
    """

    def __init__(self, config: TransportConfig, num_worlds: int):
        self._task = config.task
        self._bodies, self.scenes = config.bodies(num_worlds), config.scenes(num_worlds)
        self._strengths = np.repeat(config.strengths()[None], num_worlds, axis=0)
        self._settings = config.decomposition
        self._own_boxes = self._task.max_obstacles
        self._told = self._told_by(config)
        self._needs_keys = any(
            isinstance(entry, Sensor) and entry.is_random for entry in config.observe
        )
        self._ranges = config.randomise
        self._variations = self._varied_by(config)
        self.changing = self._own_boxes > 0 or self._task.moves or bool(self._variations)
        self.reach = self._farthest()

    def first(self) -> Conditions:
        """What holds before the first episode is drawn."""
        bodies, scenes = self._bodies, self.scenes
        capacity = self._own_boxes + max(len(scene.obstacles) for scene in scenes)
        return Conditions(
            bodies=bodies,
            scenes=scenes,
            team=Team.build(np.array([b.grips for b in bodies]), self._strengths, self._settings),
            load=Load.of(bodies, max(len(body.outline) for body in bodies)),
            room=Room.of(scenes, capacity),
            task=self._task,
            plan=np.zeros((len(bodies), 0)),
            told=np.repeat(self._told[None], len(bodies), axis=0),
            key=np.zeros(len(bodies), dtype=np.uint64),
            randomised=bool(self._variations),
        )

    def next(
        self, conditions: Conditions, generators: Generators, worlds: IntArray
    ) -> tuple[Conditions, FloatArray, FloatArray]:
        """Conditions with the next episodes of ``worlds``, and their starts and goals."""
        chosen = worlds.tolist()
        carried = [self._carried(generators[k], k) for k in chosen]
        rooms = [self._room(generators[k], k) for k in chosen]
        episodes = [
            self._episode(generators[k], body, room)
            for k, (body, _), room in zip(chosen, carried, rooms, strict=True)
        ]
        start = _poses([episode.start for episode in episodes], "start")
        goal = _poses([episode.goal for episode in episodes], "goal")
        planned = conditions.plan.shape[1] or any(episode.plan for episode in episodes)
        if chosen and (self.changing or planned):
            plan = _plans(episodes, conditions)
            if plan.shape[1] != conditions.plan.shape[1]:  # the first ones
                conditions = replace(
                    conditions, plan=np.zeros((len(conditions.bodies), plan.shape[1]))
                )
            conditions = conditions.with_worlds(
                worlds,
                bodies=[body for body, _ in carried],
                scenes=[self._furnished(r, e) for r, e in zip(rooms, episodes, strict=True)],
                strengths=np.array([strengths for _, strengths in carried]),
                plan=plan,
            )
        if self._needs_keys and chosen:  # last: other draws do not depend on it
            conditions = conditions.with_keys(worlds, draw_keys(generators, worlds))
        return conditions, start, goal

    def _carried(self, generator: np.random.Generator | None, k: int) -> tuple[Body, FloatArray]:
        """The body of world ``k``'s next episode, and the team's strengths ``(agent, …)``."""
        body, strengths = self._bodies[k], self._strengths[k]
        if not self._variations:
            return body, strengths
        assert generator is not None
        variations = self._variations[body]
        return variations(generator.random(variations.count).tolist())

    def _room(self, generator: np.random.Generator | None, k: int) -> Scene:
        """The scene of world ``k``'s next episode, before the task furnishes it."""
        if self._ranges is None or self._ranges.gravity is None:
            return self.scenes[k]
        assert generator is not None
        return self._ranges.scene(self.scenes[k], float(generator.random()))

    def _episode(self, generator: np.random.Generator | None, body: Body, room: Scene) -> Episode:
        assert generator is not None
        drawn = self._task.sample(generator, body, room)
        return drawn if isinstance(drawn, Episode) else Episode(start=drawn[0], goal=drawn[1])

    def _furnished(self, scene: Scene, episode: Episode) -> Scene:
        """A scene with the obstacles that an episode brings."""
        boxes = episode.obstacles
        if not boxes:
            return scene
        if len(boxes) > self._own_boxes:
            raise InvalidInput(
                f"max_obstacles of the task must be at least {len(boxes)}, got {self._own_boxes}; "
                "raise it to the most obstacles an episode brings"
            )
        far = [side / 2 + WALL_THICKNESS for side in scene.size]
        for box in boxes:
            if not box.lies_within(far):
                raise InvalidInput(
                    f"obstacles of an episode must lie within the walls of a room of {scene.size} "
                    f"m, got {box}; move or shorten it"
                )
        return replace(scene, obstacles=scene.obstacles + boxes)

    def _varied_by(self, config: TransportConfig) -> dict[Body, Variations]:
        """For each body what is drawn of it, nothing without ranges.

        Raises where the decomposition could not work with what is drawn.
        """
        if config.randomise is None:
            return {}
        strengths = config.strengths()
        varied = {b: Variations(config.randomise, b, strengths) for b in set(self._bodies)}
        grips = [body.grips for each in varied.values() for body in each.samples()]
        try:
            Decomposer(grips, config.decomposition.of_agents)
        except InvalidInput as error:
            raise InvalidInput(
                f"randomise must leave grips that the decomposition can work with: {error}"
            ) from error
        return varied

    def _farthest(self) -> float:
        bodies = set(self._bodies)
        if self._variations:
            bodies = {drawn for each in self._variations.values() for drawn in each.extremes()}
        return max(body.reach for body in bodies)

    def _told_by(self, config: TransportConfig) -> np.ndarray:
        told = np.ones((config.num_agents, 2), dtype=np.bool_)
        if config.informed is not None:
            told[:] = False
            told[list(config.informed)] = True
        return told & self._task.told(config.num_agents)


def _poses(drawn: Sequence[Pose], name: str) -> FloatArray:
    """What a task's ``sample`` gave for ``name``, ``(world, 3)``."""
    if any(np.shape(pose) != (3,) for pose in drawn) or not np.isfinite(drawn).all():
        wrong = [pose for pose in drawn if np.shape(pose) != (3,) or not np.isfinite(pose).all()]
        raise InvalidInput(
            f"{name} of an episode must be three finite numbers x, y [m], θ [rad], got {wrong[0]}; "
            "change the task's sample"
        )
    return np.array(drawn, dtype=np.float64).reshape(-1, 3)


def _plans(episodes: Sequence[Episode], before: Conditions) -> FloatArray:
    """The episodes' plans ``(world, number)``, as long as those under way."""
    lengths = {len(episode.plan) for episode in episodes} | ({before.plan.shape[1]} - {0})
    if len(lengths) > 1:
        raise InvalidInput(
            f"plan must have as many numbers in every episode of a task, got {sorted(lengths)}; "
            "fill it up with zeros"
        )
    return np.array([episode.plan for episode in episodes], dtype=np.float64)
