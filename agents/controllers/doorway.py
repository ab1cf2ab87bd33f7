"""Scripted controller of the doorway: line up before the gap, go through, on to the goal."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import placed, wrapped
from coopenv.tasks import passage
from coopenv.transition import Transition

from .impedance import ImpedanceController, approach

_CREEP = 0.2  # [m/s] in the gap while out of line
_SLACK = 0.02  # [m] kept from the sides of the gap
_TOUCH = 0.04  # [m] that a corner may be back in the gap before the object counts as in it again


class DoorwayController(ImpedanceController):
    """`ImpedanceController` on a `coopenv.DoorwayTask`, over way points.

    While the whole object is before the wall: to the standoff on the gap's axis, turned to the
    angle at which it is narrowest; the better it is in line, the faster it goes on. In the gap: on
    along the axis. Once the whole object is out: to the goal. The gap's place is read from the
    episode's plan. Obstacles of the scene are not avoided.
    """

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, FloatArray | float]:
        """Twist ``(world, 3)`` [m/s, rad/s] to aim for, world frame."""
        conditions = transition.conditions
        pose, goal, plan = transition.next_state.pose, transition.next_state.goal, conditions.plan
        outline, half_room = conditions.load.outline, conditions.room.size / 2
        wall, half = plan[:, passage.WALL_X], plan[:, passage.HALF_DEPTH]
        side = np.where(goal[:, 0] >= wall, 1.0, -1.0)  # of the wall, where the goal is
        corners = side[:, None] * (_corners_x(pose, outline) - wall[:, None])  # [m] along the way
        out = corners.min(axis=1) >= half - _TOUCH
        before = corners.max(axis=1) <= -half
        lined_up, in_line = self._lined_up(pose, goal, plan, side, before | out)

        target = np.where(out[:, None], goal, lined_up)
        here = np.where(out, side, -side)  # the side of the wall that is to be kept to
        low, high = -half_room, half_room.copy()
        face = wall + here * half
        low[:, 0] = np.where(here > 0, face, low[:, 0])
        high[:, 0] = np.where(here < 0, face, high[:, 0])
        wanted = approach(pose, target, outline, low, high, self.gains)

        inside = ~(before | out)
        slow = np.where(inside, _CREEP * side, wanted[:, 0])
        passing = in_line * self.gains.speed * side + (1 - in_line) * slow
        wanted[:, 0] = np.where(out, wanted[:, 0], passing)
        through = self.gains.approach * (lined_up - pose)
        wanted[inside, 1] = through[inside, 1]
        spin = self.gains.spin
        wanted[inside, 2] = np.clip(
            self.gains.approach * wrapped(lined_up[inside, 2] - pose[inside, 2]), -spin, spin
        )
        return wanted, 0.0

    def _lined_up(
        self,
        pose: FloatArray,
        goal: FloatArray,
        plan: FloatArray,
        side: FloatArray,
        free: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """The pose before the gap ``(world, 3)``, and how well in line with it, 0 to 1."""
        half_turn = np.pi * np.round((pose[:, 2] - plan[:, passage.THROUGH]) / np.pi)
        nearest = plan[:, passage.THROUGH] + half_turn
        angle = np.where(free, passage.headings(plan, pose, goal), nearest)
        x = plan[:, passage.WALL_X] - side * plan[:, passage.STANDOFF]
        lined_up = np.stack([x, plan[:, passage.GAP_Y], angle], axis=-1)
        tilt = wrapped(angle - pose[:, 2])
        width, ahead = plan[:, passage.WIDTH], plan[:, passage.AHEAD]
        off = np.abs(pose[:, 1] - lined_up[:, 1]) + ahead * np.abs(np.sin(tilt))  # [m] of the nose
        slack = np.maximum((plan[:, passage.GAP] - width) / 2 - _SLACK, 1e-3)  # [m]
        facing = np.cos(tilt) > 0.5
        return lined_up, facing * np.clip(2 * (1 - off / slack), 0.0, 1.0)


def _corners_x(pose: FloatArray, outline: FloatArray) -> FloatArray:
    """World x of the outline's corners, ``(world, vertex)`` [m]."""
    c, s = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
    return placed(pose[:, 0, None], pose[:, 1, None], c, s, outline[..., 0], outline[..., 1])[0]
