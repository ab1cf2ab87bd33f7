"""Clearance: exact distance and direction from convex outlines to boxes and walls, in batches."""

import numpy as np

from coopenv.compiled import compiled
from coopenv.geometry.frames import placed, rotated, seen_from

WALLS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))  # the way to each wall, world frame


@compiled
def ways_to_boxes(outline, pose, boxes, count):
    """The shortest way from a body to every box of its world.

    Parameters
    ----------
    outline
        ``(world, vertex, 2)`` convex, object frame [m]; repeated vertices do no harm.
    pose
        ``(world, 3)``, world frame.
    boxes, count
        As in `coopenv.conditions.Room`.

    Returns
    -------
    ``(world, box, 5)``: the distance [m], the unit vector of the way, and the point of the box
    where it ends [m]; world frame. Where the two overlap the distance is 0 and the way leads to
    the box's centre; for boxes that are not there it is infinite.
    """
    num_worlds, capacity = boxes.shape[:2]
    ways = np.zeros((num_worlds, capacity, 5))
    ways[:, :, 0] = np.inf
    for k in range(num_worlds):
        for j in range(count[k]):
            _way_to_box(outline[k], pose[k], boxes[k, j], ways[k, j])
    return ways


@compiled
def ways_to_walls(outline, pose, size):
    """The distance of a body from the four walls (right, left, upper, lower), ``(world, 4)`` [m].

    Negative where it reaches into one; ``size`` is ``(world, 2)`` [m].
    """
    ways = np.empty((len(pose), 4))
    for k in range(len(pose)):
        c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
        for a, b in outline[k]:
            x, y = placed(pose[k, 0], pose[k, 1], c, s, a, b)
            low_x, high_x = min(low_x, x), max(high_x, x)
            low_y, high_y = min(low_y, y), max(high_y, y)
        half_x, half_y = size[k, 0] / 2, size[k, 1] / 2
        ways[k, 0], ways[k, 1] = half_x - high_x, half_x + low_x
        ways[k, 2], ways[k, 3] = half_y - high_y, half_y + low_y
    return ways


@compiled
def _way_to_box(outline, pose, box, way):
    """Fill one row of `ways_to_boxes`; works in the box's own frame."""
    box_x, box_y, width, height, angle = box
    half_x, half_y = width / 2, height / 2
    c, s = np.cos(pose[2] - angle), np.sin(pose[2] - angle)
    turn_c, turn_s = np.cos(angle), np.sin(angle)
    center_x, center_y = seen_from(box_x, box_y, turn_c, turn_s, pose[0], pose[1])
    count = len(outline)
    corners = np.empty((count, 2))
    for i in range(count):
        x, y = placed(center_x, center_y, c, s, outline[i, 0], outline[i, 1])
        corners[i, 0], corners[i, 1] = x, y
    best, from_x, from_y, to_x, to_y = np.inf, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y = corners[i]
        near_x, near_y = min(max(x, -half_x), half_x), min(max(y, -half_y), half_y)
        distance = np.hypot(x - near_x, y - near_y)
        if distance < best:
            best, from_x, from_y, to_x, to_y = distance, x, y, near_x, near_y
        edge_x, edge_y = corners[(i + 1) % count, 0] - x, corners[(i + 1) % count, 1] - y
        square = edge_x * edge_x + edge_y * edge_y
        for j in range(4):
            a, b = half_x * (1 - 2 * (j % 2)), half_y * (1 - 2 * (j // 2))
            part = 0.0 if square == 0.0 else ((a - x) * edge_x + (b - y) * edge_y) / square
            part = min(max(part, 0.0), 1.0)
            on_x, on_y = x + part * edge_x, y + part * edge_y
            distance = np.hypot(a - on_x, b - on_y)
            if distance < best:
                best, from_x, from_y, to_x, to_y = distance, on_x, on_y, a, b
    if best == 0.0 or _overlap(corners, half_x, half_y):
        best, from_x, from_y, to_x, to_y = 0.0, center_x, center_y, 0.0, 0.0
    length = np.hypot(to_x - from_x, to_y - from_y)
    x, y = (to_x - from_x) / max(length, 1e-300), (to_y - from_y) / max(length, 1e-300)
    way[0] = best
    way[1], way[2] = rotated(turn_c, turn_s, x, y)
    way[3], way[4] = placed(box_x, box_y, turn_c, turn_s, to_x, to_y)


@compiled
def _overlap(corners, half_x, half_y):
    """Whether a convex polygon and the box ±half share a point (separating axes)."""
    count = len(corners)
    if corners[:, 0].min() > half_x or corners[:, 0].max() < -half_x:
        return False
    if corners[:, 1].min() > half_y or corners[:, 1].max() < -half_y:
        return False
    for i in range(count):
        edge = corners[(i + 1) % count] - corners[i]
        if edge[0] == 0.0 and edge[1] == 0.0:
            continue
        spread = half_x * abs(edge[1]) + half_y * abs(edge[0])  # of the box along the normal
        low, high = np.inf, -np.inf
        for j in range(count):
            across = edge[1] * corners[j, 0] - edge[0] * corners[j, 1]
            low, high = min(low, across), max(high, across)
        if low > spread or high < -spread:
            return False
    return True
