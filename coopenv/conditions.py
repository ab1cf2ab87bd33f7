"""Conditions of an episode, one row a world: body, scene, team, plan, and who is told the goal."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, has_items, with_items, with_rows
from coopenv.geometry import frames
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.physics.strengths import ACTUATORS, HANDS, parted
from coopenv.randomisation import Ranges
from coopenv.wrench import Decomposer, Settings


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Team:
    """The effectors of every world: where they hold and how strong they are."""

    grips: FloatArray  # (world, agent, 2), object frame [m]
    frame: FloatArray  # (world, agent, 2): see `coopenv.geometry.frames`
    limits: FloatArray  # (world, agent, 2): force [N] and torque [N·m] an action of 1 stands for
    hands: FloatArray  # (world, agent, 6): `coopenv.Hands.table`; (world, agent, 0) without hands
    actuators: FloatArray  # (world, agent, 3): `coopenv.Actuators.table`; likewise
    settings: Settings  # of the environment's own decomposition
    alike: bool  # whether every world has the same grips
    _decomposers: dict[Settings | None, Decomposer] = field(default_factory=dict, repr=False)

    @classmethod
    def build(cls, grips: FloatArray, strengths: FloatArray, settings: Settings) -> "Team":
        """A team from grips and strengths ``(world, agent, …)``, by `coopenv.physics.strengths`."""
        limits, hands, actuators = parted(strengths)
        return cls(
            grips=grips,
            frame=frames.agent_frames(grips),
            limits=limits,
            hands=hands,
            actuators=actuators,
            settings=settings,
            alike=bool((grips == grips[:1]).all()),
        )

    def __reduce__(self):
        return Team.build, (
            self.grips,
            self.strengths,
            self.settings,
        )  # compiled parts do not pickle

    @property
    def strengths(self) -> FloatArray:
        """``(world, agent, column)``: limits, and what hands and actuators there are."""
        return np.concatenate([self.limits, self.hands, self.actuators], axis=-1)

    @property
    def num_agents(self) -> int:
        """Number of effectors in a world."""
        return self.grips.shape[1]

    def decomposer(self, settings: Settings | None = None) -> Decomposer:
        """The decomposition of the agents' wrenches under ``settings``, checked on first use.

        ``None`` are the environment's own, which need no hashing. Surroundings, of which it knows
        nothing, are added by `coopenv.Transition`.
        """
        if settings is None and self.settings.surroundings:
            settings = self.settings  # whose decomposer has others, without
        found = self._decomposers.get(settings)
        if settings is None:
            if found is None or found.settings is not self.settings:  # of a team it was copied from
                found = self._decomposers[None] = self.decomposer(self.settings)
        elif found is None:
            grips = self.grips[0] if self.alike else self.grips
            found = Decomposer(grips, settings.of_agents)
            self._decomposers[settings] = found
        return found

    def take(self, worlds: IntArray) -> "Team":
        """Only the given worlds."""
        return replace(
            self,
            grips=self.grips[worlds],
            frame=self.frame[worlds],
            limits=self.limits[worlds],
            hands=self.hands[worlds],
            actuators=self.actuators[worlds],
            _decomposers=self._decomposers if self.alike else {},
        )

    def with_worlds(self, worlds: IntArray, grips: FloatArray, strengths: FloatArray) -> "Team":
        """A copy with the grips and strengths of ``worlds`` replaced."""
        strengths = with_rows(self.strengths, worlds, strengths)
        if np.array_equal(self.grips[worlds], grips):
            limits, hands, actuators = parted(strengths)
            return replace(self, limits=limits, hands=hands, actuators=actuators)
        return Team.build(with_rows(self.grips, worlds, grips), strengths, self.settings)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Load:
    """The body of every world as arrays."""

    mass: FloatArray  # (world,) [kg]
    inertia: FloatArray  # (world,) [kg·m²]
    linear_drag: FloatArray  # (world,) [N·s/m]
    angular_drag: FloatArray  # (world,) [N·m·s]
    friction: FloatArray  # (world,)
    ground_friction: FloatArray  # (world,)
    outline: FloatArray  # (world, vertex, 2), object frame [m]; short ones repeat their last vertex

    @classmethod
    def of(cls, bodies: Sequence[Body], vertices: int) -> "Load":
        """One row a body, with space for ``vertices`` in each outline."""
        numbers = [entry.name for entry in fields(cls) if entry.name != "outline"]
        return cls(
            **{name: np.array([getattr(b, name) for b in bodies], dtype=float) for name in numbers},
            outline=np.array(
                [b.outline + b.outline[-1:] * (vertices - len(b.outline)) for b in bodies]
            ),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Room:
    """The scene of every world as arrays; world frame."""

    size: FloatArray  # (world, 2) [m], inner width and height, centred on the origin
    boxes: FloatArray  # (world, box, 5): centre x, y, width, height [m], angle [rad]
    axes: FloatArray  # (world, box, 2): cosine and sine of the boxes' angles
    count: IntArray  # (world,): boxes there are; the rows after them are zero
    gravity: FloatArray  # (world, 2) [m/s²], in the plane

    @classmethod
    def of(cls, scenes: Sequence[Scene], capacity: int) -> "Room":
        """One row a scene, with space for ``capacity`` boxes in each."""
        boxes = np.zeros((len(scenes), capacity, 5))
        for k, scene in enumerate(scenes):
            for j, box in enumerate(scene.obstacles):
                boxes[k, j] = box.row
        return cls(
            size=np.array([scene.size for scene in scenes]),
            boxes=boxes,
            axes=np.stack([np.cos(boxes[..., 4]), np.sin(boxes[..., 4])], axis=-1),
            count=np.array([len(scene.obstacles) for scene in scenes]),
            gravity=np.array([scene.gravity for scene in scenes]),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Conditions:
    """What holds for an episode; a reset replaces the rows of the worlds that begin anew."""

    bodies: tuple[Body, ...]
    scenes: tuple[Scene, ...]
    team: Team
    load: Load
    room: Room
    task: Any  # the `coopenv.Task`
    plan: FloatArray  # (world, number): what the task drew for itself; see `coopenv.tasks.Episode`
    told: BoolArray  # (world, agent, 2): who is told the goal's place, and its angle
    key: npt.NDArray[np.uint64]  # (world,): what errors of sensors are drawn with; see `Sensor`
    randomised: bool = False  # whether `coopenv.Ranges` are drawn from in every episode

    def parameters(self) -> dict[str, FloatArray]:
        """What is carried, where and by how strong a team, by the names of `coopenv.Ranges`.

        ``(world,)`` each, ``gravity`` as the strength of that in the plane [m/s²]; ``grips``
        ``(world, agent, 2)`` in the object frame [m], limits, where there are hands stiffness and
        damping, and where there are actuators delay, time constant and rate limit
        (`coopenv.physics.actuators.UNLIMITED` for none), ``(world, agent)``. The arrays are the
        conditions' own.
        """
        load, along = self.load, self.load.outline[..., 0]
        return {
            "mass": load.mass,
            "inertia": load.inertia,
            "linear_drag": load.linear_drag,
            "angular_drag": load.angular_drag,
            "friction": load.friction,
            "ground_friction": load.ground_friction,
            "length": along.max(axis=1) - along.min(axis=1),
            "grips": self.team.grips,
            "force_limit": self.team.limits[..., 0],
            "torque_limit": self.team.limits[..., 1],
            **{name: value for name, value in self._tables() if name in Ranges.__slots__},
            "gravity": np.hypot(self.room.gravity[:, 0], self.room.gravity[:, 1]),
        }

    def _tables(self) -> Iterator[tuple[str, FloatArray]]:
        """Columns of hands and actuators, if there are any, by their names."""
        for names, table in ((HANDS, self.team.hands), (ACTUATORS, self.team.actuators)):
            yield from zip(names, np.moveaxis(table, -1, 0), strict=False)

    def take(self, worlds: IntArray) -> "Conditions":
        """Only the given worlds."""
        return replace(
            self,
            bodies=tuple(self.bodies[k] for k in worlds.tolist()),
            scenes=tuple(self.scenes[k] for k in worlds.tolist()),
            team=self.team.take(worlds),
            load=_rows(self.load, worlds),
            room=_rows(self.room, worlds),
            plan=self.plan[worlds],
            told=self.told[worlds],
            key=self.key[worlds],
        )

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What `with_state` needs of ``worlds``, one entry each."""
        chosen = worlds.tolist()
        return {
            "bodies": [self.bodies[k] for k in chosen],
            "scenes": [self.scenes[k] for k in chosen],
            "strengths": self.team.strengths[worlds],
            "plan": self.plan[worlds],
            "key": self.key[worlds],
        }

    def with_state(self, state: dict[str, Any], worlds: IntArray) -> "Conditions":
        """A copy in which ``worlds`` are under the conditions that `get_state` returned."""
        conditions, plan = self.with_keys(worlds, state["key"]), state["plan"]
        width = max(plan.shape[1], self.plan.shape[1])  # 0 before the first plan is drawn
        plan, plans = _widened(plan, width), _widened(self.plan, width)
        conditions = replace(conditions, plan=with_rows(plans, worlds, plan))
        bodies, scenes, strengths = state["bodies"], state["scenes"], state["strengths"]
        if (
            has_items(self.bodies, worlds, bodies)
            and has_items(self.scenes, worlds, scenes)
            and np.array_equal(self.team.strengths[worlds], strengths)
        ):
            return conditions
        return conditions.with_worlds(worlds, bodies, scenes, strengths, plan)

    def with_keys(self, worlds: IntArray, keys: npt.NDArray[np.uint64]) -> "Conditions":
        """A copy in which ``worlds`` have other keys."""
        return replace(self, key=with_rows(self.key, worlds, keys))

    def with_worlds(
        self,
        worlds: IntArray,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        strengths: FloatArray,
        plan: FloatArray,
    ) -> "Conditions":
        """A copy in which ``worlds`` hold new things, one entry of each argument a world."""
        changed: dict[str, Any] = {"plan": with_rows(self.plan, worlds, plan)}
        known = has_items(self.bodies, worlds, bodies)
        if not known:
            load = Load.of(bodies, self.load.outline.shape[1])
            changed["bodies"] = with_items(self.bodies, worlds, bodies)
            changed["load"] = _merged_rows(self.load, worlds, load)
        if not (known and np.array_equal(self.team.strengths[worlds], strengths)):
            grips = np.array([body.grips for body in bodies])
            changed["team"] = self.team.with_worlds(worlds, grips, strengths)
        if not has_items(self.scenes, worlds, scenes):
            room = Room.of(scenes, self.room.boxes.shape[1])
            changed["scenes"] = with_items(self.scenes, worlds, scenes)
            changed["room"] = _merged_rows(self.room, worlds, room)
        return replace(self, **changed)


def _widened(plan: FloatArray, width: int) -> FloatArray:
    """Plans with zeros after them, up to ``width`` numbers each."""
    if plan.shape[1] == width:
        return plan
    return np.pad(plan, ((0, 0), (0, width - plan.shape[1])))


def _rows(value: Any, worlds: IntArray) -> Any:
    return replace(value, **{name: getattr(value, name)[worlds] for name in value.__slots__})


def _merged_rows(value: Any, worlds: IntArray, other: Any) -> Any:
    return replace(
        value,
        **{
            name: with_rows(getattr(value, name), worlds, getattr(other, name))
            for name in value.__slots__
        },
    )
