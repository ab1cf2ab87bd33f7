"""Renderer: what a picture of a step shows, and windows."""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pygame
import pytest

from coopenv import Body, Scene, Transport, TransportTask
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput, MissingExtra, UnknownName
from coopenv.render import Renderer
from coopenv.render.canvas import Picture
from coopenv.render.look import AGENTS, APPLIED, ARRIVED, INTERNAL
from tests.helpers import CLUTTERED, TRIO
from tests.render.cases import SQUEEZE, last, picture, started, stepped

SHARE = [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]  # both push the same way
PLATE = Body(
    mass=12.0,
    outline=((-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)),
    grips=((-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)),
)


def amount(frame: Picture, color: tuple[int, int, int]) -> int:
    """How many pixels of the room, the caption left out, have exactly this colour."""
    room = frame[: frame.shape[1]]
    return int((room == color).all(axis=-1).sum())


@pytest.fixture
def dummy_display(monkeypatch) -> Iterator[None]:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield
    pygame.display.quit()


def test_a_picture_has_the_width_asked_for_and_an_even_height_after_the_room():
    square = picture(started(), width=320)
    wide = picture(started(scene=Scene(size=(9.0, 3.0))), width=320)
    assert square.dtype == np.uint8
    assert square.shape[1:] == wide.shape[1:] == (320, 3)
    assert square.shape[0] % 2 == wide.shape[0] % 2 == 0
    assert wide.shape[0] < square.shape[0] / 2 + 60


def test_a_tall_room_is_drawn_narrower_rather_than_endlessly_high():
    frame = picture(started(scene=Scene(size=(2.5, 40.0))), width=200)
    assert frame.shape[0] < 1.5 * 200 + 200


def test_the_same_transition_gives_the_same_bits():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes)
    first = renderer.picture(last(core))
    core.step(np.zeros((1, 2, 3)))
    other = renderer.picture(last(core))
    assert (first != other).any()
    again = stepped(SQUEEZE)
    assert np.array_equal(renderer.picture(last(again)), first)
    assert np.array_equal(picture(again), first)


def test_a_picture_is_the_callers_own():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes)
    first = renderer.picture(last(core))
    kept = first.copy()
    first[:] = 0
    assert np.array_equal(renderer.picture(last(core)), kept)


def test_every_part_of_the_state_shows():
    frames = [
        picture(core, width=320)
        for core in (started(), stepped(np.zeros((2, 3))), stepped(SHARE), stepped(SQUEEZE))
    ]
    moved, turned, elsewhere = Transport(), Transport(), Transport()
    moved.reset(seed=0, pose=(0.5, 0.0, 0.3), goal=(0.4, 1.4, 0.0))
    turned.reset(seed=0, pose=(0.0, 0.0, 0.3 + np.pi), goal=(0.4, 1.4, 0.0))  # the ends differ
    elsewhere.reset(seed=0, pose=(0.0, 0.0, 0.3), goal=(0.4, 1.4, np.pi))
    frames += [picture(core, width=320) for core in (moved, turned, elsewhere)]
    assert len({frame.tobytes() for frame in frames}) == len(frames)


def test_y_points_up():
    core = Transport()
    core.reset(seed=0, pose=(0.0, 2.0, 0.0), goal=(0.0, -2.0, 0.0))
    rows = np.argwhere((picture(core)[:640] == AGENTS[0]).all(axis=-1))[:, 0]
    discs = np.bincount(rows, minlength=640)  # the body's disc is filled, the goal's a thin ring
    assert discs[:200].sum() > discs[-200:].sum() > 0


def test_an_applied_force_draws_a_dark_arrow_and_no_force_none():
    assert amount(picture(stepped(np.zeros((2, 3)))), APPLIED) == 0
    weak, strong = ([[size, 0.0, 0.0], [0.0, 0.0, 0.0]] for size in (0.3, 0.9))
    assert 0 < amount(picture(stepped(weak)), APPLIED) < amount(picture(stepped(strong)), APPLIED)


