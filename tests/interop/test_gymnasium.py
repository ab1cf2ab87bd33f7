"""What Gymnasium's own tests ask of registered environments, asked of ours."""

import pickle
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import data_equivalence

from coopenv.envs import TransportEnv
from tests.helpers import EASY_TASKS, IDS, NEVER, constant
from tests.interop.cases import DRAWS, drawn_actions, names, started

SCALE: Any = (-2.0, 2.0)
EVERY_ID = pytest.mark.parametrize("view", IDS)


@EVERY_ID
def test_making_resetting_and_stepping_says_nothing_under_the_passive_checker(view):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env: Any = gymnasium.make(view)
        assert "PassiveEnvChecker" in names(env)
        env.reset()
        for action in drawn_actions(env, 5):
            env.step(action)
        env.close()


@EVERY_ID
def test_two_episodes_of_one_seed_are_equivalent_down_to_their_infos(view):
    first, second = (
        gymnasium.make(view, task=EASY_TASKS[view], horizon=20, disable_env_checker=True)
        for _ in "ab"
    )
    assert data_equivalence(first.reset(seed=0), second.reset(seed=0), exact=True)
    ends = 0
    for action in drawn_actions(first, 60):
        mine, theirs = first.step(action), second.step(action)
        assert mine[0] in first.observation_space
        assert data_equivalence(mine, theirs, exact=True)
        if mine[2] or mine[3]:
            ends += 1
            again = first.reset(seed=ends), second.reset(seed=ends)
            assert data_equivalence(*again, exact=True)
    assert ends >= 3


@EVERY_ID
def test_a_pickled_environment_begins_again_alike_after_a_reset_and_a_step(view):
    bare: Any = gymnasium.make(view, disable_env_checker=True).unwrapped
    for env in (bare, started(gymnasium.make(view))):
        (action,) = drawn_actions(env, 1)
        begun, moved = env.reset(seed=123), env.step(action)
        twin = pickle.loads(pickle.dumps(env))
        assert data_equivalence(twin.reset(seed=123), begun, exact=True)
        assert data_equivalence(twin.step(action), moved, exact=True)


@EVERY_ID
def test_a_pickled_vector_begins_again_alike_after_a_reset_and_a_step(view):
    env: Any = gymnasium.make_vec(view, num_envs=2)
    (action,) = drawn_actions(env, 1)
    begun, moved = env.reset(seed=123), env.step(action)
    twin = pickle.loads(pickle.dumps(env))
    assert data_equivalence(twin.reset(seed=123), begun, exact=True)
    assert data_equivalence(twin.step(action), moved, exact=True)


def check_picture(picture: Any) -> None:
    assert isinstance(picture, np.ndarray)
    assert picture.dtype == np.uint8
    assert picture.ndim == 3
    assert picture.shape[2] == 3
    assert picture.std() > 0  # something is on it


@EVERY_ID
@pytest.mark.skipif(not DRAWS, reason="needs coopenv[render]")
def test_every_render_mode_gives_what_its_name_says(view, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    modes = gymnasium.make(view).metadata["render_modes"]
    assert set(modes) == {"human", "rgb_array"}
    for mode in ("human", "rgb_array", "rgb_array_list"):
        env: Any = gymnasium.make(view, render_mode=mode)
        assert env.render_mode == mode
        env.reset(seed=0)
        for action in drawn_actions(env, 2):
            env.step(action)
        shown = env.render()
        if mode == "human":
            assert shown is None
        elif mode == "rgb_array":
            check_picture(shown)
        else:
            assert len(shown) == 3
            for picture in shown:
                check_picture(picture)
        env.close()


@EVERY_ID
@pytest.mark.skipif(not DRAWS, reason="needs coopenv[render]")
def test_nothing_of_pygame_starts_without_pictures_and_no_sound_with_them(view, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame = pytest.importorskip("pygame")
    pygame.quit()
    started(gymnasium.make(view))
    assert not pygame.display.get_init()
    assert not pygame.font.get_init()
    env: Any = started(gymnasium.make(view, render_mode="rgb_array"))
    env.render()
    assert not pygame.mixer.get_init()
    env.close()


@EVERY_ID
def test_an_environment_prints_as_what_it_is(view):
    assert str(gymnasium.make(view).unwrapped) == f"<TransportEnv<{view}>>"
    assert str(gymnasium.make_vec(view, num_envs=3)) == f"TransportVectorEnv({view}, num_envs=3)"
    assert str(TransportEnv()) == "<TransportEnv instance>"
    for env in (gymnasium.make(view), gymnasium.make_vec(view)):
        assert repr(env) == str(env)
        assert view in repr(env.spec)


@EVERY_ID
def test_unwrapping_ends_at_the_environment_whatever_is_around_it(view):
    bare: Any = gymnasium.make(view).unwrapped
    assert type(bare) is TransportEnv
    assert bare.unwrapped is bare
    wrapped = gymnasium.wrappers.NormalizeReward(gymnasium.wrappers.ClipAction(bare))
    assert wrapped.unwrapped is bare
    assert wrapped.get_wrapper_attr("transport") is bare.transport
    assert (
        gymnasium.wrappers.vector.ClipReward(vector := gymnasium.make_vec(view), 0, 1).unwrapped
        is vector
    )


@EVERY_ID
def test_a_specification_makes_the_environment_again_with_its_wrappers(view):
    env: Any = gymnasium.wrappers.TimeAwareObservation(
        gymnasium.wrappers.RescaleAction(
            gymnasium.make(view, horizon=17, action="force", reward="balanced"),
            *SCALE,
        )
    )
    assert env.spec.id == view
    read = EnvSpec.from_json(env.spec.to_json())
    for again in (gymnasium.make(env.spec), gymnasium.make(read)):
        limit = "TimeLimit"  # around what is made from a specification, at the same horizon
        assert [name for name in names(again) if name != limit] == names(env)
        assert again.observation_space == env.observation_space
        assert again.action_space == env.action_space
        assert again.get_wrapper_attr("transport").config == env.unwrapped.transport.config
        assert data_equivalence(again.reset(seed=4), env.reset(seed=4), exact=True)


@EVERY_ID
@pytest.mark.parametrize("steps", [2, 250])
@pytest.mark.parametrize("wrapper", ["TimeLimit", "TimeAwareObservation"])
def test_wrappers_that_ask_for_the_horizon_find_the_one_that_make_was_given(view, steps, wrapper):
    env: Any = gymnasium.make(view, max_episode_steps=steps, task=NEVER)
    if wrapper == "TimeLimit":
        env = gymnasium.wrappers.TimeLimit(env, env.spec.max_episode_steps)
    else:
        env = gymnasium.wrappers.TimeAwareObservation(env)
    env.reset(seed=0)
    still = constant(env)
    stops = [env.step(still)[3] for _ in range(steps)]
    assert stops == [False] * (steps - 1) + [True]


@EVERY_ID
def test_the_registry_knows_the_id_by_name_and_with_its_module(view):
    assert gymnasium.spec(view).nondeterministic is False
    assert gymnasium.spec(view).namespace == "coopenv"
    assert view.rpartition("/")[2].rpartition("-")[0] in gymnasium.pprint_registry(
        disable_print=True
    )
    assert "coopenv" in sys.modules
    assert gymnasium.make(f"coopenv:{view}").unwrapped.spec.id == view  # pyright: ignore[reportOptionalMemberAccess]
