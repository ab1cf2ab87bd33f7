"""Checks that the fields of an environment's description agree with each other."""

from collections.abc import Iterable, Sequence
from itertools import product
from math import sqrt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.physics.strengths import parted
from coopenv.randomisation import Ranges, Variations
from coopenv.tasks import Task


def check_team_size(bodies: Sequence[Body]) -> None:
    """Raise `InvalidInput` unless all bodies have as many grips."""
    counts = sorted({body.num_agents for body in bodies})
    if len(counts) > 1:
        raise InvalidInput(
            f"body.grips must be as many in every world, got {counts}; "
            "one batch holds teams of one size"
        )


def check_ranges(
    ranges: Ranges,
    task: Task,
    bodies: Sequence[Body],
    scenes: Sequence[Scene],
    strengths: FloatArray,
) -> None:
    """Raise `InvalidInput` where the task cannot be done with what may be drawn.

    ``strengths`` ``(agent, column)`` are those of the team, from `TransportConfig.strengths`.
    """
    for body in set(bodies):
        ranges.check(body)
    for body, scene in _together(bodies, scenes):
        _check_ground(ranges, body, scene)
        extremes = Variations(ranges, body, strengths).extremes()
        for extreme, room in product(extremes, ranges.scenes(scene)):
            try:
                task.check(extreme, room)
            except InvalidInput as error:
                raise InvalidInput(f"randomise must leave the task possible: {error}") from error


def check_strength(
    task: Task,
    bodies: Sequence[Body],
    scenes: Sequence[Scene],
    strengths: FloatArray,
    ranges: Ranges | None,
) -> None:
    """Raise `InvalidInput` where the team is too weak for the task.

    Of what may be drawn, it is the weakest with the heaviest body in the most gravity. A force is
    limited along each of an agent's axes, so that between them it may be larger by √2.
    """
    for body, scene in _together(bodies, scenes):
        if ranges is None:
            task.check_strength(body, scene, _most_force(strengths))
            continue
        (_, weakest), (heaviest, _) = Variations(ranges, body, strengths).ends()
        try:
            task.check_strength(heaviest, ranges.scenes(scene)[-1], _most_force(weakest))
        except InvalidInput as error:
            raise InvalidInput(f"randomise must leave the task possible: {error}") from error


def _most_force(strengths: FloatArray) -> float:
    """More than a team gives in any direction [N]."""
    return sqrt(2) * float(parted(strengths)[0][:, 0].sum())


def _check_ground(ranges: Ranges, body: Body, scene: Scene) -> None:
    """Raise `InvalidInput` where friction is drawn for a ground that cannot rub the body."""
    drawn = ranges.ground_friction
    if drawn is None or drawn[1] == 0:
        return
    if body.nonholonomic:
        raise InvalidInput(
            f"randomise.ground_friction must be left out on wheels, got {drawn}; wheels roll on "
            "the ground: draw linear_drag and angular_drag instead"
        )
    if scene.normal_gravity == 0:
        raise InvalidInput(
            "randomise.ground_friction must come with a scene.normal_gravity that presses the body "
            f"on its ground, got {drawn} and 0 m/s²; drop it where the plane stands upright"
        )


def check_partner(
    partner: object | None,
    agents: Sequence[int] | None,
    driven: Sequence[int],
    num_agents: int,
) -> None:
    """Raise `InvalidInput` unless a partner drives some of the agents, but not all.

    ``agents`` are those that were named for it, ``driven`` those that it drives then.
    """
    if partner is None and agents is not None:
        raise InvalidInput(
            f"partner_agents must come with a partner, got {agents} without; "
            "pass for example partner='follower'"
        )
    if partner is not None and not 0 < len(driven) < num_agents:
        raise InvalidInput(
            f"partner_agents must name at least one of {num_agents} agents and leave at "
            f"least one to learn, got {driven}; change them, or give body another grip"
        )


def check_task(task: Task, bodies: Sequence[Body], scenes: Sequence[Scene]) -> None:
    """Raise `InvalidInput` where the task cannot be done with a body in a scene."""
    for body, scene in _together(bodies, scenes):
        scene.check(body)
        task.check(body, scene)


def _together(bodies: Sequence[Body], scenes: Sequence[Scene]) -> set[tuple[Body, Scene]]:
    """Which body is in which scene; with one of either for all worlds, all combinations."""
    one_each = len(bodies) == len(scenes)
    pairs: Iterable[tuple[Body, Scene]] = (
        zip(bodies, scenes, strict=True) if one_each else product(bodies, scenes)
    )
    return set(pairs)