def test_squeezing_draws_internal_arrows_and_sharing_the_load_none():
    assert amount(picture(stepped(SHARE)), INTERNAL) == 0
    assert amount(picture(stepped(SHARE)), APPLIED) > 100
    assert amount(picture(stepped(SQUEEZE)), INTERNAL) > 100


def test_an_arrow_starts_at_its_grip_and_points_along_the_force():
    core = Transport()
    core.reset(seed=0, pose=(0.0, 0.0, 0.0), goal=(0.0, 2.0, 0.0))
    core.step([[[0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]])  # agent 0 sits at (−0.9, 0), x to the right
    scale = (640 - 24) / 6.0  # [px/m]
    dark = np.argwhere((picture(core)[:640] == APPLIED).all(axis=-1))
    assert abs(dark[:, 1].mean() - (320 - 0.9 * scale)) < 3.0
    assert dark[:, 0].min() > 320  # downwards
    assert dark[:, 0].max() > 320 + 0.7 * scale


def test_a_torque_draws_a_bent_arrow_and_its_sense_shows():
    left, right = (stepped([[0.0, 0.0, sign], [0.0, 0.0, 0.0]]) for sign in (1.0, -1.0))
    assert amount(picture(left), APPLIED) > 30
    assert (picture(left) != picture(right)).any()
    assert amount(picture(stepped([[0.0, 0.0, 0.01], [0.0, 0.0, 0.0]])), APPLIED) == 0


def test_success_turns_the_goal_green():
    core = Transport()
    core.reset(seed=0, pose=(0.0, 0.0, 0.0), goal=(0.0, 0.0, 0.0))
    assert amount(picture(core), ARRIVED) == 0
    core.step(np.zeros((1, 2, 3)))
    assert last(core).success[0]
    assert amount(picture(core), ARRIVED) > 0


@pytest.mark.parametrize("body", [TRIO, PLATE, Body(grips=((-0.9, 0.0),) * 9)])
def test_any_number_of_agents_is_drawn_among_obstacles(body):
    core = Transport(body=body, scene=CLUTTERED)
    core.reset(seed=1)
    core.step(np.full((1, body.num_agents, 3), 0.7))
    frame = picture(core)
    for agent in range(min(body.num_agents, len(AGENTS))):
        assert (frame == AGENTS[agent]).all(axis=-1).any()


def test_the_world_asked_for_is_drawn():
    core = Transport(num_worlds=3, scene=[Scene(), CLUTTERED, Scene(size=(9.0, 3.0))])
    core.reset(seed=0)
    core.step(np.full((3, 2, 3), 0.5))
    frames = [picture(core, world=k, width=320) for k in range(3)]
    assert len({frame.tobytes() for frame in frames}) == 3
    alone = Transport(scene=CLUTTERED)
    alone.reset(seed=1)
    alone.step(np.full((1, 2, 3), 0.5))
    assert np.array_equal(picture(alone, width=320), frames[1])


def test_undefined_load_shares_and_a_start_are_drawn():
    core = started()
    assert np.isnan(last(core).decomposition.load_share.force).all()
    assert picture(core).any()


@pytest.mark.parametrize(
    ("keywords", "error", "says"),
    [
        ({"mode": "rgb"}, UnknownName, "rgb_array"),
        ({"world": 1}, InvalidInput, "world must be less than the 1"),
        ({"world": -1}, InvalidInput, "world"),
        ({"width": 20}, InvalidInput, "width"),
        ({"mode": "human", "fps": 0}, InvalidInput, "fps"),
    ],
)
def test_wrong_arguments_are_named(keywords, error, says):
    core = started()
    with pytest.raises(error, match=says):
        Renderer(core.bodies, core.scenes, **keywords)


def test_arrays_need_no_display_and_leave_sdl_alone():
    code = """
import os, numpy as np
before = {name: value for name, value in os.environ.items() if name.startswith(("SDL", "PYGAME"))}
from coopenv import Transport
from coopenv.render import Renderer
core = Transport(); core.reset(seed=0)
assert Renderer(core.bodies, core.scenes).draw(core.transition).any()
import pygame
assert not pygame.display.get_init()
after = {name: value for name, value in os.environ.items() if name.startswith(("SDL", "PYGAME"))}
assert before == after, (before, after)
"""
    without = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    without["SDL_VIDEODRIVER"] = "no such driver"
    run = subprocess.run(
        [sys.executable, "-c", code], env=without, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == ""  # pygame's greeting would spoil tables


def test_standard_output_stays_while_pygame_is_imported():
    """An interruption in that moment could keep it away for good."""
    code = """
import sys
seen = []
class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "pygame":
            seen.append(sys.stdout)
sys.meta_path.insert(0, Watch())
from coopenv.render.canvas import load_pygame
load_pygame()
assert seen == [sys.stdout], seen
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


def test_another_librarys_pygame_quit_does_no_harm():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes)
    first = renderer.picture(last(core))
    pygame.quit()
    assert np.array_equal(renderer.picture(last(core)), first)


@pytest.mark.usefixtures("dummy_display")
def test_a_window_opens_with_the_first_picture_and_closes():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes, mode="human", width=320, fps=1000)
    assert not renderer.is_open
    assert renderer.draw(last(core)) is None
    assert renderer.is_open
    assert renderer.held_keys() == frozenset()
    surface = pygame.display.get_surface()
    assert surface is not None
    shown = pygame.surfarray.array3d(surface).transpose(1, 0, 2)
    assert np.array_equal(shown, renderer.picture(last(core)))
    renderer.close()
    renderer.close()
    assert not renderer.is_open
    assert not pygame.display.get_init()


@pytest.mark.usefixtures("dummy_display")
def test_a_window_closed_by_hand_stays_closed():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes, mode="human", width=320, fps=1000)
    renderer.draw(last(core))
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    renderer.draw(last(core))
    assert not renderer.is_open
    renderer.draw(last(core))
    assert not renderer.is_open
    assert not pygame.display.get_init()


@pytest.mark.usefixtures("dummy_display")
def test_a_window_keeps_to_its_pace():
    core = stepped(SQUEEZE)
    renderer = Renderer(core.bodies, core.scenes, mode="human", width=200, fps=10)
    renderer.draw(last(core))
    start = pygame.time.get_ticks()
    for _ in range(3):
        renderer.draw(last(core))
    assert pygame.time.get_ticks() - start >= 250  # [ms]
    renderer.close()


def test_a_window_without_a_display_says_what_to_do(monkeypatch):
    pygame.display.quit()
    monkeypatch.setenv("SDL_VIDEODRIVER", "no such driver")
    core = started()
    renderer = Renderer(core.bodies, core.scenes, mode="human")
    with pytest.raises(InvalidInput, match="'rgb_array' where no window"):
        renderer.draw(last(core))


def test_a_missing_pygame_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    core = started()
    with pytest.raises(MissingExtra, match=r"coopenv\[render\]"):
        Renderer(core.bodies, core.scenes)


def test_platforms_and_paths_of_a_task_show_on_the_floor_and_change_with_the_plan():
    for env in ("coopenv/BeamDoorway-v0", "coopenv/BeamTracking-v0"):
        core = Transport(config=find_config(env, {}))
        core.reset(seed=0)
        assert core.transition is not None
        renderer = Renderer(core.bodies, core.scenes)
        marked = renderer.picture(core.transition)
        hidden = replace(core.conditions, task=TransportTask())
        plain = renderer.picture(replace(core.transition, conditions=hidden))
        assert (marked != plain).any(axis=2).sum() > 100
        np.testing.assert_array_equal(renderer.picture(core.transition), marked)
    other = replace(core.conditions, plan=core.conditions.plan * 0.5)
    assert (renderer.picture(replace(core.transition, conditions=other)) != marked).any()
