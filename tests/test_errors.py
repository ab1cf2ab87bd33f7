"""Hints of errors about names: what is meant, or where it belongs; nothing that is merely alike."""

import gymnasium
import pytest

import coopenv
from coopenv.errors import SYNONYMS, UnknownName, likely


@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        ("n_envs", "num_envs to gymnasium.make_vec, or num_worlds to coopenv.Transport"),
        ("num_envs", "num_envs to gymnasium.make_vec"),
        ("mass", r"pass body=Body\(mass=\.\.\.\)"),
        ("grips", r"pass body=Body\(grips=\.\.\.\)"),
        ("seed", r"reset\(seed=\.\.\.\)"),
        ("obstacles", r"pass scene=Scene\(obstacles=\.\.\.\)"),
        ("gamma", "the learner's"),
        ("max_steps", "did you mean 'horizon'"),
        ("frame_skip", "did you mean 'substeps'"),
        ("reward_fn", "did you mean 'reward'"),
        ("observation", "did you mean 'observe'"),
        ("horizn", "did you mean 'horizon'"),
    ],
)
def test_a_keyword_of_elsewhere_is_told_its_place(given, remedy):
    with pytest.raises(UnknownName, match=f"got '{given}'; .*{remedy}"):
        gymnasium.make("coopenv/BeamTransport-v0", **{given: 3})  # pyright: ignore[reportArgumentType]
    with pytest.raises(UnknownName, match=f"got '{given}'; .*{remedy}"):
        coopenv.TransportConfig.parse({given: 3})


@pytest.mark.parametrize("given", ["mask", "frob", "x", "", "colour", "agent", "state"])
def test_what_is_merely_alike_is_not_offered(given):
    with pytest.raises(
        UnknownName, match=f"got '{given}'; known: action, actuators, body"
    ) as raised:
        coopenv.TransportConfig.parse({given: 3})
    assert "did you mean" not in str(raised.value)


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("lr", "learning_rate"),
        ("gamma", "discount"),
        ("n_steps", "rollout"),
        ("n_envs", "num_worlds"),
        ("total_timesteps", "steps"),
        ("timesteps", "steps"),
        ("ent_coef", "entropy_weight"),
        ("net-arch", "hidden"),
        ("Seed", "seed"),
        ("learning", "learning_rate"),
        ("stesp", "steps"),
    ],
)
def test_words_of_other_learners_have_their_name_here(given, meant):
    from dataclasses import fields

    from coopenv.agents.settings import TrainConfig

    assert likely(given, [entry.name for entry in fields(TrainConfig)]) == meant


def test_no_synonym_is_a_name_of_a_thing_it_does_not_stand_for():
    assert not {word for word, meant in SYNONYMS.items() if word in meant}
    assert likely("gamma", ["gamma_rays", "relative_cost"]) == "relative_cost"
    assert likely("anything", []) is None
