"""Shortest paths of a disc round boxes: a visibility graph over the boxes' widened corners."""

import numpy as np

from coopenv.compiled import compiled
from coopenv.geometry.frames import placed, rotated_back, seen_from, wrapped

_BESIDE = 0.02  # [m] by which the corners of a way keep off what may not be crossed


@compiled
def next_stops(place, goal, boxes, count, size, radius):
    """Where a disc has to go first to get to its goal on the shortest way.

    Boxes are widened by the radius with square corners, so a way keeps off them by at least that
    much; a disc that starts or ends nearer than that may do so.

    Parameters
    ----------
    place, goal
        ``(world, 2 or more)``: x, y first, world frame [m].
    boxes, count, size
        As in `coopenv.conditions.Room`.
    radius
        ``(world,)`` [m].

    Returns
    -------
    ``(stop, way)``: ``(world, 2)`` the first corner of the way, or the goal where nothing is
    between; and ``(world, 3)`` how long the way is [m], what its corners turn by together, and
    the direction of its last leg [rad]. Where there is no way the length is infinite, and stop and
    direction are those of the straight line.
    """
    num_worlds, capacity = boxes.shape[:2]
    stops, ways = np.empty((num_worlds, 2)), np.empty((num_worlds, 3))
    nodes = np.empty((4 * capacity + 2, 2))
    slack = np.empty(capacity)
    for k in range(num_worlds):
        nodes[0, 0], nodes[0, 1] = place[k, 0], place[k, 1]
        nodes[1, 0], nodes[1, 1] = goal[k, 0], goal[k, 1]
        here = boxes[k, : count[k]]
        for j in range(len(here)):
            room = min(_outside(nodes[0], here[j]), _outside(nodes[1], here[j]))
            slack[j] = max(min(radius[k], room - 1e-9), 0.0)
        used = 2 + _corners(here, radius[k], size[k], nodes[2:])
        first = _shortest(nodes[:used], here, slack, ways[k])
        stops[k] = nodes[first]
    return stops, ways


@compiled
def _corners(boxes, radius, size, out):
    """Write the widened corners that lie in the room; returns how many."""
    used = 0
    for box in boxes:
        box_x, box_y, width, height, angle = box
        c, s = np.cos(angle), np.sin(angle)
        for corner in range(4):
            a = (width / 2 + radius + _BESIDE) * (1 - 2 * (corner % 2))
            b = (height / 2 + radius + _BESIDE) * (1 - 2 * (corner // 2))
            x, y = placed(box_x, box_y, c, s, a, b)
            if abs(x) <= size[0] / 2 - radius and abs(y) <= size[1] / 2 - radius:
                out[used, 0], out[used, 1] = x, y
                used += 1
    return used


@compiled
def _shortest(nodes, boxes, slack, way):
    """The node that comes first on the way from node 0 to node 1 (Dijkstra); fills ``way``."""
    count = len(nodes)
    distance, before = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
    done = np.zeros(count, dtype=np.bool_)
    distance[0] = 0.0
    for _ in range(count):
        nearest = -1
        for i in range(count):
            if not done[i] and (nearest < 0 or distance[i] < distance[nearest]):
                nearest = i
        if nearest == 1 or distance[nearest] == np.inf:
            break
        done[nearest] = True
        for i in range(count):
            if done[i]:
                continue
            leg = np.hypot(nodes[i, 0] - nodes[nearest, 0], nodes[i, 1] - nodes[nearest, 1])
            if distance[nearest] + leg < distance[i] and _is_open(
                nodes[nearest], nodes[i], boxes, slack
            ):
                distance[i], before[i] = distance[nearest] + leg, nearest
    at, turned = 1, 0.0
    last = later = _direction(nodes[before[1]], nodes[1])
    while before[at] != 0:
        at = before[at]
        earlier = _direction(nodes[before[at]], nodes[at])
        turned += abs(wrapped(later - earlier))
        later = earlier
    way[0], way[1], way[2] = distance[1], turned, last
    return at


@compiled
def _direction(start, end):
    return np.arctan2(end[1] - start[1], end[0] - start[0])


@compiled
def _is_open(start, end, boxes, slack):
    """Whether a straight leg crosses no box widened by its slack (clipping against its sides)."""
    for j in range(len(boxes)):
        box_x, box_y, width, height, angle = boxes[j]
        c, s, sides = np.cos(angle), np.sin(angle), (width, height)
        begin = seen_from(box_x, box_y, c, s, start[0], start[1])
        leg = rotated_back(c, s, end[0] - start[0], end[1] - start[1])
        low, high = 0.0, 1.0
        for axis in range(2):
            at, step = begin[axis], leg[axis]
            half = sides[axis] / 2 + slack[j]
            if step == 0.0:
                if abs(at) >= half:
                    high = -1.0
            else:
                enter, leave = (-half - at) / step, (half - at) / step
                low, high = max(low, min(enter, leave)), min(high, max(enter, leave))
        if high - low > 1e-9:
            return False
    return True


@compiled
def _outside(point, box):
    """How far a point is beyond a box's sides, the larger of the two ways [m]; negative inside."""
    box_x, box_y, width, height, angle = box
    x, y = seen_from(box_x, box_y, np.cos(angle), np.sin(angle), point[0], point[1])
    return max(abs(x) - width / 2, abs(y) - height / 2)
