"""Distance of a body on wheels from a pose, which counts the turns it has to make."""

from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled
from coopenv.geometry.frames import wrapped
from coopenv.tasks.transport import TransportTask


@dataclass(frozen=True, slots=True, kw_only=True)
class RollingTask(TransportTask):
    """`TransportTask` for a body that cannot move sideways; its distance knows that.

    The way to the goal counts as a turn towards it, a straight drive (forwards or backwards,
    whichever is cheaper) and a turn into the goal's angle.
    """

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """ρ + w (s(|α| + |β|) + (1 − s)|Δθ|) [m], s = ρ² / (ρ² + ρ₀²).

        ρ is the distance, α the turn from the heading to the way, β the turn from the way to the
        goal's angle, w ``angle_weight`` and ρ₀ ``position_tolerance``: within it there is no way
        left to turn to.
        """
        return rolling_distance(
            pose, goal, goal, _straight(pose, goal), self.angle_weight, self.position_tolerance
        )

    def partner_agents(self, num_agents: int) -> tuple[int, ...]:
        """All but the last agent: a partner is the human, and who learns is the drive."""
        return tuple(range(num_agents - 1))


@compiled
def rolling_distance(pose, goal, stop, way, angle_weight, blur):
    """See `RollingTask.distance`; along ways that `coopenv.geometry.routes.next_stops` tells of."""
    distance = np.empty(len(pose))
    for k in range(len(pose)):
        straight = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
        length = way[k, 0] if way[k, 0] < np.inf else straight
        between = abs(wrapped(goal[k, 2] - pose[k, 2]))
        turns = between
        if straight > 0.0:
            first = np.arctan2(stop[k, 1] - pose[k, 1], stop[k, 0] - pose[k, 0])
            ends = abs(wrapped(first - pose[k, 2])) + abs(wrapped(goal[k, 2] - way[k, 2]))
            share = length * length / (length * length + blur * blur)
            # Backwards it turns by the other part of half a turn at both ends.
            ends = min(ends, 2 * np.pi - ends)
            turns = share * (ends + way[k, 1]) + (1 - share) * between
        distance[k] = length + angle_weight * turns
    return distance


@compiled
def _straight(pose, goal):
    """The way where nothing is in between, as `coopenv.geometry.routes.next_stops` tells it."""
    way = np.zeros((len(pose), 3))
    for k in range(len(pose)):
        dx, dy = goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1]
        way[k, 0], way[k, 2] = np.hypot(dx, dy), np.arctan2(dy, dx)
    return way
