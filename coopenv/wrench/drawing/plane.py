"""A split in the plane, drawn on axes of Matplotlib."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.drawing import looks, regions, shapes
from coopenv.wrench.drawing.looks import Look
from coopenv.wrench.drawing.scene import RADIUS, Scene, round_number

BEGIN = 0.5 * np.pi  # [rad] where arcs begin: above the grip


def draw(axes: Any, scene: Scene, *, show_regions: bool) -> None:
    """Draw everything, from the bottom up; artists bear names such as ``internal force 1``."""
    _object(axes, scene)
    if show_regions:
        _regions(axes, scene)
    for i, grip in enumerate(scene.grips):
        _wrench(axes, scene, i, grip)
    _object_wrench(axes, scene)
    _grips(axes, scene)
    axes.set_aspect("equal", adjustable="box" if _is_bound(axes) else "datalim")
    axes.autoscale_view()
    _scale_bars(axes, scene)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def _is_bound(axes: Any) -> bool:
    """Whether others have the limits of both of its axes, which are then not its own to widen."""
    both = (axes.get_shared_x_axes(), axes.get_shared_y_axes())
    return all(len(group.get_siblings(axes)) > 1 for group in both)


def _object(axes: Any, scene: Scene) -> None:
    """Outline, or lines from the centre of mass to the grips; the centre of mass."""
    if scene.outline is not None:
        axes.fill(*scene.outline.T, facecolor="#F4F4F4", edgecolor="#999999", linewidth=1.0,
                  zorder=0.5, gid="object")  # fmt: skip
    else:
        for grip in scene.grips:
            axes.plot(*np.stack([np.zeros(2), grip], axis=1), color="#E4E4E4", linewidth=9,
                      solid_capstyle="round", zorder=0.5, gid="object")  # fmt: skip
    axes.plot([0.0], [0.0], marker="+", color=looks.BLACK, markersize=9, linestyle="", zorder=7,
              gid="centre of mass")  # fmt: skip


def _regions(axes: Any, scene: Scene) -> None:
    """Discs of eq. 9, what bands of eq. 10 leave of them, and for a pair what is feasible."""
    seen = np.linalg.norm(scene.force(scene.applied), axis=-1) > 0.0
    for i in np.flatnonzero(seen).tolist():
        _region(axes, scene, i, regions.disc(scene.applied[i, :2]), looks.BALL)
        if np.any(scene.grips[i]):
            corners = regions.disc_and_band(scene.applied, scene.grips, i)
            _region(axes, scene, i, corners, looks.BAND)
    if len(scene.grips) == 2:
        first = regions.feasible_forces(scene.applied, scene.grips)
        both = (first, scene.applied[:, :2].sum(axis=0) - first)
        for i in np.flatnonzero(seen).tolist():
            _region(axes, scene, i, both[i], looks.FEASIBLE)


_LEVELS = {looks.BALL: 1.0, looks.BAND: 1.0, looks.FEASIBLE: 3.5}  # a line too is to be seen
_STYLES = {
    looks.BALL: {"facecolor": "none", "edgecolor": "#888888", "linestyle": "--", "linewidth": 0.9},
    looks.BAND: {"facecolor": "#56B4E924", "edgecolor": "none", "linewidth": 0.0},
    looks.FEASIBLE: {"facecolor": "#56B4E970", "edgecolor": looks.SKY, "linewidth": 2.6},
}


def _region(axes: Any, scene: Scene, i: int, corners: FloatArray, name: str) -> None:
    from matplotlib.patches import Polygon

    place = scene.grips[i] + scene.metres_per_newton * corners
    style: dict[str, Any] = _STYLES[name]
    axes.add_patch(
        Polygon(
            place,
            closed=True,
            zorder=_LEVELS[name],
            label=name,
            gid=f"{name} {i + 1}",
            joinstyle="round",
            **style,
        )
    )


def _wrench(axes: Any, scene: Scene, i: int, grip: FloatArray) -> None:
    """Applied arrow and arc of one effector, and its split upon them, tip to tail."""
    parts = (
        (looks.APPLIED, scene.applied[i], grip, 3.0),
        (looks.MANIPULATION, scene.manipulation[i], grip, 4.0),
        (looks.INTERNAL, scene.internal[i], scene.internal_starts()[i], 5.0),
    )
    for look, wrench, start, level in parts:
        _arrow(axes, scene, start, scene.force(wrench), look, f"force {i + 1}", level)
    applied, forward, back = (float(scene.torque(part)[0]) for _, part, _, _ in parts)
    radius = RADIUS * scene.size
    beside = radius * 1.25 if forward * back < 0 else radius
    for look, sweep, begin, where, level in (
        (looks.APPLIED, applied, BEGIN, radius, 3.0),
        (looks.MANIPULATION, forward, BEGIN, radius, 4.0),
        (looks.INTERNAL, back, BEGIN + forward, beside, 5.0),
    ):
        _arc(axes, scene, grip, (where, begin, sweep), look, f"torque {i + 1}", level)


def _object_wrench(axes: Any, scene: Scene) -> None:
    """Resultant force and torque at the centre of mass."""
    wrench, centre = scene.object_wrench, np.zeros(2)
    look = looks.OBJECT_WRENCH
    if np.any(scene.grips):
        _arrow(axes, scene, centre, scene.force(wrench), look, "force", 3.5)
        sweep = float(scene.torque(wrench)[0])
        _arc(axes, scene, centre, (0.7 * RADIUS * scene.size, BEGIN, sweep), look, "torque", 3.5)


def _arrow(
    axes: Any,
    scene: Scene,
    start: FloatArray,
    vector: FloatArray,
    look: Look,
    name: str,
    level: float,
) -> None:
    if np.any(vector):
        corners = shapes.arrow(start, vector, look.width * scene.size)
        _patch(axes, corners, look, name, level)


def _arc(
    axes: Any,
    scene: Scene,
    centre: FloatArray,
    arc: tuple[float, float, float],
    look: Look,
    name: str,
    level: float,
) -> None:
    """``arc``: radius [m], first angle and sweep [rad]."""
    if arc[2] != 0.0:
        corners = shapes.round_arrow(centre, *arc, 0.75 * look.width * scene.size)
        _patch(axes, corners, look, name, level)


def _patch(axes: Any, corners: FloatArray, look: Look, name: str, level: float) -> None:
    from matplotlib.patches import Polygon

    kind = look.name.split()[0]
    axes.add_patch(
        Polygon(
            corners,
            closed=True,
            facecolor=look.face,
            edgecolor=look.edge,
            linewidth=1.0,
            joinstyle="miter",
            zorder=level,
            label=look.name,
            gid=f"{kind} {name}",
        )
    )


def _grips(axes: Any, scene: Scene) -> None:
    """Where the effectors hold, and their numbers."""
    axes.plot(*scene.grips.T, "o", color="white", markeredgecolor=looks.BLACK, markersize=5,
              zorder=6, gid="grips")  # fmt: skip
    places = np.array([_number_place(scene, i) for i in range(len(scene.grips))])
    axes.plot(*places.T, ".", markersize=14, alpha=0.0)  # room for the numbers
    for i, place in enumerate(places):
        axes.text(*place, str(i + 1), ha="center", va="center", fontsize=10, zorder=8,
                  color=looks.BLACK, gid=f"number {i + 1}")  # fmt: skip


def _number_place(scene: Scene, i: int) -> FloatArray:
    """Beside the grip where nothing points; at the tips where the effectors share one place."""
    grip, force = scene.grips[i], scene.force(scene.applied)[i]
    if not np.ptp(scene.grips, axis=0).any():
        length = float(np.linalg.norm(force))
        return grip + force * (1.0 + 0.06 * scene.size / length) if length else grip
    taken = [force, scene.force(scene.manipulation)[i], scene.force(scene.internal)[i], -grip]
    ways = [each / np.linalg.norm(each) for each in taken if np.any(each)]
    angles = np.arctan2(grip[1], grip[0]) + np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    free = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    nearest = np.max(free @ np.stack(ways, axis=-1), axis=-1) if ways else np.zeros(16)
    return grip + 1.6 * RADIUS * scene.size * free[nearest.round(3).argmin()]


def _scale_bars(axes: Any, scene: Scene) -> None:
    """Below everything: how long a round force, how wide a round torque is drawn."""
    left, bottom = axes.dataLim.x0, axes.dataLim.y0
    base, size = bottom - 0.12 * scene.size, scene.size
    if scene.largest_force > 0.0:
        force = round_number(scene.largest_force)
        right = left + force * scene.metres_per_newton
        axes.plot([left, right], [base, base], color=looks.BLACK, linewidth=2.5,
                  solid_capstyle="butt", gid="scale of forces")  # fmt: skip
        axes.text(left, base - 0.035 * size, f"{force:g} N", va="top", fontsize=9)
        left = right + 0.25 * size
    if scene.largest_torque > 0.0:
        torque = round_number(scene.largest_torque)
        angles = BEGIN + np.linspace(0.0, torque * scene.radians_per_torque, 60)
        radius = 0.6 * RADIUS * size
        x, y = left + radius * np.cos(angles), base + radius * np.sin(angles)
        axes.plot(x, y, color=looks.BLACK, linewidth=2.5, gid="scale of torques")
        axes.text(left + 1.6 * radius, base, f"{torque:g} N·m", va="center", fontsize=9)
    axes.plot([left], [base - 0.12 * size], alpha=0.0)  # room for the words
