"""Partners that move hands: what they give, whom they need, and what comes of it."""

import itertools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from coopenv import Body, Hands, Transport, TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.partners import (
    Compliant,
    Guiding,
    Lagging,
    LoadSharing,
    Noisy,
    Population,
    Switching,
)
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import NEVER, OPEN_ROOM, actions, assert_same
from tests.test_partner import SteadyPlayer


def hands(num_worlds=4, **keywords) -> Transport:
    core = Transport(
        num_worlds=num_worlds, **{"task": NEVER, "scene": OPEN_ROOM, "action": "motion", **keywords}
    )
    core.reset(seed=0)
    return core


@dataclass(frozen=True)
class Mover:
    """A partner of somebody else's making, who says what it gives."""

    gives: Any = "actions"
    given: tuple[float, ...] = (0.5, -0.25, 2.0)

    def player(self, config, num_worlds, agents):
        player = SteadyPlayer(np.tile(self.given, (num_worlds, len(agents), 1)))
        player.gives = self.gives  # pyright: ignore
        return player


def test_a_player_that_gives_actions_moves_its_hand_as_a_learner_does():
    driven, free = hands(partner=Mover()), hands()
    for push in actions(0, 6, 4, 1, 3):
        driven.step(push)
        both = np.concatenate([push, np.tile((0.5, -0.25, 2.0), (4, 1, 1))], axis=1)
        free.step(both)
        assert driven.transition is not None
        assert free.transition is not None
        np.testing.assert_array_equal(driven.transition.applied, free.transition.applied)
        np.testing.assert_array_equal(driven.transition.stretch, free.transition.stretch)
    assert driven.transition is not None
    np.testing.assert_array_equal(driven.transition.action[:, 1], [[0.5, -0.25, 1.0]] * 4)


def test_a_player_that_gives_actions_of_wrenches_holds_them_in_parts_of_its_limits():
    core = hands(action="wrench", partner=Mover(), force_limit=20.0, torque_limit=4.0)
    core.step(np.zeros((4, 1, 3)))
    assert core.transition is not None
    np.testing.assert_allclose(core.transition.applied[:, 1], [[-10.0, 5.0, 4.0]] * 4, atol=1e-12)


@pytest.mark.parametrize(
    ("partner", "said"),
    [
        (Mover(gives="forces"), "gives of a player must be 'wrenches' or 'actions', got 'forces'"),
        (
            Mover(given=(0.0, 1.0)),
            r"actions of the partner must have shape .*action_size\) = ",
        ),
        (Mover(given=(0.0, 1.0, np.nan)), "actions of the partner must be finite, got nan"),
        (Mover(gives="wrenches", given=(0.0, 1.0)), "wrenches of the partner must have shape"),
    ],
)
def test_what_a_player_must_not_give_is_refused(partner, said):
    with pytest.raises(InvalidInput, match=said):
        hands(partner=partner).step(np.zeros((4, 1, 3)))


@pytest.mark.parametrize(
    "kind",
    [
        Compliant(),
        Guiding(),
        Lagging(partner=Guiding()),
        Noisy(partner=Compliant()),
        Switching(first=LoadSharing(), second=Compliant()),
        Population(members=(LoadSharing(), Guiding())),
    ],
)
def test_who_acts_by_what_a_hand_feels_says_that_it_needs_one(kind):
    with pytest.raises(InvalidInput, match="action must be 'motion' or 'impedance' for a partner"):
        Transport(partner=kind)
    *_, info = hands(partner=kind, action="impedance").step(np.zeros((4, 1, 5)))
    assert np.isfinite(info["stored_energy"]).all()


def test_a_policy_as_a_partner_moves_the_hands_that_it_drives():
    policy = find_controller(TransportConfig(action="motion"))
    partnered, free = hands(partner=policy), hands()
    for _ in range(5):
        assert free.transition is not None
        moves = policy(np.empty(0), free.transition)
        partnered.step(moves[:, :1])
        free.step(moves)
        assert partnered.transition is not None
        assert_same(partnered.transition.applied, free.transition.applied)
    assert free.transition is not None
    assert np.abs(free.transition.applied).max() > 1.0


