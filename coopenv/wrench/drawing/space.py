"""A split in space, drawn on three-dimensional axes of Matplotlib."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.drawing import looks
from coopenv.wrench.drawing.looks import Look
from coopenv.wrench.drawing.scene import RADIUS, Scene, across, round_number

TURN = np.linspace(0.0, 2 * np.pi, 73)  # [rad]
KINDS = (looks.APPLIED, looks.OBJECT_WRENCH, looks.MANIPULATION, looks.INTERNAL)
WIDTHS = dict(zip(KINDS, (7.0, 2.0, 2.6, 3.6), strict=True))  # [pt]
LEVELS = dict(zip(KINDS, (3.0, 3.5, 4.0, 5.0), strict=True))  # what is drawn last lies on top


def draw(axes: Any, scene: Scene, *, show_regions: bool) -> None:
    """Draw everything; artists bear names such as ``internal force 1``."""
    axes.computed_zorder = False  # by kind, not by depth: an arrow upon another is to be seen
    for grip in scene.grips:
        _line(axes, np.stack([np.zeros(3), grip]), "object", color="#D8D8D8", linewidth=6)
    axes.plot([0], [0], [0], marker="+", color=looks.BLACK, markersize=9, gid="centre of mass")
    if show_regions:
        _regions(axes, scene)
    for i, grip in enumerate(scene.grips):
        _wrench(axes, scene, i, grip)
        axes.text(*(1.2 * grip if np.any(grip) else grip), str(i + 1), fontsize=10, zorder=8)
    if np.any(scene.grips):
        wrench, look = scene.object_wrench, looks.OBJECT_WRENCH
        _arrow(axes, scene, np.zeros(3), scene.force(wrench), look, "force")
        _arc(axes, scene, np.zeros(3), scene.torque(wrench), look, "torque")
    axes.plot(*scene.grips.T, "o", color="white", markeredgecolor=looks.BLACK, markersize=5,
              gid="grips")  # fmt: skip
    _equal(axes, scene)
    _scale_bar(axes, scene)


def _equal(axes: Any, scene: Scene) -> None:
    """One scale in all directions, at which flat things keep some height; few ticks."""
    tips = [scene.grips + scene.force(part) for part in (scene.applied, scene.manipulation)]
    resultant = scene.force(scene.object_wrench)[None, :]
    points = np.concatenate([scene.grips, *tips, scene.internal_starts(), resultant, 0 * resultant])
    room = 1.6 * RADIUS * scene.size
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    extent = np.maximum(high - low, 0.5 * (high - low).max())
    low = 0.5 * (low + high - extent)
    axes.set_box_aspect(tuple(extent), zoom=1.1)  # an array would be scaled in place
    for name, start, length in zip("xyz", low, extent, strict=True):
        getattr(axes, f"set_{name}lim")(start, start + length)
        getattr(axes, f"set_{name}label")(f"{name} [m]")
        getattr(axes, f"{name}axis").set_major_locator(_few_ticks())
        axes.tick_params(axis=name, labelsize=8)


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def _regions(axes: Any, scene: Scene) -> None:
    """Balls of eq. 9 and tubes of eq. 10; for a pair the rim of the lens of both balls."""
    scale = scene.metres_per_newton
    for i in np.flatnonzero(np.linalg.norm(scene.force(scene.applied), axis=-1) > 0.0):
        force, grip = scale * scene.applied[i, :3], scene.grips[i]
        for circle in _great_circles(force):
            _line(axes, grip + circle, f"{looks.BALL} {i + 1}", color="#888888", linewidth=0.8,
                  linestyle="--", label="ball of eq. 9")  # fmt: skip
        for line in _tube(force, grip):
            _line(axes, grip + line, f"{looks.BAND} {i + 1}", color=looks.SKY, linewidth=0.9,
                  label="tube of eq. 10")  # fmt: skip
    if len(scene.grips) == 2:
        first, second = scale * scene.applied[:, :3]
        for line in lens(first, first + second):
            for i, place in enumerate((line, first + second - line)):
                _line(axes, scene.grips[i] + place, f"{looks.FEASIBLE} {i + 1}", color=looks.PURPLE,
                      linewidth=1.2, label="lens of both balls (9)")  # fmt: skip


def lens(first: FloatArray, total: FloatArray) -> list[FloatArray]:
    """Lines ``(k, 3)`` on the lens of f_M,1 that lie in both balls of eq. 9: rim and meridians.

    One ball has the diameter [0, f_1], the other [f_1, f_o]; nothing where they touch in f_1 alone
    or one is a point.
    """
    centres = (0.5 * first, 0.5 * (first + total))
    radii = (0.5 * float(np.linalg.norm(first)), 0.5 * float(np.linalg.norm(total - first)))
    axis = centres[1] - centres[0]
    apart = float(np.linalg.norm(axis))
    if min(radii) == 0.0:
        return []
    if apart <= 1e-9 * sum(radii):  # opposed forces: one ball
        return [centres[0] + circle for circle in _about(first)]
    axis = axis / apart
    along = (apart**2 + radii[0] ** 2 - radii[1] ** 2) / (2 * apart)
    rim = np.sqrt(max(radii[0] ** 2 - along**2, 0.0))
    if rim <= 1e-6 * max(radii):
        return []
    left = across(axis)
    up = np.cross(axis, left)
    circle = np.outer(np.cos(TURN), left) + np.outer(np.sin(TURN), up)
    lines = [centres[0] + along * axis + rim * circle]
    for side in circle[:-1:12]:
        lines += _meridian(centres[0], axis, side, along, rim, radii[0])
        lines += _meridian(centres[1], -axis, side, apart - along, rim, radii[1])
    return lines


def _meridian(
    centre: FloatArray, axis: FloatArray, side: FloatArray, along: float, rim: float, radius: float
) -> list[FloatArray]:
    """From the rim to the pole of one cap."""
    angles = np.linspace(np.arctan2(rim, along), 0.0, 16)
    return [centre + radius * (np.outer(np.cos(angles), axis) + np.outer(np.sin(angles), side))]


def _great_circles(force: FloatArray) -> list[FloatArray]:
    return [0.5 * force + circle for circle in _about(force)]


def _about(force: FloatArray) -> list[FloatArray]:
    """Three great circles of a ball with that diameter, about its centre."""
    along = force / np.linalg.norm(force)
    left = across(along)
    up = np.cross(along, left)
    radius = 0.5 * np.linalg.norm(force)
    pairs = ((along, left), (along, up), (left, up))
    return [radius * (np.outer(np.cos(TURN), a) + np.outer(np.sin(TURN), b)) for a, b in pairs]


def _tube(force: FloatArray, grip: FloatArray) -> list[FloatArray]:
    """Forces that induce no other torque than eq. 10 allows, as far as the ball reaches."""
    lever = float(np.linalg.norm(grip))
    if lever == 0.0:
        return []
    axis = grip / lever
    across_lever = force - axis * (axis @ force)
    if np.linalg.norm(across_lever) <= 1e-9 * np.linalg.norm(force):
        return []
    circle = _about(across_lever)
    side = across_lever / np.linalg.norm(across_lever)
    radius, other = 0.5 * np.linalg.norm(across_lever), np.cross(axis, side)
    circle = 0.5 * across_lever + radius * (
        np.outer(np.cos(TURN), side) + np.outer(np.sin(TURN), other)
    )
    reach = 0.5 * (axis @ force) + 0.5 * np.linalg.norm(force) * np.array([-1.0, 1.0])
    rings = [circle + end * axis for end in reach]
    return [*rings, *(np.stack([rings[0][k], rings[1][k]]) for k in range(0, 72, 18))]


def _wrench(axes: Any, scene: Scene, i: int, grip: FloatArray) -> None:
    """Applied arrow and arc of one effector, and its split upon them."""
    parts = (
        (looks.APPLIED, scene.applied[i], grip),
        (looks.MANIPULATION, scene.manipulation[i], grip),
        (looks.INTERNAL, scene.internal[i], scene.internal_starts()[i]),
    )
    for number, (look, wrench, start) in enumerate(parts):
        _arrow(axes, scene, start, scene.force(wrench), look, f"force {i + 1}")
        _arc(axes, scene, grip, scene.torque(wrench), look, f"torque {i + 1}", 1.0 + 0.25 * number)


def _arrow(
    axes: Any, scene: Scene, start: FloatArray, vector: FloatArray, look: Look, name: str
) -> None:
    """The internal arrow is hollow: white upon its colour."""
    if not np.any(vector):
        return
    head = min(0.3, 0.06 * scene.size / float(np.linalg.norm(vector)))
    gid, width = f"{look.name.split()[0]} {name}", WIDTHS[look]
    axes.quiver(*start, *vector, color=_colour(look), linewidth=width, zorder=LEVELS[look],
                arrow_length_ratio=head, label=look.name, gid=gid)  # fmt: skip
    if look is looks.INTERNAL:
        axes.quiver(*start, *vector, color="white", linewidth=0.4 * width,
                    arrow_length_ratio=head, zorder=LEVELS[look])  # fmt: skip


def _arc(
    axes: Any,
    scene: Scene,
    centre: FloatArray,
    torque: FloatArray,
    look: Look,
    name: str,
    wider: float = 1.0,
) -> None:
    """An arc about the axis of a torque, as long as the torque is large, with a head."""
    sweep = float(np.linalg.norm(torque))
    if sweep == 0.0:
        return
    axis, radius = torque / sweep, wider * RADIUS * scene.size
    left = across(axis)
    up = np.cross(axis, left)
    angles = np.linspace(0.0, sweep, 40)
    line = centre + radius * (np.outer(np.cos(angles), left) + np.outer(np.sin(angles), up))
    width, level = 0.7 * WIDTHS[look], LEVELS[look]
    _line(axes, line, f"{look.name.split()[0]} {name}", color=_colour(look), linewidth=width,
          zorder=level, label=look.name)  # fmt: skip
    if look is looks.INTERNAL:
        axes.plot(*line.T, color="white", linewidth=0.4 * width, zorder=level)
    head = line[-1] - line[-2]
    head *= 0.4 * radius / np.linalg.norm(head)
    axes.quiver(*line[-1], *head, color=_colour(look), linewidth=width, zorder=level,
                arrow_length_ratio=1.0)  # fmt: skip


def _colour(look: Look) -> str:
    return "#BDBDBD" if look is looks.APPLIED else look.edge


def _line(axes: Any, points: FloatArray, gid: str, **style: Any) -> None:
    axes.plot(*points.T, gid=gid, **style)


def _scale_bar(axes: Any, scene: Scene) -> None:
    """At the front along x a round force; how wide a round torque is, in words."""
    words = []
    if scene.largest_force > 0.0:
        force = round_number(scene.largest_force)
        low = [limits[0] for limits in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())]
        end = np.array([low, low]) + 0.03 * scene.size * np.array([1.0, 1.0, 0.0])
        end[1, 0] += force * scene.metres_per_newton
        _line(axes, end, "scale of forces", color=looks.BLACK, linewidth=3.0)
        words.append(f"black bar: {force:g} N")
    if scene.largest_torque > 0.0:
        torque = round_number(scene.largest_torque)
        degrees = round(float(np.degrees(torque * scene.radians_per_torque)))
        words.append(f"arc of {degrees}°: {torque:g} N·m")
    axes.text2D(0.02, 0.97, "\n".join(words), transform=axes.transAxes, fontsize=9, va="top")
