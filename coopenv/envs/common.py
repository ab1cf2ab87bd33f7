"""Spaces, joint actions, reset options and pictures, which all views share."""

import warnings
from collections.abc import Mapping, Sequence
from copy import deepcopy
from math import isfinite
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space

from coopenv.arrays import FloatArray, plain_array
from coopenv.errors import InvalidInput, UnknownName
from coopenv.pushes import check_numbers
from coopenv.render.renderer import MODES, Renderer
from coopenv.transport import Transport

RENDER_MODES = tuple(MODES)
RESET_OPTIONS = ("pose", "goal")
COMPONENTS = ("fx", "fy", "tz")  # of an action, agent frame


def agent_observation_space(transport: Transport) -> "Box[np.float32]":
    """What one agent sees."""
    return Box(transport.observation.low, transport.observation.high, dtype=np.float32)


def agent_action_space(transport: Transport) -> Space[Any]:
    """What one agent does: numbers in [−1, 1], or the number of a push."""
    if transport.table is not None:
        return Discrete(len(transport.table))
    return Box(-1.0, 1.0, (transport.action_size,), dtype=np.float32)


def team_observation_space(transport: Transport) -> "Box[np.float32]":
    """What all agents of a world that learn see, one after the other."""
    low, high = transport.observation.low, transport.observation.high
    count = len(transport.learners)
    return Box(np.tile(low, count), np.tile(high, count), dtype=np.float32)


def team_action_space(transport: Transport) -> Space[Any]:
    """What all agents of a world that learn do, one after the other."""
    if transport.table is not None:
        return MultiDiscrete([len(transport.table)] * len(transport.learners))
    return Box(-1.0, 1.0, (len(transport.learners) * transport.action_size,), dtype=np.float32)


def team_actions(
    transport: Transport, action: npt.ArrayLike, shape: tuple[int, ...] | None
) -> npt.NDArray[Any]:
    """Joint actions of ``shape`` as the core takes them (`Transport.action_shape`)."""
    given = plain_array(action, "action")
    if given.shape != shape:
        raise InvalidInput(f"action must have shape {shape}, got {given.shape}; see action_space")
    return given.reshape(transport.action_shape)


def check_action(action: npt.NDArray[Any], name: str, table: FloatArray | None) -> None:
    """Raise `InvalidInput` unless one agent's action, of the right shape, can be done.

    Parameters
    ----------
    action
        ``(action_size,)``, or the number ``()`` of a push.
    name
        What its user calls it.
    table
        Of the pushes, if actions are discrete.
    """
    if table is not None:
        check_numbers(action, name, len(table))
        return
    numbers = action.astype(np.float64).tolist()
    for component, number in zip(COMPONENTS, numbers, strict=False):  # without a torque, two
        if not isfinite(number):
            raise InvalidInput(
                f"{name} must be finite, got {number} for {component}; give numbers in [-1, 1]"
            )


def refused(
    joint: npt.NDArray[Any], names: Sequence[str], table: FloatArray | None
) -> InvalidInput | None:
    """What `check_action` refuses of one world's actions ``(1, learner, ...)``, called ``names``.

    To be asked once the core has refused something, to name an agent instead of a place in a batch;
    ``None`` where it was no action.
    """
    for action, name in zip(joint[0], names, strict=True):
        try:
            check_action(action, name, table)
        except InvalidInput as error:
            return error
    return None


def check_render_mode(mode: str | None, known: Sequence[str]) -> str | None:
    """Return ``mode``, or raise `UnknownName` unless it is ``None`` or ``known``."""
    if mode is not None and mode not in known:
        raise UnknownName("render_mode", mode, known)
    return mode


def start_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Read ``options={"pose": ..., "goal": ...}`` of a reset.

    Another key warns and is left out: the option dictionary is shared with wrappers, and
    PettingZoo's API test puts a key of its own there.
    """
    given = options_dict(options)
    for name in set(given).difference(RESET_OPTIONS):
        warnings.warn(
            f"reset options must be among {RESET_OPTIONS}, got {name!r}; it has no effect",
            stacklevel=3,
        )
        del given[name]
    return given


def options_dict(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """A copy of a reset's ``options``, or raise `InvalidInput` unless a mapping or ``None``."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise InvalidInput(
            f"options must be a dict or None, got {options!r}; pass for example "
            "options={'goal': (1.0, 0.0, 0.0)}"
        )
    return dict(options)


def metadata_of(env: Any, transport: Transport, **other: Any) -> dict[str, Any]:
    """What the class of an environment tells in ``metadata``, at this one's pace; nobody else's.

    Wrappers change it: PettingZoo's `CaptureStdoutWrapper` adds a render mode.
    """
    fps = max(1, round(1 / transport.dt))  # pictures a second, one a control step
    return deepcopy({**env.metadata, "render_fps": fps, **other})


class Pictures:
    """Draws the worlds of a transport, each with a renderer made when it is first needed."""

    def __init__(self, transport: Transport, mode: str | None, known: Sequence[str] = RENDER_MODES):
        self._transport, self._mode = transport, check_render_mode(mode, known)
        self._renderers: dict[int, Any] = {}

    def draw(self, world: int = 0) -> Any:
        """The picture of a world ``(height, width, 3)`` uint8; ``None`` without mode or window."""
        transition = self._transport.transition
        if self._mode is None or transition is None:
            return None
        if world not in self._renderers:
            self._renderers[world] = Renderer(
                self._transport.bodies,
                self._transport.scenes,
                mode=self._mode,
                world=world,
                fps=max(1, round(1 / self._transport.dt)),
            )
        return self._renderers[world].draw(transition)

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_renderers": {}}  # pictures are drawn anew, windows stay here

    def close(self) -> None:
        """Close every window."""
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()