def test_a_hand_of_who_plans_gives_what_it_would_give_without_one():
    """A partner with no offset does what one hand of the scripted controller does."""
    config = find_config("coopenv/BeamTransport-v0", {"action": "motion", "partner": "impedance"})
    seen = run_episodes(find_controller(config), config, episodes=40, num_worlds=40)
    assert seen.success.mean() >= 0.95
    assert seen.relative_cost.mean() < 0.02
    apart = replace(config, partner="stubborn")
    assert run_episodes(find_controller(apart), apart, episodes=40).relative_cost.mean() > 0.3


def test_who_shares_by_hand_bears_its_share():
    core = hands(partner=LoadSharing(share=0.3), force_limit=40.0, torque_limit=40.0)
    push, shares = actions(3, 1, 4, 1, 3)[0] * 0.3, []
    for _ in range(25):
        *_, info = core.step(push)
        shares.append(info["force_load_share"][:, 1])
    np.testing.assert_allclose(np.median(shares[5:], axis=0), 0.3, atol=0.1)


def drawn_along(partner, steps=30) -> np.ndarray:
    """Way ``(world,)`` [m] that a learner draws the beam along itself in a while."""
    core = hands(partner=partner, force_limit=20.0)
    assert core.transition is not None
    start = core.transition.next_state.pose
    for _ in range(steps):
        core.step(np.tile((0.5, 0.0, 0.0), (4, 1, 1)))
    moved = core.transition.next_state.pose[:, :2] - start[:, :2]
    return np.linalg.norm(moved, axis=1)


def test_who_gives_way_is_lighter_to_lead_than_who_stays():
    gives_way, stays = drawn_along(Compliant()), drawn_along(Mover(given=(0.0, 0.0, 0.0)))
    assert (gives_way > 0.5).all()
    assert (stays < 0.4 * gives_way).all()


@pytest.mark.parametrize("env", ["BeamTransport", "BeamDoorway", "BeamLift", "WalkerTurn"])
def test_who_shows_the_way_brings_a_hand_home_that_only_gives_way(env):
    config = find_config(f"coopenv/{env}-v0", {"action": "motion", "partner": "guiding"})
    follower: dict[str, Any] = {}

    def gives_way(obs, transition):
        if not follower:
            player = Compliant().player(config, len(obs), config.learners)
            worlds = np.arange(len(obs))
            generators = [np.random.default_rng(k) for k in worlds]
            player.reset(worlds, generators, transition)
            follower["learner"] = player
        return follower["learner"].act(transition)

    seen = run_episodes(gives_way, config, episodes=40, num_worlds=40)
    assert seen.success.mean() >= 0.6
    assert seen.relative_cost.mean() < 0.15


@pytest.mark.parametrize(
    ("hand", "substeps"),
    [(Hands(), 10), (Hands(stiffness=400.0, damping=100.0), 20), (Hands(damping=(30.0, 0.0)), 10)],
)
@pytest.mark.parametrize("yielding", [0.02, 0.2, 1e12])
def test_who_gives_way_comes_to_rest_however_readily(hand, substeps, yielding):
    core = hands(
        partner=Compliant(yielding=yielding, turn_yielding=yielding), hands=hand, substeps=substeps
    )
    given = []
    for step in range(70):
        core.step(np.tile((0.3, 0.0, 0.0), (4, 1, 1)) * (step < 5))
        assert core.transition is not None
        given.append(np.abs(core.transition.applied[:, 1]).max())
    assert max(given[:10]) > 0.1
    assert max(given[-10:]) < 0.03 * max(given)


def test_the_stretch_of_who_gives_way_fades_as_its_description_says():
    free = hands(body=Body(mass=1e6), dt=0.05)  # nothing moves it
    for _ in range(4):
        free.step(np.tile((0.1, -0.05, 0.2), (4, 2, 1)))
    player = Compliant(yielding=0.05, turn_yielding=0.3).player(free.config, 4, (0, 1))
    assert free.transition is not None
    player.reset(np.arange(4), [np.random.default_rng(k) for k in range(4)], free.transition)
    held = []
    for _ in range(4):
        assert free.transition is not None
        assert free.transition.stretch is not None
        held.append(free.transition.stretch)
        free.step(player.act(free.transition))
    for rate, axes, stiff, damped in ((0.05, slice(2), 150, 30), (0.3, slice(2, 3), 20, 5)):
        left = (1 + rate * damped) / (1 + rate * damped + rate * stiff * 0.05)
        for before, after in itertools.pairwise(held):
            np.testing.assert_allclose(after[..., axes], left * before[..., axes], rtol=1e-3)
