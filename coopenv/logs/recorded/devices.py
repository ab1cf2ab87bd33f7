"""Devices of a recording that was joined: whose the pose is, and whose each effector's wrench."""

from collections.abc import Mapping
from dataclasses import dataclass

from coopenv.logs.columns import ORIENTATION, POSITION
from coopenv.logs.formats.chunks import Owner
from coopenv.logs.plan import Plan


@dataclass(frozen=True, slots=True, kw_only=True)
class Devices:
    """Who recorded what; ``None`` where the columns of one quantity are of several devices."""

    pose: Owner | None
    sensors: tuple[Owner | None, ...]  # an effector each
    all: tuple[Owner, ...] = ()  # that have a column of any kind

    @classmethod
    def of(cls, plan: Plan, owners: Mapping[str, Owner]) -> "Devices | None":
        """Of the columns that are read; nothing where one device has recorded all of them."""
        wrenches = zip(plan.effector_names("f"), plan.effector_names("t"), strict=True)
        pose = (*POSITION[plan.dimension], *ORIENTATION[plan.dimension])
        groups = [pose, *((*force, *torque) for force, torque in wrenches)]
        found = [
            {owners.get(plan.source[name]) for name in group if name in plan.source}
            for group in groups
        ]
        if len(set().union(*found) - {None}) < 2:
            return None
        one = [next(iter(each)) if len(each) == 1 else None for each in found]
        everyone = tuple(dict.fromkeys(owners.values()))
        return cls(pose=one[0], sensors=tuple(one[1:]), all=everyone)

    @property
    def owners(self) -> tuple[Owner, ...]:
        """Each device once, that of the pose first."""
        return tuple(dict.fromkeys(each for each in (self.pose, *self.sensors) if each is not None))

    def sensors_of(self, owner: Owner) -> tuple[int, ...]:
        """Effectors, from 0, whose wrenches a device recorded."""
        return tuple(i for i, each in enumerate(self.sensors) if each == owner)
