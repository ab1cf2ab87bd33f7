"""Style of rendered pictures: colour palette, shapes of arrows, wheels and marks."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.physics.body import Body
from coopenv.render.canvas import Canvas, Color, Pen, around, arrow, bent_arrow

PAGE: Color = (255, 255, 255)
FLOOR: Color = (248, 247, 243)
GRID: Color = (236, 234, 227)
MARK: Color = (150, 172, 196)
WALL: Color = (94, 104, 118)
SHADOW: Color = (214, 214, 212)
BODY: Color = (198, 206, 216)
EDGE: Color = (74, 84, 98)
TEXT: Color = (74, 82, 94)
APPLIED: Color = (38, 44, 54)
INTERNAL: Color = (255, 92, 62)
ARRIVED: Color = (0, 158, 115)
BODY_ARRIVED: Color = (184, 226, 210)
AGENTS: tuple[Color, ...] = (  # after Okabe & Ito: they stay apart for the colour-blind
    (0, 114, 178),
    (240, 170, 20),
    (204, 121, 167),
    (0, 158, 115),
    (86, 180, 233),
    (240, 228, 66),
)
FULL_TURN = 1.5 * np.pi  # [rad] of a bent arrow that stands for the torque limit
SHAFT, CORE = 5.0, 2.4  # [unit] widths of an arrow and of the internal one in it


def agent_color(agent: int) -> Color:
    """The colour of an agent's grip; from the seventh on they come round again."""
    return AGENTS[agent % len(AGENTS)]


def ghost(pen: Pen, outline: FloatArray, color: Color, unit: float) -> None:
    """Draw a body that is not there."""
    red, green, blue = (round((c + f) / 2) for c, f in zip(color, FLOOR, strict=True))
    pen.polygon(outline, color, opacity=0.16)
    pen.line(outline, 1.2 * unit, (red, green, blue), closed=True)


def chevron(pen: Pen, center: FloatArray, angle: float, color: Color, unit: float) -> None:
    """Draw a small mark that points along ``angle``."""
    forward = np.array([np.cos(angle), -np.sin(angle)])
    side = np.array([-forward[1], forward[0]])
    ends = [center - 2 * unit * forward + across * unit * side for across in (3.2, -3.2)]
    pen.line([ends[0], center + 2 * unit * forward, ends[1]], 1.6 * unit, color)


def wheels(body: Body) -> list[FloatArray]:
    """Outlines of a wheel at each side of the centre of mass, object frame [m]."""
    ys = [y for _, y in body.outline]
    long, thick = 0.16 * body.reach, 0.06 * body.reach
    sides = min(ys) + 1.5 * thick, max(ys) - 1.5 * thick
    corners = ((-long, -thick), (long, -thick), (long, thick), (-long, thick))
    return [np.array([(x, y + side) for x, y in corners]) for side in sides]


def wrench_arrows(
    grip: FloatArray, force: FloatArray, outwards: float, turn: float, width: float, unit: float
) -> list[FloatArray]:
    """Outlines of a force [px] and of a torque as a turn [rad]; negligible ones are left out.

    The force starts at the rim of the grip's disc, the torque goes round it from ``outwards`` on.
    """
    shapes, length = [], float(np.hypot(*force))
    if abs(turn) > 0.3:
        shapes.append(bent_arrow(grip, 17 * unit, outwards, turn, 0.65 * width * unit))
    if length > 2 * unit:
        shapes.append(arrow(grip + 8.5 * unit / length * force, force, width * unit))
    return shapes


def draw_wrenches(
    canvas: Canvas,
    grips: FloatArray,
    forces: FloatArray,
    turns: FloatArray,
    outwards: FloatArray,
    unit: float,
) -> None:
    """Draw the grips, and at each the applied wrench with the internal one in it.

    Parameters
    ----------
    grips
        ``(n, 2)`` [px].
    forces, turns
        Applied and internal, ``(2, n, 2)`` [px] and ``(2, n)`` [rad].
    outwards
        ``(n,)``, where bent arrows begin [rad].
    unit
        Width of a line that is just well visible [px].
    """
    for agent, grip in enumerate(grips):
        dark, bright = (
            wrench_arrows(
                grip, force[agent], float(outwards[agent]), float(turn[agent]), width, unit
            )
            for force, turn, width in zip(forces, turns, (SHAFT, CORE), strict=True)
        )
        with canvas.fine(around([grip, *dark, *bright], 10 * unit)) as pen:
            for shape in dark:
                pen.line(shape, 2 * unit, FLOOR, closed=True)  # sets it off from the body
            for shape in dark:
                pen.polygon(shape, APPLIED)
            for shape in bright:
                pen.polygon(shape, INTERNAL)
            for radius, color in ((8, EDGE), (6.8, PAGE), (5.4, agent_color(agent))):
                pen.disc(grip, radius * unit, color)
