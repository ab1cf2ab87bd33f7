"""What PettingZoo's own tests ask of its environments, asked of ours, and its wrappers."""

import pickle
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from pettingzoo.utils import average_total_reward, wrappers
from pettingzoo.utils.conversions import (
    aec_to_parallel,
    parallel_to_aec,
    turn_based_aec_to_parallel,
)
from pettingzoo.utils.random_demo import random_demo

from tests.helpers import EASY_TASKS, IDS, NEVER, PARALLEL
from tests.interop.cases import DRAWS, around_ids

EVERY_ID = pytest.mark.parametrize("view", IDS)


def turns(env: Any, count: int, seed: int = 0) -> list[Any]:
    """What ``count`` agents in turn are told, and what they do, from a seeded reset on."""
    env.reset(seed=seed)
    for i, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(i)
    told = []
    for agent in env.agent_iter(count):
        *seen, terminated, truncated, info = env.last()
        action = None if terminated or truncated else env.action_space(agent).sample()
        told.append((agent, *seen, terminated, truncated, dict(info), action))
        env.step(action)
    return told


def rounds(env: Any, count: int, seed: int = 0) -> list[Any]:
    """What ``count`` steps of all agents return, from a seeded reset on."""
    returned = [env.reset(seed=seed)]
    for i, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(i)
    while env.agents and len(returned) <= count:
        returned.append(env.step({agent: env.action_space(agent).sample() for agent in env.agents}))
    return returned


@EVERY_ID
def test_two_episodes_of_one_seed_are_equivalent_down_to_their_infos(view):
    keywords = {"task": EASY_TASKS[view], "horizon": 12}
    for make, play in ((PARALLEL[view].env, turns), (PARALLEL[view].parallel_env, rounds)):
        first, second = (make(**keywords) for _ in "ab")
        for seed in (0, 7):
            mine = play(first, 40, seed)
            assert data_equivalence(mine, play(second, 40, seed), exact=True)
            assert 1 < len(mine) < 40  # to the end


