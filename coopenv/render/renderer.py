"""Renderer: pictures of a step, with applied and internal wrenches at every grip."""

from collections.abc import Sequence
from math import cos, sin
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, positive, whole
from coopenv.errors import InvalidInput, UnknownName
from coopenv.geometry.frames import moved
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.render.canvas import Canvas, Picture, Window, around
from coopenv.render.caption import Caption
from coopenv.render.look import (
    ARRIVED,
    BODY,
    BODY_ARRIVED,
    EDGE,
    FLOOR,
    FULL_TURN,
    GRID,
    MARK,
    PAGE,
    SHADOW,
    WALL,
    agent_color,
    chevron,
    draw_wrenches,
    ghost,
    wheels,
)
from coopenv.transition import Transition

MODES = ("human", "rgb_array")
TALLEST = 1.5  # of a room's picture, per width


class Renderer:
    """Draws one world: room, goal, body and, at every grip, applied and internal wrench.

    Dark arrows are what the agents apply, as forces and, round the grip, torques; the bright core
    in them is the internal part. Beneath: time, γ, F_I, T_I and each agent's share of the load.
    The goal is a ghost of the body, its grips in the agents' colours too. What a task
    marks, platforms or a path, is drawn on the floor.

    Parameters
    ----------
    bodies, scenes
        One a world, as `coopenv.Transport` has them.
    mode
        ``"rgb_array"`` returns pictures and needs no display; ``"human"`` shows them in a window.
    world
        The one that is drawn.
    width
        Of the picture [px]; its height follows from the room. A tall room is drawn narrower.
    fps
        Pictures a second to which a window is held.

    Raises
    ------
    UnknownName, InvalidInput, MissingExtra
        If the mode is not known, a value breaks its rule, or pygame is not installed.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        scenes: Sequence[Scene],
        *,
        mode: str = "rgb_array",
        world: int = 0,
        width: int = 640,
        fps: float = 20,
    ):
        if mode not in MODES:
            raise UnknownName("mode", mode, MODES)
        self.mode, self.world = mode, whole(world, "world", at_least=0)
        if self.world >= len(bodies):
            raise InvalidInput(
                f"world must be less than the {len(bodies)} worlds there are, got {world}; "
                "worlds are counted from 0"
            )
        width = whole(width, "width", at_least=160, at_most=16384)
        self._window = Window("coopenv", positive(fps, "fps")) if mode == "human" else None
        self._set(bodies[self.world], scenes[self.world])
        self._lay_out(width)
        self._background = self._paint_background()

    @property
    def is_open(self) -> bool:
        """Whether a window shows; false in ``"rgb_array"`` mode and once closed by hand."""
        return self._window is not None and self._window.is_open

    def draw(self, transition: Transition) -> Picture | None:
        """Show the end of a step in the window, or return its `picture` if there is none."""
        picture = self.picture(transition)
        if self._window is None:
            return picture
        self._window.show(picture)
        return None

    def picture(self, transition: Transition) -> Picture:
        """The end of a step, ``(height, width, 3)`` uint8, in either mode.

        Wrenches are held in the object frame, so they appear turned with the body.
        """
        conditions = transition.conditions
        body, scene = conditions.bodies[self.world], conditions.scenes[self.world]
        if body is not self.body or scene is not self.scene:  # another episode
            self._set(body, scene)
            self._background = self._paint_background()
        self._draw_scenery(transition)
        self._draw_body(transition)
        self._draw_wrenches(transition)
        self._caption.write(self._canvas, transition, self.world)
        return self._canvas.pixels.copy()

    def held_keys(self) -> frozenset[str]:
        """Names of the keys held down in the window (``"w"``, ``"left"``, ...), to play by."""
        return frozenset() if self._window is None else self._window.held_keys()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _set(self, body: Body, scene: Scene) -> None:
        """Draw this body in this scene from now on; rooms keep their size."""
        self.body, self.scene = body, scene
        self._shown_goal: tuple[Any, ...] | None = None
        self._marked: tuple[Any, Picture] | None = None  # task and plan, the background with them

    def _lay_out(self, width: int) -> None:
        """Fix what goes where: the room first, the caption beneath it."""
        self._unit = min(max(width / 640, 0.6), 3.0)  # [px] a line that is just well visible
        self._frame = frame = round(12 * self._unit)
        across, up = self.scene.size
        self._scale = min((width - 2 * frame) / across, TALLEST * width / up)  # [px/m]
        self._center = np.array([width / 2, frame + up * self._scale / 2])
        self._caption = Caption(
            left=frame,
            right=width - frame,
            top=round(up * self._scale) + 2 * frame,
            num_agents=self.body.num_agents,
            unit=self._unit,
        )
        height = self._caption.bottom
        self._canvas = Canvas(width, height + height % 2)  # video codecs want it even

    def _paint_background(self) -> Picture:
        canvas, unit = self._canvas, self._unit
        height, width, _ = canvas.pixels.shape
        canvas.fill((0, 0, width, height), PAGE)
        half = np.array(self.scene.size) / 2
        corners = [self._pixels(-half), self._pixels(half)]
        left, top, right, bottom = room = around(corners, 0)
        canvas.fill(around(corners, self._frame), WALL)
        canvas.fill(room, FLOOR)
        for metre in range(-int(max(half)), int(max(half)) + 1):
            x, y = self._pixels((metre, metre))
            if abs(metre) < half[0]:
                canvas.fill((x, top, x + max(unit, 1), bottom), GRID)
            if abs(metre) < half[1]:
                canvas.fill((left, y, right, y + max(unit, 1)), GRID)
        for obstacle in self.scene.obstacles:
            outline = self._pixels(obstacle.vertices)
            with canvas.fine(around([outline], 5 * unit)) as pen:
                if not self.scene.has_weight:  # an upright plane is seen from the side
                    pen.polygon(outline + 2.5 * unit, SHADOW)
                pen.polygon(outline, WALL)
        self._caption.paint(canvas)
        return canvas.pixels.copy()

    def _draw_scenery(self, transition: Transition) -> None:
        """Start from the background with the goal, which is drawn anew only when it changes."""
        goal, success = transition.next_state.goal[self.world], transition.success[self.world]
        floor = self._floor(transition)
        shown = (*goal.tolist(), bool(success), id(floor))
        if shown == self._shown_goal:
            self._canvas.pixels[:] = self._scenery
            return
        self._canvas.pixels[:] = floor
        outline, grips = self._placed(self.body.outline, goal), self._placed(self.body.grips, goal)
        color, unit = ARRIVED if success else EDGE, self._unit
        with self._canvas.fine(around([outline, grips], 8 * unit)) as pen:
            ghost(pen, outline, color, unit)
            chevron(pen, self._pixels(self._mark(goal)), goal[2], color, unit)
            for agent, grip in enumerate(grips):
                pen.disc(grip, 6 * unit, agent_color(agent))
                pen.disc(grip, 3.4 * unit, FLOOR)
        self._scenery, self._shown_goal = self._canvas.pixels.copy(), shown

    def _floor(self, transition: Transition) -> Picture:
        """The background with the task's markings, drawn anew only when they change."""
        task, plan = transition.conditions.task, transition.conditions.plan[self.world]
        key = task, plan.tobytes()
        if self._marked is None or self._marked[0] != key:
            self._canvas.pixels[:] = self._background
            for line in task.markings(plan):
                points, unit = self._pixels(line), self._unit
                with self._canvas.fine(around([points], 3 * unit)) as pen:
                    if np.array_equal(line[0], line[-1]):
                        pen.polygon(points, MARK, opacity=0.12)
                    pen.line(points, 1.4 * unit, MARK)
            self._marked = key, self._canvas.pixels.copy()
        return self._marked[1]

    def _draw_body(self, transition: Transition) -> None:
        pose, unit = transition.next_state.pose[self.world], self._unit
        outline = self._placed(self.body.outline, pose)
        arrived = transition.success[self.world]
        fill, edge = (BODY_ARRIVED, ARRIVED) if arrived else (BODY, EDGE)
        with self._canvas.fine(around([outline], 5 * unit)) as pen:
            if not self.scene.has_weight:
                pen.polygon(outline + 2.5 * unit, SHADOW)
            pen.polygon(outline, fill)
            pen.line(outline, 1.6 * unit, edge, closed=True)
            for wheel in wheels(self.body) if self.body.nonholonomic else ():
                pen.polygon(self._placed(wheel, pose), edge)
            chevron(pen, self._pixels(self._mark(pose)), pose[2], edge, unit)

    def _draw_wrenches(self, transition: Transition) -> None:
        k, unit = self.world, self._unit
        pose = transition.next_state.pose[k]
        internal = transition.of_agents(transition.decomposition.internal)
        wrenches = np.stack([transition.applied[k], internal[k]])
        force_limit, torque_limit = transition.team.limits[k].max(axis=0)
        longest = max(0.8 * self.body.reach, 0.12 * min(self.scene.size))  # [m] at the limit
        to_pixels = self._scale * longest / force_limit * np.array([1, -1])  # [px/N]
        turned = moved(wrenches[..., :2], (0.0, 0.0, pose[2]))  # world frame [N]
        forces = to_pixels * turned  # (applied or internal, agent, 2) [px]
        turns = FULL_TURN * np.clip(wrenches[..., 2] / torque_limit, -1.2, 1.2)  # [rad]
        frames = transition.team.frame[k]
        outwards = pose[2] + np.arctan2(-frames[:, 1], -frames[:, 0])  # away from the centre [rad]
        grips = self._placed(self.body.grips, pose)
        draw_wrenches(self._canvas, grips, forces, turns, outwards, unit)

    def _mark(self, pose: FloatArray) -> FloatArray:
        """Where the mark of the heading goes [m]: to the centre of mass unless a grip is there."""
        if np.linalg.norm(self.body.grips, axis=1).min() > 0.1:
            return pose[:2]
        ahead = 0.7 * max(x for x, _ in self.body.outline)
        return pose[:2] + ahead * np.array([cos(pose[2]), sin(pose[2])])

    def _placed(self, points: npt.ArrayLike, pose: FloatArray) -> FloatArray:
        """Points of the object frame [m] in the picture [px]."""
        return self._pixels(moved(points, pose))

    def _pixels(self, points: npt.ArrayLike) -> FloatArray:
        """Points of the world frame [m] in the picture [px]."""
        return self._center + self._scale * np.asarray(points, dtype=np.float64) * (1, -1)
