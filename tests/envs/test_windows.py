"""Windows of the views, and what the parallel view says before the first episode."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pygame
import pytest

from coopenv import beam_transport_v0
from coopenv.render import Renderer
from tests.helpers import constant, parallel_actions


@pytest.fixture(autouse=True)
def _dummy_display(monkeypatch) -> Iterator[None]:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame.display.quit()
    yield
    pygame.display.quit()


def shown() -> np.ndarray | None:
    """The picture ``(height, width, 3)`` in the window, if one is open."""
    surface = pygame.display.get_surface() if pygame.display.get_init() else None
    return None if surface is None else pygame.surfarray.array3d(surface).transpose(1, 0, 2)


def drawn(core) -> np.ndarray:
    """The picture of the core's last step."""
    return Renderer(core.bodies, core.scenes).picture(core.transition)


def single(**keywords):
    env: Any = gymnasium.make("coopenv/BeamTransport-v0", **keywords).unwrapped
    return env, lambda: env.step(constant(env, 0.5))


def parallel(**keywords):
    env: Any = beam_transport_v0.parallel_env(**keywords)
    return env, lambda: env.step(parallel_actions(env, np.full((2, 3), 0.5)))


@pytest.mark.parametrize("make", [single, parallel])
def test_a_window_shows_every_reset_and_every_step_by_itself(make):
    env, step = make(render_mode="human", dt=0.001)  # as fast as pictures can be drawn
    assert env.metadata["render_fps"] == 1000
    assert env.render() is None  # nothing to show yet
    assert shown() is None
    env.reset(seed=0)
    np.testing.assert_array_equal(shown(), first := drawn(env.transport))
    step()
    np.testing.assert_array_equal(shown(), second := drawn(env.transport))
    assert (first != second).any()
    env.reset(seed=1)
    np.testing.assert_array_equal(shown(), drawn(env.transport))
    assert env.render() is None
    env.close()
    assert shown() is None


@pytest.mark.parametrize("make", [single, parallel])
@pytest.mark.parametrize("mode", [None, "rgb_array"])
def test_without_a_window_nothing_is_shown(make, mode):
    env, step = make(render_mode=mode)
    assert env.render() is None
    env.reset(seed=0)
    step()
    assert shown() is None
    picture = env.render()
    if mode is None:
        assert picture is None
    else:
        np.testing.assert_array_equal(picture, drawn(env.transport))


@pytest.mark.parametrize(("dt", "fps"), [(0.05, 20), (0.3, 3), (3.0, 1)])
def test_pictures_a_second_follow_the_control_step(dt, fps):
    for make in (single, parallel):
        assert make(dt=dt)[0].metadata["render_fps"] == fps


def test_the_state_before_the_first_reset_is_zero_and_then_all_that_is_seen():
    env: Any = beam_transport_v0.parallel_env()
    state = env.state()
    assert (state.shape, state.dtype) == (env.state_space.shape, np.float32)
    assert not state.any()
    state[:] = 1.0  # the caller's own
    assert not env.state().any()
    seen, _ = env.reset(seed=0)
    np.testing.assert_array_equal(env.state(), np.concatenate([seen["agent_0"], seen["agent_1"]]))
    seen, *_ = env.step(parallel_actions(env, np.full((2, 3), 0.5)))
    np.testing.assert_array_equal(env.state(), np.concatenate([seen["agent_0"], seen["agent_1"]]))


def test_nobody_is_there_before_the_first_reset():
    env: Any = beam_transport_v0.parallel_env()
    assert env.agents == []
    assert env.possible_agents == ["agent_0", "agent_1"]