@EVERY_ID
def test_a_pickled_environment_plays_as_the_one_it_was_made_from(view, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    keywords = {"render_mode": "human" if DRAWS else None}
    for make, play in ((PARALLEL[view].env, turns), (PARALLEL[view].parallel_env, rounds)):
        env = make(**keywords)
        twin = pickle.loads(pickle.dumps(env))
        assert data_equivalence(play(twin, 10, 42), play(env, 10, 42), exact=True)
        env.close()
        twin.close()


@EVERY_ID
def test_a_pickled_environment_begins_again_alike_after_a_reset_and_a_step(view):
    for make, play in ((PARALLEL[view].env, turns), (PARALLEL[view].parallel_env, rounds)):
        env = make()
        wanted = play(env, 6)
        twin = pickle.loads(pickle.dumps(env))
        assert data_equivalence(play(twin, 6), wanted, exact=True)


AROUND: dict[str, Any] = {  # those for agents in turn; name → what goes around
    "AssertOutOfBoundsWrapper": wrappers.AssertOutOfBoundsWrapper,
    "BaseWrapper": wrappers.BaseWrapper,
    "ClipOutOfBoundsWrapper": wrappers.ClipOutOfBoundsWrapper,
    "MultiEpisodeEnv": lambda env: wrappers.MultiEpisodeEnv(env, 1),
    "OrderEnforcingWrapper": wrappers.OrderEnforcingWrapper,
    "parallel and back": lambda env: parallel_to_aec(aec_to_parallel(env)),
}
AROUND_PARALLEL: dict[str, Any] = {
    "BaseParallelWrapper": wrappers.BaseParallelWrapper,
    "MultiEpisodeParallelEnv": lambda env: wrappers.MultiEpisodeParallelEnv(env, 1),
    "in turn and back": lambda env: aec_to_parallel(parallel_to_aec(env)),
}
OTHERS = {  # tested below; for windows that print text; for discrete actions with masks
    "RecordVideo",
    "RecordVideoParallel",
    "CaptureStdoutWrapper",
    "TerminateIllegalWrapper",
}


def test_every_wrapper_of_pettingzoos_is_tried_or_named():
    assert set(wrappers.__all__) <= {*AROUND, *AROUND_PARALLEL, *OTHERS}


@pytest.mark.parametrize(("view", "name"), around_ids([*AROUND, *AROUND_PARALLEL]))
def test_a_wrapped_environment_plays_as_the_bare_one(view, name):
    parallel = name in AROUND_PARALLEL
    make = PARALLEL[view].parallel_env if parallel else PARALLEL[view].env
    play = rounds if parallel else turns
    bare = make(task=NEVER, horizon=6)
    wrapped = {**AROUND, **AROUND_PARALLEL}[name](make(task=NEVER, horizon=6))
    assert wrapped.possible_agents == bare.possible_agents
    assert wrapped.metadata["name"] == bare.metadata["name"]
    assert data_equivalence(play(wrapped, 11), play(bare, 11), exact=True)
    assert wrapped.state().shape == bare.state().shape


@EVERY_ID
def test_several_episodes_can_be_played_as_one(view):
    bare = PARALLEL[view].parallel_env(task=NEVER, horizon=5)
    steps = rounds(wrappers.MultiEpisodeParallelEnv(bare, num_episodes=3), 100)
    assert len(steps) == 1 + 3 * 5


@EVERY_ID
def test_unwrapping_ends_at_the_environment_whatever_is_around_it(view, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env: Any = PARALLEL[view].env(render_mode="human" if DRAWS else None)
    base = env.unwrapped
    env.reset(seed=0)
    kinds: list[Any] = [
        wrappers.AssertOutOfBoundsWrapper,
        wrappers.BaseWrapper,
        wrappers.ClipOutOfBoundsWrapper,
        wrappers.OrderEnforcingWrapper,
        aec_to_parallel,
        parallel_to_aec,
        turn_based_aec_to_parallel,
    ]
    if DRAWS:
        kinds.insert(2, wrappers.CaptureStdoutWrapper)
    for around in kinds:
        env = around(env)
        assert env.unwrapped is base
    env.close()


@EVERY_ID
def test_an_environment_prints_as_its_name_and_prints_nothing_else(view, capsys):
    module = PARALLEL[view]
    name = module.__name__.rpartition(".")[2]
    parallel, env = module.parallel_env(), module.env()
    assert str(parallel) == name
    assert name in str(env)
    rounds(parallel, 5)
    turns(env, 10)
    assert capsys.readouterr() == ("", "")


@EVERY_ID
def test_pettingzoos_demonstrations_run(view, capsys):
    env = PARALLEL[view].env(horizon=5)
    total = random_demo(env, render=False, episodes=2)
    mean = average_total_reward(env, max_episodes=2)
    assert np.isfinite([total, mean]).all()
    assert capsys.readouterr().out.count("Average total reward") == 2


@EVERY_ID
@pytest.mark.skipif(not DRAWS, reason="needs coopenv[render]")
def test_nothing_of_pygame_starts_without_pictures_and_no_sound_with_them(view, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame = pytest.importorskip("pygame")
    pygame.quit()
    turns(PARALLEL[view].env(), 4)
    assert not pygame.display.get_init()
    assert not pygame.font.get_init()
    env = PARALLEL[view].env(render_mode="rgb_array")
    turns(env, 4)
    picture = env.render()
    assert (picture.dtype, picture.shape[2]) == (np.uint8, 3)
    assert picture.std() > 0
    assert not pygame.mixer.get_init()
    env.close()


@pytest.mark.skipif(not DRAWS, reason="needs coopenv[render]")
def test_videos_of_both_views_are_written(tmp_path, monkeypatch):
    pytest.importorskip("moviepy")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    module, keywords = PARALLEL[IDS[0]], {"render_mode": "rgb_array", "horizon": 3, "task": NEVER}
    kinds: list[tuple[Any, Any, Any]] = [
        (wrappers.RecordVideo, module.env, turns),
        (wrappers.RecordVideoParallel, module.parallel_env, rounds),
    ]
    for kind, make, play in kinds:
        folder = tmp_path / kind.__name__
        env = kind(make(**keywords), str(folder), episode_trigger=lambda episode: episode == 1)
        for _ in range(3):
            play(env, 20)
        env.close()
        (video,) = folder.iterdir()
        assert video.name == "rl-video-episode-1.mp4"
        assert video.stat().st_size > 1000


@pytest.mark.skipif(not DRAWS, reason="needs pygame")
def test_a_render_mode_that_a_wrapper_adds_is_its_environments_alone():
    wrappers.CaptureStdoutWrapper(PARALLEL[IDS[0]].env(render_mode="human"))
    for view in IDS:
        for make in (PARALLEL[view].env, PARALLEL[view].single_env):
            assert "ansi" not in make().metadata["render_modes"]
